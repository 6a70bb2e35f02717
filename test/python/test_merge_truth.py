"""merge_truth adds the file of the library at the USB boundary to a session, by the robot's clock or by commands."""
import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import raven2_session  # noqa: E402

PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"
pytestmark = pytest.mark.skipif(not (PROGRAMS / "merge_truth").exists(), reason="merge_truth is not built")
OFFSET = 1_700_000_000_000_000_000  # [ns] wall clock of the robot's computer (since 1970) minus its CLOCK_MONOTONIC
START = "2023-11-14T22:13:20Z"  # OFFSET: CLOCK_MONOTONIC is 0 in a session's first tick


@pytest.fixture(scope="module", name="recorded")
def record(tmp_path_factory):
    """A session of four seconds, recorded without a hazard."""
    output = tmp_path_factory.mktemp("truth") / "session"
    done = subprocess.run([PROGRAMS / "simulate", "--hazard", "none", "--seconds", "4", "--homing", "quick", "--output",
                           output], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return output


@pytest.fixture(name="session")
def copied(recorded, tmp_path):
    return shutil.copytree(recorded, tmp_path / "session")


@pytest.fixture(scope="module", name="ticks")
def read_ticks(recorded):
    return raven2_session.Session(str(recorded)).log.ticks


def moment(ticks, index, command=True):
    """Entry that the robot's computer would write for the robot state that this tick of the session received."""
    robot = ticks["robot"][index]
    return {"cycle": int(robot["cycle"]), "time_ns": int(robot["time_ns"]) + OFFSET,
            "command": int(robot["last_sequence"]) if command else 0}


def truth_of(inject, clear, **others):
    return {"scenario": "sudden_jump", "seed": 1, "monotonic_offset_ns": OFFSET, "ended_ns": OFFSET + 10**12, "injections": [
        {"name": "sudden_jump", "host": "robot", "row": 0, "site": "put_usb_packet", "variable": "dac", "arm": "gold",
         "channel": 1, "kind": "stuck_at", "value": 8000, "inject": inject, "clear": clear}], **others}


def write(path, truth):
    path.write_text(json.dumps(truth))
    return path


def merge(session, *file):
    return subprocess.run([PROGRAMS / "merge_truth", session, *map(str, file)], capture_output=True, text=True, check=False)


def read(session, name):
    return json.loads((session / name).read_text())


def begin_of(ticks):
    """Index of the tick two seconds after the first pedal down."""
    return int(np.argmax(ticks["model"]["session_tick"] >= 2000))


def test_a_fault_at_the_boundary_is_reported_like_the_virtual_ravens(session, ticks, tmp_path):
    at = begin_of(ticks)
    log = (session / "session.rlog").read_bytes()
    done = merge(session, write(tmp_path / "truth.json", truth_of(moment(ticks, at), moment(ticks, at + 300))))
    assert done.returncode == 0, done.stderr
    assert "1 injections act in the session, 0 lie outside; found by the clock" in done.stdout
    injection = read(session, "faults.json")["injections"][0]
    assert injection["name"] == "sudden_jump" and injection["variable"] == "dac" and injection["value"] == 8000
    assert injection["arm"] == "gold"
    assert abs(injection["inject"]["tick"] - 2000) <= 1 and abs(injection["clear"]["tick"] - 2300) <= 1
    assert injection["inject"]["cycle"] == ticks["robot"][at]["cycle"]
    fault = read(session, "metrics.json")["faults"][0]
    assert fault["name"] == "sudden_jump" and abs(fault["first_tick"] - 2000) <= 1
    assert (session / "session.rlog").read_bytes() == log, "the log is a record and must not change"


def test_the_figure_of_a_video_that_is_there_stays(session, ticks, tmp_path):
    metrics = read(session, "metrics.json")
    write(session / "metrics.json", {**metrics, "frames": 71})
    done = merge(session, write(tmp_path / "truth.json", truth_of(moment(ticks, begin_of(ticks)), None)))
    assert done.returncode == 0, done.stderr
    merged = read(session, "metrics.json")
    assert merged["frames"] == 71 and merged["faults"] and not metrics["faults"]


@pytest.mark.parametrize("foreign", [{"monotonic_offset_ns": 0}, {"monotonic_offset_ns": OFFSET + 10**15}])
def test_where_the_clock_says_nothing_commands_do(session, ticks, tmp_path, foreign):
    at = begin_of(ticks)
    truth = truth_of(moment(ticks, at), moment(ticks, at + 300), **foreign)
    done = merge(session, write(tmp_path / "truth.json", truth))
    assert done.returncode == 0, done.stderr
    assert "found by the commands" in done.stdout
    injection = read(session, "faults.json")["injections"][0]
    assert abs(injection["inject"]["tick"] - 2000) <= 5 and abs(injection["clear"]["tick"] - 2300) <= 5


def test_what_lasted_to_the_end_has_no_end(session, ticks, tmp_path):
    done = merge(session, write(tmp_path / "truth.json", truth_of(moment(ticks, begin_of(ticks)), None)))
    assert done.returncode == 0, done.stderr
    assert read(session, "faults.json")["injections"][0]["clear"]["tick"] is None


def test_what_had_begun_before_the_session_acts_from_its_first_state_on(session, ticks, tmp_path):
    before = {"cycle": 1, "time_ns": int(ticks["robot"]["time_ns"][ticks["robot"]["frame"] > 0][0]) + OFFSET - 10**9, "command": 0}
    done = merge(session, write(tmp_path / "truth.json", truth_of(before, moment(ticks, begin_of(ticks)))))
    assert done.returncode == 0, done.stderr
    injection = read(session, "faults.json")["injections"][0]
    assert injection["inject"]["cycle"] == 1 and abs(injection["clear"]["tick"] - 2000) <= 1
    over = {**before, "time_ns": before["time_ns"] + 10**8}
    done = merge(session, write(tmp_path / "over.json", truth_of(before, over)))
    assert done.returncode == 1 and "none of its 1 injections" in done.stderr


def test_a_file_that_a_score_could_not_be_made_from_is_not_kept(session, ticks, tmp_path):
    truth = truth_of(moment(ticks, begin_of(ticks)), None)
    for spoiled in ({"kind": "foo"}, {"value": None}, {"row": -1}, {"channel": 300}, {"arm": "both hands"}):
        truth["injections"][0] = {**truth_of(1, None)["injections"][0], "inject": moment(ticks, begin_of(ticks)), **spoiled}
        done = merge(session, write(tmp_path / "spoiled.json", truth))
        assert done.returncode == 1, spoiled
        assert not (session / "usb_truth.json").exists(), spoiled


def test_ticks_of_an_earlier_merge_are_found_again(session, ticks, tmp_path):
    early = {**moment(ticks, begin_of(ticks)), "tick": -5}
    late = {"cycle": 1, "time_ns": int(ticks["robot"][-1]["time_ns"]) + OFFSET + 10**10, "command": 0, "tick": 100}
    done = merge(session, write(tmp_path / "late.json", truth_of(late, None)))
    assert done.returncode == 1
    assert merge(session, write(tmp_path / "early.json", truth_of(early, None))).returncode == 0
    assert abs(read(session, "faults.json")["injections"][0]["inject"]["tick"] - 2000) <= 1


def test_the_truth_of_another_session_is_refused(session, ticks, tmp_path):
    at = begin_of(ticks)
    late = {"cycle": 1, "time_ns": int(ticks["robot"][-1]["time_ns"]) + OFFSET + 10**10, "command": 0}
    done = merge(session, write(tmp_path / "late.json", truth_of(late, None)))
    assert done.returncode == 1 and "none of its 1 injections falls into the session" in done.stderr
    torn = {**moment(ticks, at), "command": moment(ticks, at + 900)["command"]}
    done = merge(session, write(tmp_path / "torn.json", truth_of(torn, None)))
    assert done.returncode == 1 and "the file does not fit the session" in done.stderr
    assert not (session / "usb_truth.json").exists()


@pytest.mark.parametrize("text, why", [("", "no ground truth"), ("[]", "no ground truth"), ('{"injections": 3}', "no ground truth"),
                                       ('{"scenario": "mine", "injections": []}', 'injected scenario "mine"'),
                                       (None, "No such file")])
def test_what_is_no_truth_is_refused(session, tmp_path, text, why):
    path = tmp_path / "file.json"
    if text is not None:
        path.write_text(text)
    before = (session / "metrics.json").read_bytes()
    done = merge(session, path)
    assert done.returncode == 1 and why in done.stderr, done.stderr
    assert (session / "metrics.json").read_bytes() == before


def test_without_a_file_the_one_that_the_session_remembers_is_taken(session, ticks, tmp_path):
    done = merge(session)
    assert done.returncode == 1 and "without RAVEN2_USB_FAULTS_TRUTH" in done.stderr
    stale = write(tmp_path / "stale.json", truth_of(moment(ticks, begin_of(ticks)), None, monotonic_offset_ns=OFFSET + 10**15))
    meta = read(session, "meta.json")
    (session / "meta.json").write_text(json.dumps({**meta, "usb_faults_truth": str(stale)}))
    done = merge(session)
    assert done.returncode == 1 and "none of its 1 injections" in done.stderr, "the commands are not used here"
    path = write(tmp_path / "truth.json", truth_of(moment(ticks, begin_of(ticks)), None))
    for start in ("2023-11-13T22:13:20Z", "2023-11-14T22:13:00Z", "2023-11-15T22:13:20Z"):
        (session / "meta.json").write_text(json.dumps({**meta, "usb_faults_truth": str(path), "start_time_utc": start}))
        done = merge(session)
        assert done.returncode == 1 and "the file is of another start of the computer" in done.stderr, start
        assert not (session / "usb_truth.json").exists()
    (session / "meta.json").write_text(json.dumps({**meta, "usb_faults_truth": str(path), "start_time_utc": START}))
    report = subprocess.run([ROOT / "scripts/session_report", session, "--output", tmp_path / "page.html"],
                            capture_output=True, text=True, check=False, env={**os.environ, "PATH": f"{PROGRAMS}:{os.environ['PATH']}"})
    assert report.returncode == 0, report.stderr
    assert read(session, "faults.json")["injections"], "the report merged it"
    assert "sudden jump" in (tmp_path / "page.html").read_text()


def test_trainee_and_band_given_by_hand_stay(tmp_path):
    session = tmp_path / "session"
    subprocess.run([PROGRAMS / "simulate", "--exercise", "pick_hand_over_place", "--hazard", "none", "--seconds", "4", "--homing", "quick",
                    "--output", session], capture_output=True, check=True)
    band = shutil.copy(ROOT / "config/bands/pick_hand_over_place.yaml", tmp_path / "ours.yaml")
    subprocess.run([PROGRAMS / "score_session", session, "--trainee", "kim", "--band", band], capture_output=True, check=True)
    before = read(session, "score.json")
    ticks = raven2_session.Session(str(session)).log.ticks
    at = begin_of(ticks)
    done = merge(session, write(tmp_path / "truth.json", truth_of(moment(ticks, at), moment(ticks, at + 300))))
    assert done.returncode == 0, done.stderr
    after = read(session, "score.json")
    assert (after["trainee"], after["band"]) == (before["trainee"], before["band"])
    assert before["trainee"] == "kim" and before["band"]["file"] == str(band)
    assert after["hazards"] and not before["hazards"], "scored with the truth"
    score = (session / "score.json").read_bytes()
    pathlib.Path(band).unlink()
    (session / "usb_truth.json").unlink()
    done = merge(session, tmp_path / "truth.json")
    assert done.returncode == 1 and str(band) in done.stderr and "merged, but score.json" in done.stderr
    assert "1 injections act" in done.stdout and (session / "usb_truth.json").exists(), "the merge stays"
    assert (session / "score.json").read_bytes() == score
