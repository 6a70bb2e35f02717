"""Knowledge of tune_model about the robot: its control law, cables, gravity compensation and filter, and how a recording of
its motors is turned into desired positions and parameters. Arrays have one row a millisecond and a column for each of
shoulder, elbow and insertion; motor angles in rad, joints in rad and m, torques in Nm at the capstan.

Sources: raven2 (uw-biorobotics) and raven2_sim (DEPEND), files and lines in doc/model.md.
"""

import csv

import numpy as np

from raven2_kinematics import forward, link

PERIOD = 1e-3  # [s]
GEAR = 49.0 / 4.0
TRANSMISSION = np.array([136.19625551, 121.52207496, 2158.59030837])  # [rad/rad, rad/rad, rad/m]
C01, C02, C12 = 0.14545, 0.0077973826, 0.008077387  # [rad/rad, m/rad, m/rad] cable coupling
KP = np.array([0.300, 0.300, 0.150])  # [Nm/rad] r2params.yaml, both programs
KD = np.array([0.008, 0.008, 0.012])  # [Nms/rad] gold
COUNTS_PER_NM = 2730 / 0.738675
GOLD_SIGN = -1.0  # of a DAC count's torque
HOME_TOOL = np.array([0.0, 0.0, np.pi / 4, np.pi / 4])  # roll, wrist, jaws [rad]

VISCOUS_TO_JOINT = TRANSMISSION**2 / GEAR  # capstan Nms per motor rad -> Nms per joint rad, Ns/m
TORQUE_TO_JOINT = TRANSMISSION / GEAR

# Columns of a recording: motor positions and velocities [deg, deg/s], DAC [counts], axes 1 to 3 of the gold arm.
COLUMNS = [f"{name}{axis}{unit}" for name, unit in (("mpos", "_deg"), ("mvel", "_deg_s"), ("dac", ""))
           for axis in (1, 2, 3)]


class TuningError(Exception):
    """A recording or a run of the model cannot be used; the message says where and why."""


class Recording:
    """Motor angles [rad], rates [rad/s] and DAC [counts] of the gold arm's axes 1 to 3, as its software had them."""

    def __init__(self, motor, rate, dac):
        self.motor, self.rate, self.dac = motor, rate, dac


def read_recording(path):
    rows = []
    with open(path, newline="") as file:
        reader = csv.reader(file)
        header = next(reader, None)
        if header is None or any(name not in header for name in COLUMNS):
            raise TuningError(f"{path}:1: expected the columns {', '.join(COLUMNS)}")
        places = [header.index(name) for name in COLUMNS]
        for number, row in enumerate(reader, start=2):
            try:
                values = [float(row[place]) for place in places]
            except (ValueError, IndexError):
                raise TuningError(f"{path}:{number}: expected {len(header)} numbers") from None
            if not np.isfinite(values).all():
                raise TuningError(f"{path}:{number}: not a finite number")
            rows.append(values)
    if len(rows) < 1000:
        raise TuningError(f"{path}: {len(rows)} rows, expected 1000 or more (1 s)")
    table = np.array(rows)
    return Recording(np.radians(table[:, 0:3]), np.radians(table[:, 3:6]), table[:, 6:9])


# ---- cables and kinematics -------------------------------------------------------------------------------------------


def coupling():
    """A of motor = A joint."""
    return TRANSMISSION[:, None] * np.array([[1.0, 0.0, 0.0], [C01, 1.0, 0.0], [C02, C12, 1.0]])


def to_motor(joint):
    return joint @ coupling().T


def to_joint(motor):
    return motor @ np.linalg.inv(coupling()).T


def _gold_frames(joint):
    """DH frames 1 to 3 of the gold arm in its base frame."""
    first = link(0, 0, joint[:, 0] + np.radians(205), 0)
    second = first @ link(np.radians(75), 0, joint[:, 1] + np.pi, 0)
    return first, second, second @ link(np.radians(128), 0, np.full(len(joint), np.pi / 2), joint[:, 2])


def tips(joint):
    """Tool tip [m] of the gold arm in its base frame, the tool joints at home, jaws together."""
    return forward(0, np.pad(joint, ((0, 0), (0, 4))), -0.47, 0.013)[:, :3, 3]


def gravity_compensation(joint):
    """Capstan torques that the robot's software adds against gravity when that is switched on (grav_comp.cpp)."""
    masses = (0.494, 0.750, 0.231)
    centres = ((0.0065, 0.09775, -0.13771, 1.0), (-0.002, -0.18274, -0.23053, 1.0), (0.0, 0.0, 0.0, 1.0))
    frames = _gold_frames(joint)
    torque = np.zeros((len(joint), 3))
    moment = np.zeros((len(joint), 3))
    for j in (2, 1, 0):
        weight = masses[j] * np.array([-9.8, 0.0, 0.0])
        moment = moment + np.cross((frames[j] @ np.array(centres[j]))[:, :3], weight)
        axis = frames[j][:, :3, 2]
        load = axis @ weight if j == 2 else np.einsum("ki,ki->k", axis, moment)
        torque[:, j] = -load / TORQUE_TO_JOINT[j]
    return torque


def low_pass(x):
    """The software's 3rd-order Butterworth, "120 Hz" (state_estimate.cpp), at rest on the first row before it."""
    b, a = (0.02864, 0.08591, 0.08591, 0.02864), (1.5189, -0.9600, 0.2120)
    y = np.empty_like(x)
    for k in range(len(x)):
        past = [x[max(k - i, 0)] for i in range(4)]
        out = [y[k - i] if k >= i else x[0] for i in (1, 2, 3)]
        y[k] = sum(c * v for c, v in zip(b, past)) + sum(c * v for c, v in zip(a, out))
    return y


# ---- the control law, inverted ---------------------------------------------------------------------------------------


def torque_of(dac):
    """Capstan torque that the gold arm's software asked for."""
    return GOLD_SIGN * dac / COUNTS_PER_NM


def desired_motor(recording, with_gravity):
    """Desired motor angles from tau = kp (desired - motor) - kd rate (+ gravity compensation)."""
    torque = torque_of(recording.dac)
    if with_gravity:
        torque = torque - gravity_compensation(to_joint(recording.motor))
    return recording.motor + (torque + KD * recording.rate) / KP


def on_encoder_grid(recording):
    """Share of the changes of position that are whole encoder counts: near 1 for raw counts, near 0 after a filter."""
    changes = np.diff(recording.motor, axis=0)
    counts = changes[changes != 0.0] / (2.0 * np.pi / 4000)
    return float(np.mean(np.abs(counts - np.rint(counts)) < 0.01))


def damping_seen(recording):
    """kd as the changes of DAC from row to row show it: least absolute deviations, since most rows have no new packet
    and hence an unchanged desired position. So kp is under-estimated, as the desired position moves on."""
    gains = np.empty((2, 3))
    for j in range(3):
        y = np.diff(torque_of(recording.dac[:, j]))
        X = np.column_stack([np.diff(recording.motor[:, j]), np.diff(recording.rate[:, j])])
        weight = np.ones(len(y))
        for _ in range(60):
            solution = np.linalg.lstsq(X * weight[:, None], y * weight, rcond=None)[0]
            weight = 1.0 / np.sqrt(np.maximum(np.abs(y - X @ solution), 1e-4))
        gains[:, j] = -solution
    return gains


def error_at_start(recording, with_gravity):
    """[motor rad] mean |desired - measured| while no motor has moved yet: next to nothing for the right law, because
    the software puts the desired position on the arm until the pedal goes down."""
    moving = np.flatnonzero(np.any(recording.rate != 0.0, axis=1))
    end = max(int(moving[0]) if len(moving) else len(recording.rate), 1)
    still = Recording(recording.motor[:end], recording.rate[:end], recording.dac[:end])
    return np.abs(desired_motor(still, with_gravity) - still.motor).mean(axis=0)


def identify(recording, rows):
    """Regression of each motor's torque on its motion over `rows`: inertia [capstan Nm per motor rad/s2, the links
    included], viscous [Nms/rad], Coulomb [Nm], load [Nm], and the share of variance explained, by axis."""
    smooth = np.ones(21) / 21.0  # the same for torque and motion, or it would look like a delay
    result = np.empty((5, 3))
    for j in range(3):
        smoothed = np.convolve(recording.rate[:, j], smooth, "same")
        rate, acceleration = smoothed[rows], np.gradient(smoothed, PERIOD)[rows]
        torque = np.convolve(torque_of(recording.dac[:, j]), smooth, "same")[rows]
        moves = np.abs(rate) > 0.3  # [rad/s] below it dry friction has any value
        X = np.column_stack([acceleration, rate, np.sign(rate), np.ones_like(rate)])[moves]
        solution = np.linalg.lstsq(X, torque[moves], rcond=None)[0]
        rest = torque[moves] - X @ solution
        result[:4, j], result[4, j] = solution, 1.0 - rest.var() / torque[moves].var()
    return result


# ---- how well one motion follows another -----------------------------------------------------------------------------


def rms(x):
    return np.sqrt(np.mean(np.square(x), axis=0))


def delay(leader, follower, longest=200):
    """[ms] by which `follower` lags: the shift of least squared difference, to a fraction of a row by a parabola."""
    shifts = np.arange(-longest, longest + 1)
    middle = leader[longest:-longest]
    costs = np.array([np.mean((follower[longest + s:len(follower) - longest + s] - middle) ** 2) for s in shifts])
    k = int(np.clip(np.argmin(costs), 1, len(costs) - 2))
    left, here, right = costs[k - 1:k + 2]
    bend = left - 2.0 * here + right
    return float(shifts[k] + (0.5 * (left - right) / bend if bend > 0.0 else 0.0))


def constant_velocity(motor, rate, horizon=100):
    """Motor angles predicted `horizon` rows ahead from the one-sample velocity, aligned with those that came."""
    return motor[:-horizon] + horizon * PERIOD * rate[:-horizon], motor[horizon:]
