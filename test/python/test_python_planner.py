"""Tests Kinematics and Planner: agreement with the state, paths, clearances and refused arguments."""

import subprocess
import sys
import threading

import numpy as np
import pytest

from built_module import raven2_trainer


def test_kinematics_agree_with_themselves_and_the_state(ready):
    kinematics = raven2_trainer.Kinematics()
    p, _ = kinematics.forward("gold", ready.state.joints[0])
    assert p == pytest.approx(ready.state.tips[0], abs=1e-6)
    random = np.random.default_rng(4)
    home = ready.state.joints[1]
    q = home + random.uniform(-0.1, 0.1, (20, 7)) * [1, 1, 0.1, 1, 1, 1, 1]
    p, R = kinematics.forward("green", q)
    assert p.shape == (20, 3) and R.shape == (20, 3, 3)
    joints, valid = kinematics.inverse("green", p, R, 0.0)
    assert joints.shape == (20, 8, 7) and valid.any(axis=1).all() and np.isnan(joints[~valid]).all()
    again, _ = kinematics.forward("green", joints[valid])
    assert again == pytest.approx(np.repeat(p, valid.sum(axis=1), axis=0), abs=1e-5)
    opened, found = kinematics.inverse("green", p, R, 0.6)
    assert found.any() and np.allclose(opened[found][:, 5:].sum(axis=1), 0.6)
    J = kinematics.jacobian("green", q)
    step = 1e-6
    for joint in range(5):
        moved = q.copy()
        moved[:, joint] += step
        assert (kinematics.forward("green", moved)[0] - p) / step == pytest.approx(J[:, :3, joint], abs=1e-4)


@pytest.mark.parametrize("arguments", [("blue", np.zeros(7)), ("gold", np.zeros(6)), ("gold", "x"), ("gold", None),
                                       ("green", [[0] * 7, [0] * 6 + [np.nan]]), ("gold", [np.inf] * 7)])
def test_wrong_joints_are_refused(arguments):
    for function in (raven2_trainer.Kinematics().forward, raven2_trainer.Kinematics().jacobian):
        with pytest.raises((ValueError, TypeError)):
            function(*arguments)


def test_a_reflection_has_no_joints(ready):
    kinematics = raven2_trainer.Kinematics()
    p, R = kinematics.forward("gold", ready.state.joints[0])
    assert kinematics.inverse("gold", p, R)[1].any() and not kinematics.inverse("gold", p, R @ np.diag([1, 1, -1]))[1].any()
    for place, rotation, opening in ((p * np.nan, R, 0), (p, R * np.inf, 0), (p, R, 1e300), (p, R, np.nan)):
        with pytest.raises(ValueError):
            kinematics.inverse("gold", place, rotation, opening)


def test_places_and_rotations_of_other_shapes_are_refused():
    with pytest.raises(ValueError, match="expected arrays of shapes"):
        raven2_trainer.Kinematics().inverse("gold", np.zeros((2, 3, 3)), np.tile(np.eye(3), (3, 2, 1, 1)))


@pytest.fixture(scope="module", name="planner")
def made():
    return raven2_trainer.Planner()


@pytest.fixture(scope="module", name="home")
def joints_at_rest():
    with raven2_trainer.Simulation() as simulation:
        simulation.start()
        return simulation.state.joints.copy()


PLANS = """
import raven2_trainer
with raven2_trainer.Simulation(motion="scripted") as first:
    first.start()
    first.step(ticks=26400)
with raven2_trainer.Simulation(motion="scripted", seed=2) as second:
    second.start()
    second.step(ticks=25500)
    begin, ends = second.save(), []
    for _ in range(2):
        second.step(ticks=1500)
        ends.append((second.state.mode, second.state.joints.tobytes()))
        second.restore(begin)
assert ends[0] == ends[1] and ends[0][0] == "tracking", ends[0][0]
"""


def test_simulations_that_plan_share_no_memory():
    """OMPL has global objects. They must not be in the memory of a simulation: it ends, or goes back to a snapshot."""
    done = subprocess.run([sys.executable, "-c", PLANS], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_plan_leads_from_start_to_goal(planner, home):
    goal = home[0] + [0.2, -0.1, 0.01, 0, 0, 0, 0]
    plan = planner.plan("gold", home[0], goal, other=home[1])
    assert plan["status"] == "success" and plan["cost"] > 0 and plan["clearance"] > 0
    assert plan["waypoints"][0] == pytest.approx(home[0]) and plan["waypoints"][-1][:5] == pytest.approx(goal[:5], abs=1e-6)
    assert (np.diff(plan["arrival"]) > 0).all() and not planner.in_collision("gold", plan["waypoints"], home[1]).any()
    again = raven2_trainer.Planner().plan("gold", home[0], goal, other=home[1])
    assert np.array_equal(again["waypoints"], plan["waypoints"]), "the same seed, the same path"
    edges = sum(planner.edge_cost("gold", a, b) for a, b in zip(plan["waypoints"], plan["waypoints"][1:]))
    assert edges <= plan["cost"] * (1 + 1e-9), "eq. (1) without the clearance term"


def test_a_path_is_followed_as_the_plan_says(planner, home):
    goal = home[0] + [0.2, -0.1, 0.01, 0, 0, 0, 0]
    plan = planner.plan("gold", home[0], goal, other=home[1])
    followed = planner.roll_out("gold", plan["waypoints"], other=home[1])
    assert followed["free"] and followed["failed_edge"] is None
    assert followed["arrival"] == pytest.approx(plan["arrival"]) and followed["duration"] >= plan["arrival"][-1]
    assert followed["tracking_error"] == pytest.approx(plan["tracking_error"], rel=1e-6)
    assert followed["clearance"] == pytest.approx(plan["clearance"], rel=1e-6)
    along = planner.clearance("gold", plan["waypoints"], other=home[1])
    assert along.shape == (len(plan["waypoints"]),) and (along >= followed["clearance"] - 1e-3).all()
    again = planner.plan("gold", home[0], goal, other=home[1])
    assert np.array_equal(again["waypoints"], plan["waypoints"]), "roll_out() leaves nothing behind"


def test_a_path_into_an_obstacle_touches_it(planner, home):
    across = home[0] + np.array([[angle, 0, 0, 0, 0, 0, 0] for angle in np.linspace(0, 0.4, 17)])
    distances = planner.clearance("gold", across, home[1])
    assert distances[-1] == 0 and planner.in_collision("gold", across[-1], home[1])
    near = distances[(distances > 1e-4) & (distances < 0.01)]
    assert len(near) > 2 and (np.diff(near) < 0).all(), "less and less"
    moved = home[0] + [0.05, 0, 0, 0, 0, 0, 0]
    followed = planner.roll_out("gold", [home[0], moved, across[-1]], other=home[1])
    assert not followed["free"] and followed["failed_edge"] == 1 and followed["clearance"] < 1e-3
    assert followed["duration"] < followed["arrival"][-1]
    both = planner.clearance("green", home)
    assert both.shape == (2,) and np.isfinite(both).all()
    for waypoints in ([], home[0], [[np.nan] * 7], np.zeros((2, 6)), "text"):
        with pytest.raises(ValueError):
            planner.roll_out("gold", waypoints)
    with pytest.raises(ValueError, match="gold or green"):
        planner.clearance("blue", home)


def test_planners_in_threads_plan_as_each_alone(home):
    def run(seed, out):
        plans = raven2_trainer.Planner()
        out[seed] = [plans.plan(arm, home[i], home[i] + [0.2, -0.1, 0.01, 0, 0, 0, 0], other=home[1 - i], seed=seed)["waypoints"].tobytes()
                     for i, arm in enumerate(("gold", "green"))]

    alone, together = {}, {}
    for seed in range(1, 5):
        run(seed, alone)
    threads = [threading.Thread(target=run, args=(seed, together)) for seed in range(1, 5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert alone == together and len(alone) == 4


def test_other_seeds_give_other_paths(planner):
    """Past the tower of config/problems/past_tower.yaml there is no straight way."""
    beside = [0.1559, 1.6197, 0.3450, -1.6563, -0.9356, 1.4132, 0.1576]
    plans = [planner.plan("gold", beside, [0.002, 0.030, 0.012], seed=seed) for seed in (1, 2, 3, 1)]
    assert {plan["status"] for plan in plans} == {"success"}
    paths = [plan["waypoints"].tobytes() for plan in plans]
    assert paths[0] == paths[3] and len(set(paths)) > 1


def test_a_path_beside_the_other_arm_is_as_near_to_it_as_the_caller_says(planner, home):
    """Both arms lean to the same side, green as far as it does not touch. A plan before was made with green at home."""
    gold, green = (joints + [lean, -0.4, 0, 0, 0, 0, 0] for joints, lean in zip(home, (0.1, 0.0)))
    while planner.clearance("gold", gold, green) < 0.003:
        green = green + 0.02 * (home[1] - green)
    near = float(planner.clearance("gold", gold, green))
    assert near < 0.008 and planner.clearance("gold", gold, home[1]) > 0.01
    assert planner.plan("gold", home[0], gold, other=home[1])["status"] == "success"
    found = planner.roll_out("gold", [gold, gold + [0.001, 0, 0, 0, 0, 0, 0]], other=green)["clearance"]
    assert found == pytest.approx(near, abs=1.5e-3)


def test_what_cannot_be_planned_says_why(planner, home):
    assert planner.plan("green", home[1], [10.0, 0, 0])["status"] == "goal_unreachable"
    assert planner.in_collision("green", home).shape == (2,)
    for arguments in (("green", home[1], [0, 0]), ("blue", home[1], home[0]), ("green", home[1][:6], home[0]), ("green", home[1] * np.nan, home[0])):
        with pytest.raises(ValueError):
            planner.plan(*arguments)


def test_joints_far_outside_any_robot_are_refused(planner, home):
    """FCL's distance ends the process there."""
    far = home[0] + [0, 0, -1e300, 0, 0, 0, 0]
    for call in (lambda: planner.plan("gold", far, home[0]), lambda: planner.plan("gold", home[0], far), lambda: planner.clearance("gold", far),
                 lambda: planner.plan("gold", home[0], home[0], other=far), lambda: planner.in_collision("gold", [home[0], far]),
                 lambda: planner.clearance("gold", home[0], other=far), lambda: planner.roll_out("gold", [home[0], far]),
                 lambda: planner.edge_cost("gold", far, home[0]), lambda: planner.edge_cost("gold", home[0], far)):
        with pytest.raises(ValueError, match="not between -10000 and 10000"):
            call()
    assert planner.clearance("gold", np.clip(far, -1e4, 1e4)) >= 0


@pytest.mark.parametrize("kind", [complex, str, bool])
def test_a_place_of_other_kinds_is_refused(kind):
    with pytest.raises(ValueError, match="p, R"):
        raven2_trainer.Kinematics().inverse("gold", np.ones(3).astype(kind), np.eye(3))


def test_the_other_arm_is_where_the_caller_says(planner, home):
    """Both arms lean to the same side: green is in gold's way there, and not at its home."""
    gold, green = (joints + [lean, -0.4, 0, 0, 0, 0, 0] for joints, lean in zip(home, (0.1, 0.0)))
    assert planner.clearance("gold", gold, green) == 0 and planner.in_collision("gold", gold, green)
    assert planner.clearance("gold", gold, home[1]) > 0.01 and not planner.in_collision("gold", gold, home[1])
    assert planner.plan("gold", home[0], gold, other=green)["status"] == "goal_in_collision"
    assert planner.plan("gold", home[0], gold, other=home[1])["status"] == "success"
