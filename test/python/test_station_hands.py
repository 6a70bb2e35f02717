"""Tests how the station adds up a page's motion, limits its speed, and lifts the pedal when the page is silent."""

import math
import pathlib
import random
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from raven2_station import frames, hands  # noqa: E402


def motion(move=(0, 0, 0), turn=(0, 0, 0), pedal=True, arm="gold"):
    return {"pedal": pedal, "arms": {arm: {"move": list(move), "turn": list(turn)}}}


def test_hands_add_up_and_are_cut_at_their_speed():
    device = hands.Hands()
    device.apply(motion(), 10.0)
    device.apply(motion((0.001, 0, 0)), 10.016)
    assert device.arms["gold"].position == pytest.approx([0.001, 0, 0])
    assert device.arms["green"].position == [0, 0, 0]
    device.apply(motion((5.0, 0, 0)), 10.026)
    assert device.arms["gold"].position[0] == pytest.approx(0.001 + hands.SPEED * 0.01)


def test_messages_in_a_bunch_lose_nothing():
    device = hands.Hands()
    device.apply(motion(), 10.0)
    for now in (10.016, 10.070, 10.071, 10.072, 10.073, 10.090):  # six messages of 60 Hz, four of them late
        device.apply(motion((0.012, 0, 0), (0, 0, 0.1)), now)
    for now in (10.106, 10.122, 10.138):
        device.apply(motion(), now)
    assert device.arms["gold"].position[0] == pytest.approx(0.072)
    assert 2 * math.asin(device.arms["gold"].orientation[2]) == pytest.approx(0.6)


@pytest.mark.parametrize("arm", ["gold", "green"])
def test_what_is_late_does_not_come_after_the_pedal(arm):
    device = hands.Hands()
    device.apply(motion(arm=arm), 10.0)
    device.apply(motion((5.0, 0, 0), arm=arm), 10.01)
    device.apply(motion(pedal=False, arm=arm), 10.02)
    before = device.arms[arm].position[0]
    device.apply(motion(arm=arm), 10.04)
    assert device.arms[arm].position[0] == before
    for i in range(30):
        device.apply(motion((5.0, 0, 0) if i == 0 else (0, 0, 0), arm=arm), 10.06 + 0.02 * i)
    assert device.arms[arm].position[0] == pytest.approx(before + hands.SPEED * hands.LONGEST), "at most 0.1 s late"


def test_the_other_arm_moves_alone():
    device = hands.Hands()
    device.apply({"pedal": True, "arms": {"green": {"move": [0, 0.001, 0], "turn": [0, 0, 0], "jaw": 0.0}}}, 1.0)
    assert device.arms["green"].position == pytest.approx([0, 0.001, 0]) and device.arms["green"].jaw == 0.0
    assert device.arms["gold"].position == [0, 0, 0] and device.arms["gold"].jaw > 0


@pytest.mark.parametrize("arm", ["gold", "green"])
def test_nothing_moves_with_the_pedal_up_but_back_to_the_middle(arm):
    device = hands.Hands()
    device.apply(motion((0.01, 0, 0), pedal=False, arm=arm), 1.0)
    assert device.arms[arm].position == [0, 0, 0]
    device.arms[arm].position = [1.5, 0, 0]
    device.apply(motion(pedal=False, arm=arm), 1.1)
    assert 1.3 < device.arms[arm].position[0] < 1.5


def test_what_is_late_of_either_hand_does_not_come_after_the_pedal():
    for arm in ("gold", "green"):
        device = hands.Hands()
        device.apply({"pedal": True, "arms": {arm: {"move": [0, 0, 0]}}}, 10.0)
        device.apply({"pedal": True, "arms": {arm: {"move": [5.0, 0, 0]}}}, 10.01)
        device.release()
        before = device.arms[arm].position[0]
        device.apply({"pedal": True, "arms": {arm: {"move": [0, 0, 0]}}}, 10.5)
        assert device.arms[arm].position[0] == before, arm


def test_rotations_are_about_the_axes_of_the_table_in_any_pose_of_the_hand():
    device = hands.Hands()
    device.apply(motion(), 0.0)
    device.apply(motion(turn=(0.8, 0, 0)), 0.1)
    device.apply(motion(turn=(0, 0, 0.1)), 0.2)
    right = frames.rotated(device.arms["gold"].orientation, [1, 0, 0])
    assert right == pytest.approx([math.cos(0.1), math.sin(0.1), 0.0], abs=1e-12)


def test_rotations_stay_unit_quaternions():
    device, source = hands.Hands(), random.Random(1)
    for i in range(500):
        device.apply(motion(turn=[source.uniform(-0.1, 0.1) for _ in range(3)]), 1.0 + 0.016 * i)
    assert math.sqrt(sum(v * v for v in device.arms["gold"].orientation)) == pytest.approx(1.0, abs=1e-12)
    device = hands.Hands()
    device.apply(motion(), 0.0)
    device.apply(motion(turn=(0, 0, 0.1)), 0.016)
    assert device.arms["gold"].orientation == pytest.approx([0, 0, math.sin(0.05), math.cos(0.05)])


def test_a_silent_page_lifts_the_pedal_within_100_ms():
    device = hands.Hands()
    device.apply(motion(), 1.0)
    assert not device.watch(0.999 + hands.SILENT) and device.pedal
    assert device.watch(1.0 + hands.SILENT + 0.001) and not device.pedal
    assert hands.SILENT + 0.02 <= 0.1
    assert not device.watch(5.0), "the pedal is up already"


def test_the_camera_key_alone_moves_the_camera_and_never_the_arms():
    """The console sends motion only with its pedal down; it must be up again before the camera's pedal."""
    device = hands.Hands()
    device.apply({**motion(pedal=False), "camera": True}, 10.0)
    assert not device.console_pedal and device.camera_pedal(10.0), "the trainer does not move the camera yet"
    device.see("camera_moving", False)
    device.apply({**motion((0.01, 0, 0), pedal=False), "camera": True}, 10.02)
    assert device.console_pedal and device.arms["gold"].position[0] > 0.005
    device.apply({**motion(pedal=False), "camera": False}, 10.04)
    assert not device.console_pedal and device.camera_pedal(10.1) and not device.camera_pedal(10.3)
    device.see("pedal_up", False)
    device.apply({**motion(pedal=False), "camera": True}, 10.5)
    assert not device.console_pedal


@pytest.mark.parametrize("modes, counts", [
    ([], True), (["teleoperating"], True), (["simulating"], True), (["trial"], True), (["executing"], True),  # only the page had stalled
    (["pedal_up"], True), (["pedal_up", "teleoperating"], True),           # of the time before the press
    (["teleoperating", "camera_moving", "teleoperating"], True),           # the same press moves the robot again
    (["teleoperating", "pedal_up"], False), (["trial", "stopped"], False)])  # something else had lifted the pedal
def test_a_key_held_over_a_stall_counts_again_unless_something_else_had_lifted_the_pedal(modes, counts):
    device, now = hands.Hands(), 1.0
    device.see("teleoperating", True)  # of another press
    for stall in range(2):
        device.apply(motion(), now)
        assert device.pedal == (counts or stall == 0)
        for mode in modes:
            device.see(mode, mode != "pedal_up")
        now += 0.1
        device.watch(now)
        assert not device.pedal
    device.apply(motion((0.001, 0, 0)), now)
    assert device.pedal == counts and (device.arms["gold"].position[0] > 0.0) == counts
    device.apply(motion(pedal=False), now + 0.016)
    device.apply(motion(), now + 0.032)
    assert device.pedal, "a new press counts"


@pytest.mark.parametrize("seconds, mode, counts", [
    (0.5, "pedal_up", True), (1.0, "pedal_up", False), (1.0, "teleoperating", True), (1.0, "camera_moving", True),
    (1.0, "executing", True), (1.0, "choosing", True)])
def test_a_refused_key_does_not_count_after_a_stall(seconds, mode, counts):
    """The page asked for another press. A stall is not one."""
    device = hands.Hands()
    device.see("pedal_up", False)
    for i in range(round(seconds / 0.02)):
        device.apply(motion(), 1.0 + 0.02 * i)
        device.see(mode, mode not in ("pedal_up", "camera_moving"))
    device.watch(1.1 + seconds)
    device.apply(motion(), 1.2 + seconds)
    assert device.pedal == counts


def test_a_stall_so_short_that_the_trainer_publishes_no_mode_refuses_no_key():
    device = hands.Hands()
    device.apply(motion(), 1.0)
    device.see("teleoperating", True)
    for begin in (1.2, 2.4):  # two stalls, held for 1 s between them
        device.watch(begin)
        for i in range(50):
            device.apply(motion(), begin + 0.003 + 0.02 * i)
            assert device.pedal, f"{begin} s"


@pytest.mark.parametrize("message", [
    None, [], "x", {}, {"pedal": 1}, {"pedal": True, "camera": "no"}, {"pedal": True, "arms": []}, {"pedal": True, "arms": {"blue": {}}},
    {"pedal": True, "arms": {"gold": {"move": [0, 0]}}}, {"pedal": True, "arms": {"gold": {"move": [0, 0, float("nan")]}}},
    {"pedal": True, "arms": {"gold": {"move": [0, 0, "1"]}}}, {"pedal": True, "arms": {"gold": {"turn": [0, 0, True]}}},
    {"pedal": True, "arms": {"gold": {"jaw": float("inf")}}}, {"pedal": True, "arms": {"gold": 3}},
    {"pedal": True, "arms": {"gold": {"jaw": 10 ** 400}}}, {"pedal": True, "arms": {"gold": {"move": [0, -10 ** 400, 0]}}}])
def test_a_message_that_is_wrong_changes_nothing(message):
    device = hands.Hands()
    device.apply(motion((0.001, 0, 0)), 1.0)
    before = (list(device.arms["gold"].position), device.pedal, device.arms["gold"].jaw)
    with pytest.raises(ValueError):
        device.apply(message, 1.016)
    assert (device.arms["gold"].position, device.pedal, device.arms["gold"].jaw) == before


def test_hands_that_the_instructor_took_stay_away_from_the_page_after_a_kill(tmp_path):
    file = tmp_path / "station_logs/hands_away"
    away = hands.Away(file)
    assert not away.is_on
    away.set(True)
    assert hands.Away(file).is_on
    away.set(False)
    assert not hands.Away(file).is_on
    (tmp_path / "station_logs").rmdir()
    (tmp_path / "station_logs").write_text("no folder")
    away.set(True)  # a disk that takes nothing
    assert away.is_on


def test_rotations_are_cut_at_their_speed_and_late_ones_at_a_tenth_of_a_second():
    device = hands.Hands()
    device.apply(motion(), 10.0)
    device.apply(motion(turn=(0, 0, 3.0)), 10.01)
    assert 2 * math.asin(device.arms["gold"].orientation[2]) == pytest.approx(hands.TURN_SPEED * 0.01)
    for i in range(30):
        device.apply(motion(), 10.03 + 0.02 * i)
    assert 2 * math.asin(device.arms["gold"].orientation[2]) == pytest.approx(hands.TURN_SPEED * hands.LONGEST)
