"""The module raven2_trainer: simulations and kinematics for programs (doc/python.md)."""

import copy
import json
import os
import pathlib
import pickle
import shutil
import subprocess
import sys
import tempfile
import threading

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
sys.path.insert(0, str(BUILD / "devel/lib/python3/dist-packages"))
raven2_trainer = pytest.importorskip("raven2_trainer._core", reason="the module is not built") and __import__("raven2_trainer")

PICK = "pick_hand_over_place"


def numbers(simulation):
    """All values of a state, as bytes."""
    s = simulation.state
    return b"".join(np.ascontiguousarray(a).tobytes() for a in (
        s.joints, s.joint_rates, s.torques, s.desired_joints, s.tips, s.robot_joints, s.dac, s.force, s.objects, s.true_joints)) + str(
            (s.tick, s.mode, s.runlevel, s.exercise)).encode()


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


@pytest.fixture(name="ready")
def started():
    with raven2_trainer.Simulation(PICK) as simulation:
        simulation.start()
        yield simulation


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


def test_many_side_by_side_are_as_each_alone():
    many = raven2_trainer.VectorSimulation(3, PICK, seed=7)
    many.start()
    commands = np.zeros((3, 2, 7))
    commands[:, 0, 2] = [1e-3, 2e-3, 3e-3]
    commands[:, :, 6] = 0.3
    many.step(commands, ticks=100)
    assert many.tips.shape == many.tips_in_world.shape == (3, 2, 3) and many.dac.shape == (3, 2, 7)
    assert many.mode == ["teleoperating"] * 3 and many.hazard.tolist() == [False] * 3 and many.exercise[2]["status"] == "waiting"
    assert many.tick.tolist() == [simulation.state.tick for simulation in many.simulations]
    assert [len(points) for points in many.contact_points] == [len(simulation.state.contact_points) for simulation in many.simulations]
    with raven2_trainer.Simulation(PICK, seed=8) as one:
        one.start()
        one.step(commands[1], ticks=100)
        assert np.array_equal(one.state.joints, many.joints[1])
    many.close()
    with pytest.raises(AttributeError, match="no attribute 'joint'"):
        many.joint  # pylint: disable=pointless-statement


def test_many_record_each_in_its_folder(tmp_path):
    with raven2_trainer.VectorSimulation(2, robot="none", seed=5, output=tmp_path / "all") as many:
        many.step(ticks=20)
    assert [raven2_trainer.Session(tmp_path / "all" / str(i)).meta["seed"] for i in range(2)] == [5, 6]
    assert all(simulation.closed for simulation in many.simulations)
    for n in (0, -1, 257, 2**70):
        with pytest.raises(ValueError, match="whole number from 1 to 256"):
            raven2_trainer.VectorSimulation(n)


def test_without_a_robot_the_model_moves_alone():
    with raven2_trainer.Simulation(robot="none") as simulation:
        simulation.start()
        before = simulation.state.tips.copy()
        simulation.step({"green": {"move": [0.008, 0, 0]}}, ticks=400)
        simulation.step(ticks=200)
        assert np.linalg.norm(simulation.state.tips[1] - before[1]) == pytest.approx(0.008, abs=3e-4)
        assert not simulation.state.robot_joints.any() and simulation.state.runlevel == "none"


def test_a_hazard_acts_when_it_is_injected(ready):
    ready.step(ticks=200)
    assert not ready.state.hazard
    ready.inject("sudden_jump")
    ready.step(ticks=100)
    assert ready.state.hazard and ready.state.error[0] > 0.0


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


def test_a_recorded_simulation_has_the_bytes_of_simulate(tmp_path):
    subprocess.run([BUILD / "devel/lib/raven2_trainer/simulate", "--exercise", PICK, "--motion", "expert", "--seed", "3", "--seconds", "2",
                    "--homing", "quick", "--output", tmp_path / "program"], check=True, capture_output=True)
    with raven2_trainer.Simulation(PICK, motion="expert", seed=3, output=tmp_path / "python") as simulation:
        while simulation.state.session_tick + 1 < 2000:
            simulation.step()
    assert (tmp_path / "python/session.rlog").read_bytes() == (tmp_path / "program/session.rlog").read_bytes()


def test_a_recorded_simulation_has_its_start_time_from_the_start_and_its_duration_at_the_end(tmp_path):
    def meta():
        return json.loads((tmp_path / "session/meta.json").read_text())

    simulation = raven2_trainer.Simulation(robot="none", output=tmp_path / "session")
    begun = meta()
    simulation.step(ticks=100)
    simulation.close()
    assert (begun["program"], begun["realtime"]) == ("python", "unknown: not ended cleanly")
    assert meta()["start_time_utc"] == begun["start_time_utc"] and meta()["realtime"] == "lockstep"
    assert meta()["wall_duration_s"] > begun["wall_duration_s"] >= 0


def test_motion_to_joint_set_points_is_spread_over_the_ticks(tmp_path):
    with raven2_trainer.Simulation(output=tmp_path / "session") as simulation:
        simulation.start()
        goal = simulation.state.joints[1] + [0.05, 0, 0, 0.08, 0, 0, 0]
        simulation.step({"green": {"joints": goal}}, ticks=200)
    commands = raven2_trainer.Session(tmp_path / "session").log.commands["command"]
    turned, moved = np.linalg.norm(commands["dq_I"][:, 1, :3], axis=1), np.linalg.norm(commands["dp_I"][:, 1], axis=1)
    for each in (turned, moved):
        assert 0 < each.max() < 1.5 * each.sum() / 200


def test_simulate_does_the_recorded_commands_with_the_same_bytes(tmp_path):
    random = np.random.default_rng(4)
    with raven2_trainer.Simulation(PICK, hazard="sudden_jump", seed=5, output=tmp_path / "python") as simulation:
        simulation.start()
        for i in range(40):
            arms = {arm: {"move": random.uniform(-2e-3, 2e-3, 3), "turn": random.uniform(-0.1, 0.1, 3), "jaw": random.uniform(0.0, 1.0)}
                    for arm in ("gold", "green")}
            simulation.step({**arms, "pedal": i % 7 != 6}, ticks=int(random.integers(1, 80)))
        joints = np.array(simulation.state.joints)
        joints[:, 2] += 0.004
        simulation.step({"gold": {"joints": joints[0]}, "green": {"joints": joints[1]}}, ticks=300)
    subprocess.run([BUILD / "devel/lib/raven2_trainer/simulate", "--exercise", PICK, "--drill", "sudden_jump", "--seed", "5", "--homing", "quick",
                    "--motion", f"commands:{tmp_path / 'python/commands.csv'}", "--output", tmp_path / "program"], check=True, capture_output=True)
    assert (tmp_path / "python/session.rlog").read_bytes() == (tmp_path / "program/session.rlog").read_bytes()


def test_commands_that_end_before_the_robot_is_ready_are_done_alike(tmp_path):
    with raven2_trainer.Simulation(seed=5, output=tmp_path / "python") as simulation:
        simulation.step({"gold": {"move": [0, 0, 1e-3], "jaw": 0.6}}, ticks=100)
    subprocess.run([BUILD / "devel/lib/raven2_trainer/simulate", "--seed", "5", "--hazard", "none", "--motion",
                    f"commands:{tmp_path / 'python/commands.csv'}", "--output", tmp_path / "program"], check=True, capture_output=True)
    assert (tmp_path / "python/session.rlog").read_bytes() == (tmp_path / "program/session.rlog").read_bytes()


@pytest.mark.parametrize("options, says", [
    (["--homing", "full"], "without --homing full"), (["--replay", "x"], "without --homing full and --replay"),
    (["--reaction", "400"], "heeds no force")])
def test_simulate_refuses_what_would_change_the_commands(tmp_path, options, says):
    file = ROOT / "test/fuzz/seeds/recording/commands"
    ended = subprocess.run([BUILD / "devel/lib/raven2_trainer/simulate", "--motion", f"commands:{file}", *options, "--output", tmp_path / "x"],
                           check=False, capture_output=True, text=True)
    assert ended.returncode != 0 and says in ended.stderr and not (tmp_path / "x").exists()
    with pytest.raises(ValueError, match="only the program simulate"):
        raven2_trainer.Simulation(motion=f"commands:{file}")


@pytest.mark.parametrize("command, says", [
    ({"gold": {"move": [0, 0]}}, "gold/move: expected 3 numbers"), ({"gold": {"move": [0, 0, np.nan]}}, "gold/move: not a finite number"),
    ({"gold": {"jump": 1}}, "gold/jump: unknown key"), ({"blue": {}}, "blue: unknown key"), ({"gold": 3}, "gold: expected a dict"),
    (np.zeros((2, 6)), "expected None, a dict or an array"), (np.full((2, 7), np.inf), "not a finite number"), ("x", "expected None"),
    ({"gold": {"joints": [0] * 7, "jaw": 1}}, "joints go alone"), ({"gold": {"move": "abc"}}, "gold/move: expected 3 numbers"),
    *(({"gold": {"move": move}}, "gold/move: expected 3 numbers") for move in (["0", "0", "1e-4"], [0, 0, 1j], [True, False, True], [0, 0, None])),
    *(({"pedal": pedal}, "pedal: expected True or False") for pedal in (np.nan, "False", "no", [0], [], None, 2, -1, 0.5, object(), np.zeros(2)))])
def test_a_wrong_command_is_refused_and_changes_nothing(ready, command, says):
    before = numbers(ready)
    with pytest.raises(ValueError, match=says.replace("(", r"\(")):
        ready.step(command)
    assert numbers(ready) == before


@pytest.mark.parametrize("pedal, is_down", [(True, 1), (False, 0), (np.True_, 1), (np.False_, 0), (1, 1), (0, 0), (np.int8(1), 1), (np.array(0), 0)])
def test_a_pedal_is_down_or_up(tmp_path, pedal, is_down):
    with raven2_trainer.Simulation(robot="none", output=tmp_path / "session") as simulation:
        simulation.start()
        simulation.step({"pedal": pedal}, ticks=20)
    assert raven2_trainer.Session(tmp_path / "session").log.ticks["model"]["pedal"][-1] == is_down


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


def test_wrong_settings_are_refused_with_the_programs_texts():
    with pytest.raises(raven2_trainer.ConfigError, match="did you mean"):
        raven2_trainer.Simulation("pick_hand_over_plase")
    with pytest.raises(raven2_trainer.ConfigError, match="did you mean"):
        raven2_trainer.Simulation(hazard="suden_jump")
    for settings in ({"robot": "real"}, {"seed": -1}, {"seed": 1.5}):
        with pytest.raises(ValueError):
            raven2_trainer.Simulation(**settings)
    for settings in ({"output": "/tmp/a\0b"}, {"output": b"/tmp/a\0b"}, {"config": "config\0/trainer.yaml"}):
        with pytest.raises(ValueError, match="null characters"):
            raven2_trainer.Simulation(**settings)
    with pytest.raises(ValueError, match="output is .* null characters"):
        raven2_trainer.VectorSimulation(2, output="/tmp/a\0b")
    for settings in ({"link": "wan\0.yaml"}, {"plant": "more_friction\0"}):
        with pytest.raises(ValueError, match="null characters"):
            raven2_trainer.Simulation(**settings)
    for settings in ({"output": False}, {"output": 3}, {"config": []}):
        with pytest.raises(TypeError):
            raven2_trainer.Simulation(**settings)
    for seed in (True, "1", None, 2**64, 1.5):
        with pytest.raises(ValueError, match="seed is"):
            raven2_trainer.Simulation(seed=seed)
        with pytest.raises(ValueError, match="seed is"):
            raven2_trainer.VectorSimulation(2, seed=seed)
    with pytest.raises(ValueError, match="seed is"):
        raven2_trainer.VectorSimulation(2, seed=2**64 - 1)
    for name in ("n", "threads"):
        for value in (0, -1, True, 2.5, "2"):
            with pytest.raises(ValueError, match=f"{name} is"):
                raven2_trainer.VectorSimulation(**{"n": 2, name: value})


def test_a_simulation_that_could_not_be_made_leaves_nothing_behind(tmp_path):
    raven2_trainer.Simulation(output=tmp_path / "session").close()
    for _ in range(3):
        with pytest.raises(raven2_trainer.SessionError, match="session"):
            raven2_trainer.Simulation(output=tmp_path / "session")
        with raven2_trainer.Simulation(robot="none") as simulation:
            simulation.step(ticks=5)
            assert np.isfinite(simulation.state.joints).all()


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


def test_a_hazard_that_could_not_act_without_a_robot_is_refused():
    for hazard in ("sudden_jump", "net_loss_10"):
        for settings in ({"hazard": hazard}, {"exercise": PICK, "hazard": hazard}):
            with pytest.raises(ValueError, match=f"{hazard} acts on the robot"):
                raven2_trainer.Simulation(robot="none", **settings)
    with raven2_trainer.Simulation(robot="none") as simulation:
        simulation.inject("master_sluggish")
        with pytest.raises(ValueError, match="sudden_jump acts on the robot"):
            simulation.inject("sudden_jump")


def moved(**options):
    """Joints after a short fast motion of the gold arm, and after a rest."""
    with raven2_trainer.Simulation(**options) as simulation:
        simulation.start()
        simulation.step({"gold": {"move": [0, 0.02, 0]}}, ticks=100)
        fast = simulation.state.joints[0].copy()
        simulation.step(ticks=400)
        return fast, simulation.state.joints[0].copy(), simulation.state.robot_joints[0].copy()


def test_settings_plant_and_link_change_what_they_name():
    usual = moved()
    sticky = moved(settings={"model/coulomb_friction": np.array([4.0, 4.0, 9.0, 0, 0, 0, 0])})
    assert np.abs(sticky[0] - usual[0])[:2].min() > 0.01, "both joints lag by their friction"
    worn = moved(plant="more_friction")
    assert np.abs(worn[2] - usual[2])[:3].max() > 1e-4
    late = moved(link="wan")
    assert np.abs(late[0] - usual[0]).max() > 1e-4 and np.array_equal(late[1], moved(link="wan")[1])


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


def test_many_at_once_raise_what_one_would_and_none_is_stepped():
    many = raven2_trainer.VectorSimulation(3, robot="none")
    for command, says in (({"gold": {"move": [0, 0, 0.5]}}, "take more ticks"), ({"gold": {"turn": [1e154, 1e154, 0]}}, "over 3.14 rad")):
        with pytest.raises(ValueError, match=says):
            many.step([None, command, None], ticks=2)
    many.simulations[2].close()
    with pytest.raises(RuntimeError, match="closed"):
        many.step(ticks=2)
    assert [simulation.state.tick for simulation in many.simulations] == [0, 0, 0]


def test_of_many_that_are_closed_one_that_fails_leaves_no_other_open(monkeypatch, tmp_path):
    many = raven2_trainer.VectorSimulation(3, robot="none", output=tmp_path / "all")
    many.step(ticks=5)

    def fail():
        raise raven2_trainer.SessionError("the disk is full")

    with monkeypatch.context() as broken, pytest.raises(raven2_trainer.SessionError, match="the disk is full"):
        broken.setattr(many.simulations[0], "close", fail)
        many.close()
    assert [simulation.closed for simulation in many.simulations] == [False, True, True]
    many.close()


def alone(program, folder, *arguments):
    """The end of a program in another Python: it could end this one."""
    return subprocess.run([sys.executable, "-c", "import os, signal, sys, threading, time\nimport numpy as np\nimport raven2_trainer\n" + program, *arguments],
                          cwd=folder, capture_output=True, text=True, timeout=120, check=False,
                          env=dict(os.environ, PYTHONPATH=str(BUILD / "devel/lib/python3/dist-packages")))


CLEARED = """
many = raven2_trainer.VectorSimulation(2, robot="none")
stepping = threading.Thread(target=lambda: many.step(ticks=5000))
stepping.start()
time.sleep(0.1)
many.simulations.clear()
stepping.join()
"""
CHANGED = """
class Array:
    def __array__(self, *_):
        many.simulations[0] = None
        return np.zeros((2, 7))
many = raven2_trainer.VectorSimulation(2, robot="none")
many.step([Array(), Array()])
class Key(str):
    def __str__(self):
        command.clear()
        return "move"
    __hash__ = str.__hash__
command = {Key("move"): [0.0, 0.0, 0.0]}
raven2_trainer.Simulation(robot="none").step({"gold": command})
"""


@pytest.mark.parametrize("program", [CLEARED, CHANGED])
def test_what_a_caller_takes_away_meanwhile_ends_nothing(program, tmp_path):
    done = alone(program, tmp_path)
    assert done.returncode == 0, done.stderr


def test_ctrl_c_ends_a_long_step(tmp_path):
    done = alone("""
simulation = raven2_trainer.Simulation(robot="none")
threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    simulation.step(ticks=1000000)
except KeyboardInterrupt:
    print(simulation.state.tick < 1000000)
simulation.step(ticks=5)
""", tmp_path)
    assert (done.returncode, done.stdout) == (0, "True\n"), done.stderr


def test_ctrl_c_ends_many_long_steps(tmp_path):
    done = alone("""
many = raven2_trainer.VectorSimulation(3, robot="none", threads=2)
threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    many.step(ticks=1000000)
except KeyboardInterrupt:
    print(bool((many.tick < 1000000).all()))
many.step(ticks=5)
""", tmp_path)
    assert (done.returncode, done.stdout) == (0, "True\n"), done.stderr


@pytest.mark.parametrize("ticks", [20, 1000000])
def test_a_thread_that_steps_when_the_program_ends_does_not_abort_it(tmp_path, ticks):
    done = alone("""
simulation = raven2_trainer.Simulation(robot="none")
threading.Thread(target=lambda: [simulation.step(ticks=int(sys.argv[1])) for _ in iter(int, 1)], daemon=True).start()
time.sleep(0.3)
print("ends")
""", tmp_path, str(ticks))
    assert (done.returncode, done.stdout, done.stderr) == (0, "ends\n", "")


def test_a_signal_may_close_the_simulation_that_is_stepped(tmp_path):
    done = alone("""
simulation = raven2_trainer.Simulation(robot="none", output="session")
signal.signal(signal.SIGALRM, lambda *_: simulation.close())
signal.setitimer(signal.ITIMER_REAL, 0.5)
try:
    simulation.step(ticks=1000000)
except RuntimeError as error:
    print(error, simulation.closed, os.path.exists("session/metrics.json"))
""", tmp_path)
    assert (done.returncode, done.stdout) == (0, "the simulation is closed True True\n"), done.stderr


def test_a_forked_process_leaves_the_recording_and_the_pictures_alone(tmp_path):
    done = alone("""
simulation = raven2_trainer.Simulation(output="made")
simulation.start()
simulation.step({"gold": {"move": [0, 0, 0.001]}}, ticks=100)

for has_drawn in (False, True):
    if has_drawn:
        simulation.render("endoscope", 64, 64)
    if os.fork() == 0:
        for call in (simulation.step, simulation.close, *(has_drawn * [lambda: simulation.render("endoscope", 64, 64)])):
            try:
                call()
                os._exit(1)
            except (RuntimeError, raven2_trainer.RenderError) as error:
                assert "fork" in str(error), error

        del simulation, call
        # As multiprocessing ends: the drawing library would wait for its threads.
        os._exit(0) if has_drawn else sys.exit(0)
    assert os.wait()[1] == 0

simulation.step({"gold": {"move": [0, 0, 0.001]}}, ticks=2000)
ticks = simulation.state.tick
simulation.close()
log = raven2_trainer.Session("made").log
assert log.clean and log.bad_bytes == 0 and len(log.ticks) == ticks, (log.clean, log.bad_bytes, len(log.ticks), ticks)
assert open("made/commands.csv").read().count("pedal") == 1
""", tmp_path)
    assert done.returncode == 0, done.stderr


def test_a_recording_ends_where_it_began_and_says_so_if_it_cannot(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    simulation = raven2_trainer.Simulation(output="made")
    simulation.start()
    simulation.step(ticks=50)
    monkeypatch.chdir(tmp_path / "elsewhere")
    simulation.close()
    assert (tmp_path / "made/metrics.json").exists() and not list((tmp_path / "elsewhere").iterdir())
    lost = raven2_trainer.Simulation(output=tmp_path / "lost")
    lost.start()
    (tmp_path / "lost").rename(tmp_path / "away")
    for _ in range(2):
        with pytest.raises(raven2_trainer.SessionError, match="lost"):
            lost.close()


def test_hazards_that_do_not_fit_are_refused_and_not_forgotten(ready):
    names = ("sudden_jump", "encoder_dead", "attack_dac_add", "packet_delay", "grasper_runaway", "unavailable_recoverable", "fk_pos", "fk_vel", "jpos_d")
    with pytest.raises(RuntimeError, match="clear_hazards"):
        for name in names:
            ready.inject(name)
            ready.step(ticks=2)
    ready.clear_hazards()
    ready.step(ticks=2)
    ready.inject("encoder_dead")
    ready.step(ticks=20)
    assert ready.state.hazard
    with pytest.raises(RuntimeError, match="step first|clear_hazards"):
        for _ in range(100):
            ready.inject("encoder_dead")


EIGHT_ROWS = ("sudden_jump", "attack_dac_add", "packet_delay", "grasper_runaway", "unavailable_recoverable", "fk_pos", "fk_vel")  # kMaxFaults


def test_after_all_hazards_are_cleared_another_one_fits_at_once(ready):
    for name in EIGHT_ROWS:
        ready.inject(name)
    ready.step(ticks=2)
    ready.clear_hazards()
    ready.inject("encoder_dead")
    ready.step(ticks=20)
    assert ready.state.hazard


def test_a_restored_simulation_knows_what_hazards_it_was_asked_for(ready):
    for name in EIGHT_ROWS:
        ready.inject(name)
    ready.restore(ready.save())
    with pytest.raises(RuntimeError, match="clear_hazards"):
        ready.inject("encoder_dead")


def test_jaws_reach_their_goal_while_a_hazard_keeps_the_packets_back():
    """master_sluggish: each packet comes 200 ms late. A command that is under way is not sent again."""
    with raven2_trainer.Simulation(robot="none") as simulation:
        simulation.start()
        simulation.inject("master_sluggish")
        simulation.step(ticks=500)
        openings = []
        for call in range(200):
            simulation.step({"gold": {"jaw": 0.6}, "green": {"jaw": 0.9}} if call == 0 else None, ticks=5)
            openings.append(simulation.state.desired_joints[:, 5:].sum(axis=1))
        assert openings[-1] == pytest.approx([0.6, 0.9], abs=0.01)
        assert (np.min(openings, axis=0) > np.array([0.6, 0.9]) - 0.01).all(), "wide open at first, and never closed farther"


def test_a_link_is_that_of_the_own_configuration(tmp_path):
    for part in ("config", "urdf", "meshes"):
        (tmp_path / part).symlink_to(ROOT / part) if part != "config" else shutil.copytree(ROOT / part, tmp_path / part)
    path = tmp_path / "config/impairments/wan.yaml"
    path.write_text(path.read_text().replace("constant_ms: 40.0", "constant_ms: 400.0"))

    def late(**options):
        with raven2_trainer.Simulation(robot="none", link="wan", **options) as simulation:
            simulation.start()
            before = simulation.state.desired_joints.copy()
            simulation.step({"gold": {"move": [0, 0, 0.005]}}, ticks=50)
            simulation.step(ticks=100)
            return np.array_equal(simulation.state.desired_joints, before)

    assert late(config=tmp_path / "config/trainer.yaml") and not late()


def test_settings_that_are_not_good_are_refused_with_their_key():
    for settings, says in (({"model/contact_mo": 1}, r"model/contact_mo|contact_mo"), ({"model/contact_mu": -1}, r"contact_mu"),
                           ({"model/contact_mu": float("nan")}, "contact_mu"), ({"injection/enable": False}, "files alone"),
                           ({"model/viscous_friction": [1, 2]}, "viscous_friction")):
        with pytest.raises(raven2_trainer.ConfigError, match=says):
            raven2_trainer.Simulation(settings=settings)
    for options in ({"plant": "wood"}, {"link": "string"}, {"motion": "expert"}, {"motion": "clumsy:bear"}, {"motion": "dance"}):
        with pytest.raises(raven2_trainer.ConfigError, match="wood|string|needs an exercise|dance"):
            raven2_trainer.Simulation(**options)
    with pytest.raises(ValueError, match="robot is 'none'"):
        raven2_trainer.Simulation(robot="none", plant="worn_tool")


def test_none_is_no_hazard_to_inject(ready):
    with pytest.raises(ValueError, match="clear_hazards"):
        ready.inject("none")


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


def test_a_picture_shows_the_motion_of_a_tool(ready):
    first = ready.render("endoscope", 320, 240)
    assert first.shape == (240, 320, 3) and first.dtype == np.uint8 and first.std() > 10
    assert np.array_equal(ready.render("endoscope", 320, 240), first), "the same state, the same pixels"
    ready.step({"gold": {"move": [0.01, 0, 0]}}, ticks=400)
    assert np.abs(ready.render("endoscope", 320, 240).astype(int) - first).max() > 50
    assert {"overview", "endoscope", "top"} <= set(ready.cameras)


def test_pictures_show_what_a_hazard_of_the_video_does():
    with raven2_trainer.Simulation(PICK) as simulation:
        simulation.start()
        clear = simulation.render("endoscope", 80, 60)
        simulation.inject("video_loss")
        simulation.step(ticks=100)
        assert simulation.state.hazard and not simulation.render("endoscope", 80, 60).any() and not simulation.render("top", 80, 60).any()
        simulation.clear_hazards()
        simulation.step(ticks=100)
        assert np.abs(simulation.render("endoscope", 80, 60).astype(int) - clear).max() < 100
        simulation.inject("video_freeze")
        simulation.step(ticks=50)
        frozen, before = simulation.render("endoscope", 80, 60), simulation.save()
        simulation.step({"gold": {"move": [0, 0, 0.02]}}, ticks=400)
        assert np.array_equal(simulation.render("endoscope", 80, 60), frozen)
        simulation.clear_hazards()
        simulation.step(ticks=100)
        assert not np.array_equal(simulation.render("endoscope", 80, 60), frozen), "the tool has moved"
        simulation.restore(before)
        assert np.array_equal(simulation.render("endoscope", 80, 60), frozen), "a snapshot has the frozen picture"


def test_help_has_the_stubs_texts():
    assert raven2_trainer.State.joints.__doc__.startswith("(2, 7) [rad; m")
    for function in (raven2_trainer.Simulation.step, raven2_trainer.Simulation.render, raven2_trainer.Kinematics.forward, raven2_trainer.Planner.plan):
        assert "[m]" in function.__doc__ or "(height, width, 3)" in function.__doc__, function


@pytest.mark.parametrize("arguments, says", [(("endoscop",), "endoscop"), (("top", 0, 10), "expected 1 to 4096"), (("top", 10, 5000), "expected 1 to 4096")])
def test_a_wrong_picture_is_refused(ready, arguments, says):
    with pytest.raises(ValueError, match=says):
        ready.render(*arguments)


JUNK = (None, True, -1, 0, 3, 2**70, 1e300, float("nan"), "", "gold", b"\xff\x00", [], [1, 2, 3], {}, {"gold": {}}, {"gold": {"joints": "x"}}, {1: 2},
        object(), np.zeros(7), np.zeros((2, 7)), np.zeros((2, 7), dtype=complex), np.full((2, 7), "a"), np.zeros((0, 7)), [[None] * 7] * 2,
        lambda: 1, Ellipsis, np.zeros((2, 7))[::-1, ::-1])


def test_nothing_that_a_caller_passes_ends_the_interpreter(ready):
    """Calls everything with random arguments from a seed. Each call works or raises, and the simulation continues."""
    random = np.random.default_rng(11)
    snapshot, kinematics = ready.save(), raven2_trainer.Kinematics()
    calls = [ready.step, ready.start, ready.restore, ready.inject, ready.render, kinematics.forward, kinematics.inverse, kinematics.jacobian,
             raven2_trainer._core.step_all, raven2_trainer.Simulation, raven2_trainer.VectorSimulation, lambda x=None: setattr(ready.state, "tips", x)]
    raised = 0
    for _ in range(250):
        call = calls[random.integers(len(calls))]
        arguments = [JUNK[random.integers(len(JUNK))] for _ in range(random.integers(1, 4))]
        try:
            call(*arguments)
        except Exception:  # pylint: disable=broad-except
            raised += 1
    assert raised > 125
    ready.restore(snapshot)
    ready.start()
    ready.step(ticks=10)
    assert np.isfinite(ready.state.joints).all()


def test_a_simulation_is_not_copied(ready):
    for thing in (ready, ready.state, ready.save()):
        for copied in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(TypeError):
                copied(thing)


BLANK = """
from raven2_trainer import _core

def refuses(call, *arguments):
    try:
        call(*arguments)
    except RuntimeError as error:
        return "__init__ has not been called" in str(error)
    except TypeError:
        return False
    raise SystemExit(f"{call} has worked without a value")

blanks = [kind.__new__(kind) for kind in (_core.Simulation, _core.State, _core.Snapshot, _core.Kinematics, _core.Planner)]

def is_method(kind, name):
    return not isinstance(getattr(kind, name), property)


for blank in blanks:
    for name in dir(blank):
        if name.startswith("_"):
            continue
        if is_method(type(blank), name):
            method = getattr(blank, name)
            assert any([refuses(method, *[None] * count) for count in range(12)]), (blank, name)
        else:
            assert refuses(getattr, blank, name), (blank, name)

assert refuses(_core.step_all, blanks[:1], [None], 1, 1)
"""


def test_an_object_without_its_constructor_raises_and_does_not_crash():
    subprocess.run(["/usr/bin/python3", "-c", BLANK], check=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(
        [str(BUILD / "devel/lib/python3/dist-packages"), "/usr/lib/python3/dist-packages"])})


def test_the_messages_are_there_without_the_simulator():
    code = "import sys; from raven2_trainer.msg import TrainerMode; assert 'raven2_trainer._core' not in sys.modules; print(TrainerMode().mode)"
    subprocess.run(["/usr/bin/python3", "-c", code], check=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(
        [str(BUILD / "devel/lib/python3/dist-packages"), "/usr/lib/python3/dist-packages"])})


# ---- planner, sessions, campaigns


@pytest.fixture(scope="module", name="planner")
def made():
    return raven2_trainer.Planner()


@pytest.fixture(scope="module", name="home")
def joints_at_rest():
    with raven2_trainer.Simulation() as simulation:
        simulation.start()
        return simulation.state.joints.copy()


def test_one_exception_is_for_sessions_that_cannot_be_read_or_written(tmp_path):
    (tmp_path / "file").touch()
    for use in (lambda: raven2_trainer.Session(tmp_path / "none"),
                lambda: raven2_trainer.Simulation(output=tmp_path / "file" / "session")):
        with pytest.raises(raven2_trainer.SessionError) as refused:
            use()
        assert isinstance(refused.value, RuntimeError) and str(tmp_path) in str(refused.value)


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


def test_a_path_into_the_other_arm_touches_it(planner, home):
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


def test_what_is_wrong_with_a_model_is_said_as_by_the_program(tmp_path):
    for part in ("config", "urdf"):
        shutil.copytree(ROOT / part, tmp_path / part)
    (tmp_path / "meshes").symlink_to(ROOT / "meshes")
    scene = tmp_path / "urdf/frs_trainer.urdf"
    scene.write_text(scene.read_text().replace('<collision name="', '<collision name="wooden_', 1))
    root = tmp_path / "config/trainer.yaml"
    with pytest.raises(raven2_trainer.ModelError, match="expected a material of config/model.yaml") as refused:
        raven2_trainer.Simulation(config=root)
    done = subprocess.run([BUILD / "devel/lib/raven2_trainer/simulate", "--config", root, "--seconds", "1", "--output", tmp_path / "session"],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 1 and str(refused.value).split(": ", 1)[1] in done.stderr
    robot = tmp_path / "urdf/raven2.urdf"
    robot.write_text(robot.read_text().replace("</robot>", ""))
    with pytest.raises(raven2_trainer.ModelError, match="raven2.urdf"):
        raven2_trainer.Planner(config=root)


def test_the_stubs_name_what_there_is():
    import ast
    stubs = {node.name: node for node in ast.parse((ROOT / "python/raven2_trainer/__init__.pyi").read_text()).body if isinstance(node, ast.ClassDef)}
    functions = {"outcomes"}
    assert set(stubs) | functions == set(raven2_trainer.__all__)
    of_instances = {"VectorSimulation": None, "Session": {"log", "metrics", "faults", "meta"}, "Campaign": {"definition"}}
    for name, stub in stubs.items():
        said = {node.name for node in stub.body if isinstance(node, ast.FunctionDef)}
        said |= {node.target.id for node in stub.body if isinstance(node, ast.AnnAssign)}
        made = getattr(raven2_trainer, name)
        there = {member for member in dir(made) if not member.startswith("_")}
        if issubclass(made, BaseException):
            continue
        if name == "VectorSimulation":  # has what a state has
            assert {s for s in said if not s.startswith("_")} == there - {"LISTS"} | {"simulations"} | {
                member for member in dir(raven2_trainer.State) if not member.startswith("_")}, name
        else:
            assert {s for s in said if not s.startswith("_")} == there | of_instances.get(name, set()), name


def test_what_cannot_be_planned_says_why(planner, home):
    assert planner.plan("green", home[1], [10.0, 0, 0])["status"] == "goal_unreachable"
    assert planner.in_collision("green", home).shape == (2,)
    for arguments in (("green", home[1], [0, 0]), ("blue", home[1], home[0]), ("green", home[1][:6], home[0]), ("green", home[1] * np.nan, home[0])):
        with pytest.raises(ValueError):
            planner.plan(*arguments)


def test_a_session_is_read_as_arrays(tmp_path):
    with raven2_trainer.Simulation(motion="scripted", robot="virtual", output=tmp_path / "session") as simulation:
        while simulation.state.session_tick < 300:
            simulation.step(ticks=10)
        last = simulation.state.joints.copy()
    session = raven2_trainer.Session(str(tmp_path / "session"))
    ticks = session.log.ticks
    assert np.array_equal(ticks["model"]["arms"]["q"][-1], last)
    table = session.table()
    assert [table[f"model.arms.1.q.{joint}"][-1] for joint in range(7)] == last[1].tolist()
    assert all(column.shape == ticks.shape and column.dtype.names is None for column in table.values())
    assert len(session.table("commands")["command.sequence"]) == len(session.log.commands) > 0


def test_a_campaign_is_defined_run_and_read(tmp_path):
    fault = {"host": "robot", "site": "put_usb_packet", "variable": "dac", "kind": "stuck_at", "arm": ["gold", "green"], "channel": "shoulder",
             "value": [-20000, 0], "start": {"trigger": "pedal_down", "first_tick": 300}, "duration_ticks": 100}
    campaign = raven2_trainer.Campaign({
        "name": "four", "title": "Four", "source": "none", "plant": "identified", "homing": "quick", "arm_contacts": False, "cpu_limit": 20,
        "horizon_ticks": {"homing": 300, "pedal_down": 400}, "limits": {"masked": 1e-4, "jump": 1e-3, "still": 3e-4, "moved": 1e-3, "force": 0.05},
        "scenarios": [{"scenario": "dac", "injection": 0, "number": 0, "observed": "none", "published": [], "phase": "pedal_down",
                       "repetitions": 1, "faults": [fault]}]})
    rows = campaign.run(tmp_path / "out", seed=2)
    assert [row["run"] for row in rows] == [1, 2, 3, 4]
    assert {row["outcome"] for row in rows if row["value"] == -20000} <= {"estop", "unsafe_jump"}
    assert raven2_trainer.outcomes(tmp_path / "out") == rows
    for other in (campaign, raven2_trainer.Campaign("no_such_campaign")):
        with pytest.raises(RuntimeError, match="holds a campaign|no campaign|no_such"):
            other.run(tmp_path / "out", seed=99)
    assert [path.name for path in tmp_path.iterdir()] == ["out"], "nothing is left next to it"
    elsewhere = raven2_trainer.Campaign({"name": "../elsewhere", "cpu_limit": np.int64(3)})
    with pytest.raises(RuntimeError, match="name holds a /"):
        elsewhere.run(tmp_path / "none")
    assert not list(pathlib.Path(tempfile.gettempdir()).glob("elsewhere*"))
    with pytest.raises(RuntimeError, match="no campaign|nowhere"):
        raven2_trainer.Campaign("nowhere").run(tmp_path / "none")


def test_depth_and_parts_are_those_of_the_scene(ready):
    """Seen from above: the back-projected pixels of the ring are at the ring's position."""
    depth, part = ready.measure("top", 640, 480)
    assert depth.shape == part.shape == (480, 640) and depth.dtype == np.float32
    assert np.isinf(depth[part == 0]).all() and np.isfinite(depth[part > 0]).all()
    ring = part == ready.part_names.index(ready.object_names[0])
    assert ring.sum() > 10
    focal = 240 / np.tan(0.3)  # config/render.yaml: 1.5 m above the middle, vertical_fov 0.6, up is x of the world
    v, u = np.nonzero(ring)
    z = depth[ring]
    seen = np.stack([-(v - 239.5) * z / focal, -(u - 319.5) * z / focal, 1.5 - z])
    middle = (seen.min(axis=1) + seen.max(axis=1)) / 2
    assert middle[:2] == pytest.approx(ready.state.objects[0, :2], abs=0.004)
    assert abs(seen[2].mean() - ready.state.objects[0, 2]) < 0.03
    names = {ready.part_names[i] for i in np.unique(part)}
    assert any("_L" in name for name in names) and any("_R" in name for name in names), names


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


def test_a_relative_configuration_outlives_a_change_of_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    simulation = raven2_trainer.Simulation(config="config/trainer.yaml", robot="none", output=tmp_path / "s")
    monkeypatch.chdir(tmp_path)
    simulation.start()
    simulation.close()
    session = raven2_trainer.Session("s")
    assert session.meta["realtime"] == "lockstep"
    monkeypatch.chdir("/")
    assert session.file("commands.csv")


def test_jaws_asked_for_with_the_pedal_up_do_not_move_later():
    with raven2_trainer.Simulation(robot="none") as simulation:
        simulation.start()
        simulation.step(ticks=100)
        before = simulation.state.joints[0, 5:].sum()
        simulation.step({"gold": {"jaw": 0.2}, "pedal": False}, ticks=100)
        simulation.step(ticks=500)
        assert simulation.state.joints[0, 5:].sum() == pytest.approx(before, abs=0.02)


@pytest.mark.parametrize("record, field", [("ticks", "model.mode"), ("tick", "model.mood"), ("tick", "model.tick")])
def test_a_name_that_a_log_does_not_have_is_said(tmp_path, record, field):
    raven2_trainer.Simulation(robot="none", output=tmp_path / "s").close()
    log = raven2_trainer.Session(tmp_path / "s").log
    with pytest.raises(ValueError, match="ticks|mood|model.tick"):
        log.names(record, field)


def test_many_that_could_not_be_made_leave_nothing_behind(tmp_path):
    raven2_trainer.Simulation(output=tmp_path / "1", robot="none").close()
    with pytest.raises(raven2_trainer.SessionError, match="already holds"):
        raven2_trainer.VectorSimulation(3, output=tmp_path, robot="none")
    assert [path.name for path in tmp_path.iterdir()] == ["1"]


@pytest.mark.parametrize("kind", [complex, str, bool])
def test_a_place_of_other_kinds_is_refused(kind):
    with pytest.raises(ValueError, match="p, R"):
        raven2_trainer.Kinematics().inverse("gold", np.ones(3).astype(kind), np.eye(3))


def test_a_campaigns_wrong_seed_is_said(tmp_path):
    for seed in (-1, 2**64, 1.5, True, "1"):
        with pytest.raises(ValueError, match="seed is"):
            raven2_trainer.Campaign({"name": "x"}).run(tmp_path / "out", seed=seed)


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
