"""Figures of a session that simulate made. The session has a planned motion."""
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import forked  # noqa: E402
import raven2_figures  # noqa: E402
import raven2_kinematics  # noqa: E402
import raven2_session  # noqa: E402

SIMULATE = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer/simulate"

pytestmark = pytest.mark.skipif(not SIMULATE.exists(), reason="simulate is not built")


@pytest.fixture(scope="module", name="directory")
def make_session(tmp_path_factory):
    output = tmp_path_factory.mktemp("figures") / "session"
    done = subprocess.run([SIMULATE, "--seconds", "30", "--hazard", "none", "--homing", "quick", "--seed", "3", "--output",
                           output], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return output


@pytest.fixture(scope="module", name="series")
def read_series(directory):
    return raven2_figures.Series(raven2_session.Session(directory))


def test_forward_kinematics_is_that_of_the_log(series):
    for arm in (0, 1):
        pose = raven2_kinematics.forward(arm, series.q_model[::1000, arm], series.header["d4"], 0.013)
        assert np.allclose(pose[:, :3, 3], series.p_model[::1000, arm], atol=1e-12)


def test_the_planned_motion_begins_and_ends_where_its_track_does(series):
    motion = series.longest_tracking()
    assert motion["arm"] == "gold"
    for end in (0, -1):
        assert np.linalg.norm(motion["plan"][end] - motion["track"][end]) < 1e-3
    # Each mark of the track is near the planned line, and the user's own motion ends where the plan begins.
    apart = np.linalg.norm(motion["track"][:, None] - motion["plan"][None], axis=2).min(axis=1)
    assert apart.max() < 3e-3
    assert np.linalg.norm(motion["user"][-1] - motion["plan"][0]) < 3e-3
    assert np.linalg.norm(motion["plan"][0] - motion["plan"][-1]) > 1e-2, "the planned motion is long"


def test_a_planned_motion_of_the_green_arm_has_green_s_track(directory):
    session = raven2_session.Session(directory)
    session.log.plans = session.log.plans.copy()
    session.log.plans["result"]["arm"] = 1
    series = raven2_figures.Series(session)
    motion = series.longest_tracking()
    first, last = max(raven2_figures.runs(series.tracking), key=lambda span: span[1] - span[0])
    assert motion["arm"] == "green"
    assert np.array_equal(motion["track"], series.p_model[first:last + 1:raven2_figures.PATH_STEP, 1])


@pytest.mark.parametrize("part, field", [("model", "robot_fresh"), ("model", "linked"), ("robot", "frame")])
def test_without_a_fresh_linked_robot_there_is_no_error(part, field, directory, series):
    """A robot that is not heard any more keeps its last pose in the log."""
    session = raven2_session.Session(directory)
    session.log.ticks = session.log.ticks.copy()
    before = int(np.argmax(session.log.ticks["model"]["session_tick"] >= 0))
    lost = np.flatnonzero(np.isfinite(series.error_mm[:, 0]))[1000:1500]
    session.log.ticks[part][field][before + lost] = 0
    expected = series.error_mm.copy()
    expected[lost] = np.nan
    assert np.array_equal(raven2_figures.Series(session).error_mm, expected, equal_nan=True)


def test_a_session_with_a_plan_has_its_figure(directory, tmp_path):
    done = forked.run(ROOT / "scripts/plot_session", directory, "--output", tmp_path)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in tmp_path.glob("*.png")} == {f"{name}.png" for name in raven2_figures.FIGURES
                                                              if name != "timing"}
