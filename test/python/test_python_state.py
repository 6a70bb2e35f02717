"""Tests the state of a Simulation: its views and contacts, its snapshots, and that equal seeds give equal numbers."""

import threading

import numpy as np
import pytest

from built_module import PICK, numbers, raven2_trainer


def walk(simulation, seed, steps=200):
    """Random motion of both arms. @return the bytes of each state."""
    random = np.random.default_rng(seed)
    states = []
    for _ in range(steps):
        command = np.zeros((2, 7))
        command[:, :3] = random.normal(0, 2e-4, (2, 3))
        command[:, 3:6] = random.normal(0, 2e-3, (2, 3))
        command[:, 6] = random.uniform(0, 0.6, 2)
        simulation.step(command, ticks=int(random.integers(1, 8)))
        states.append(numbers(simulation))
    return states


def test_views_show_each_step_without_a_copy_and_cannot_be_written(ready):
    joints = ready.state.joints
    first = joints.copy()
    ready.step({"gold": {"move": [0, 0.005, 0]}}, ticks=200)
    assert not np.array_equal(joints, first) and np.shares_memory(joints, ready.state.joints)
    with pytest.raises(ValueError):
        joints[0, 0] = 1.0


def test_the_same_seed_and_commands_give_the_same_numbers():
    runs = []
    for _ in range(2):
        with raven2_trainer.Simulation(PICK, hazard="sudden_jump", seed=5) as simulation:
            simulation.start()
            runs.append(walk(simulation, 5))
    assert runs[0] == runs[1]


def test_a_restored_simulation_repeats_itself_to_the_bit(ready):
    walk(ready, 1, 50)
    snapshot = ready.save()
    before = numbers(ready)
    first = walk(ready, 2)
    ready.restore(snapshot)
    assert numbers(ready) == before
    assert walk(ready, 2) == first
    assert walk(ready, 3) != first
    ready.restore(snapshot)
    assert walk(ready, 2) == first


def test_a_restored_simulation_asks_for_the_jaws_of_then(ready):
    ready.step({"gold": {"jaw": 0.6}, "green": {"jaw": 0.2}}, ticks=300)
    snapshot = ready.save()
    ready.step({"gold": {"jaw": 0.2}, "green": {"jaw": 0.6}}, ticks=50)
    ready.restore(snapshot)
    ready.step(ticks=300)
    assert ready.state.desired_joints[:, 5:].sum(axis=1) == pytest.approx([0.6, 0.2], abs=0.01)


def test_threads_do_not_disturb_each_other():
    def run(seed, out):
        with raven2_trainer.Simulation(PICK, seed=seed) as simulation:
            simulation.start()
            walk(simulation, seed, 40)
            snapshot = simulation.save()
            walk(simulation, seed + 100, 40)
            simulation.restore(snapshot)
            out[seed] = walk(simulation, seed, 60)

    alone, together = {}, {}
    for seed in range(4):
        run(seed, alone)
    threads = [threading.Thread(target=run, args=(seed, together)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert alone == together and len({tuple(states) for states in alone.values()}) == 4


def test_contacts_are_listed_with_place_and_force():
    with raven2_trainer.Simulation(PICK, robot="none", motion="expert") as simulation:
        names = simulation.body_names

        def of_jaws_and_objects(points):
            pairs = [({names[p["a"]], names[p["b"]]}, p) for p in points]
            return [p for pair, p in pairs if pair & set(simulation.object_names) and any(name.endswith(("_L", "_R")) for name in pair)]

        for _ in range(400):
            simulation.step(ticks=50)
            points = simulation.state.contact_points
            held = of_jaws_and_objects(points)
            if any(np.linalg.norm(p["force"]) > 0.1 for p in held):
                break
        else:
            pytest.fail("nothing presses")
        assert simulation.state.contacts_dropped == 0
        assert len(held) >= 2, "the jaws hold the ring"
        assert (points["a"] < points["b"]).all() and (points["depth"] >= 0).all()
        assert np.allclose(np.linalg.norm(points["normal"], axis=1), 1)
        ring = simulation.state.objects[:, :3]
        assert all(np.linalg.norm(ring - p["position"], axis=1).min() < 0.02 for p in held), "at the ring, in the world"
        arms = [sum(any(names[p[side]].endswith(end) for side in "ab") for p in points) for end in ("_L", "_R")]
        assert simulation.state.contacts == arms
        kept = points.copy()
        simulation.step(ticks=200)
        assert np.array_equal(points, kept), "a copy"


def test_a_simulation_that_steps_in_a_thread_can_be_read_in_another():
    with raven2_trainer.Simulation(robot="none") as simulation:
        stepping = threading.Thread(target=simulation.step, kwargs={"ticks": 20000})
        stepping.start()
        read = 0
        while stepping.is_alive():
            assert len(simulation.body_names) > 10 and simulation.object_names is not None
            state = simulation.state
            assert len(state.contact_points) >= 0 and state.contacts_dropped == 0 and np.isfinite(state.true_joints).all()
            read += 1
        stepping.join()
        assert read > 0 and simulation.state.tick >= 20000


def test_a_link_draws_from_the_seed_that_it_is_given():
    with raven2_trainer.Simulation(link="wifi") as simulation:
        simulation.start()
        begin = simulation.save()

        def path(seed):
            simulation.restore(begin)
            if seed is not None:
                simulation.reseed(seed)
            seen = []
            for _ in range(120):
                simulation.step({"gold": {"move": [0, 0, 5e-5]}}, ticks=5)
                seen.append(simulation.state.desired_tips_in_world[0].copy())
            return np.array(seen)

        first, second = path(1), path(2)
        assert not np.array_equal(first, second) and np.array_equal(first, path(1)) and np.array_equal(path(None), path(None))
        assert first[-1, 2] - first[0, 2] > 0.003 and second[-1, 2] - second[0, 2] > 0.003, "commands arrive"
        with pytest.raises(TypeError):
            simulation.reseed("x")


@pytest.mark.parametrize("hazard", ["put_usb_cmd_random", "comm_loss_30"])
def test_a_hazard_draws_from_the_seed_that_was_given_before_it(hazard):
    """The first one draws a number for each motor once, the second one which packets to the robot are lost."""
    with raven2_trainer.Simulation() as simulation:
        simulation.start()
        begin = simulation.save()

        def joints(seed):
            simulation.restore(begin)
            if seed is not None:
                simulation.reseed(seed)
            simulation.inject(hazard)
            seen = []
            for _ in range(60):
                simulation.step({"gold": {"move": [0, 0, 1e-3]}}, ticks=10)
                seen.append(simulation.state.robot_joints[0].copy())
            return np.array(seen)

        first, second, configured = joints(1), joints(2), joints(None)
        assert not np.array_equal(first, second) and np.array_equal(first, joints(1)) and np.array_equal(configured, joints(None))


def test_without_link_and_hazard_a_seed_changes_nothing_and_a_recorded_simulation_refuses_one(ready, tmp_path):
    begin, found = ready.save(), []
    for seed in (None, 7):
        ready.restore(begin)
        if seed is not None:
            ready.reseed(seed)
        ready.step({"gold": {"move": [0, 0, 0.005]}}, ticks=100)
        found.append(numbers(ready))
    assert found[0] == found[1]
    with raven2_trainer.Simulation(link="wifi", output=tmp_path / "session") as simulation:
        with pytest.raises(RuntimeError, match="has one seed"):
            simulation.reseed(7)


def test_a_restored_simulation_knows_what_is_under_way():
    with raven2_trainer.Simulation(robot="none", link="wan") as simulation:
        simulation.start()
        simulation.step({"gold": {"jaw": 0.6}}, ticks=20)
        snapshot = simulation.save()
        simulation.step(ticks=300)
        rest = numbers(simulation)
        simulation.restore(snapshot)
        simulation.step(ticks=300)
        assert numbers(simulation) == rest


def test_a_closed_simulation_says_so_and_keeps_its_last_state(ready):
    ready.close()
    for call in (ready.step, ready.start, ready.save, lambda: ready.inject("sudden_jump")):
        with pytest.raises(RuntimeError, match="is closed"):
            call()
    assert ready.state.joints.shape == (2, 7)


def test_a_snapshot_of_another_simulation_is_refused(ready):
    with raven2_trainer.Simulation(PICK) as other:
        with pytest.raises(ValueError, match="another simulation's"):
            ready.restore(other.save())


def test_a_view_outlives_its_simulation():
    simulation = raven2_trainer.Simulation(robot="none")
    simulation.start()
    joints = simulation.state.joints
    last = joints.copy()
    del simulation
    assert np.array_equal(joints, last)


def test_velocities_and_rotations_are_those_of_each_arms_joints(ready):
    ready.step({"gold": {"move": [0, 0, 0.01], "turn": [0, 0, 0.2]}, "green": {"move": [0.005, 0, 0], "turn": [0.1, 0, 0]}}, ticks=200)
    state, kinematics, axes = ready.state, raven2_trainer.Kinematics(), np.eye(3)
    for i, arm in enumerate(("gold", "green")):
        v, w = state.tip_rotations[i, :3], state.tip_rotations[i, 3]
        turned = (axes + 2 * np.cross(v, np.cross(v, axes) + w * axes)).T
        assert turned == pytest.approx(kinematics.forward(arm, state.joints[i])[1], abs=1e-9)
        velocity = kinematics.jacobian(arm, state.joints[i])[:3] @ state.joint_rates[i]
        assert state.tip_velocities[i] == pytest.approx(velocity, abs=1e-9) and np.linalg.norm(velocity) > 0.005


def test_the_true_joints_are_those_of_each_arm(ready):
    ready.step({"gold": {"move": [0, 0, 0.02]}}, ticks=800)
    ready.step(ticks=300)
    true, reported = (np.diff(joints[:, 2])[0] for joints in (ready.state.true_joints, ready.state.robot_joints))
    assert abs(reported) > 6e-3 and true == pytest.approx(reported, abs=3e-3), "the insertions differ"
