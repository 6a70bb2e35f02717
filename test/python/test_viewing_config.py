"""Programs draw a session with the session's own copy of the configuration. Needs the programs built."""
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
FALLBACK = "the packaged configuration instead"

pytestmark = pytest.mark.skipif(not (PROGRAMS / "simulate").exists() or not (PROGRAMS / "render_session").exists(),
                                reason="simulate or render_session is not built")


def run(program, *arguments):
    return subprocess.run([PROGRAMS / program, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False, timeout=300)


def record(directory, *arguments):
    done = run("simulate", "--seconds", 2, "--homing", "quick", "--hazard", "none", "--output", directory, *arguments)
    assert done.returncode == 0, done.stdout
    return directory


def draw(directory, pictures, *arguments):
    return run("render_session", directory, "--size", "128x72", "--inset", "none", "--from", 1, "--to", 1.04,
               "--output", pictures, *arguments)


def test_an_exercise_of_ones_own_is_drawn_without_being_asked_for_its_files(tmp_path):
    config = raven2_lockstep.copy_of_configuration(tmp_path)
    own = exercise("stay", [("gold", "gold", 1.0)], "{time: {}}")
    (tmp_path / "config/exercises/stay.yaml").write_text(own)
    directory = record(tmp_path / "session", "--config", config, "--exercise", "stay")
    shutil.rmtree(tmp_path / "config")  # the configuration of the recording is gone
    done = draw(directory, tmp_path / "pictures")
    assert done.returncode == 0 and FALLBACK not in done.stdout, done.stdout
    assert len(list((tmp_path / "pictures").glob("*.png"))) == 1


def test_a_copy_that_was_altered_is_not_used(tmp_path):
    directory = record(tmp_path / "session")
    done = draw(directory, tmp_path / "whole")
    assert done.returncode == 0 and FALLBACK not in done.stdout, done.stdout
    haptics = next(directory.glob("configuration/**/haptics.yaml"))
    haptics.write_text(haptics.read_text() + "# altered\n")
    done = draw(directory, tmp_path / "altered")
    assert done.returncode == 0 and FALLBACK in done.stdout and "haptics.yaml" in done.stdout, done.stdout
    first, second = (next((tmp_path / name).glob("*.png")).read_bytes() for name in ("whole", "altered"))
    assert first == second
