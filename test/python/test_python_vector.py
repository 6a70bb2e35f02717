"""Tests VectorSimulation, which steps many simulations at once."""

import numpy as np
import pytest

from built_module import PICK, raven2_trainer


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


def test_many_that_could_not_be_made_leave_nothing_behind(tmp_path):
    raven2_trainer.Simulation(output=tmp_path / "1", robot="none").close()
    with pytest.raises(raven2_trainer.SessionError, match="already holds"):
        raven2_trainer.VectorSimulation(3, output=tmp_path, robot="none")
    assert [path.name for path in tmp_path.iterdir()] == ["1"]
