"""The program score_session on a session of simulate. Needs both built; skipped where they are not."""
import json
import os
import pathlib
import random
import re
import resource
import subprocess
import sys

import numpy
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
sys.path.insert(0, str(ROOT / "test" / "python"))
import raven2_session  # noqa: E402
from raven2_station import library, records  # noqa: E402
from smoothness_oracle import dimensionless_jerk, spectral_arc_length  # noqa: E402

PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"

pytestmark = pytest.mark.skipif(not (PROGRAMS / "score_session").exists() or not (PROGRAMS / "simulate").exists(),
                                reason="score_session or simulate is not built")


def score(directory, *options):
    return subprocess.run([PROGRAMS / "score_session", directory, *map(str, options)], capture_output=True, text=True,
                          check=False)


@pytest.fixture(scope="module", name="directory")
def session(tmp_path_factory):
    """Twelve seconds with a fault. The scripted surgeon does not react to it."""
    output = tmp_path_factory.mktemp("score") / "first"
    done = subprocess.run([PROGRAMS / "simulate", "--hazard", "sudden_jump", "--seconds", "12", "--homing", "quick",
                           "--output", output],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return output


@pytest.fixture(scope="module", name="result")
def scored(directory):
    done = score(directory)
    assert done.returncode == 0, done.stderr
    return json.loads((directory / "score.json").read_text())


@pytest.fixture(scope="module", name="ticks")
def counted_ticks(directory):
    """The ticks that count, read from the log independently."""
    ticks = raven2_session.Session(directory).log.ticks
    return ticks[ticks["model"]["session_tick"] >= 0]


def sampled_speeds(ticks, arm):
    """Tip speeds [mm/s] of means of ten ticks, an array per press of the pedal. With the pedal up the tip rests."""
    down = ticks["model"]["pedal"] != 0
    newest_down = numpy.maximum.accumulate(numpy.where(down, numpy.arange(len(down)), 0))
    tips = ticks["model"]["arms"][:, arm]["p_BT"][newest_down]
    presses = numpy.nonzero(down[1:] & ~down[:-1])[0] + 1
    pieces = [tips[begin:end] for begin, end in zip((0, *presses), (*presses, len(tips)))]
    means = [piece[:len(piece) // 10 * 10].reshape(-1, 10, 3).mean(axis=1) for piece in pieces]
    return [1000 * numpy.linalg.norm(numpy.diff(mean, axis=0), axis=1) * 100 for mean in means]


def test_figures_are_those_of_an_own_reading_of_the_log(result, ticks):
    (attempt,) = result["attempts"]
    pieces = [sampled_speeds(ticks, arm) for arm in (0, 1)]
    assert len(pieces[0]) > 1, "the surgeon clutched"
    speeds = [numpy.concatenate(own) for own in pieces]
    metrics = {name: metric["value"] for name, metric in attempt["metrics"].items()}
    assert metrics["time"] == pytest.approx(len(ticks) / 1000)
    assert metrics["path"] == pytest.approx(sum(speed.sum() for speed in speeds) / 100, rel=1e-9)
    assert metrics["path"] > 50, "the tips moved"
    assert metrics["idle"] == pytest.approx(numpy.mean(numpy.maximum(*speeds) < 1))
    assert metrics["engaged"] == pytest.approx(numpy.mean(ticks["model"]["pedal"] != 0))
    assert metrics["speed_correlation"] == pytest.approx(numpy.corrcoef(*speeds)[0, 1], rel=1e-9)
    assert attempt["hands"]["gold"]["sparc"] == pytest.approx(spectral_arc_length(speeds[0]), rel=1e-9)
    assert attempt["hands"]["green"]["dlj"] == pytest.approx(dimensionless_jerk(*pieces[1]), rel=1e-9)
    apart = numpy.linalg.norm(ticks["model"]["arms"]["p_BT"] - ticks["robot"]["arms"]["p_BT"], axis=2).max(axis=1)
    linked = (ticks["model"]["linked"] != 0) & (ticks["model"]["robot_fresh"] != 0)
    assert metrics["tracking"] == pytest.approx(1000 * apart[linked].mean(), rel=1e-9)


def test_a_session_without_an_exercise_is_measured_and_not_judged(result):
    assert result["exercise"] is None and result["band"] is None
    (attempt,) = result["attempts"]
    assert attempt["status"] == "none" and attempt["passed"] is None
    assert attempt["metrics"]["drops"]["value"] is None
    assert attempt["metrics"]["sparc"]["value"] < -1.4
    assert 0 < attempt["metrics"]["master_radius"]["value"] < 500
    assert attempt["metrics"]["tracking"]["value"] < 10


def test_the_hazard_is_judged_from_its_injection(directory, result):
    fault = json.loads((directory / "metrics.json").read_text())["faults"][0]
    hazard = result["hazards"][0]
    assert hazard["scenario"] == "sudden_jump"
    assert abs(hazard["injection_tick"] - fault["first_tick"]) <= 5, "[ms] robot's clock, daemon's clock"
    assert hazard["error_mm"] == pytest.approx(fault["max_error_mm"], abs=0.01)
    assert hazard["excursion_mm"] > 3
    assert hazard["injection_tick"] + hazard["force_after_ms"] == pytest.approx(fault["force_tick"], abs=2)
    assert hazard["cue"] == "force"
    assert all(each["after_ms"] < hazard["cue_after_ms"] + 100 for each in hazard["coincidences"])
    assert hazard["reaction"] is None or hazard["reaction"]["after_ms"] >= hazard["cue_after_ms"] + 100


def test_the_same_bytes_come_twice(directory, result, tmp_path):
    assert result["version"] == 1
    assert score(directory, "--output", tmp_path / "again.json").returncode == 0
    assert (tmp_path / "again.json").read_bytes() == (directory / "score.json").read_bytes()


def test_a_trainees_session_is_entered_once(directory, tmp_path):
    index = tmp_path / "index.json"
    for _ in range(2):
        done = score(directory, "--trainee", "kim-01", "--index", index, "--output", tmp_path / "score.json")
        assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "score.json").read_text())["trainee"] == "kim-01"
    (entry,) = json.loads(index.read_text())["sessions"]
    assert (entry["directory"], entry["trainee"], entry["exercise"]) == ("first", "kim-01", "")
    assert entry["start_time_utc"].startswith("20")
    assert entry["attempts"][0]["metrics"]["time"] > 1
    assert score(directory, "--trainee", "Kim", "--index", index, "--output", tmp_path / "kim.json").returncode == 1
    assert not (tmp_path / "kim.json").exists()


def test_a_session_that_is_killed_has_its_start_time(tmp_path):
    """The system kills the program when its log grows beyond 8 MB, after some twelve seconds of the session."""
    most = 8_000_000
    done = subprocess.run([PROGRAMS / "simulate", "--hazard", "none", "--seconds", "60", "--homing", "quick", "--output",
                           tmp_path / "cut"], capture_output=True, text=True, check=False,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)))
    assert done.returncode != 0 and not (tmp_path / "cut" / "metrics.json").exists()
    meta = json.loads((tmp_path / "cut" / "meta.json").read_text())
    assert re.fullmatch(r"20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ", meta["start_time_utc"])
    assert meta["realtime"] == "unknown: not ended cleanly"


def test_a_folder_without_a_session_is_refused(tmp_path):
    done = score(tmp_path)
    assert done.returncode == 1
    assert "session.rlog" in done.stderr


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """A session of a trainee in a curriculum. Each test writes another index for it."""
    output = tmp_path_factory.mktemp("course") / "last"
    done = subprocess.run([PROGRAMS / "simulate", "--curriculum", "frs_basics", "--trainee", "kim-01", "--exercise", "camera_clutch",
                           "--seconds", "3", "--homing", "quick", "--output", output], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return output


@pytest.mark.parametrize("seed", range(6))
def test_the_station_finds_the_stage_that_score_session_finds(course, tmp_path, seed):
    known = library.Library(ROOT).curriculum("frs_basics")
    source, entries = random.Random(seed), []
    for day in range(10, 10 + source.choice((0, 20, 60))):
        at = min(len(known["stages"]) - 1, max(0, (day - 10) // 3 + source.randint(-1, 1)))
        stage = known["stages"][at]
        passed = source.choices((True, False, None), (10, 1, 1))[0]
        entries.append({"directory": f"s{day}", "start_time_utc": f"2020-01-{day}T10:00:00Z", "trainee": source.choices(("kim-01", "bo"), (9, 1))[0],
                        "exercise": stage["exercise"], "drill": "" if stage["drill"] == "none" else stage["drill"],
                        "attempts": [{"status": "done", "passed": passed, "metrics": {}}]})
    source.shuffle(entries)
    index = tmp_path / "index.json"
    index.write_text(json.dumps({"version": 1, "sessions": entries}))
    done = score(course, "--index", index, "--output", tmp_path / "score.json")
    assert done.returncode == 0, done.stderr
    stages, current = records.Records(tmp_path).progress("kim-01", known)
    assert f"{current} of {len(stages)} stages done" in done.stdout
    rows = re.findall(r"^[> ] \w.*: (\d+) of \d+ in a row(?:, (\d+) of \d+ more)?$", done.stdout, re.M)
    found = [(int(in_a_row), int(more or 0)) for in_a_row, more in rows]
    assert found == [(stage.in_a_row, stage.more) for stage in stages]
