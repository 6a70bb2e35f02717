"""Tests of scripts/raven2_hazards.py on synthetic sessions, and of measure_hazards' report of a broken promise."""
import importlib.machinery
import importlib.util
import pathlib
import sys
import types

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import raven2_hazards  # noqa: E402
import raven2_lockstep  # noqa: E402

TOLERANCE = 0.003
HOMING = 100  # [ticks] before the first pedal-down
CYCLE = 5000  # robot's cycle that the haptic loop compares in session tick 0; the physics loop has the previous one
MODEL = np.dtype([("tick", "i8"), ("session_tick", "i8"), ("linked", "u1"), ("robot_fresh", "u1")])
ROBOT = np.dtype([("cycle", "u8"), ("frame", "u8"), ("runlevel", "u1"), ("soft_estopped", "u1")])
HAPTIC = np.dtype([("tick", "i8"), ("robot_cycle", "u8"), ("error", "f8", (2,)), ("force_B", "f8", (2, 3))])


class Made:
    """A lockstep session without a fault: 1000 ticks from the first pedal-down. Tests change it."""

    def __init__(self, length=1000):
        ticks = np.zeros(HOMING + length, [("model", MODEL), ("robot", ROBOT)])
        haptic = np.zeros(HOMING + length, [("haptic", HAPTIC)])
        number = np.arange(HOMING + length)
        ticks["model"]["tick"] = haptic["haptic"]["tick"] = 1 + number
        ticks["model"]["session_tick"] = np.maximum(number - HOMING, -1)
        ticks["model"]["linked"] = ticks["model"]["session_tick"] >= 0
        ticks["model"]["robot_fresh"] = 1
        ticks["robot"]["cycle"] = CYCLE + number - HOMING - 1
        ticks["robot"]["frame"] = 1 + number
        ticks["robot"]["runlevel"] = 3
        haptic["haptic"]["robot_cycle"] = CYCLE + number - HOMING
        self.log = types.SimpleNamespace(ticks=ticks, haptic=haptic, header={"tolerance": TOLERANCE})
        self.metrics, self.faults = {"faults": []}, {"injections": []}

    def model(self, name, first, last, value):
        self.log.ticks["model"][name][HOMING + first:HOMING + last + 1] = value

    def robot(self, name, first, last, value):
        self.log.ticks["robot"][name][HOMING + first:HOMING + last + 1] = value

    def parted(self, arm, first, last, metres):
        self.log.haptic["haptic"]["error"][HOMING + first:HOMING + last + 1, arm] = metres

    def pushed(self, arm, first, last, newton):
        self.log.haptic["haptic"]["force_B"][HOMING + first:HOMING + last + 1, arm, 1] = newton

    def injected(self, tick, host="robot", name="x", cycle=None):
        seen = CYCLE + tick - 1 if cycle is None else cycle
        self.faults["injections"].append({"name": name, "host": host, "inject": {"tick": tick, "cycle": seen}})

    def activation(self, first, end, name="x"):
        self.metrics["faults"].append(
            {"name": name, "first_tick": first, "first_cycle": CYCLE + first - 1, "end_tick": end})


@pytest.fixture
def made():
    return Made()


def delays(session):
    return [(c.beyond, c.delay) for c in raven2_hazards.Cue(session).crossings]


def test_rows_that_begin_together_are_one_time(made):
    for tick in (100, 100, 100, 400, 400):
        made.injected(tick)
    assert raven2_hazards.times(made.faults) == 2


def test_times_before_the_first_pedal_down_are_told_apart_by_the_robots_cycle(made):
    for cycle in (10, 10, 310, 610):  # an intermittent fault during homing; at first two rows begin together
        made.injected(-1, cycle=cycle)
    assert raven2_hazards.times(made.faults) == 3


def test_the_delay_counts_from_the_distance_that_the_haptic_loop_compared(made):
    made.parted(0, 200, 299, 0.004)
    made.pushed(0, 202, 299, 0.5)
    assert delays(made) == [(200, 2)]
    assert [c.beyond for c in raven2_hazards.Cue(made).broken()] == [200]


@pytest.mark.parametrize("late, kept", [(0, True), (1, True), (2, False)])
def test_the_promise_is_one_tick(made, late, kept):
    made.parted(1, 300, 399, 0.0031)
    made.pushed(1, 300 + late, 399, 0.1)
    assert (raven2_hazards.Cue(made).broken() == []) == kept


def test_every_crossing_counts_not_the_first_alone(made):
    for begin in (100, 300, 500):
        made.parted(0, begin, begin + 50, 0.010)
        made.pushed(0, begin + (7 if begin == 500 else 0), begin + 50, 1.0)
    assert delays(made) == [(100, 0), (300, 0), (500, 7)]


def test_a_force_on_the_other_hand_is_no_answer(made):
    made.parted(0, 100, 150, 0.010)
    made.pushed(1, 100, 150, 1.0)
    assert delays(made) == [(100, None)]
    assert len(raven2_hazards.Cue(made).broken()) == 1


def test_a_force_after_the_tips_are_together_again_is_no_answer(made):
    made.parted(0, 100, 150, 0.010)
    made.pushed(0, 151, 200, 1.0)
    assert delays(made) == [(100, None)]


def test_at_the_threshold_no_force_is_due(made):
    made.parted(0, 100, 150, TOLERANCE)
    assert delays(made) == []


@pytest.mark.parametrize("what", ["linked", "robot_fresh"])
def test_no_force_is_due_unless_both_move_from_a_common_pose_and_the_robot_speaks(made, what):
    made.parted(0, 100, 199, 0.010)
    made.pushed(0, 150, 199, 1.0)
    made.model(what, 100, 149, 0)
    assert delays(made) == [(150, 0)]


def test_nothing_counts_before_the_first_pedal_down(made):
    made.log.haptic["haptic"]["error"][:HOMING] = 0.010
    made.log.ticks["model"]["linked"] = 1
    assert delays(made) == []


def test_a_haptic_tick_without_its_physics_tick_is_not_judged(made):
    made.parted(0, 100, 100, 0.010)
    made.log.ticks = np.delete(made.log.ticks, HOMING + 100)
    assert delays(made) == []


def test_a_session_that_never_began_has_nothing_to_tell():
    made = Made(0)
    assert raven2_hazards.Cue(made).crossings == [] and raven2_hazards.Cue(made).events() == []
    made.log.ticks = made.log.ticks[:0]
    assert raven2_hazards.Cue(made).crossings == []
    assert raven2_hazards.ending(made, False) == "no frame"


@pytest.mark.parametrize("host, begin", [("robot", 499), ("relay", 500)])
def test_a_fault_in_the_robot_is_felt_a_tick_before_the_physics_loop_tells(made, host, begin):
    # GIVEN physics tick 500 is the first to report the cycle that haptic tick 499 compared
    made.injected(500, host)
    made.activation(500, 900)
    made.parted(0, 560, 600, 0.006)
    made.pushed(0, 560, 600, 0.9)
    [event] = raven2_hazards.Cue(made).events()
    assert (event.begin, event.onset) == (begin, 560 - begin)
    assert (event.parted, event.force) == (0.006, 0.9)


def test_what_acts_since_before_begins_with_the_session(made):
    made.injected(-1, cycle=CYCLE - 50)
    made.activation(0, None)
    made.parted(0, 738, 800, 0.006)
    [event] = raven2_hazards.Cue(made).events()
    assert (event.begin, event.onset) == (0, 738)


def test_what_is_behind_an_aftermath_is_not_the_faults(made):
    made.injected(100, "relay")
    made.activation(100, 700)
    made.parted(0, 800, 850, 0.020)
    made.pushed(0, 800, 850, 3.0)
    [event] = raven2_hazards.Cue(made).events()
    assert (event.crossings, event.parted, event.force, event.onset) == ([], 0.0, 0.0, None)


def test_a_stop_by_the_robots_own_check_is_read_and_not_inferred(made):
    assert raven2_hazards.stop_tick(made.log.ticks) is None
    made.robot("soft_estopped", 600, 999, 1)
    assert raven2_hazards.stop_tick(made.log.ticks) == 600
    made.robot("frame", 0, 999, 0)  # no frame has arrived
    assert raven2_hazards.stop_tick(made.log.ticks) is None


def test_the_ending_in_words(made):
    assert raven2_hazards.ending(made, True) == "PEDAL_DN"
    made.robot("runlevel", 900, 999, 0)
    assert raven2_hazards.ending(made, True) == "E-STOP"
    made.robot("soft_estopped", 700, 999, 1)
    assert raven2_hazards.ending(made, True) == "E-STOP, by its own check"
    made.robot("runlevel", 900, 999, 1)
    assert raven2_hazards.ending(made, False) == "never started: INIT"
    made.model("robot_fresh", 999, 999, 0)
    assert raven2_hazards.ending(made, True) == "INIT, silent"


def script(name):
    loader = importlib.machinery.SourceFileLoader(name, str(ROOT / "scripts" / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


def test_a_sweep_tells_the_stop_at_the_last_jump_and_adds_up_a_value():
    sweep = script("sweep_hazard")
    runs = [([5.0, 2.0, 19.04], 2, 24306), ([3.0, 4.0], 1, None)]
    assert sweep.row(800, 4, *runs[0]) == "| 800 | 4 | 5.0, 2.0, 19.0 | at 24.306 s |"
    assert sweep.row(800, 5, *runs[1]) == "| 800 | 5 | 3.0, 4.0 | no |"
    assert sweep.summary(800, runs) == "| 800 | 2.0 / 4.0 / 19.0 | 3 of 5 | 1 of 2 |"
    assert sweep.summary(800, [([], 0, 0), ([], 0, -1)]).endswith("| 2 of 2 |"), "a stop at tick 0 or earlier counts"


def test_measure_hazards_fails_where_the_promise_is_not_kept(made, monkeypatch, capsys):
    measure = script("measure_hazards")
    made.injected(200, "relay")
    made.activation(200, 900)
    made.parted(0, 240, 299, 0.005)
    monkeypatch.setattr(raven2_lockstep, "require_program", lambda: None)
    monkeypatch.setattr(raven2_lockstep, "simulate", lambda *options, **more: (made, True))
    monkeypatch.setattr(sys, "argv", ["measure_hazards", "--hazard", "x", "--jobs", "1"])
    made.pushed(0, 241, 299, 0.7)
    assert measure.main() == 0
    assert "| `x` | 1 | 40 | 1 | 5.0 | 0.70 | PEDAL_DN |" in capsys.readouterr().out
    made.pushed(0, 241, 241, 0.0)
    assert measure.main() == 1
    assert "Not kept: x, tick 240, force after 2 ticks" in capsys.readouterr().out
    made.pushed(0, 241, 299, 0.0)
    assert measure.main() == 1
    assert "Not kept: x, tick 240, no force" in capsys.readouterr().out


def test_a_value_is_replaced_in_one_place_or_not_at_all(tmp_path):
    file = tmp_path / "config/faults/x.yaml"
    file.parent.mkdir(parents=True)
    file.write_text("faults:\n  - kind: stuck_at\n    value: 800   # [counts]\n")
    raven2_lockstep.set_value(tmp_path, "x", 12)
    assert file.read_text() == "faults:\n  - kind: stuck_at\n    value: 12   # [counts]\n"
    file.write_text("  - value: 1\n    value: 2\n    value: 3\n")
    with pytest.raises(raven2_lockstep.LockstepError, match="2 places"):
        raven2_lockstep.set_value(tmp_path, "x", 12)
