#!/usr/bin/env python3
"""Clones the scripted expert in raven2_trainer/PickRing-v0: a network of scikit-learn learns from the expert's sessions, then tries
50 seeds that it has not seen.

    /usr/bin/python3 -m venv --system-site-packages ENV && ENV/bin/pip install gymnasium==1.4.0 scikit-learn==1.9.1
    ENV/bin/python doc/examples/clone_pick_ring.py        # half a minute on two cores

The network learns where the expert will be in 0.2 s, not the expert's speed: that is 0 before and after each motion, and a network
that learned it would stay there. It also learns from poses next to the path, so that it comes back to it.
"""

import argparse
import collections
import concurrent.futures
import os
import time

import gymnasium
import numpy as np
from sklearn.neural_network import MLPRegressor

import raven2_trainer
from raven2_trainer.gym import MOVE, OPEN, TICKS, TURN

AHEAD = 10                        # [steps] how far the network looks into the future
BESIDE = 8                        # poses next to the path, for each pose on it
AWAY, TURNED = 0.006, 0.1         # [m, rad] largest distance of these poses from the path, along and about each axis
FAR, CLOSE = 0.015, 0.1           # [m, -] from FAR to the grip that distance falls to this share
OPEN_FOR_GRIP, CLOSING = 0.81, 0.77  # [rad] the expert opens the jaws to 0.8 before the grip
THERE = 0.0008                    # [m] from the grip: the jaws begin to close
WIDEST = 1.6                      # [rad] opening of the jaws in any pose before the grip
UNIT = np.array([0.01] * 3 + [0.1] * 3 + [0.5])  # [m, rad, rad] of what is learned
STILL = 0.01                      # [UNIT] less motion in a step is a pause
R_WB = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]])  # axes of the gold arm's base in the world, as columns

Seen = collections.namedtuple("Seen", "way R jaws height")  # from commanded tip to ring [m], tool's axes, opening [rad], ring's height [m]
Pose = collections.namedtuple("Pose", "tip R jaws")         # commanded


def matrix(quaternion):
    x, y, z, w = quaternion
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def small_rotation(vector):
    """Matrix of a rotation vector [rad]."""
    angle = np.linalg.norm(vector)
    return matrix([*(np.sinc(angle / 2 / np.pi) / 2 * vector), np.cos(angle / 2)])


def vector_of(R):
    """[rad] of a rotation by less than 90 degrees."""
    sine = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    return sine / np.sinc(np.arcsin(min(np.linalg.norm(sine), 1.0)) / np.pi)


def motion(pose, later):
    """[UNIT]"""
    return np.concatenate([later.tip - pose.tip, vector_of(later.R @ pose.R.T), [later.jaws - pose.jaws]]) / UNIT


def see(state):
    ring = state.objects[0, :3]
    return Seen(ring - state.desired_tips_in_world[0], R_WB @ matrix(state.tip_rotations[0]), state.joints[0, 5] + state.joints[0, 6], ring[2])


def commanded(state, kinematics):
    joints = np.array(state.desired_joints[0])
    return Pose(np.array(state.desired_tips_in_world[0]), R_WB @ kinematics.forward("gold", joints)[1], max(joints[5] + joints[6], 0.0))


def demonstration(seed):
    """[(seen, pose)] until the ring is lifted, without the expert's pauses."""
    kinematics, frames = raven2_trainer.Kinematics(), []
    with raven2_trainer.Simulation("pick_hand_over_place", motion="expert", robot="none", seed=seed) as simulation:
        simulation.start()
        state = simulation.state
        while state.exercise["steps_done"] == 0:
            frames.append((see(state), commanded(state, kinematics)))
            simulation.step(ticks=TICKS)
    return [a for a, b in zip(frames, frames[1:]) if np.abs(motion(a[1], b[1])).max() > STILL]


def phases(frames):
    """Numbers of the frames at which the jaws are open for the grip, close, and are closed."""
    opening = np.array([pose.jaws for _, pose in frames])
    ready = np.argmax(opening < OPEN_FOR_GRIP)
    closing = ready + np.argmax(opening[ready:] < CLOSING)
    return ready, closing, closing + np.argmax(opening[closing:] == 0.0)


def on_the_path(frames):
    """(seen, pose, pose AHEAD steps later, does it hold the ring) of each frame. The tip waits at the grip until the jaws are closed."""
    ready, closing, closed = phases(frames)
    for i in range(ready, len(frames)):
        seen, pose = frames[i]
        last = len(frames) - 1 if i >= closed else max(i, closing)
        later = frames[min(i + AHEAD, last)][1] if not closing <= i < closed else pose
        is_there = i >= closing or np.linalg.norm(pose.tip - frames[closing][1].tip) < THERE
        yield seen, pose, Pose(later.tip, later.R, 0.0 if is_there else pose.jaws), i >= closing


def next_to_the_path(seen, pose, held, share, random):
    """(seen, pose) with the tool elsewhere and the jaws perhaps wider, or, with the ring held, the ring elsewhere between the jaws."""
    off, R = share * random.uniform(-AWAY, AWAY, 3), small_rotation(share * random.uniform(-TURNED, TURNED, 3))
    if held:
        return Seen(seen.way - off, seen.R, seen.jaws, seen.height), pose
    jaws = seen.jaws if random.random() < 0.5 else random.uniform(seen.jaws, WIDEST)
    return Seen(seen.way - off, R @ seen.R, jaws, seen.height), Pose(pose.tip + off, R @ pose.R, pose.jaws)


class Policy:
    def __init__(self, demonstrations, seed):
        random = np.random.default_rng(seed)
        self._grip = np.mean([frames[phases(frames)[1]][0].way for frames in demonstrations], axis=0)
        pairs = [pair for frames in demonstrations for pair in self._pairs(frames, random)]
        self._network = MLPRegressor(hidden_layer_sizes=(128, 128), batch_size=256, max_iter=40, tol=0, random_state=seed)
        self._network.fit(*map(np.array, zip(*pairs)))

    def __call__(self, state):
        """The action: one step of the motion that the network foresees."""
        go = self._network.predict([self._features(see(state))])[0] * UNIT
        action = np.concatenate([go[:3] / MOVE / AHEAD, go[3:6] / TURN / AHEAD, [2 * go[6] / OPEN - 1]])
        return np.clip(action, -1, 1).astype(np.float32)

    def _pairs(self, frames, random):
        for seen, pose, later, held in on_the_path(frames):
            share = np.clip(np.linalg.norm(seen.way - self._grip) / FAR, CLOSE, 1.0)
            for where in ((seen, pose), *(next_to_the_path(seen, pose, held, share, random) for _ in range(BESIDE))):
                go = motion(where[1], later)
                yield self._features(where[0]), np.append(go[:6], later.jaws / UNIT[6])

    def _features(self, seen):
        """All about 1. The way to the ring twice: from afar, and close to the grip."""
        return np.concatenate([30 * seen.way, np.clip(300 * (seen.way - self._grip), -4, 4), seen.R[:, :2].ravel(),
                               [2 * seen.jaws - 1.4, 100 * seen.height - 1.6]])


def episode(policy, seed, variations):
    """@return whether the ring was lifted."""
    env = gymnasium.make("raven2_trainer/PickRing-v0", variations=variations)
    env.reset(seed=seed)
    over = False
    while not over:
        _, _, terminated, truncated, info = env.step(policy(env.unwrapped.simulation.state))
        over = terminated or truncated
    env.close()
    return info["is_success"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--demonstrations", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--variations", type=int, default=1, help="other friction and networks in the test than in the demonstrations: 20, for example")
    options = parser.parse_args()
    begin = time.monotonic()
    with concurrent.futures.ProcessPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        shown = list(pool.map(demonstration, range(1, options.demonstrations + 1)))
        print(f"{sum(map(len, shown))} frames of {len(shown)} sessions after {time.monotonic() - begin:.0f} s", flush=True)
        policy = Policy(shown, options.seed)
        print(f"learned after {time.monotonic() - begin:.0f} s", flush=True)
        lifted = list(pool.map(episode, 50 * [policy], range(10**6, 10**6 + 50), 50 * [options.variations]))
    print(f"success {sum(lifted)} of 50 unseen seeds after {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()
