"""urdf/raven2.srdf against urdf/raven2.urdf, and the URDFs against Debian's own parser."""

import pathlib
import shutil
import subprocess
import xml.etree.ElementTree as ET

import numpy as np
import pytest

URDF = pathlib.Path(__file__).resolve().parents[2] / "urdf"
ARMS = {"gold": "L", "green": "R"}


@pytest.fixture(scope="module")
def robot():
    return ET.parse(URDF / "raven2.urdf").getroot()


@pytest.fixture(scope="module")
def semantics():
    return ET.parse(URDF / "raven2.srdf").getroot()


def joints(robot):
    return {joint.get("name"): joint for joint in robot.iter("joint")}


def links(robot):
    return {link.get("name") for link in robot.findall("link")}


def chain(robot, base, tip):
    """Joints from base to tip, in order. Fails if they are not connected."""
    above = {joint.find("child").get("link"): joint for joint in robot.iter("joint")}
    way = []
    while tip != base:
        assert tip in above, f"{tip} is not connected to {base}"
        way.append(above[tip])
        tip = above[tip].find("parent").get("link")
    return way[::-1]


def moving(way):
    return [joint.get("name") for joint in way if joint.get("type") != "fixed"]


def group(semantics, name):
    (found,) = [g for g in semantics.findall("group") if g.get("name") == name]
    return found


def joints_of(semantics, robot, name):
    of = group(semantics, name)
    names = [joint.get("name") for joint in of.findall("joint")]
    for part in of.findall("chain"):
        names += moving(chain(robot, part.get("base_link"), part.get("tip_link")))
    for part in of.findall("group"):
        names += joints_of(semantics, robot, part.get("name"))
    return names


def state(semantics, name):
    (found,) = [s for s in semantics.findall("group_state") if s.get("group") == name and s.get("name") == "home"]
    return {joint.get("name"): float(joint.get("value")) for joint in found}


def test_every_name_is_one_of_the_urdf(robot, semantics):
    assert semantics.get("name") == robot.get("name")
    links_named = [element.get(key) for element in semantics.iter()
                   for key in ("base_link", "tip_link", "parent_link", "link1", "link2") if element.get(key)]
    links_named += [element.get("name") for element in semantics.iter("link")]
    assert len(links_named) > 30 and set(links_named) <= links(robot)
    assert {element.get("name") for element in semantics.iter("joint")} <= set(joints(robot))


def test_groups_hold_every_joint_that_moves_once(robot, semantics):
    movable = [name for name, joint in joints(robot).items() if joint.get("type") != "fixed"]
    named = [joint for colour in ARMS for part in ("arm", "jaws")
             for joint in joints_of(semantics, robot, f"{colour}_{part}")]
    assert sorted(named) == sorted(movable) and len(named) == 14
    arms = joints_of(semantics, robot, "gold_arm") + joints_of(semantics, robot, "green_arm")
    assert joints_of(semantics, robot, "both_arms") == arms


@pytest.mark.parametrize("colour,letter", ARMS.items())
def test_chains_are_connected_and_jaws_hang_on_their_end(robot, semantics, colour, letter):
    part = group(semantics, f"{colour}_arm").find("chain")
    assert part.get("base_link").endswith(letter)
    assert len(moving(chain(robot, part.get("base_link"), part.get("tip_link")))) == 5
    (effector,) = [e for e in semantics.findall("end_effector") if e.get("group") == f"{colour}_jaws"]
    assert effector.get("parent_link") == part.get("tip_link") and effector.get("parent_group") == f"{colour}_arm"
    for joint in joints_of(semantics, robot, f"{colour}_jaws"):
        assert joints(robot)[joint].find("parent").get("link") == part.get("tip_link")


def test_home_is_of_all_joints_of_its_group_and_inside_their_limits(robot, semantics):
    groups = [g.get("name") for g in semantics.findall("group")]
    assert len(groups) == len(set(groups)) == 5
    for name in groups:
        values = state(semantics, name)
        assert list(values) == joints_of(semantics, robot, name)
        for joint, value in values.items():
            limit = joints(robot)[joint].find("limit")
            assert float(limit.get("lower")) <= value <= float(limit.get("upper")), joint


def test_arms_together_are_at_home_where_each_is(semantics):
    assert state(semantics, "both_arms") == {**state(semantics, "gold_arm"), **state(semantics, "green_arm")}


def turned(axis, angle):
    """Rotation about a unit axis (Rodrigues)."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def pose(position, rotation):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = rotation, position
    return X


def numbers(element, key):
    return np.array([float(word) for word in element.get(key).split()])


def step(joint, values):
    """Pose of a joint's child in its parent, as in the URDF specification."""
    origin = joint.find("origin")
    roll, pitch, yaw = numbers(origin, "rpy")
    R = turned((0, 0, 1), yaw) @ turned((0, 1, 0), pitch) @ turned((1, 0, 0), roll)
    X = pose(numbers(origin, "xyz"), R)
    axis, value = numbers(joint.find("axis"), "xyz"), values[joint.get("name")]
    if joint.get("type") == "prismatic":
        return X @ pose(axis * value, np.eye(3))
    return X @ pose(np.zeros(3), turned(axis, value))


@pytest.mark.parametrize("colour,letter,y", [("gold", "L", -0.025266), ("green", "R", 0.025266)])
def test_home_is_the_robots_published_home_pose(robot, semantics, colour, letter, y):
    values = {**state(semantics, f"{colour}_arm"), **state(semantics, f"{colour}_jaws")}
    X = np.eye(4)
    for joint in chain(robot, f"base_link_{letter}", f"grasper1_{letter}"):
        X = X @ step(joint, values)
    assert X[:3, 3] == pytest.approx([-0.077947, y, 0.013226], abs=1e-6)


def test_overlaps_are_allowed_on_every_joint_and_not_between_arms(robot, semantics):
    pairs = {frozenset((e.get("link1"), e.get("link2"))): e.get("reason")
             for e in semantics.findall("disable_collisions")}
    adjacent = {frozenset((j.find("parent").get("link"), j.find("child").get("link")))
                for j in robot.iter("joint") if j.get("type") != "fixed"}
    assert {pair for pair, reason in pairs.items() if reason == "Adjacent"} == adjacent
    assert all(len({link[-1] for link in pair}) == 1 for pair in pairs)
    assert len(semantics.findall("disable_collisions")) == len(pairs) == 16


@pytest.mark.skipif(not shutil.which("check_urdf"), reason="liburdfdom-tools is not installed")
@pytest.mark.parametrize("path", sorted(URDF.glob("*.urdf")), ids=lambda path: path.stem)
def test_debians_parser_has_nothing_to_say(path):
    result = subprocess.run(["check_urdf", path], capture_output=True, text=True, timeout=60)
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stderr == "" and "Successfully Parsed XML" in result.stdout
    assert not [line for line in result.stdout.splitlines() if "warn" in line.lower() or "error" in line.lower()]
