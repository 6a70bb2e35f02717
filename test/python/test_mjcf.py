"""The MuJoCo model of generate_description. The tests read the kinematics and masses from its file. They also compare
its free motion in MuJoCo with the ODE model's (model_probe). MuJoCo is installed from PyPI into the build folder; the
tests that need it are skipped where PyPI cannot be reached."""
import os
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "test/python")]
import raven2_kinematics  # noqa: E402
import test_model_probe as model_probe  # noqa: E402

BUILD = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
MUJOCO = "mujoco==3.2.7"
SIDES = {"gold": "_L", "green": "_R"}
SCENES = sorted(path.stem for path in (ROOT / "config/scenes").glob("*.yaml") if (ROOT / f"urdf/{path.stem}.urdf").exists())


def write_mjcf(folder, scene):
    path = folder / f"{scene}.xml"
    subprocess.run([ROOT / "scripts/generate_description", "--mjcf", path, "--scene", scene], check=True)
    return path


@pytest.fixture(scope="module", name="bare")
def make_bare(tmp_path_factory):
    return write_mjcf(tmp_path_factory.mktemp("mjcf"), "none")


@pytest.fixture(scope="module", name="mujoco")
def import_mujoco():
    folder = BUILD / "mujoco"
    if not (folder / "mujoco").is_dir():
        done = subprocess.run(["/usr/bin/python3", "-m", "pip", "install", "--quiet", "--no-deps", "--target", folder, MUJOCO],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            pytest.skip(f"{MUJOCO} cannot be had from PyPI: {done.stderr.strip().splitlines()[-1:]}")
    os.environ["MUJOCO_GL"] = "disable"
    sys.path.insert(0, str(folder))
    return pytest.importorskip("mujoco")


def pose(element):
    """4 x 4 of an element's pos and quat."""
    w, x, y, z = model_probe.numbers(element.get("quat", "1 0 0 0"))
    result = np.eye(4)
    result[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                      [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                      [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    result[:3, 3] = model_probe.numbers(element.get("pos", "0 0 0"))
    return result


def moved(joint, value):
    result, axis = np.eye(4), model_probe.numbers(joint.get("axis"))
    if joint.get("type") == "slide":
        result[:3, 3] = value * axis
    else:
        result[:3, :3] = model_probe.turn(axis, value)
    return result


def jaws(root, side, q):
    """Frames of both jaws in the arm's base."""
    body, at, found = root.find(f".//body[@name='base_link{side}']"), np.eye(4), []
    values = dict(zip((name + side for name in model_probe.JOINTS), q))
    while True:
        children = body.findall("body")
        for child in children:
            joint = child.find("joint")
            frame = at @ pose(child) @ moved(joint, values[joint.get("name")])
            if child.get("name").startswith("grasper"):
                found.append(frame)
        if found:
            return found
        (body,), at = children, frame


def urdf_joints(arm, j, d4):
    """URDF joints from the robot's (doc/model.md). Insertion and roll have another zero, two joints another sign."""
    gold = arm == "gold"
    return [j[0], j[1], j[2] + d4, j[3] + (-1 if gold else 1) * np.pi / 4, j[4] if gold else -j[4], j[5], -j[6]]


@pytest.mark.parametrize("arm", SIDES)
def test_the_tip_is_where_the_robot_s_own_kinematics_have_it(bare, arm):
    root = ElementTree.parse(bare).getroot()
    arms = yaml.safe_load((ROOT / "config/arms.yaml").read_text())
    tool = arms["tools"][arms["tool"]]
    random = np.random.default_rng(7)
    for _ in range(200):
        j = random.uniform(arms["limits"]["min"], arms["limits"]["max"])
        expected = raven2_kinematics.forward(0 if arm == "gold" else 1, j[None, :], tool["d4"], tool["lw"])[0]
        first, second = jaws(root, SIDES[arm], urdf_joints(arm, j, tool["d4"]))
        for frame in (first, second):
            assert np.abs(frame[:3, 3] - expected[:3, 3]).max() < 1e-12
            assert np.abs(frame[:3, 2] - expected[:3, 2]).max() < 1e-12, "both jaws rotate about T's z"
        middle = (first[:3, 0] + second[:3, 0]) * np.sign(np.cos((j[5] + j[6]) / 2))  # jaws can open beyond 180 deg
        assert np.abs(middle / np.linalg.norm(middle) - expected[:3, 0]).max() < 1e-12, "T is on their mid-line"


@pytest.mark.parametrize("scene", SCENES)
def test_everything_that_moves_has_the_mass_that_its_urdf_says(tmp_path, scene):
    root = ElementTree.parse(write_mjcf(tmp_path, scene)).getroot()
    masses = {body.get("name"): float(body.find("inertial").get("mass"))
              for body in root.iter("body") if body.find("inertial") is not None}
    expected = {}
    for part in ("raven2", scene):
        urdf = ElementTree.parse(ROOT / f"urdf/{part}.urdf").getroot()
        moves = {joint.find("child").get("link") for joint in urdf.findall("joint") if joint.get("type") != "fixed"}
        expected.update({link.get("name"): float(link.find("inertial/mass").get("value"))
                         for link in urdf.findall("link") if link.get("name") in moves})
    assert masses == expected and len(expected) > 14


def corners(frame, half):
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return frame[:3, 3] + (signs * half) @ frame[:3, :3].T


def ends(frame, half):
    return frame[:3, 3] + np.outer((-half, half), frame[:3, 2])


def shapes_of_urdf(link):
    """(kind, radius, points) of what a link collides with: a box's corners, the ends of the axis of a cylinder."""
    for collision in link.findall("collision"):
        origin, frame = collision.find("origin"), np.eye(4)
        if origin is not None:
            frame[:3, :3] = model_probe.rpy(model_probe.numbers(origin.get("rpy", "0 0 0")))
            frame[:3, 3] = model_probe.numbers(origin.get("xyz", "0 0 0"))
        shape = collision.find("geometry")[0]
        radius = float(shape.get("radius", 0))
        if shape.tag == "box":
            yield "box", 0.0, corners(frame, model_probe.numbers(shape.get("size")) / 2)
        elif shape.tag == "cylinder":  # it has round ends, which belong to its length (doc/model.md)
            yield "capsule", radius, ends(frame, float(shape.get("length")) / 2 - radius)
        else:
            yield "sphere", radius, frame[None, :3, 3]


def shapes_of_mjcf(body):
    for geom in body.findall("geom"):
        if geom.get("type") == "mesh":
            continue
        size, frame, kind = model_probe.numbers(geom.get("size")), pose(geom), geom.get("type")
        if kind == "box":
            yield kind, 0.0, corners(frame, size)
        else:
            yield kind, size[0], ends(frame, size[1]) if kind == "capsule" else frame[None, :3, 3]


@pytest.mark.parametrize("scene", SCENES)
def test_everything_collides_with_the_shape_that_its_urdf_says(tmp_path, scene):
    bodies = {body.get("name"): body for body in ElementTree.parse(write_mjcf(tmp_path, scene)).getroot().iter("body")}
    compared = 0
    for part in ("raven2", scene):
        for link in ElementTree.parse(ROOT / f"urdf/{part}.urdf").getroot().findall("link"):
            is_base = link.get("name").startswith("base_link_")  # without a shape in the ODE world, too (doc/model.md)
            expected = [] if is_base else list(shapes_of_urdf(link))
            if not expected and not is_base:
                continue
            found = list(shapes_of_mjcf(bodies[link.get("name")]))
            assert len(found) == len(expected), link.get("name")
            for (kind, radius, points), (other_kind, other_radius, other_points) in zip(expected, found):
                assert kind == other_kind and radius == pytest.approx(other_radius, abs=1e-9), link.get("name")
                apart = np.linalg.norm(points[:, None] - other_points[None], axis=2)
                assert apart.min(axis=1).max() < 1e-6 and apart.min(axis=0).max() < 1e-6, link.get("name")
                compared += 1
    assert compared > 30


@pytest.mark.parametrize("scene", ["none", *SCENES])
def test_mujoco_takes_it_and_what_lies_there_rests(mujoco, tmp_path, scene):
    model = mujoco.MjModel.from_xml_path(str(write_mjcf(tmp_path, scene)))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    free = [address for address, kind in zip(model.jnt_qposadr, model.jnt_type) if kind == mujoco.mjtJoint.mjJNT_FREE]
    assert (len(free) > 0) == (scene != "none")
    before = data.qpos.copy()
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert sum(warning.number for warning in data.warning) == 0
    for address in free:
        assert np.linalg.norm(data.qpos[address:address + 3] - before[address:address + 3]) < 1e-3


def simulate(mujoco, path, arm, torques, q0, friction):
    """Joints of one arm. Each torque acts for 1 ms, in ten steps of 0.1 ms. The other arm hangs freely."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep = 1e-4
    if not friction:
        model.dof_damping[:] = model.dof_frictionloss[:] = 0
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    names = [name + SIDES[arm] for name in model_probe.JOINTS]
    places = [model.joint(name).qposadr[0] for name in names]
    motors = [model.actuator(name).id for name in names]
    data.qpos[places] = q0
    rows = []
    for row in torques:
        data.ctrl[motors] = row
        for _ in range(10):
            mujoco.mj_step(model, data)
        rows.append(data.qpos[places].copy())
    return np.array(rows)


@pytest.mark.parametrize("arm", SIDES)
@pytest.mark.parametrize("friction", [True, False])
def test_free_motion_is_that_of_the_ode_model(mujoco, bare, arm, friction):
    """The motions agree within 0.5 % of each joint's motion. Without friction, all joints but the first three get small
    torques only: otherwise they would reach their stops."""
    scale = np.array([4, 5, 95, .05, .2, .2, .2]) * (1 if friction else np.array([1, 1, 1, .02, .02, .02, .02]))
    torques = sum(model_probe.torques_of(600, 0.3 * scale, seed) for seed in (3, 4, 5))
    q0 = [0.7, 1.5, -0.1, 0.2, 0.3, 0.4, -0.4]
    ode = model_probe.states(model_probe.probe(torques, *(() if friction else ("--friction", "off")), q0=q0, arm=arm))[:, :7]
    got = simulate(mujoco, bare, arm, torques, q0, friction)
    ways = np.maximum(np.ptp(ode, axis=0), [.03, .03, .002, .01, .01, .01, .01])
    errors = np.abs(got - ode).max(axis=0) / ways
    print(f"{arm}, friction {friction}: ways {ways.round(4)}, errors [%] {(100 * errors).round(3)}")
    assert (np.ptp(ode, axis=0) > [0.05, 0.02, 0.001, 0.05, 0.05, 0.05, 0.02]).all(), "it must move for this to mean anything"
    assert errors.max() < 0.005
