"""A session as JIGSAWS kinematics: text, 30 Hz, 76 columns (Gao et al. 2014): master left 1-19, right 20-38, slave
left 39-57, slave right 58-76; each x y z, rotation row by row, linear velocity, angular velocity, gripper. Left is the
gold arm. And its labels: `first last NAME`, frames from 1, from the exercise's steps."""

import numpy as np

from raven2_exports import episode
from raven2_report import scene

RATE = 30.0  # [Hz]
COLUMNS = 76
HALF = 5  # [ticks] to both sides, over which velocities are taken: 10 ms, against the noise of single ticks
GRASP = (5, 6)  # of the seven joints; their sum is the opening of the jaws


def frame_ticks(series):
    """Index of the tick nearest to each frame, k / 30 s."""
    count = int(np.floor(series.t[-1] * RATE + 1e-9)) + 1
    wanted = np.arange(count) / RATE
    after = np.searchsorted(series.t, wanted).clip(1, len(series.t) - 1)
    nearer = np.abs(series.t[after - 1] - wanted) <= np.abs(series.t[after] - wanted)
    return np.where(nearer, after - 1, after)


def rotations(q):
    """Rotation matrices of unit quaternions x y z w, along the first axis."""
    return np.array([scene.from_quaternion(each) for each in q])


def angular_velocity(before, after, seconds):
    """[rad/s] that rotates `before` into `after` in that time, in the frame that both are seen from."""
    turn = np.einsum("nij,nkj->nik", after, before)
    axis = np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]],
                    axis=1)
    sine = np.linalg.norm(axis, axis=1) / 2
    angle = np.arctan2(sine, (np.trace(turn, axis1=1, axis2=2) - 1) / 2)
    factor = np.where(sine > 1e-12, angle / np.maximum(2 * sine, 1e-300), 0.5)
    return axis * (factor / seconds)[:, None]


def master_turns(log, ticks):
    """Orientation of each master at these ticks: all its increments up to there, from none; (ticks, 2, 3, 3)."""
    result = np.tile(np.eye(3), (len(ticks), 2, 1, 1))
    if "command" not in (log.commands.dtype.names or ()) or "dq_I" not in log.commands["command"].dtype.names:
        return result
    commands = episode.of_hands(log.commands)
    for arm in (0, 1):
        R, at = np.eye(3), 0
        for i, end in enumerate(np.searchsorted(commands["tick"], ticks, side="right")):
            for q in commands["command"]["dq_I"][at:end, arm]:
                if q[3] != 1.0:
                    R = scene.from_quaternion(q) @ R
            at = end
            U, _, V = np.linalg.svd(R)  # a million products stay a rotation
            R = U @ V
            result[i, arm] = R
    return result


def block(p, R, v, w, gripper):
    return np.concatenate([p, R.reshape(len(R), 9), v, w, gripper[:, None]], axis=1)


def kinematics(log, series, bases):
    """(frames, 76). Masters: the hands in ITP axes I, from where they were at first; slaves: tool tips in W."""
    model = series.ticks["model"]
    frames = frame_ticks(series)
    low, high = np.maximum(frames - HALF, 0), np.minimum(frames + HALF, len(model) - 1)
    seconds = np.maximum((model["tick"][high] - model["tick"][low]) / 1000.0, 1e-3)
    scale = log.header.get("motion_scale") or 1.0
    wanted, where = np.unique(np.stack([model["tick"][index] for index in (low, frames, high)]), return_inverse=True)
    turns = master_turns(log, wanted)[where.reshape(3, -1)]
    blocks = []
    for arm in (0, 1):
        hand = model["master_I"][:, arm] / scale
        opening = model["arms"]["q_d"][:, arm][:, GRASP].sum(axis=1)
        blocks.append(block(hand[frames], turns[1][:, arm], (hand[high] - hand[low]) / seconds[:, None],
                            angular_velocity(turns[0][:, arm], turns[2][:, arm], seconds), opening[frames]))
    for arm, (R_WB, p_WB) in enumerate(bases):
        state = model["arms"][:, arm]
        R = [R_WB @ rotations(state["q_BT"][index]) for index in (low, frames, high)]
        blocks.append(block(state["p_BT"][frames] @ R_WB.T + p_WB, R[1], state["v_BT"][frames] @ R_WB.T,
                            angular_velocity(R[0], R[2], seconds), state["q"][frames][:, GRASP].sum(axis=1)))
    return np.concatenate(blocks, axis=1)


def labels(steps, count):
    """[(first, last, name)] in frames from 1 to `count`; a step that is shorter than a frame still has one."""
    found = []
    for step in steps:
        first = min(int(np.ceil(step["from_s"] * RATE - 1e-9)) + 1, count)
        last = min(max(int(np.ceil(step["to_s"] * RATE - 1e-9)), first), count)
        found.append((first, last, step["name"].replace(" ", "_")))
    return found


def write(facts, bases, path, labels_path):
    """Number of frames written."""
    table = kinematics(facts.log, facts.series, bases)
    np.savetxt(path, table, fmt="%.9f", delimiter=" ")
    with open(labels_path, "w", encoding="utf-8") as file:
        file.writelines(f"{first} {last} {name}\n" for first, last, name in labels(facts.steps, len(table)))
    return len(table)
