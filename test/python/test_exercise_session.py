"""Sessions of a user's own exercise are scored as they end. The exercise needs files only, no code.
Needs the programs built."""
import json
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "test/python")]
import raven2_lockstep  # noqa: E402
from own_exercise import exercise  # noqa: E402

PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"
NEEDED = ["score_session", "simulate", "recover_session"]

pytestmark = pytest.mark.skipif(not all((PROGRAMS / name).exists() for name in NEEDED),
                                reason=f"not all of {', '.join(NEEDED)} are built")

# The exercise scores four metrics. The band has two of them, and idle, which the exercise does not score.
EXERCISE = exercise("stay", [("gold", "gold", 1.0), ("green", "green", 2.0)],
                    "{time: {}, path: {}, force_above: {limit: 1.5}, tremor: {limit: 1.0e+6}}",
                    "{scenario: sudden_jump, at: {step: 2, delay: 0.0, jitter: 0.0}, right: [stop], "
                    "wrong: [push_on, slow], within: 1.25}")
RULE = {"right": ["stop"], "wrong": ["push_on", "slow"], "within_s": 1.25}
CURRICULUM = """
title: Two stages
deviations: 1.0
stages:
  - {exercise: stay, drill: none, passes: 2, extra: 0}
  - {exercise: camera_clutch, drill: none, passes: 2, extra: 0}
"""
BAND = """
origin: this test
sessions: 2
least_spread: 0.25
metrics:
  time: {mean: %g, deviation: 0.1, better: lower, least: 0.0}
  path: {mean: 500.0, deviation: 100.0, better: lower, least: 0.0}
  idle: {mean: -1.0, deviation: 0.0, better: lower, least: 0.0}
"""


def run(program, *arguments):
    return subprocess.run([PROGRAMS / program, *map(str, arguments)], capture_output=True, text=True, check=False)


class School:
    """A folder of sessions, and a configuration with an additional exercise and curriculum."""

    def __init__(self, folder):
        self.folder = folder
        self.config = raven2_lockstep.copy_of_configuration(folder)
        self.write("exercises/stay", EXERCISE)
        self.write("curricula/two", CURRICULUM)
        (folder / "config/bands").mkdir(exist_ok=True)
        self.be_strict(False)

    def write(self, name, text):
        (self.folder / f"config/{name}.yaml").write_text(text)

    def be_strict(self, strict):
        self.write("bands/stay", BAND % (1.0 if strict else 3.0))

    def record(self, name, *options, seconds=5):
        directory = self.folder / "sessions" / name
        done = run("simulate", "--config", self.config, "--exercise", "stay", "--seconds", seconds, "--homing", "quick",
                   "--output", directory, *options)
        assert done.returncode == 0, done.stderr
        return directory, done.stderr

    def score(self, name):
        return json.loads((self.folder / "sessions" / name / "score.json").read_text())

    def index(self):
        return json.loads((self.folder / "sessions/index.json").read_text())["sessions"]


@pytest.fixture(scope="module", name="school")
def make_school(tmp_path_factory):
    return School(tmp_path_factory.mktemp("school"))


@pytest.fixture(scope="module", name="course")
def four_sessions(school):
    """Sessions: passed, failed by a band that is too strict, passed, passed. @return simulate's output of each."""
    told = []
    for name, strict in [("1", False), ("2", True), ("3", False), ("4", False)]:
        school.be_strict(strict)
        told.append(school.record(name, "--trainee", "ann", "--curriculum", "two", "--seed", name)[1])
    return told


@pytest.fixture(scope="module", name="first")
def first_score(school, course):
    assert len(course) == 4
    return school.score("1")


def test_a_session_is_scored_as_it_ends(first):
    (attempt,) = first["attempts"]
    assert (first["exercise"], first["trainee"], first["curriculum"]) == ("stay", "ann", "two")
    assert attempt["status"] == "done" and attempt["passed"] is True
    assert [step["name"] for step in attempt["steps"]] == ["gold", "green"]
    assert 2.9 < attempt["metrics"]["time"]["value"] < 3.1


def test_the_exercise_says_what_is_judged(first):
    metrics = first["attempts"][0]["metrics"]
    assert [name for name, metric in metrics.items() if metric["scored"]] == ["time", "path", "tremor", "force_above"]
    assert metrics["idle"]["passed"] is None and metrics["idle"]["mean"] == -1.0, "not scored: it would have failed"
    assert metrics["path"]["passed"] is True
    assert metrics["tremor"]["bound"] == 1e6 and metrics["tremor"]["limit"] == 1e6
    assert metrics["force_above"]["bound"] is None and first["force_limit_N"] == 1.5
    assert first["attempts"][0]["not_judged"] == ["force_above"]


def test_two_passes_in_a_row_end_a_stage(school, course):
    assert [line.split(", ")[-1] for text in course for line in text.splitlines() if line.startswith("stay: ")] == [
        "passed", "not passed", "passed", "passed"]
    done = [line for text in course for line in text.splitlines() if "stages done" in line]
    assert [line.split(": ")[1] for line in done] == ["0 of 2 stages done"] * 3 + ["1 of 2 stages done"]
    assert [entry["directory"] for entry in school.index()] == ["1", "2", "3", "4"]
    assert [entry["attempts"][0]["passed"] for entry in school.index()] == [True, False, True, True]


def test_the_curve_and_the_stage_are_printed(school, course):
    assert course
    done = run("score_session", school.folder / "sessions/4")
    assert done.returncode == 0, done.stderr
    assert "ann so far:" in done.stdout
    rows = [line for line in done.stdout.splitlines()
            if line.split()[:1] and line.split()[0] in "1234" and "done" in line]
    assert [row.split()[0] for row in rows] == ["1", "2", "3", "4"]
    assert [row.endswith("not passed") for row in rows] == [False, True, False, False]
    assert "  stay: 2 of 2 in a row" in done.stdout and "> camera_clutch: 0 of 2 in a row" in done.stdout


def test_the_band_of_then_judges_and_another_by_option(school, course):
    assert course
    directory = school.folder / "sessions/2"
    before = (directory / "score.json").read_bytes()
    school.be_strict(False)
    assert run("score_session", directory, "--no-index").returncode == 0
    assert (directory / "score.json").read_bytes() == before, "the session's own copy of the strict band judges"
    other = school.folder / "other.json"
    band = school.folder / "config/bands/stay.yaml"
    assert run("score_session", directory, "--no-index", "--band", band, "--output", other).returncode == 0
    assert json.loads(other.read_text())["attempts"][0]["passed"] is True


def test_metrics_and_score_tell_of_the_same_attempt(school, first):
    metrics = json.loads((school.folder / "sessions/1/metrics.json").read_text())
    (told,), (scored,) = metrics["exercise"]["attempts"], first["attempts"]
    assert metrics["counters_add_up"] is True
    assert metrics["exercise"]["name"] == "stay" and metrics["exercise"]["drill"] is None
    assert [told[key] for key in ("number", "status", "failure", "steps_done", "mistakes")] == [
        scored[key] for key in ("number", "status", "failure", "steps_done", "mistakes")]
    assert told["time_s"] == pytest.approx(scored["metrics"]["time"]["value"])
    assert (told["events"]["began"], told["events"]["step_done"], told["events"]["done"]) == (1, 2, 1)
    assert sum(told["events"].values()) == metrics["queues"]["exercise_records"]["pushed"]


def test_a_drill_is_judged_as_the_exercise_says(school):
    directory, _ = school.record("drill", "--drill", "sudden_jump")
    score = school.score("drill")
    assert score["drill"] == "sudden_jump"
    assert score["response_rule"] == RULE
    assert score["attempts"][0]["passed"] is False, "the drill required a stop, and nobody asked for one"
    assert not (directory.parent / "index.json").exists() or "drill" not in [
        entry["directory"] for entry in school.index()], "a session without a trainee is not in the index"


def test_a_drill_with_another_scenario_is_judged_as_the_exercise_says_too(school):
    school.record("other", "--drill", "unavailable_recoverable")
    assert school.score("other")["response_rule"] == RULE


def test_without_a_drill_the_usual_responses_are_right(first):
    assert first["response_rule"] == {"right": ["pedal_up", "hold_still", "stop"], "wrong": ["push_on"],
                                      "within_s": 2.0}


def test_a_session_that_was_cut_off_is_scored_when_it_is_recovered(school, course):
    assert course
    torn = school.folder / "torn" / "1"
    shutil.copytree(school.folder / "sessions/1", torn)
    for name in ("score.json", "metrics.json", "faults.json"):
        (torn / name).unlink()
    log = torn / "session.rlog"
    os.truncate(log, log.stat().st_size * 2 // 3)
    done = run("recover_session", torn)
    assert done.returncode == 0, done.stderr
    (scored,) = json.loads((torn / "score.json").read_text())["attempts"]
    (told,) = json.loads((torn / "metrics.json").read_text())["exercise"]["attempts"]
    assert scored["status"] == told["status"]
    assert scored["steps_done"] == told["steps_done"] == told["events"]["step_done"]
    assert told["time_s"] == pytest.approx(scored["metrics"]["time"]["value"])
    assert json.loads((torn.parent / "index.json").read_text())["sessions"][0]["directory"] == "1"
    assert "nothing to recover" in run("recover_session", torn).stderr


def test_recover_session_scores_what_was_not(school, course):
    assert course
    score = school.folder / "sessions/3/score.json"
    before = score.read_bytes()
    score.unlink()
    assert run("recover_session", score.parent).returncode == 0
    assert score.read_bytes() == before


def test_a_metric_that_is_not_there_is_refused_with_its_line(school):
    school.write("exercises/wrong", EXERCISE.replace("name: stay", "name: wrong").replace("tremor:", "tremors:"))
    line = 1 + EXERCISE.splitlines().index(
        "metrics: {time: {}, path: {}, force_above: {limit: 1.5}, tremor: {limit: 1.0e+6}}")
    done = run("simulate", "--config", school.config, "--exercise", "wrong", "--output", school.folder / "never")
    assert done.returncode == 1
    assert f"wrong.yaml:{line}: metrics/tremors is no metric: did you mean \"tremor\"?" in done.stderr


def test_the_expert_climbs_by_bands_that_were_made_of_it(school):
    """From the packaged exercise to its band, and with that through the first stage of the packaged curriculum."""
    made = subprocess.run([sys.executable, ROOT / "scripts/make_bands", "camera_clutch", "--seeds", "1001-1002",
                           "--output",
                           school.folder / "config/bands"], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stdout + made.stderr
    told = []
    for seed in (1, 2):
        done = run("simulate", "--config", school.config, "--exercise", "camera_clutch", "--motion", "expert", "--seed",
                   seed, "--homing", "quick", "--trainee", "bob", "--curriculum", "frs_basics", "--output",
                   school.folder / f"sessions/expert{seed}")
        assert done.returncode == 0, done.stderr
        told += [line for line in done.stderr.splitlines() if "attempt" in line or "stages done" in line]
    assert [line.split(": ", 1)[1] for line in told] == ["attempt 1: done, passed", "0 of 8 stages done",
                                                         "attempt 1: done, passed", "1 of 8 stages done"]
    score = school.score("expert1")
    assert score["band"]["origin"] == "scripted expert of raven2_trainer, seeds 1001-1002, not surgeons"
    assert score["attempts"][0]["not_judged"] == []
