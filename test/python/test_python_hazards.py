"""Tests how hazards are injected into a Simulation, cleared, counted and refused."""

import numpy as np
import pytest

from built_module import PICK, raven2_trainer


def test_a_hazard_acts_when_it_is_injected(ready):
    ready.step(ticks=200)
    assert not ready.state.hazard
    ready.inject("sudden_jump")
    ready.step(ticks=100)
    assert ready.state.hazard and ready.state.error[0] > 0.0


def test_a_hazard_that_could_not_act_without_a_robot_is_refused():
    for hazard in ("sudden_jump", "net_loss_10"):
        for settings in ({"hazard": hazard}, {"exercise": PICK, "hazard": hazard}):
            with pytest.raises(ValueError, match=f"{hazard} acts on the robot"):
                raven2_trainer.Simulation(robot="none", **settings)
    with raven2_trainer.Simulation(robot="none") as simulation:
        simulation.inject("master_sluggish")
        with pytest.raises(ValueError, match="sudden_jump acts on the robot"):
            simulation.inject("sudden_jump")


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


def test_none_is_no_hazard_to_inject(ready):
    with pytest.raises(ValueError, match="clear_hazards"):
        ready.inject("none")
