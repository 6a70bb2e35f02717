"""scripts/measure_drills: its figures from rows of its table, and its options. Runs no session."""
import importlib.machinery
import importlib.util
import json
import pathlib
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/measure_drills"
sys.path.insert(0, str(ROOT / "scripts"))
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("measure_drills", str(SCRIPT))
measure_drills = importlib.util.module_from_spec(importlib.util.spec_from_loader("measure_drills", loader))
loader.exec_module(measure_drills)


def rows(reaction, verdicts, cue="force", noticed=12, answer=412, let_go=412):
    """A row of the table for each verdict."""
    return [{"scenario": "sudden_jump", "reaction": reaction, "verdict": verdict, "cue": cue, "cue_after_ms": "12",
             "noticed": cue, "noticed_after_ms": str(noticed), "answer_after_ms": str(answer), "let_go_after_ms": str(let_go)} for verdict in verdicts]


def printed(capsys, table):
    """(kept, the printed lines)."""
    kept = measure_drills.verdict(table)
    return kept, capsys.readouterr().out.splitlines()


@pytest.mark.parametrize("verdicts, kept, said", [
    (["wrong"] * 50, True, "0 of 50, 0.0 %"), (["wrong"] * 49 + ["late"], True, "1 of 50, 2.0 %"),
    (["wrong"] * 48 + ["late", "right"], False, "2 of 50, 4.0 %  NOT KEPT"),
    (["none"] * 48 + ["late"] * 2, False, "2 of 50, 4.0 %  NOT KEPT")])
def test_a_late_answer_of_a_surgeon_who_ignores_the_hazard_counts_too(capsys, verdicts, kept, said):
    assert printed(capsys, rows("none", verdicts)) == (kept, [
        f"reaction none: answered in time or late in {said}", "cue: force: nothing to compare", "cue: ghost: nothing to compare",
        "answer: nothing to compare"])


def test_a_late_answer_of_a_surgeon_who_lets_go_is_not_right(capsys):
    kept, lines = printed(capsys, rows("400", ["right"] * 9 + ["late"]))
    assert not kept and lines[0] == "reaction 400: answered rightly in 9 of 10, 90.0 %  NOT KEPT"


@pytest.mark.parametrize("cue, noticed, let_go, kept, said", [
    ("force", 17, 412, True, "cue: force: right within 5 ms in 1"), ("force", 18, 412, False, "cue: force: right within 6 ms in 1  NOT KEPT"),
    ("ghost", 46, 412, True, "cue: ghost: right within 34 ms in 1"), ("ghost", 47, 412, False, "cue: ghost: right within 35 ms in 1  NOT KEPT"),
    ("force", 12, 407, True, "answer: right within 5 ms in 1"), ("ghost", 12, -50, False, "answer: right within 300 ms in 1  NOT KEPT"), ("ghost", 12, 418, False, "answer: right within 6 ms in 1  NOT KEPT")])
def test_times_that_differ_from_the_truth_are_not_kept(capsys, cue, noticed, let_go, kept, said):
    result, lines = printed(capsys, rows("250", ["right"], cue, noticed, let_go=let_go) + rows("none", ["wrong"], cue, 900, 9, 99))
    assert result == kept and said in lines


def test_a_pedal_that_was_up_already_answers_100_ms_after_the_cue(capsys):
    for let_go, kept in ((-50, True), (50, True), (112, True), (118, False)):
        assert printed(capsys, rows("250", ["right"], answer=112, let_go=let_go))[0] == kept


def test_a_cue_that_the_surgeon_noticed_by_the_other_sense_is_not_compared(capsys):
    table = [{**row, "noticed": "force"} for row in rows("250", ["right"], "ghost", 900)]
    kept, lines = printed(capsys, table)
    assert kept and lines[1:] == ["cue: force: nothing to compare", "cue: ghost: nothing to compare", "answer: right within 0 ms in 1"]


@pytest.fixture(name="config")
def own_configuration(tmp_path):
    """A configuration with two exercises, one of them with a drill, and one scenario."""
    for name, text in (("tasks/odd.yaml", "drill: {}\n"), ("tasks/even.yaml", "steps: []\n"), ("breaks/jolt.yaml", "")):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    config = tmp_path / "own.yaml"
    config.write_text("exercises: tasks\nfaults: breaks\n")
    return config


def test_every_session_has_the_chosen_configuration(monkeypatch, config, tmp_path):
    calls = []

    def simulate(output, *options, config):
        calls.append((config, dict(zip(options[::2], options[1::2]))))
        raise measure_drills.raven2_lockstep.LockstepError("no session")

    monkeypatch.setattr(measure_drills.raven2_lockstep, "simulate", simulate)
    monkeypatch.setattr(measure_drills.raven2_lockstep, "require_program", lambda: None)
    monkeypatch.setattr(sys, "argv", ["measure_drills", "--config", str(config), "--output", str(tmp_path / "own.csv"),
                                      "--seeds", "1-2", "--reactions", "none", "--drill", "all"])
    assert measure_drills.main() == 1, "no session came about"
    assert [(path, of["--exercise"], of["--drill"]) for path, of in calls] == [(config, "odd", "jolt")] * 2


def test_with_a_rhythm_each_drill_is_done_by_a_surgeon_who_clutches_so(monkeypatch, tmp_path):
    calls = []

    def simulate(output, *options, config):
        exercise = yaml.safe_load((config.parent / f"exercises/{options[1]}.yaml").read_text())
        calls.append((exercise["clumsy"]["clutch_2_0p1"]["skill"], options[options.index("--motion") + 1]))
        raise measure_drills.raven2_lockstep.LockstepError("no session")

    monkeypatch.setattr(measure_drills.raven2_lockstep, "simulate", simulate)
    monkeypatch.setattr(measure_drills.raven2_lockstep, "require_program", lambda: None)
    monkeypatch.setattr(sys, "argv", ["measure_drills", "--clutch", "2,0.1", "--output", str(tmp_path / "own.csv"), "--seeds", "1", "--reactions", "none"])
    assert measure_drills.main() == 1, "no session came about"
    exercises = measure_drills.with_a_drill(ROOT / "config/trainer.yaml")
    assert calls == [({"clutch_time": 2, "clutch_reach": 0.1}, "clumsy:clutch_2_0p1")] * len(exercises)


def test_without_a_configuration_it_is_the_packaged_one(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["measure_drills"])
    options = measure_drills.read_options()
    assert (options.config, options.output) == (ROOT / "config/trainer.yaml", pathlib.Path("drills.csv"))
    assert "camera_clutch" in measure_drills.with_a_drill(options.config)
    assert "sudden_jump" in measure_drills.scenarios(options.config)


@pytest.mark.parametrize("arguments, reason", [(["--config", "CONFIG"], "--config and --clutch need --output"),
                                               (["--clutch", "2,0.1"], "--config and --clutch need --output"),
                                               (["--clutch", "2", "--output", "x.csv"], "expected S,M"),
                                               (["--clutch", "2,9", "--output", "x.csv"], "expected 0.1 to 10 s"),
                                               (["--clutch", "2,0.1", "--motion", "scripted", "--output", "x.csv"], "no --motion"),
                                               (["--config", "nowhere.yaml"], "--config: nowhere.yaml is not a file")])
def test_a_table_is_not_mixed_from_two_configurations(config, tmp_path, arguments, reason):
    arguments = [str(config) if argument == "CONFIG" else argument for argument in arguments]
    done = subprocess.run([SCRIPT, *arguments], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 2 and reason in done.stderr and not (tmp_path / "drills.csv").exists()


def test_a_row_is_of_the_hazard_that_could_be_noticed_and_counts_from_its_injection(tmp_path):
    unseen = {"scenario": "a", "injection_tick": 100, "verdict": "not_judged", "cue": None, "cue_after_ms": None,
              "reaction": None}
    felt = {"scenario": "b", "injection_tick": 1000, "verdict": "right", "cue": "force", "cue_after_ms": 12,
            "reaction": {"response": "pedal_up", "after_ms": 410}}
    (tmp_path / "score.json").write_text(json.dumps({"hazards": [unseen, felt]}))
    commands = np.zeros(3000, [("tick", int), ("command", [("sequence", int)])])
    model = np.zeros(3000, [("tick", int), ("session_tick", int)])
    commands["tick"] = model["tick"] = 50 + np.arange(3000)  # homing took 50 ms
    commands["command"]["sequence"], model["session_tick"] = 7 + np.arange(3000), np.arange(3000)
    session = SimpleNamespace(directory=tmp_path, log=SimpleNamespace(commands=commands, ticks={"model": model}))
    truth = [("seen", 900), ("pedal_up", 950), ("felt", 1019), ("seen", 1030), ("pedal_up", 1417), ("pedal_up", 2000)]
    assert measure_drills.of_hazard(session, truth) == {
        "scenario": "b", "verdict": "right", "cue": "force", "cue_after_ms": 12, "answer": "pedal_up", "answer_after_ms": 410,
        "noticed": "force", "noticed_after_ms": 12, "let_go_after_ms": 410, "injection_ms": 1000}
    early = measure_drills.of_hazard(session, truth[:2])
    assert early["noticed"] is early["noticed_after_ms"] is early["let_go_after_ms"] is None, "before the injection"


def test_a_hazard_that_did_not_come_is_no_row_of_the_scenarios(capsys):
    measure_drills.print_scenarios([{"scenario": "a", "verdict": "right", "cue": "force"},
                                    {"scenario": "a", "verdict": "not_judged", "cue": ""},
                                    {"scenario": "", "verdict": "did_not_come", "cue": ""}])
    assert capsys.readouterr().out.splitlines()[2:] == ["| `a` | 1 of 2, 50.0 % |"]


def test_the_first_session_says_when_the_next_ones_end(monkeypatch, tmp_path):
    asked = []

    def run(key, seconds, _config):
        asked.append(seconds)
        return {**dict(zip(measure_drills.KEY, key)), "verdict": "right", "injection_ms": 8000, "cue_after_ms": 1500}

    monkeypatch.setattr(measure_drills, "run", run)
    keys = [("x", "expert", "own", reaction, "1") for reaction in ("none", "250")]
    bar = SimpleNamespace(step=lambda text: None)
    measure_drills.run_seed(keys, None, None, measure_drills.Table(tmp_path / "drills.csv"), bar, [])
    assert asked == [None, pytest.approx(17.5)], "8 s behind the cue"
