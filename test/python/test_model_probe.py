"""model_probe against independent calculations: the energy of the whole arm from the inertials of urdf/raven2.urdf, and
the motion of one jaw. Needs the built program; skipped where it is not built."""

import os
import subprocess
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PROBE = os.path.join(os.environ.get("RAVEN2_TRAINER_BUILD", os.path.join(ROOT, "build")), "devel", "lib",
                     "raven2_trainer", "model_probe")
JOINTS = ["shoulder", "elbow", "insertion", "tool_roll", "wrist_joint", "grasper_joint_1", "grasper_joint_2"]
START = [0.8, 1.5, -0.1, 0.2, 0.3, 0.1, -0.2]
HEADER = ",".join(f"tau{j}" for j in range(1, 8))

pytestmark = pytest.mark.skipif(not os.path.exists(PROBE), reason="model_probe is not built")


def numbers(text):
    return np.array([float(word) for word in text.split()])


def turn(axis, angle):
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def rpy(values):
    r, p, y = values
    return turn([0, 0, 1], y) @ turn([0, 1, 0], p) @ turn([1, 0, 0], r)


class Arm:
    """One arm's links, read from the URDF. Energies are sums over the links, rates are differences of poses."""

    def __init__(self, side):
        root = ElementTree.parse(os.path.join(ROOT, "urdf", "raven2.urdf")).getroot()
        self.links = {link.get("name"): link.find("inertial") for link in root.findall("link")}
        joints = {joint.get("name"): joint for joint in root.findall("joint")}
        self.chain = [joints[f"camera_{side}"]] + [joints[f"{name}_{side}"] for name in JOINTS]

    def centres(self, q):
        """[(R, centre of mass)] of the moving links."""
        poses, result = {"world": (np.eye(3), np.zeros(3))}, []
        for joint, position in zip(self.chain, [0.0, *q]):
            R, p = poses[joint.find("parent").get("link")]
            origin = joint.find("origin")
            p = p + R @ numbers(origin.get("xyz", "0 0 0"))
            R = R @ rpy(numbers(origin.get("rpy", "0 0 0")))
            child = joint.find("child").get("link")
            if joint.get("type") == "prismatic":
                p = p + R @ numbers(joint.find("axis").get("xyz")) * position
            elif joint.get("type") == "revolute":
                R = R @ turn(numbers(joint.find("axis").get("xyz")), position)
            poses[child] = (R, p)
            if joint.get("type") != "fixed":
                com = numbers(self.links[child].find("origin").get("xyz"))
                result.append((R, p + R @ com))
        return result

    def bodies(self):
        for joint in self.chain[1:]:
            inertial = self.links[joint.find("child").get("link")]
            i = {k: float(v) for k, v in inertial.find("inertia").attrib.items()}
            tensor = np.array([[i["ixx"], i["ixy"], i["ixz"]], [i["ixy"], i["iyy"], i["iyz"]],
                               [i["ixz"], i["iyz"], i["izz"]]])
            yield float(inertial.find("mass").get("value")), tensor

    def energy(self, q, dq, gravity):
        step = 1e-6
        before, here, after = (self.centres(q + s * step * dq) for s in (-1, 0, 1))
        total = 0.0
        for (mass, tensor), (R0, c0), (R, c), (R1, c1) in zip(self.bodies(), before, here, after):
            v = (c1 - c0) / (2 * step)
            W = R.T @ (R1 - R0) / (2 * step)
            w = np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]]) / 2
            total += 0.5 * mass * v @ v + 0.5 * w @ tensor @ w + mass * gravity * c[2]
        return total


def probe(torques, *options, q0=START, arm="gold", header=HEADER):
    lines = [header] + [",".join(repr(float(x)) for x in row) for row in torques]
    return raw("\n".join(lines) + "\n", *options, q0=q0, arm=arm)


def raw(text, *options, q0=START, arm="gold"):
    start = "--q0=" + ",".join(map(repr, q0))
    return subprocess.run([PROBE, "--arm", arm, start, *options], input=text, capture_output=True, text=True, check=False)


def states(run):
    assert run.returncode == 0, run.stderr
    lines = run.stdout.splitlines()
    assert lines[0] == ",".join([f"q{j}" for j in range(1, 8)] + [f"dq{j}" for j in range(1, 8)])
    return np.array([[float(x) for x in line.split(",")] for line in lines[1:]])


def torques_of(ticks, scale, seed):
    """Smooth torques. `scale` must suit each bare joint, so that it moves through a part of its range."""
    random = np.random.default_rng(seed)
    t = np.arange(ticks)[:, None] * 1e-3
    return scale * np.sin(2 * np.pi * random.uniform(1, 4, 7) * t + random.uniform(0, 6, 7))


@pytest.mark.parametrize("arm,side", [("gold", "L"), ("green", "R")])
@pytest.mark.parametrize("gravity", ["on", "off"])
def test_the_work_of_the_torques_is_the_gain_of_energy(arm, side, gravity):
    scale = np.array([1.0, 1.0, 4.0, 1e-4, 1e-5, 2e-7, 2e-7])
    torques = torques_of(90, scale, 3)  # ends before a stop is reached: stops take energy
    got = states(probe(torques, "--friction", "off", "--armature", "off", "--gravity", gravity, arm=arm))
    g = 9.81 if gravity == "on" else 0.0
    q = np.vstack([START, got[:, :7]])
    work = np.cumsum(np.sum(torques * np.diff(q, axis=0), axis=1))  # exact: a torque is constant for its millisecond
    model = Arm(side)
    before = model.energy(np.array(START), np.zeros(7), g)
    gained = np.array([model.energy(row[:7], row[7:], g) - before for row in got[::10]])
    assert np.ptp(gained) > 0.005, "it must move for this to mean anything"
    assert np.max(np.abs(gained - work[::10])) < 1e-6 * np.ptp(gained) + 1e-9  # 1e-9: differences of poses


def test_a_jaw_with_its_rotor_turns_as_inertia_says():
    # without gravity and friction, one jaw's small torque moves that jaw's rotor and little else
    torques = np.zeros((100, 7))
    torques[:, 5] = 1e-3
    got = states(probe(torques, "--friction", "off", "--gravity", "off"))
    assert got[-1, 5] - START[5] == pytest.approx(0.5 * 1e-3 / 2.708654e-4 * 0.1**2, rel=1e-3)


def test_columns_are_found_by_name():
    torques = torques_of(20, np.array([1, 1, 4, 1e-3, 1e-3, 1e-3, 1e-3]), 1)
    order = [3, 0, 6, 1, 5, 2, 4]
    shuffled = probe(torques[:, order], header=",".join(f"tau{j + 1}" for j in order))
    assert shuffled.stdout == probe(torques).stdout
    assert shuffled.returncode == 0


def test_no_torques_give_no_states():
    assert len(states(raw(HEADER + "\n"))) == 0


ZEROS = ",".join("0" * 7)


@pytest.mark.parametrize("text,place", [
    ("", "stdin:1"),
    (HEADER.replace("tau7", "tau8") + "\n", "stdin:1"),
    (HEADER.replace("tau7", "tau6") + "\n", "stdin:1"),
    ("tau1,tau2\n0,0\n", "stdin:1"),
    (f"{HEADER}\n{ZEROS}\n0,0,0\n", "stdin:3"),
    (f"{HEADER}\n{ZEROS},0\n", "stdin:2"),
    (f"{HEADER}\n{ZEROS}\n{ZEROS}\n0,0,nan,0,0,0,0\n", "stdin:4"),
    (f"{HEADER}\n0,0,inf,0,0,0,0\n", "stdin:2"),
    (f"{HEADER}\n0,0,1e999,0,0,0,0\n", "stdin:2"),
    (f"{HEADER}\n0,0,1x,0,0,0,0\n", "stdin:2"),
    (f"{HEADER}\n0,,0,0,0,0,0\n", "stdin:2"),
])
def test_bad_tables_are_refused_with_their_line(text, place):
    run = raw(text)
    assert run.returncode == 2
    assert place in run.stderr
    assert run.stdout == ""


@pytest.mark.parametrize("q0,says", [([-0.01, *START[1:]], "shoulder_L is -0.01"), (START[:6], "--q0"),
                                     ([*START[:6], float("nan")], "--q0: value 7 is nan"), ([*START, 0.0], "")])
def test_bad_starts_are_refused(q0, says):
    run = raw(f"{HEADER}\n{ZEROS}\n", q0=q0)
    assert run.returncode != 0
    assert says in run.stderr
    assert run.stdout == ""


def test_a_start_may_be_given_as_one_word_or_as_seven():
    torques = torques_of(5, np.array([1, 1, 4, 1e-3, 1e-3, 1e-3, 1e-3]), 1)
    text = "\n".join([HEADER] + [",".join(map(repr, map(float, row))) for row in torques]) + "\n"
    words = subprocess.run([PROBE, "--arm", "gold", "--q0", *map(repr, START)], input=text, capture_output=True,
                           text=True, check=False)
    assert words.returncode == 0, words.stderr
    assert words.stdout == raw(text).stdout


def test_a_world_that_breaks_down_ends_the_run():
    run = probe(np.full((50, 7), 1e6))
    assert run.returncode == 1
    assert "broke down in step" in run.stderr
