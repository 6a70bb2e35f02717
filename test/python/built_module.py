"""The module raven2_trainer of this build, for its tests. Skips the file that imports it if the module is not built."""

import os
import pathlib
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
sys.path.insert(0, str(BUILD / "devel/lib/python3/dist-packages"))
raven2_trainer = pytest.importorskip("raven2_trainer._core", reason="the module is not built") and __import__("raven2_trainer")

PICK = "pick_hand_over_place"


def numbers(simulation):
    """All values of a state, as bytes."""
    s = simulation.state
    return b"".join(np.ascontiguousarray(a).tobytes() for a in (
        s.joints, s.joint_rates, s.torques, s.desired_joints, s.tips, s.robot_joints, s.dac, s.force, s.objects, s.true_joints)) + str(
            (s.tick, s.mode, s.runlevel, s.exercise)).encode()
