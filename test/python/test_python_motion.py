"""Tests how the arms of a Simulation follow commands, and which commands it refuses."""

import json

import numpy as np
import pytest

from built_module import PICK, numbers, raven2_trainer


def test_a_tool_moves_as_commanded_and_the_robot_follows(ready):
    state = ready.state
    before, robot = state.tips.copy(), state.robot_tips.copy()
    ready.step({"gold": {"move": [0, 0, 0.01], "jaw": 0.6}}, ticks=500)  # up in the world is x of gold's base
    ready.step(ticks=300)
    moved = state.tips - before
    assert moved[0] == pytest.approx([0.01, 0, 0], abs=3e-4) and np.abs(moved[1]).max() < 2e-4
    assert state.robot_tips - robot == pytest.approx(moved, abs=5e-4)
    assert state.mode == "teleoperating" and state.runlevel == "PEDAL_DN"


def test_a_start_lifts_the_pedal(ready):
    ready.step(ticks=50)
    assert ready.state.mode == "teleoperating"
    assert 0 < ready.start() < 100 and ready.state.mode == "pedal_up"


def test_joint_set_points_are_reached(ready):
    goal = ready.state.joints[1] + np.array([0.05, -0.04, 0.004, 0.2, 0.1, -0.35, -0.15])
    ready.step({"green": {"joints": goal}}, ticks=800)
    ready.step(ticks=500)
    assert ready.state.desired_joints[1] == pytest.approx(goal, abs=1e-3)
    assert ready.state.joints[1] == pytest.approx(goal, abs=5e-3)


def test_without_a_robot_the_model_moves_alone():
    with raven2_trainer.Simulation(robot="none") as simulation:
        simulation.start()
        before = simulation.state.tips.copy()
        simulation.step({"green": {"move": [0.008, 0, 0]}}, ticks=400)
        simulation.step(ticks=200)
        assert np.linalg.norm(simulation.state.tips[1] - before[1]) == pytest.approx(0.008, abs=3e-4)
        assert not simulation.state.robot_joints.any() and simulation.state.runlevel == "none"


def test_an_expert_does_the_exercise():
    with raven2_trainer.Simulation(PICK, motion="expert", seed=2) as simulation:
        for _ in range(300):
            simulation.step(ticks=100)
            if simulation.state.exercise["status"] == "done":
                break
        assert simulation.state.exercise["status"] == "done"
        assert simulation.state.exercise["steps_done"] == len(simulation.state.exercise["steps"])


def test_a_start_shows_the_arms_where_they_are():
    """With a simulated surgeon and no robot nothing has to be waited for."""
    with raven2_trainer.Simulation(PICK, motion="expert", robot="none") as simulation:
        assert simulation.start() > 0
        tips = np.array(simulation.state.tips_in_world)
        assert simulation.state.desired_tips_in_world == pytest.approx(tips, abs=1e-4)
        simulation.step(ticks=10)
        assert simulation.state.tips_in_world == pytest.approx(tips, abs=1e-3)


def test_motion_to_joint_set_points_is_spread_over_the_ticks(tmp_path):
    with raven2_trainer.Simulation(output=tmp_path / "session") as simulation:
        simulation.start()
        goal = simulation.state.joints[1] + [0.05, 0, 0, 0.08, 0, 0, 0]
        simulation.step({"green": {"joints": goal}}, ticks=200)
    commands = raven2_trainer.Session(tmp_path / "session").log.commands["command"]
    turned, moved = np.linalg.norm(commands["dq_I"][:, 1, :3], axis=1), np.linalg.norm(commands["dp_I"][:, 1], axis=1)
    for each in (turned, moved):
        assert 0 < each.max() < 1.5 * each.sum() / 200


@pytest.fixture(scope="module", name="resting")
def never_stepped():
    """One for all tests that nothing may change."""
    with raven2_trainer.Simulation(PICK) as simulation:
        simulation.start()
        yield simulation


@pytest.mark.parametrize("command, says", [
    ({"gold": {"move": [0, 0]}}, "gold/move: expected 3 numbers"), ({"gold": {"move": [0, 0, np.nan]}}, "gold/move: not a finite number"),
    ({"gold": {"jump": 1}}, "gold/jump: unknown key"), ({"blue": {}}, "blue: unknown key"), ({"gold": 3}, "gold: expected a dict"),
    (np.zeros((2, 6)), "expected None, a dict or an array"), (np.full((2, 7), np.inf), "not a finite number"), ("x", "expected None"),
    ({"gold": {"joints": [0] * 7, "jaw": 1}}, "joints go alone"), ({"gold": {"move": "abc"}}, "gold/move: expected 3 numbers"),
    *(({"gold": {"move": move}}, "gold/move: expected 3 numbers") for move in (["0", "0", "1e-4"], [0, 0, 1j], [True, False, True], [0, 0, None])),
    *(({"pedal": pedal}, "pedal: expected True or False") for pedal in (np.nan, "False", "no", [0], [], None, 2, -1, 0.5, object(), np.zeros(2)))])
def test_a_wrong_command_is_refused_and_changes_nothing(resting, command, says):
    before = numbers(resting)
    with pytest.raises(ValueError, match=says.replace("(", r"\(")):
        resting.step(command)
    assert numbers(resting) == before


@pytest.mark.parametrize("pedal, is_down", [(True, 1), (False, 0), (np.True_, 1), (np.False_, 0), (1, 1), (0, 0), (np.int8(1), 1), (np.array(0), 0)])
def test_a_pedal_is_down_or_up(tmp_path, pedal, is_down):
    with raven2_trainer.Simulation(robot="none", output=tmp_path / "session") as simulation:
        simulation.start()
        simulation.step({"pedal": pedal}, ticks=20)
    assert raven2_trainer.Session(tmp_path / "session").log.ticks["model"]["pedal"][-1] == is_down


def test_motion_too_fast_for_the_packets_is_refused_and_slower_motion_arrives_whole(ready):
    before = ready.state.desired_tips_in_world.copy()
    with pytest.raises(ValueError, match="gold: 5 mm in a tick, at most"):
        ready.step({"gold": {"move": [0, 0, 0.005]}})
    with pytest.raises(ValueError, match="green: .* mm in a tick"):
        ready.step({"green": {"joints": ready.state.joints[1] + [0.3, 0, 0, 0, 0, 0, 0]}})
    assert np.array_equal(ready.state.desired_tips_in_world, before)
    ready.step(ticks=5)  # until the robot is in PEDAL_DN
    ready.step({"gold": {"move": [0, 0, 0.005]}}, ticks=5)
    ready.step(ticks=10)
    assert (ready.state.desired_tips_in_world - before)[0] == pytest.approx([0, 0, 0.005], abs=1e-5)


def assert_goes_straight(simulation, command, goal, quantity):
    """To the goal over a link, and never far beyond it: a straight motion of the tool is not quite straight in joints."""
    begin = quantity()
    seen = [begin]
    for call in range(120):
        simulation.step(command if call < 60 else None, ticks=5)
        seen.append(quantity())
    assert seen[-1] == pytest.approx(goal, abs=2e-3)
    assert (np.max(seen, axis=0) < np.maximum(begin, goal) + 0.01).all() and (np.min(seen, axis=0) > np.minimum(begin, goal) - 0.01).all()


@pytest.mark.parametrize("robot", ["none", "virtual"])
def test_over_a_link_no_motion_is_sent_twice(robot):
    """Jaws and set points come late, and once: what is under way is not sent again. Rotations and both arms, too."""
    with raven2_trainer.Simulation(robot=robot, link="wan") as simulation:
        simulation.start()
        state = simulation.state
        for jaws in ((0.6, 0.3), (0.8, 0.9)):
            assert_goes_straight(simulation, {"gold": {"jaw": jaws[0]}, "green": {"jaw": jaws[1]}}, jaws, lambda: state.desired_joints[:, 5:].sum(axis=1))
        goal = state.desired_joints + np.array([[0.05, -0.04, 0.004, 0.3, 0.1, 0.05, 0.05], [-0.05, 0.04, 0.002, -0.3, 0.1, -0.05, -0.05]])
        assert_goes_straight(simulation, {"gold": {"joints": goal[0]}, "green": {"joints": goal[1]}}, goal, state.desired_joints.copy)


def test_set_points_that_turn_the_tool_too_fast_are_refused(ready):
    ready.step(ticks=10)  # the pedal is down, and the robot knows
    goal = ready.state.desired_joints[0] + [0, 0, 0, 0.5, 0, 0, 0]
    with pytest.raises(ValueError, match="gold: joints turn the tool by .* take more ticks"):
        ready.step({"gold": {"joints": goal}}, ticks=3)
    ready.step({"gold": {"joints": goal}}, ticks=6)
    ready.step(ticks=20)
    assert ready.state.desired_joints[0] == pytest.approx(goal, abs=2e-3)


def test_a_simulated_surgeon_takes_no_commands():
    with raven2_trainer.Simulation(PICK, motion="expert") as simulation:
        simulation.step(ticks=5)
        for command in ({"gold": {"move": [0, 0, 0.001]}}, {"pedal": False}, np.zeros((2, 7))):
            with pytest.raises(ValueError, match="a simulated surgeon has the hands"):
                simulation.step(command)
        assert simulation.state.tick == 5


def test_a_fast_set_point_does_not_freeze_the_arm():
    with raven2_trainer.Simulation(robot="none") as simulation:
        simulation.start()
        simulation.step(ticks=50)
        goal = simulation.state.desired_joints[0] + [0, 0, 0.03, 0, 0, 0, 0]
        for _ in range(3):
            simulation.step({"gold": {"joints": goal}}, ticks=200)
            simulation.step(ticks=500)
        assert simulation.state.desired_joints[0] == pytest.approx(goal, abs=2e-3)
        before = simulation.state.desired_tips_in_world[0].copy()
        simulation.step({"gold": {"move": [0, 0, 0.005]}}, ticks=500)
        assert simulation.state.desired_tips_in_world[0] - before == pytest.approx([0, 0, 0.005], abs=1e-4)


def test_an_unreachable_set_point_costs_neither_the_pedal_nor_the_other_arm(tmp_path):
    with raven2_trainer.Simulation(robot="none", output=tmp_path / "s") as simulation:
        simulation.start()
        simulation.step(ticks=50)
        goal = simulation.state.desired_joints[0] + [0, 0, 0.5, 0, 0, 0, 0]
        simulation.step({"gold": {"joints": goal}}, ticks=19900)
        before = simulation.state.desired_tips_in_world[1].copy()
        simulation.step({"green": {"move": [0, 0, 0.005]}}, ticks=300)
        assert simulation.state.mode == "teleoperating"
        assert simulation.state.desired_tips_in_world[1] - before == pytest.approx([0, 0, 0.005], abs=1e-4)
    rejected = json.loads((tmp_path / "s/metrics.json").read_text())["packets"]["master_to_daemon"]["rejected"]
    assert rejected["out_of_range"] == 0


def test_jaws_asked_for_with_the_pedal_up_do_not_move_later():
    with raven2_trainer.Simulation(robot="none") as simulation:
        simulation.start()
        simulation.step(ticks=100)
        before = simulation.state.joints[0, 5:].sum()
        simulation.step({"gold": {"jaw": 0.2}, "pedal": False}, ticks=100)
        simulation.step(ticks=500)
        assert simulation.state.joints[0, 5:].sum() == pytest.approx(before, abs=0.02)


def test_a_start_may_take_as_long_as_its_limit():
    with raven2_trainer.Simulation(robot="none") as simulation:
        ticks = simulation.start()
    with raven2_trainer.Simulation(robot="none") as simulation:
        with pytest.raises(ValueError, match="limit: expected 1"):
            simulation.start(0)
        assert simulation.start(ticks) == ticks


def test_a_key_that_is_no_text_is_refused():
    with raven2_trainer.Simulation(robot="none") as simulation, pytest.raises(ValueError, match="no text"):
        simulation.step({"\ud800": {}})


def press_into_the_plate(simulation):
    """Gold, 0.1 m down. @return its joints before."""
    simulation.start()
    simulation.step(ticks=50)
    before = simulation.state.desired_joints[0].copy()
    simulation.step({"gold": {"joints": before - [0, 0, 0.1, 0, 0, 0, 0]}}, ticks=2000)
    simulation.step(ticks=500)
    return before


def test_an_arm_that_was_led_into_the_plate_can_be_led_back_by_joints():
    with raven2_trainer.Simulation(exercise="pick_hand_over_place", robot="none") as simulation:
        before = press_into_the_plate(simulation)
        lag = simulation.state.joints[0] - simulation.state.desired_joints[0]
        assert lag[2] > 0.01, "[m] held up by the plate"
        simulation.step({"gold": {"joints": before}}, ticks=2000)
        assert simulation.state.desired_joints[0] == pytest.approx(before, abs=2e-3)
        assert simulation.state.mode == "teleoperating"


def test_an_arm_that_is_held_up_is_not_led_astray_by_goals_to_the_side():
    with raven2_trainer.Simulation(exercise="pick_hand_over_place", robot="none") as simulation:
        before = press_into_the_plate(simulation)
        held = simulation.state.desired_joints[0].copy()
        aside = held + [0.1, 0, 0.0002, 0.8, 0, 0, 0]
        low, high = np.minimum.reduce([held, aside, before]), np.maximum.reduce([held, aside, before])
        slack = np.array([0.03, 0.03, 0.003, 0.03, 0.03, 0.03, 0.03])
        for goal in (aside, before):
            for _ in range(10):
                simulation.step({"gold": {"joints": goal}}, ticks=200)
                now = simulation.state.desired_joints[0]
                assert np.all(now > low - slack) and np.all(now < high + slack)
        assert simulation.state.desired_joints[0] == pytest.approx(before, abs=2e-3)


def test_an_arm_that_was_led_too_fast_is_led_back_by_joints():
    with raven2_trainer.Simulation(robot="none") as simulation:
        simulation.start()
        simulation.step(ticks=50)
        before = simulation.state.desired_joints[0].copy()
        simulation.step({"gold": {"move": [0.01, -0.005, -0.06]}}, ticks=60)  # 1 mm in a tick
        simulation.step(ticks=500)
        refused = simulation.state.desired_tips_in_world[0].copy()
        simulation.step({"gold": {"move": [0, 0, 0.002]}}, ticks=200)
        assert np.array_equal(simulation.state.desired_tips_in_world[0], refused), "it refuses though it has caught up"
        simulation.step({"gold": {"joints": before}}, ticks=2000)
        assert simulation.state.desired_joints[0] == pytest.approx(before, abs=2e-3)
