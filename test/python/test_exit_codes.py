"""Exit codes of the programs, as doc/interfaces.md lists them. Other tests cover the codes that need a session or a
robot."""

import csv
import os
import pathlib
import re
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
PROGRAMS = BUILD / "devel/lib/raven2_trainer"
NAMES = sorted(re.findall(r"^raven2_program\((\w+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.M))
DONE, NOT_DONE, BAD_TABLE = 0, 1, 2
OUT_OF_RANGE, MISSING, UNKNOWN = 105, 106, 109

pytestmark = pytest.mark.skipif(not all((PROGRAMS / name).exists() for name in NAMES), reason="the programs are not built")


def run(name, *arguments, stdin="", **environment):
    """(exit code, [line] on stderr)"""
    done = subprocess.run([PROGRAMS / name, *map(str, arguments)], input=stdin, capture_output=True, text=True, check=False,
                          env={**os.environ, **environment}, timeout=60)
    return done.returncode, done.stderr.splitlines()


def test_one_promise_that_was_not_kept_is_the_exit_code_of_scripts_soak():
    text = (ROOT / "scripts/soak").read_text(encoding="utf-8")
    module = {}
    exec(text[text.index("class Judge"):text.index("def sample")], module)  # noqa: S102  (without the rest, which draws)
    judge = module["Judge"]()
    judge.check(True, "memory is flat", "0.0 MiB/h")
    assert judge.held()
    judge.check(False, "no tick is lost", "3 lost")
    judge.check(True, "the log is whole", "yes")
    assert not judge.held() and "FAIL  no tick is lost: 3 lost" in str(judge)
    assert re.search(r"return 0 if \w+\.held\(\) else 1", text)


@pytest.mark.parametrize("name", NAMES)
def test_help_and_version_are_done_and_an_unknown_option_is_told(name):
    assert run(name, "--help")[0] == run(name, "--version")[0] == DONE
    code, told = run(name, "--no-such-option")
    assert 100 <= code <= 127 and told


def test_the_table_of_evaluate_detector_has_a_row_a_run(tmp_path):
    code, _ = run("evaluate_detector", "--input-starts", 0, "--torque-starts", 1, "--add-starts", 0, "--output", tmp_path / "runs.csv")
    with open(tmp_path / "runs.csv", encoding="ascii") as file:
        rows = [{key: float(value) for key, value in row.items() if key not in ("scenario", "kind")} for row in csv.DictReader(file)]
    assert code == DONE and [row["length"] for row in rows] == list(range(1, 20))
    unsafe = [row for row in rows if row["unsafe"]]
    assert unsafe and all(0 <= row["decided_ms"] <= row["harmed_ms"] for row in unsafe)
    assert any(row["decided_ms"] < row["harmed_ms"] for row in unsafe), "it is decided before the harm"
    assert all(row["decided_ms"] == -1 for row in rows if not row["unsafe"])


@pytest.mark.parametrize("arguments, code", [
    (["--no-such-option"], UNKNOWN), (["--seconds", "ten"], OUT_OF_RANGE), (["--seconds", "-1"], OUT_OF_RANGE)])
def test_wrong_arguments_have_numbers_of_their_own(arguments, code):
    assert run("simulate", *arguments)[0] == code


@pytest.mark.parametrize("scale", ["0", "1.5", "-0.1"])
def test_a_scale_has_the_range_of_its_key(scale):
    assert run("simulator", "--scale", scale)[0] == run("master_console", "--scale", scale)[0] == OUT_OF_RANGE


def test_an_argument_that_is_missing():
    assert run("export_session")[0] == MISSING


@pytest.mark.parametrize("command", [
    ["simulate", "--hazard", "no_such_hazard"], ["simulate", "--config", "/nowhere/trainer.yaml"], ["resimulate", "/nowhere"],
    ["export_session", "/nowhere"], ["recover_session", "/nowhere"], ["score_session", "/nowhere"],
    ["run_campaign", "no_such_campaign", "--output", "out"], ["plan", "no_such_problem"]])
def test_what_cannot_be_done_is_said_in_one_line(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, told = run(*command)
    assert code == NOT_DONE and len(told) == 1
    assert re.search(r"nowhere|no_such_\w+", told[0])


def test_a_file_that_a_full_disk_does_not_take_is_told(tmp_path):
    motors = tmp_path / "motors.csv"
    motors.write_text("mpos1_deg,mpos2_deg,mpos3_deg,dac1,dac2,dac3\n" + "180,360,-90,0,0,0\n" * 300, encoding="utf-8")
    for command in (["plant_replay", motors, "--horizons", 10, "--stride", 50, "--output", "/dev/full"],
                    ["timing_check", "--bare", "--calibrate", 1, "--json", "/dev/full"]):
        code, told = run(*command)
        assert code == NOT_DONE and "/dev/full" in told[-1]


def test_one_of_several_sessions_that_cannot_be_drawn(tmp_path):
    assert run("render_session", tmp_path)[0] == NOT_DONE


def test_without_a_display_there_is_no_window():
    code, told = run("console_view", DISPLAY="", ROS_MASTER_URI="http://127.0.0.1:1")
    assert code == NOT_DONE and "display" in told[0]


@pytest.mark.parametrize("command", [
    ["kinematics", "forward", "--arm", "gold"], ["model_probe", "--arm", "gold", "--q0", "0.8,1.5,-0.1,0.2,0.3,0.1,-0.2"]])
def test_a_wrong_table_is_told_by_its_line(command):
    code, told = run(*command, stdin="J1,J2\n0.1,0.2\n")
    assert code == BAD_TABLE and "stdin:1" in told[-1]
