"""Tests of scripts/tune_model, scripts/raven2_tuning.py and the program model_follow.

One test measures how well the shipped model follows the real robot. It needs RAVEN2_TRAINER_DATA, the folder of
gold_arm_dac_motor_a.csv, and is skipped without it: no recording is shipped.
"""

import importlib.machinery
import importlib.util
import os
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
sys.dont_write_bytecode = True

import raven2_tuning as tuning  # noqa: E402

TUNE_MODEL = ROOT / "scripts/tune_model"
MODEL_FOLLOW = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer/model_follow"
RECORDING = pathlib.Path(os.environ.get("RAVEN2_TRAINER_DATA", "/nonexistent")) / "gold_arm_dac_motor_a.csv"
needs_program = pytest.mark.skipif(not MODEL_FOLLOW.exists(), reason="model_follow is not built")


def tune_model():
    loader = importlib.machinery.SourceFileLoader("tune_model", str(TUNE_MODEL))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("tune_model", loader))
    loader.exec_module(module)
    return module


def synthetic_recording():
    """Motors that lag behind their desired positions, and the DAC of the control law in raven2.md 3.1, 3.4, 3.6."""
    t = np.arange(3000) * 1e-3
    desired = np.column_stack([70 + 3 * np.sin(2 * t), 195 + 5 * np.sin(1.5 * t), 903 + 4 * np.cos(t)])
    motor = np.column_stack([70 + 3 * np.sin(2 * t - 0.1), 195 + 5 * np.sin(1.5 * t - 0.1), 903 + 4 * np.cos(t - 0.1)])
    rate = np.vstack([np.zeros(3), np.diff(motor, axis=0)]) / 1e-3
    tau = np.array([0.3, 0.3, 0.15]) * (desired - motor) - np.array([0.008, 0.008, 0.012]) * rate
    return desired, motor, rate, tau


def dac(tau):
    return np.trunc(tau / (-0.738675) * 2730)  # positioning axes of the gold arm: negative


def test_desired_positions_come_back_from_the_dac():
    desired, motor, rate, tau = synthetic_recording()
    found = tuning.desired_motor(tuning.Recording(motor, rate, dac(tau)), with_gravity=False)
    one_count = 1.0 / 3695.8 / np.array([0.3, 0.3, 0.15])
    assert (np.abs(found - desired) <= 1.01 * one_count).all()


def test_gravity_compensation_is_taken_out_of_the_dac():
    desired, motor, rate, tau = synthetic_recording()
    home = np.array([[np.radians(30), np.radians(90), 0.40]])
    motor = motor - motor[0] + tuning.to_motor(home)
    desired = desired + motor[0] - synthetic_recording()[1][0]
    tau = tau + tuning.gravity_compensation(tuning.to_joint(motor))
    recording = tuning.Recording(motor, rate, dac(tau))
    assert np.abs(tuning.desired_motor(recording, with_gravity=True) - desired).max() < 0.002
    assert np.abs(tuning.desired_motor(recording, with_gravity=False) - desired).max() > 0.1


def test_coupling_is_that_of_the_robot():
    # raven2.md 3.3 prints both
    A = [[136.196255, 0, 0], [17.675386, 121.522075, 0], [16.831355, 17.435769, 2158.590308]]
    inverse = [[7.3423458e-3, 0, 0], [-1.0679442e-3, 8.2289576e-3, 0], [-4.8624881e-5, -6.6468475e-5, 4.6326531e-4]]
    np.testing.assert_allclose(tuning.coupling(), A, rtol=1e-6)
    np.testing.assert_allclose(tuning.to_joint(np.eye(3)).T, inverse, rtol=1e-6, atol=1e-12)


def test_tip_is_where_the_robot_has_it():
    # raven2.md 2.4: home; shoulder 0, elbow 45 deg, 0.30 m (tool joints at zero in both)
    joints = np.array([[np.radians(30), np.radians(90), 0.40], [0.0, np.radians(45), 0.30]])
    expected = [[-0.077947, -0.025266, 0.013226], [-0.149561, 0.079456, -0.069334]]
    np.testing.assert_allclose(tuning.tips(joints), expected, atol=1e-6)


def test_gravity_compensation_is_what_the_running_software_sends():
    # raven2.md 3.8: DACs 45, 159, -44 at home, truncated
    home = np.array([[np.radians(30), np.radians(90), 0.40]])
    np.testing.assert_array_equal(dac(tuning.gravity_compensation(home)), [[45, 159, -44]])


def test_low_pass_keeps_a_constant_and_delays_a_ramp():
    ramp = np.arange(400.0)[:, None] * np.ones(2)
    filtered = tuning.low_pass(ramp)
    # group delay at rest: (sum i b_i + sum i a_i) / (1 - sum a_i), from the coefficients of raven2.md 3.7
    delay = (0.08591 + 2 * 0.08591 + 3 * 0.02864 + 1.5189 - 2 * 0.96 + 3 * 0.212) / (1 - 1.5189 + 0.96 - 0.212)
    np.testing.assert_allclose(ramp[-1] - filtered[-1], delay, rtol=1e-3)
    np.testing.assert_allclose(tuning.low_pass(np.full((50, 1), 3.0)), 3.0, rtol=2e-3)


def test_delay_is_found_to_a_fraction_of_a_row():
    t = np.arange(4000) * 1e-3
    assert tuning.delay(np.sin(5 * t), np.sin(5 * (t - 0.0123))) == pytest.approx(12.3, abs=0.05)
    assert tuning.delay(np.sin(5 * t), np.sin(5 * (t + 0.0123))) == pytest.approx(-12.3, abs=0.05)


def test_regression_finds_the_motor_it_was_made_with():
    t = np.arange(8000) * 1e-3
    rate = np.column_stack([20 * np.sin(k * t) + 9 * np.sin(2.7 * k * t) for k in (3.0, 2.0, 2.5)])
    acceleration = np.gradient(rate, 1e-3, axis=0)
    tau = 3e-4 * acceleration + 0.002 * rate + 0.06 * np.sign(rate) + 0.03
    recording = tuning.Recording(np.cumsum(rate, axis=0) * 1e-3, rate, dac(tau))
    inertia, viscous, coulomb, load, explained = tuning.identify(recording, slice(100, -100))
    np.testing.assert_allclose(inertia, 3e-4, rtol=0.03)
    np.testing.assert_allclose(viscous, 0.002, rtol=0.05)  # smoothing blurs the reversals
    np.testing.assert_allclose(coulomb, 0.06, rtol=0.03)
    np.testing.assert_allclose(load, 0.03, rtol=0.03)
    assert (explained > 0.98).all()


def test_configuration_gets_the_parameters_and_gives_them_back():
    module = tune_model()
    text = (ROOT / "config/model.yaml").read_text()
    parameters = {"viscous": np.array([0.001, 0.002, 0.003]), "coulomb": np.array([0.0, 0.05, 0.06])}
    changed = module.with_parameters(text, parameters, False)
    back = module.shipped_parameters(changed)
    for key, values in parameters.items():
        np.testing.assert_allclose(back[key], values, rtol=1e-3)
    assert "gravity_compensation: false" in changed
    assert len(changed.splitlines()) == len(text.splitlines())


def run(program, *arguments):
    return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=300)


def test_without_a_recording_it_says_so_and_passes(tmp_path):
    done = run(TUNE_MODEL, tmp_path / "none.csv", "--output", tmp_path / "out")
    assert done.returncode == 0
    assert "skipped: there is no recording" in done.stdout
    assert not (tmp_path / "out").exists()


@needs_program
@pytest.mark.parametrize("line, said", [("1,2,3", "4: expected 9 numbers"), ("1,2,3,4,5,6,7,8,nan", "4: not a finite")])
def test_a_bad_row_of_a_recording_is_named(tmp_path, line, said):
    path = tmp_path / "bad.csv"
    path.write_text("\n".join([",".join(tuning.COLUMNS), *["0,0,0,0,0,0,0,0,0"] * 2, line]) + "\n")
    done = run(TUNE_MODEL, path, "--output", tmp_path)
    assert done.returncode == 1
    assert f"bad.csv:{said}" in done.stderr


# ---- model_follow ----------------------------------------------------------------------------------------------------


HEADER = ",".join(f"q{j}_d" for j in range(1, 8))
HOME = "0.5235987755982988,1.5707963267948966,0.4,0,0,0.7853981633974483,0.7853981633974483"


@needs_program
@pytest.mark.parametrize("text, said", [
    (HEADER.replace("q3_d", "z") + f"\n{HOME}\n", r":1: column q3_d is missing"),
    (f"{HEADER}\n{HOME}\n0,0,0\n", r":3: 3 cells, expected 7"),
    (f"{HEADER}\n{HOME.replace('0.4', 'x')}\n", r':2: q3_d is "x", expected a number'),
    (f"{HEADER}\n", r": no rows below the header"),
])
def test_model_follow_names_what_is_wrong(tmp_path, text, said):
    (tmp_path / "desired.csv").write_text(text)
    done = run(MODEL_FOLLOW, "--desired", tmp_path / "desired.csv", "--out", tmp_path / "states.csv")
    assert done.returncode == 2
    assert re.search("desired.csv" + said, done.stderr)


@needs_program
def test_model_follow_refuses_other_arms_and_missing_files(tmp_path):
    assert run(MODEL_FOLLOW, "--arm", "blue", "--desired", "x", "--out", "y").returncode not in (0, 1)
    done = run(MODEL_FOLLOW, "--desired", tmp_path / "none.csv", "--out", tmp_path / "states.csv")
    assert done.returncode == 2 and "none.csv" in done.stderr
    (tmp_path / "desired.csv").write_text(f"{HEADER}\n{HOME}\n")
    done = run(MODEL_FOLLOW, "--desired", tmp_path / "desired.csv", "--out", tmp_path / "no/states.csv")
    assert done.returncode == 1 and "cannot be written" in done.stderr


@needs_program
@pytest.mark.parametrize("arm", ["gold", "green"])
def test_model_follow_lags_a_ramp_as_its_gains_say(tmp_path, arm):
    t = np.arange(1500)[:, None] * 1e-3
    speeds = np.array([0.1, -0.1, 0.01, 0.3, 0.15, 0.15, -0.1])
    start = np.array([float(value) for value in HOME.split(",")])
    desired = start + speeds * t
    np.savetxt(tmp_path / "desired.csv", desired, fmt="%.17g", delimiter=",", header=HEADER, comments="")
    done = run(MODEL_FOLLOW, "--arm", arm, "--desired", tmp_path / "desired.csv", "--out", tmp_path / "states.csv")
    assert done.returncode == 0, done.stderr
    states = np.genfromtxt(tmp_path / "states.csv", delimiter=",", names=True)
    assert len(states) == 1500
    assert states.dtype.names == tuple(f"{name}{j}" for name in ("q", "dq", "tau") for j in range(1, 8))
    np.testing.assert_allclose([states[f"q{j}"][0] for j in range(1, 8)], start, atol=1e-12)
    np.testing.assert_allclose([states[f"dq{j}"][-1] for j in range(1, 8)], speeds, rtol=0.03)
    # kp e = (kd + viscous) v + Coulomb, numbers of config/model.yaml
    lag = desired[-1, 0] - states["q1"][-1]
    assert lag == pytest.approx(((12.11 + 3.74) * 0.1 + 0.464) / 454.3, rel=0.02)


# ---- against the real robot ------------------------------------------------------------------------------------------


@needs_program
@pytest.mark.skipif(not RECORDING.exists(), reason="RAVEN2_TRAINER_DATA names no folder with gold_arm_dac_motor_a.csv")
def test_the_shipped_model_follows_the_real_robot(tmp_path):
    done = run(TUNE_MODEL, RECORDING, "--evaluate", "--output", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "low-pass: on" in done.stdout and "gravity compensation: off" in done.stdout
    lines = [line.split("|") for line in done.stdout.splitlines()]
    rows = {cells[1].strip(): cells for cells in lines if len(cells) > 6}
    tip = {name: float(cells[5].split("+-")[0]) for name, cells in rows.items() if "+-" in cells[5]}
    model = tip["model, config/model.yaml"]
    assert model < 2.43  # [mm] the paper's model against its robot, figure 4: 2.43 +- 1.72
    assert model < 0.7 * tip["model, before the tuning"]
    assert model < tip["constant velocity, 100 ms ahead"]
    assert model < 0.1 * tip["robot stands still"]
    assert (tmp_path / "model_tuning.png").stat().st_size > 10000
