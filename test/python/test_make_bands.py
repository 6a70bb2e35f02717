"""scripts/make_bands with a stub in place of simulate, which writes the same files."""
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

yaml = pytest.importorskip("yaml")

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "make_bands"

STUB = """#!/usr/bin/python3
import json, pathlib, sys
options = dict(zip(sys.argv[1::2], sys.argv[2::2]))
assert options["--motion"] == "expert" and options["--drill"] == "none"
seed, folder = int(options["--seed"]), pathlib.Path(options["--output"])
if seed == 9:
    sys.exit("no pedal-down before the start time-out")
folder.mkdir(parents=True)
(folder / "session.rlog").write_text("a log")
time = {"value": 40.0 + seed, "unit": "s", "better": "lower", "scored": True}
attempt = {"status": "done" if seed != 8 else "failed", "failure": "none" if seed != 8 else "mistakes",
           "metrics": {"time": time}}
first = [{**attempt, "status": "failed", "failure": "mistakes"}] if seed == 4 else []
(folder / "score.json").write_text(json.dumps({"version": 1, "exercise": options["--exercise"], "hazards": [],
                                               "attempts": first + [attempt]}))
"""


@pytest.fixture(name="build")
def build_with_stub(tmp_path):
    program = tmp_path / "build/devel/lib/raven2_trainer/simulate"
    program.parent.mkdir(parents=True)
    program.write_text(STUB)
    program.chmod(0o755)
    return tmp_path / "build"


def run(build, *arguments):
    return subprocess.run([sys.executable, str(SCRIPT), *map(str, arguments)], capture_output=True, text=True,
                          check=False, env={**os.environ, "RAVEN2_TRAINER_BUILD": str(build)})


def test_a_band_of_what_was_done(build, tmp_path):
    done = run(build, "peg_transfer", "camera_clutch", "--seeds", "1-3,8,9", "--output", tmp_path / "bands")
    assert done.returncode == 0, done.stderr
    assert "peg_transfer: 3 of 5 done, band written" in done.stdout
    band = yaml.safe_load((tmp_path / "bands/camera_clutch.yaml").read_text())
    assert band["origin"] == "scripted expert of raven2_trainer, seeds 1-3,8,9, not surgeons"
    assert band["sessions"] == 3
    assert band["metrics"]["time"]["mean"] == 42.0
    assert "10/10" in done.stderr and "peg_transfer 8: failed (mistakes) in 48.0 s" in done.stderr
    assert "no pedal-down" in done.stderr


def test_an_installed_one_finds_programs_and_exercises_where_they_are_installed(tmp_path):
    programs, share = tmp_path / "lib/raven2_trainer", tmp_path / "share/raven2_trainer"
    programs.mkdir(parents=True)
    (share / "config/exercises").mkdir(parents=True)
    (share / "config/exercises/only_one.yaml").write_text("number: 1\n")
    for name in ("make_bands", "make_expert_band", "raven2_progress.py", "raven2_lockstep.py", "raven2_session.py",
                 "raven2_formulas.py"):
        shutil.copy(SCRIPT.parent / name, programs)
    (programs / "simulate").write_text(STUB)
    (programs / "simulate").chmod(0o755)
    done = subprocess.run([sys.executable, str(programs / "make_bands"), "--seeds", "1-2"], capture_output=True,
                          text=True, check=False, env={**os.environ, "RAVEN2_TRAINER_BUILD": str(tmp_path / "none")})
    assert done.returncode == 0, done.stderr
    assert (share / "config/bands/only_one.yaml").exists()


def test_without_two_that_were_done_there_is_no_band(build, tmp_path):
    done = run(build, "peg_transfer", "--seeds", "7-9", "--output", tmp_path / "bands")
    assert done.returncode == 1
    assert "peg_transfer: 1 of 3 done, NO BAND" in done.stdout
    assert not list((tmp_path / "bands").iterdir())


def test_a_session_is_done_whose_last_attempt_was(build, tmp_path):
    done = run(build, "peg_transfer", "--seeds", "2-4", "--output", tmp_path / "bands")
    assert done.returncode == 0, done.stderr
    assert "peg_transfer: 3 of 3 done, band written" in done.stdout


def test_sessions_are_kept_where_asked_and_else_removed(build, tmp_path):
    kept = tmp_path / "kept"
    assert run(build, "peg_transfer", "--seeds", "1,2", "--output", tmp_path, "--keep", kept).returncode == 0
    assert sorted(path.name for path in kept.iterdir()) == ["peg_transfer_1", "peg_transfer_2"]
    assert (kept / "peg_transfer_1/session.rlog").exists()


def test_an_exercise_that_is_not_there_is_refused_by_name(build):
    done = run(build, "peg_transfers")
    assert done.returncode == 1
    assert "no exercise is called peg_transfers; known: ring_tower_transfer, pick_hand_over_place" in done.stderr
