"""Parts of the station that need neither ROS nor a network: hands, choices, session files, access, messages, words."""

import asyncio
import contextlib
import fcntl
import http.client
import json
import math
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import types
import zlib

import psutil
import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import raven2_session  # noqa: E402
from raven2_station import access, clients, curriculum, finisher, frames, hands, library, records, ros_link, server, supervisor, wire, words  # noqa: E402
from raven2_station import station as station_module  # noqa: E402


@pytest.fixture(scope="module")
def known():
    return library.Library(ROOT)


# ---- hands


def motion(move=(0, 0, 0), turn=(0, 0, 0), pedal=True, **more):
    return {"pedal": pedal, "arms": {"gold": {"move": list(move), "turn": list(turn)}, **more}}


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


def test_what_is_late_does_not_come_after_the_pedal():
    device = hands.Hands()
    device.apply(motion(), 10.0)
    device.apply(motion((5.0, 0, 0)), 10.01)
    device.apply(motion(pedal=False), 10.02)
    before = device.arms["gold"].position[0]
    device.apply(motion(), 10.04)
    assert device.arms["gold"].position[0] == before
    for i in range(30):
        device.apply(motion((5.0, 0, 0) if i == 0 else (0, 0, 0)), 10.06 + 0.02 * i)
    assert device.arms["gold"].position[0] == pytest.approx(before + hands.SPEED * hands.LONGEST), "at most 0.1 s late"


def test_the_other_arm_moves_alone():
    device = hands.Hands()
    device.apply({"pedal": True, "arms": {"green": {"move": [0, 0.001, 0], "turn": [0, 0, 0], "jaw": 0.0}}}, 1.0)
    assert device.arms["green"].position == pytest.approx([0, 0.001, 0]) and device.arms["green"].jaw == 0.0
    assert device.arms["gold"].position == [0, 0, 0] and device.arms["gold"].jaw > 0


def test_nothing_moves_with_the_pedal_up_but_back_to_the_middle():
    device = hands.Hands()
    device.apply(motion((0.01, 0, 0), pedal=False), 1.0)
    assert device.arms["gold"].position == [0, 0, 0]
    device.arms["gold"].position = [1.5, 0, 0]
    device.apply(motion(pedal=False), 1.1)
    assert 1.3 < device.arms["gold"].position[0] < 1.5


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


def test_a_disengaged_robot_is_said():
    assert [words.mode(name, True) for name in ("pedal_up", "teleoperating")] == ["Ready: press the pedal", "The hands move the robot"]
    assert all("disengaged" in words.mode(name, False) for name in ("pedal_up", "teleoperating"))
    assert words.mode("paused", False) == words.mode("paused") and words.mode("some_mode", False) == "some mode"


def test_answers_are_sentences():
    assert words.answer("accepted") == "Done." and words.answer("the hazard acts") == "The hazard acts."
    assert words.clear_refused("stopped", True, True) == words.CLEAR_FIRST and words.clear_refused("stopped", False, True) == words.ROBOT_STOPPED
    assert words.clear_refused("stopped", False, False) == words.MODEL_STOPPED and words.clear_refused("pedal_up", False, False) == "Nothing is stopped."
    assert not any("bracket" in sentences for _, _, sentences in words.CAUSES), "a trainee sees none"
    assert words.sentence("the trainer is not running") == "The trainer is not running." and words.sentence("Done.") == "Done."


@pytest.mark.parametrize("header, array, sentences", [
    ("state.h", "kPlanningAnswerNames", words.PLANNING_ANSWERS), ("command.h", "kPlanStatusNames", words.PLAN_STATUSES)])
def test_each_answer_of_the_trainer_has_a_sentence(header, array, sentences):
    text = (ROOT / "include/raven2_trainer/core" / header).read_text()
    names = re.findall(r'"(\w+)"', text.split(array + "{")[1].split("}")[0])
    assert len(names) > 5 and set(names) == set(sentences)
    for name in [*names, "no answer", "accepted; the planner is still ending"]:
        assert re.fullmatch(r"[A-Z].*\.", words.answer(name)), name


def test_the_steps_of_each_track_are_counted(known):
    for exercise in known.exercises:
        assert sum(exercise["tracks"]) == len(exercise["steps"]) and all(exercise["tracks"])


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


# ---- choices


def test_what_the_page_offers_is_what_the_configuration_has(known):
    assert {e["name"] for e in known.exercises} == {p.stem for p in (ROOT / "config/exercises").glob("*.yaml")}
    assert {h["name"] for h in known.hazards} == {p.stem for p in (ROOT / "config/faults").glob("*.yaml")}
    assert all(h["title"] and h["expected"] and h["response"] for h in known.hazards)
    severities = [words.SEVERITIES.index(h["severity"]) for h in known.hazards]
    assert severities == sorted(severities) and severities[0] == 0
    assert known.links[0]["name"] == "none" and "browser" not in known.names("masters")
    json.dumps(known.describe())


GOOD = {"trainee": "ann", "exercise": "pick_hand_over_place", "hazard": "own", "driver": "expert", "link": "net_delay_2"}


def test_a_good_choice_is_taken(known):
    choice = supervisor.Choice(GOOD, known)
    assert choice.is_drill and choice.seed > 0
    assert supervisor.Choice({}, known).exercise == "none"
    assert supervisor.Choice({**GOOD, "seed": 7}, known).seed == 7


@pytest.mark.parametrize("change, words_of_it", [
    ({"trainee": "Ann Smith"}, "not an ID"), ({"trainee": "a" * 33}, "not an ID"), ({"trainee": "../x"}, "not an ID"), ({"trainee": "ann\n"}, "not an ID"),
    ({"driver": "expert\n"}, "driver"),
    ({"exercise": "nonsense"}, "exercise"), ({"hazard": "nonsense"}, "hazard"), ({"link": "nonsense"}, "link"),
    ({"driver": "nonsense"}, "driver"), ({"driver": "clumsy:nonsense"}, "clumsy"), ({"driver": "master:nonsense"}, "hand device"),
    ({"driver": "expert; rm -rf /"}, "driver"), ({"exercise": "none"}, "drill"), ({"exercise": "none", "hazard": "none"}, "exercise"),
    ({"when": "never"}, "when"), ({"curriculum": "nonsense"}, "curriculum"), ({"seed": "1"}, "seed"), ({"seed": 1 << 60}, "seed"),
    ({"seed": True}, "seed"), ({"extra": 1}, "unknown setting"), ({"trainee": 5}, "not a text"), ({"trainee": None, "link": []}, "link")])
def test_a_choice_that_cannot_be_is_refused_in_words(known, change, words_of_it):
    with pytest.raises(supervisor.Refused) as refused:
        supervisor.Choice({**GOOD, **change}, known)
    assert words_of_it in str(refused.value) and len(str(refused.value)) > 10


def supervise(folder, known, stages=(), current=0):
    return supervisor.Supervisor(folder, folder, known, lambda: None, lambda trainee, curriculum: (list(stages), current))


def test_an_educators_own_configuration_is_offered_and_used(known, tmp_path):
    shutil.copytree(ROOT / "config", tmp_path / "ours")
    own = (tmp_path / "ours/curricula/frs_basics.yaml").read_text()
    (tmp_path / "ours/curricula/tuesday.yaml").write_text(own.replace("title:", "title: Tuesday, not", 1))
    ours = library.Library(ROOT, tmp_path / "ours")
    assert set(ours.names("curricula")) - set(known.names("curricula")) == {"tuesday"}
    assert ours.curriculum("tuesday")["title"].startswith("Tuesday")
    boss = supervisor.Supervisor(tmp_path, tmp_path, ours, lambda: None, lambda *_: ([], 0), config=tmp_path / "ours/trainer.yaml")
    used = boss._arguments(supervisor.Choice({**GOOD, "curriculum": "tuesday"}, ours))
    assert used[:2] == ["--config", str(tmp_path / "ours/trainer.yaml")] and used[used.index("--curriculum") + 1] == "tuesday"
    assert boss._profile("wifi") == str(tmp_path / "ours/impairments/wifi.yaml") and supervise(tmp_path, known)._profile("wifi") == "wifi"
    (tmp_path / "ours/curricula/tuesday.yaml").write_text("title: [")
    with pytest.raises(ValueError, match="tuesday.yaml"):
        library.Library(ROOT, tmp_path / "ours")
    (tmp_path / "ours/curricula/tuesday.yaml").write_text("stages: []")
    with pytest.raises(ValueError, match="lacks 'title'"):
        library.Library(ROOT, tmp_path / "ours")


def test_programs_get_what_was_chosen(known, tmp_path):
    boss = supervise(tmp_path, known)
    drill = boss._arguments(supervisor.Choice({**GOOD, "seed": 3}, known))
    assert drill == ["--seed", "3", "--trainee", "ann", "--exercise", "pick_hand_over_place", "--drill", "own", "--hazard", "none"]
    by_hand = boss._arguments(supervisor.Choice({**GOOD, "seed": 3, "hazard": "sudden_jump", "when": "instructor"}, known))
    assert "--drill" not in by_hand and by_hand[-2:] == ["--hazard", "none"]
    free = boss._arguments(supervisor.Choice({"hazard": "sudden_jump", "seed": 3}, known))
    assert free == ["--seed", "3", "--exercise", "none", "--hazard", "sudden_jump"]
    assert boss._hands(supervisor.Choice({"driver": "browser"}, known)) == ["--master", "browser"]
    assert boss._hands(supervisor.Choice({**GOOD, "driver": "master:omni_pair"}, known)) == ["--master", "omni_pair"]


PROGRAM = """#!/bin/sh
while [ $# -gt 0 ]; do [ "$1" = --output ] && mkdir -p "$2" && touch "$2/session.rlog"; shift; done
exec sleep 60
"""


WAITS = "#!/bin/sh\nexec sleep 60\n"  # a daemon that has no log yet


def break_robot(folder):
    """From now on the virtual Raven ends at once, before the daemon's log begins."""
    (folder / "programs/virtual_raven").write_text("#!/bin/false\n")
    (folder / "programs/simulator").write_text(WAITS)


def supervised(folder, known, program):
    """A supervisor whose programs are all `program`; the daemon's begins a log."""
    (folder / "programs").mkdir(parents=True)
    for name in ("virtual_raven", "master_console", "simulator"):
        (folder / "programs" / name).write_text(program)
        (folder / "programs" / name).chmod(0o755)
    return supervisor.Supervisor(folder / "programs", folder / "sessions", known, lambda: None, lambda trainee, stages: ([], 0))


def test_a_program_that_ends_at_once_is_named_and_the_next_start_is_free(known, tmp_path):
    made = supervised(tmp_path, known, "#!/bin/false\n")

    async def starts():
        for _ in range(10):
            with pytest.raises(supervisor.Refused, match="ended"):
                await made.start({"driver": "scripted"})
            assert made.phase == "idle"

    asyncio.run(starts())


def test_a_replay_is_no_session_and_the_next_attempt_is_of_the_one_before(known, tmp_path):
    made = supervised(tmp_path, known, PROGRAM)
    kept = {"trainee": "ann", "exercise": "peg_transfer", "driver": "browser"}

    async def sessions():
        first = await made.start(kept)
        await made.end()
        for _ in range(2):  # the second one takes the place of the first
            directory = await made.start({"exercise": "camera_clutch", "driver": "browser"}, replay=True)
            (directory / "left").touch(exist_ok=False)
            assert made.is_replay and made.state()["replay"]
            again = supervisor.Supervisor(tmp_path / "programs", tmp_path / "sessions", known, lambda: None, lambda trainee, stages: ([], 0))
            assert again.adopt() and again.is_replay and again.state()["last"] is None
            again._watcher.cancel()
            with pytest.raises(supervisor.Refused, match="no session has been started"):
                await again.next()
            await made.end()
        assert made.last == first and not made.is_replay
        assert [s["name"] for s in records.Records(tmp_path / "sessions").list()] == [first.name]
        await made.next()
        assert {key: made.state()["choice"][key] for key in kept} == kept and not made.is_replay
        await made.end()

    asyncio.run(sessions())


def test_the_next_attempt_that_cannot_start_leaves_the_session_or_says_that_it_has_ended(known, tmp_path):
    made = supervised(tmp_path, known, PROGRAM)
    stages = curriculum.stages_of(known.curriculum("frs_basics"))
    has_passed = [False]
    made._progress = lambda trainee, chosen: (stages, len(stages) if has_passed[0] else 0)

    async def attempts():
        await made.start({"trainee": "ann", "curriculum": "frs_basics", "driver": "browser"})
        has_passed[0] = True
        with pytest.raises(supervisor.Refused, match="^ann has done all stages"):
            await made.next()
        assert made.phase == "running", "nothing has changed"
        has_passed[0] = False
        break_robot(tmp_path)
        with pytest.raises(supervisor.Refused, match="^The session has ended. The next attempt did not start: virtual_raven"):
            await made.next()
        assert made.phase == "idle"
        with pytest.raises(supervisor.Refused, match="^virtual_raven"):
            await made.next()

    asyncio.run(attempts())


def programs_of(boss, choice):
    """{name: arguments} of a session's programs, without starting them."""
    launched = {}

    async def launch(name, arguments):
        launched[name] = arguments

    async def await_log():
        pass

    boss._launch, boss._await_log = launch, await_log
    asyncio.run(boss._start(choice))
    return launched


@pytest.mark.parametrize("robot", ["", "192.168.0.102"])
def test_with_a_real_robot_the_trainer_is_strict(known, tmp_path, robot):
    """As launch/hardware.launch starts it."""
    boss = supervisor.Supervisor(tmp_path, tmp_path, known, lambda: None, lambda *_: ([], 0), robot=robot)
    launched = programs_of(boss, supervisor.Choice({}, known))
    assert ("virtual_raven" in launched) == (not robot)
    assert ("--strict" in launched["simulator"]) == bool(robot)
    assert '<arg name="strict" default="true"' in (ROOT / "launch/hardware.launch").read_text()


@pytest.mark.parametrize("driver, robot, forced, scale", [
    ("master:mtm", "", None, "0.2"), ("master:mtm", "192.168.0.102", None, "0.2"), ("browser", "", None, "0.1"),
    ("scripted", "", None, None), ("scripted", "192.168.0.102", None, "0.05"), ("expert", "192.168.0.102", None, "0.05"),
    ("master:omni_pair", "192.168.0.102", 0.02, "0.02"), ("scripted", "192.168.0.102", 0.02, "0.02")])
def test_console_and_daemon_have_the_same_motion_scale(known, tmp_path, driver, robot, forced, scale):
    """doc/hardware.md: with different ones, forces and record are wrong."""
    boss = supervisor.Supervisor(tmp_path, tmp_path, known, lambda: None, lambda *_: ([], 0), robot=robot, scale=forced)
    launched = programs_of(boss, supervisor.Choice({**GOOD, "driver": driver, **({"exercise": "none", "hazard": "none"} if driver == "scripted" else {})}, known))
    for name in ("master_console", "simulator"):
        given = launched[name]
        assert (given[given.index("--scale") + 1] if "--scale" in given else None) == scale
    assert "--scale" not in launched.get("virtual_raven", [])
    slow = f"""name="scale" default="$(eval '{library.SLOW}' if console"""
    assert slow in (ROOT / "launch/hardware.launch").read_text()


@pytest.mark.parametrize("sender, stream, hearer", [("master_console", "--master-port", "simulator"), ("simulator", "--force-port", "master_console"),
                                                    ("simulator", "--sight-port", "master_console")])
def test_a_bad_link_carries_each_stream_to_its_hearer(known, tmp_path, sender, stream, hearer):
    """config/network.yaml: motion goes to the daemon, forces and sight come from it."""
    launched = programs_of(supervise(tmp_path, known), supervisor.Choice({**GOOD, "link": "wifi"}, known))
    ways = dict(word.split(":127.0.0.1:") for word in launched["impair"] if ":127.0.0.1:" in word)
    sent, heard = (launched[name][launched[name].index(stream) + 1] for name in (sender, hearer))
    assert len(ways) == 3 and ways[sent] == heard != sent


@pytest.mark.parametrize("driver, is_one", [("expert", True), ("clumsy:hasty", True), ("scripted-over-wan", True), ("expert-over-net_delay_2", True),
                                            ("browser", False), ("own_console", False), ("own_console-over-wan", False), ("master:omni", False)])
def test_a_simulated_surgeon_is_known_by_its_name_also_over_a_link(driver, is_one):
    assert words.is_demonstration(driver) == is_one


def has_ended(process):
    """Until asyncio's thread has asked for its status, a program that has ended is a zombie."""
    return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE


def test_a_session_starts_and_ends_on_a_full_disk(known, tmp_path, capsys):
    made = supervised(tmp_path, known, PROGRAM)

    async def sessions():
        for _ in range(2):
            await made.start({"driver": "scripted"})
            processes = list(made._processes.values())
            (tmp_path / "sessions/station_logs/processes.part").unlink(missing_ok=True)
            (tmp_path / "sessions/station_logs/processes.part").symlink_to("/dev/full")
            await made.end()
            assert made.phase == "idle" and made.last is not None and all(has_ended(p) for p in processes)

    asyncio.run(sessions())
    assert "cannot be written" in capsys.readouterr().err


def test_a_station_that_was_killed_in_a_start_leaves_no_program_behind(known, tmp_path):
    made = supervised(tmp_path, known, PROGRAM)
    with subprocess.Popen(["sleep", "60"]) as left:
        made._processes = {"virtual_raven": psutil.Process(left.pid)}
        made._remember()
        made._processes = {}
        assert not made.adopt() and made.phase == "idle"
        assert left.wait(5) == -signal.SIGTERM


@pytest.mark.parametrize("newest", ["session", "replay", "failed start"])
def test_a_station_that_starts_again_between_sessions_repeats_the_settings_of_the_last_session(known, tmp_path, newest):
    made = supervised(tmp_path, known, PROGRAM)

    async def sessions():
        await made.start({"trainee": "ann", "exercise": "peg_transfer", "driver": "browser"})
        await made.end()
        if newest == "replay":
            await made.start({"exercise": "camera_clutch", "driver": "browser"}, replay=True)
            await made.end()
        if newest == "failed start":
            break_robot(tmp_path)
            with pytest.raises(supervisor.Refused):
                await made.start({"trainee": "bea", "exercise": "camera_clutch", "driver": "browser"})
            for name in ("virtual_raven", "simulator"):
                (tmp_path / "programs" / name).write_text(PROGRAM)
        again = supervisor.Supervisor(tmp_path / "programs", tmp_path / "sessions", known, lambda: None, lambda trainee, stages: ([], 0))
        assert not again.adopt() and again.phase == "idle"
        await again.next()  # the page offers it, because state() has a choice
        assert (again.state()["choice"]["trainee"], again.state()["choice"]["exercise"]) == ("ann", "peg_transfer")
        await again.end()

    asyncio.run(sessions())


def test_a_station_that_was_killed_in_a_replay_offers_no_next_attempt(known, tmp_path):
    made = supervised(tmp_path, known, PROGRAM)
    made._choice, made._directory = supervisor.Choice({"driver": "browser"}, known), made._replay
    made._remember()
    again = supervised(tmp_path / "again", known, PROGRAM)
    again._logs, again._replay = made._logs, made._replay
    assert not again.adopt() and again.state()["choice"] is None


@pytest.mark.parametrize("later, is_ours", [(0.0, True), (-1.0, False), (1.0, False)])
def test_a_process_that_has_the_number_of_an_earlier_one_is_not_adopted(known, tmp_path, later, is_ours):
    made = supervised(tmp_path, known, PROGRAM)
    made._file().parent.mkdir(parents=True)
    made._file().write_text(json.dumps({"processes": {"simulator": [os.getpid(), psutil.Process().create_time() - later]}, "choice": None,
                                        "session": str(tmp_path / "sessions/s1")}))

    async def adopt():
        found = made.adopt()
        if made._watcher:
            made._watcher.cancel()
        return found

    assert asyncio.run(adopt()) == is_ours and made.is_running == is_ours
    assert (time.monotonic() - made.began_at < 100) == is_ours, "pages wait for the trainer as after a start"


def test_a_station_that_ends_waits_for_what_is_under_way_and_starts_nothing(known, tmp_path):
    made = supervised(tmp_path, known, PROGRAM.replace("exec sleep 60", "trap 'sleep 0.5; exit' TERM; while :; do sleep 0.05; done"))

    async def ending():
        await made.start({"driver": "scripted"})
        processes = list(made._processes.values())
        asked = asyncio.ensure_future(made.end())
        await asyncio.sleep(0.05)
        assert made.phase == "ending"
        await made.close()
        assert asked.done() and made.phase == "idle" and not any(p.is_running() and p.status() != psutil.STATUS_ZOMBIE for p in processes)
        with pytest.raises(supervisor.Refused, match="the station ends"):
            await made.start({"driver": "scripted"})

    asyncio.run(ending())


@pytest.mark.parametrize("crash", [True, False])
def test_a_simulated_surgeon_who_has_finished_is_no_trouble_but_a_crash_is(known, tmp_path, crash):
    made = supervised(tmp_path, known, PROGRAM)
    end = "kill -9 $$" if crash else "exit 0"
    (tmp_path / "programs/master_console").write_text(f"#!/bin/sh\nsleep 0.5\n{end}\n")

    async def session():
        await made.start({"exercise": "pick_hand_over_place", "driver": "expert"})
        while made.phase != "idle":
            await asyncio.sleep(0.05)
        return made.trouble

    assert bool(asyncio.run(asyncio.wait_for(session(), 30))) == crash


class SlowPage:
    """A socket of a page that reads nothing."""

    def __init__(self):
        self.closed, self.sent, self.aborted, self.stuck, self.gone = False, [], False, False, False

    async def send_str(self, text):
        if self.gone:
            raise ConnectionResetError("Cannot write to closing transport")
        if self.stuck:
            await asyncio.sleep(3600)
        self.sent.append(text)

    async def send_bytes(self, data):
        self.sent.append(data)

    def abort(self):
        self.aborted = True


def test_no_picture_is_sent_ahead_of_a_page_that_acknowledges(monkeypatch):
    async def run():
        page = SlowPage()
        client = clients.Client(page, "trainee", 1)
        client.acknowledges = True
        writer = asyncio.ensure_future(client.write())
        for number in range(10):
            client.show("view", bytes([number]))
            await asyncio.sleep(0)
            await asyncio.sleep(0)
        await asyncio.sleep(0.05)
        assert len(page.sent) == clients.MOST_AHEAD
        client.send({"t": "text"})
        await asyncio.sleep(0.05)
        assert page.sent[-1] == '{"t":"text"}', "texts do not wait"
        client.shown()
        await asyncio.sleep(0.05)
        assert page.sent[-1] == b"\x00\x09" and len(page.sent) == clients.MOST_AHEAD + 2, "the newest, not those that waited"
        monkeypatch.setattr(clients, "AHEAD_LIMIT", 0.01)
        await asyncio.sleep(0.02)
        client.show("view", b"x")
        await asyncio.sleep(0.05)
        assert page.sent[-1] == b"\x00x", "a page that forgot to acknowledge goes on"
        writer.cancel()

    asyncio.run(run())


def test_a_page_over_its_rate_learns_why_once_a_second(monkeypatch):
    async def run():
        now = 100.0
        monkeypatch.setattr(clients.time, "monotonic", lambda: now)
        page = SlowPage()
        client = clients.Client(page, "trainee", 1)
        for _ in range(1000):
            client.warn()
        now += clients.WARN_EVERY
        client.warn()
        await client._write_all()
        assert [json.loads(text)["text"] for text in page.sent] == ["too many messages: 200 a second are read"] * 2
        assert json.loads(page.sent[0])["ok"] is False

    asyncio.run(run())


def test_a_page_that_goes_while_it_is_written_to_is_no_error():
    async def run():
        page = SlowPage()
        page.gone = True
        client = clients.Client(page, "trainee", 1)
        client.send({"t": "text"})
        await asyncio.wait_for(client.write(), 5)

    asyncio.run(run())


def test_a_page_that_takes_no_message_is_cut_off(monkeypatch):
    monkeypatch.setattr(clients, "WRITE_LIMIT", 0.05)

    async def run():
        page = SlowPage()
        page.stuck = True
        client = clients.Client(page, "trainee", 1, transport=page)
        client.send({"t": "text"})
        await asyncio.wait_for(client.write(), 5)
        assert page.aborted

    asyncio.run(run())


class Finishing:
    """A finisher whose report takes 0.5 s and whose video takes a minute."""

    def __init__(self, folder):
        (folder / "session").mkdir()
        self.session, self.said = folder / "session", []
        (folder / "session_report").write_text("import pathlib, sys, time\ntime.sleep(0.5)\n"
                                               "(pathlib.Path(sys.argv[1]) / 'report.html').touch()\n")
        (folder / "render_session").write_text("#!/bin/sh\nsleep 60 & echo $! >\"$1/worker\"; wait\n")
        (folder / "render_session").chmod(0o755)
        self.finisher = finisher.Finisher(folder, folder, lambda *words: self.said.append(words[1:3]))

    async def worker(self):
        while not (self.session / "worker").is_file() or not (self.session / "worker").read_text():
            await asyncio.sleep(0.05)
        return psutil.Process(int((self.session / "worker").read_text()))


def test_a_report_is_finished_when_the_station_ends(tmp_path):
    async def run():
        work = Finishing(tmp_path)
        work.finisher.report(work.session)
        await asyncio.sleep(0)
        await work.finisher.end()
        assert (work.session / "report.html").is_file() and work.said[-1] == ("report", 1.0)

    asyncio.run(run())


def test_a_report_that_is_asked_for_again_is_written_again(tmp_path):
    async def run():
        work = Finishing(tmp_path)
        work.finisher.report(work.session)
        await asyncio.sleep(0.1)
        assert work.finisher.is_busy("session") and not work.finisher.is_busy("other")
        work.finisher.report(work.session)  # the session has ended meanwhile
        while work.said.count(("report", 1.0)) < 2:
            await asyncio.sleep(0.05)
        await asyncio.sleep(0)
        assert not work.finisher.is_busy("session")

    asyncio.run(asyncio.wait_for(run(), 30))


def test_a_report_does_not_wait_for_a_video(tmp_path):
    async def run():
        work = Finishing(tmp_path)
        work.finisher.video(work.session)
        await work.worker()
        work.finisher.report(work.session)
        while ("report", 1.0) not in work.said:
            await asyncio.sleep(0.05)
        await work.finisher.end()

    asyncio.run(asyncio.wait_for(run(), 30))


def test_a_video_ends_with_the_station_and_so_does_one_that_waits(tmp_path):
    async def run():
        work = Finishing(tmp_path)
        work.finisher.video(work.session)
        worker = await work.worker()
        (tmp_path / "other").mkdir()
        waiting = work.finisher.video(tmp_path / "other")
        await work.finisher.end()
        assert waiting.done() and not list((tmp_path / "other").iterdir())
        assert not worker.is_running() or worker.status() == psutil.STATUS_ZOMBIE

    asyncio.run(run())


# As ProgressBar (src/apps/common/command_line.cpp): a bar on a terminal, a line every 25 % elsewhere.
RENDERER = """#!/usr/bin/python3
import sys, time
for percent in range(0, 100, 10):
    if sys.stderr.isatty():
        sys.stderr.write(f"\\rrender [##..] {percent:3d} % 1 min 20 s left\\033[K")
    elif percent % 50 == 0:
        sys.stderr.write(f"render {percent} %\\n")
    sys.stderr.flush()
    time.sleep(0.03)
sys.stderr.write("\\rrender: over\\033[K\\n")
if STATUS:
    sys.exit("\\033[1mno ffmpeg\\033[0m")
"""


@pytest.mark.parametrize("status", [0, 1])
def test_a_video_shows_its_progress_and_is_in_the_report_afterwards(tmp_path, status):
    async def run():
        work, texts = Finishing(tmp_path), []
        (tmp_path / "render_session").write_text(RENDERER.replace("STATUS", str(status)))
        work.finisher = finisher.Finisher(tmp_path, tmp_path, lambda *change: (work.said.append(change[1:3]), texts.append(change[3])))
        await work.finisher.video(work.session)
        shares = [share for what, share in work.said if what == "video"]
        assert len({share for share in shares if share and share < 1.0}) >= 6, shares
        assert shares[-1] == (None if status else 1.0)
        assert not status or "no ffmpeg" in texts
        assert work.finisher.is_busy("session") == (not status)
        while not status and ("report", 1.0) not in work.said:
            await asyncio.sleep(0.05)
        assert (work.session / "report.html").is_file() == (not status)

    asyncio.run(asyncio.wait_for(run(), 30))


def test_a_curriculum_chooses_exercise_and_hazard(known, tmp_path):
    asked = {"trainee": "ann", "curriculum": "frs_basics", "seed": 3, "when": "instructor", "driver": "expert"}
    stages = curriculum.stages_of(known.curriculum("frs_basics"))
    drills = [i for i, stage in enumerate(stages) if stage.drill]
    assert drills and drills[0] > 0
    for current in (0, drills[0]):
        boss = supervise(tmp_path, known, stages, current)
        choice = supervisor.Choice(boss._with_stage(asked), known)
        drill = ["--drill", stages[current].drill] if stages[current].drill else []
        assert boss._arguments(choice) == ["--seed", "3", "--curriculum", "frs_basics", "--trainee", "ann", "--exercise",
                                           stages[current].exercise, *drill, "--hazard", "none"]
        assert boss._with_stage(choice.as_dict()) == choice.as_dict(), "the next attempt asks again"
    with pytest.raises(supervisor.Refused, match="all stages"):
        supervise(tmp_path, known, stages, len(stages))._with_stage(asked)
    assert supervise(tmp_path, known)._with_stage({"curriculum": "nonsense"}) == {"curriculum": "nonsense"}


# ---- sessions on disk


@pytest.fixture
def folder(tmp_path):
    for name, passed in (("2026-01-01T10-00-00Z_ann", True), ("2026-01-02T10-00-00Z_ann", False)):
        directory = tmp_path / name
        directory.mkdir()
        (directory / "session.rlog").write_bytes(b"x")
        report = {"session": {"trainee": "ann", "exercise": "peg_transfer", "drill": "none", "duration_s": 12.5},
                  "verdict": {"headline": "Passed" if passed else "Not passed: time", "passed": passed, "reasons": []},
                  "improve": [{"what": "time", "how": "be faster", "metric": "time"}] * 5, "summary": ""}
        (directory / "report.json").write_text(json.dumps(report))
        (directory / "report.html").write_text("<p>report</p>")
    entries = [{"directory": f"s{i}", "start_time_utc": f"2026-01-0{i + 1}", "trainee": trainee, "exercise": exercise, "drill": "",
                "attempts": [{"status": "done", "passed": passed, "metrics": {"time": 10.0 + i}}]}
               for i, (trainee, exercise, passed) in enumerate([("ann", "peg_transfer", True), ("ann", "peg_transfer", True),
                                                                ("bea", "peg_transfer", False), ("ann", "camera_clutch", True)])]
    (tmp_path / "index.json").write_text(json.dumps({"version": 1, "sessions": entries}))
    (tmp_path / "other").mkdir()
    return tmp_path


def test_sessions_are_listed_newest_first(folder):
    found = records.Records(folder).list()
    assert [s["name"] for s in found] == ["2026-01-02T10-00-00Z_ann", "2026-01-01T10-00-00Z_ann"]
    assert found[0]["passed"] is False and found[0]["report"] and not found[0]["video"]
    verdict = records.Records(folder).verdict(found[0]["name"])
    assert verdict["headline"] == "Not passed: time" and len(verdict["improve"]) == 3


def test_a_session_whose_report_is_missing_is_listed_from_its_other_files(folder, monkeypatch):
    name = "2026-01-01T10-00-00Z_ann"
    (folder / name / "report.json").unlink()
    header = {"trainee": "ann", "exercise": "peg_transfer", "drill": "sudden_jump"}
    monkeypatch.setattr(records, "_header_of_log", lambda _: header)
    (folder / name / "metrics.json").write_text(json.dumps({"duration_s": 12.5, "faults": [{"name": "fk_pos"}, {"name": "fk_pos"}]}))
    (folder / name / "score.json").write_text(json.dumps({
        "attempts": [{"status": "failed", "passed": False}, {"status": "done", "passed": True}, {"status": "running", "passed": None}]}))
    keys = ("trainee", "exercise", "drill", "hazards", "passed", "duration")
    found = records.Records(folder).summary(name)
    assert [found[key] for key in keys] == ["ann", "peg_transfer", "sudden_jump", ["fk_pos"], True, 12.5]
    header = {"trainee": "", "exercise": "none", "drill": "none"}  # a free session has no score
    (folder / name / "score.json").unlink()
    found = records.Records(folder).summary(name)
    assert [found[key] for key in keys] == ["", "none", "none", ["fk_pos"], None, 12.5]
    for broken in ("[]", "{", '{"attempts": 1, "duration_s": "long", "faults": 3}', '{"attempts": [3], "faults": [{"name": 3}]}'):
        for file in ("score.json", "metrics.json"):
            (folder / name / file).write_text(broken)
        found = records.Records(folder).summary(name)
        assert (found["hazards"], found["passed"], found["duration"]) == ([], None, None), broken
    monkeypatch.undo()
    found = records.Records(folder).summary(name)  # the log is one byte
    assert (found["trainee"], found["exercise"], found["drill"]) == ("", "", "")


@pytest.mark.parametrize("name", ["..", ".", "", "../x", "a/b", "/etc", "other", "x" * 200, None, 3, ".hidden", "a\0b", "a b",
                                  "2026-01-01T10-00-00Z_ann\n"])
def test_names_that_are_no_sessions_are_refused(folder, name):
    store = records.Records(folder)
    for call in (store.directory, store.summary, store.verdict, store.delete, lambda n: store.file(n, "report.html")):
        with pytest.raises(KeyError):
            call(name)


def test_only_a_sessions_own_files_are_served(folder):
    store = records.Records(folder)
    name = "2026-01-01T10-00-00Z_ann"
    assert store.file(name, "report.html")[0].name == "report.html"
    os.symlink("/etc/passwd", folder / name / "video.mp4")
    for which in ("video.mp4", "configuration", "../index.json", "score.json"):
        with pytest.raises(KeyError):
            store.file(name, which)
    os.symlink(folder / name, folder / "link")
    with pytest.raises(KeyError):
        store.directory("link")


STAGES = {"stages": [{"exercise": "peg_transfer", "drill": "none", "passes": 2, "extra": 0},
                     {"exercise": "camera_clutch", "drill": "none", "passes": 2, "extra": 1},
                     {"exercise": "peg_transfer", "drill": "sudden_jump", "passes": 2, "extra": 0}]}


def test_the_class_has_a_row_a_trainee_and_a_cell_a_stage(folder):
    store = records.Records(folder)
    ann, bea = store.the_class(STAGES)
    assert (ann["trainee"], ann["sessions"], ann["current"]) == ("ann", 3, 1)
    assert [c["done"] for c in ann["stages"]] == [True, False, False]
    assert [c["attempts"] for c in bea["stages"]] == [1, 0, 0] and bea["stages"][0]["in_a_row"] == 0
    lines = store.class_csv(STAGES).splitlines()
    assert len(lines) == 3 and lines[1].startswith("ann,3,2,2,0,yes,1,1,0,no,0,0,0,no,")
    assert "peg transfer with sudden jump done" in lines[0]
    assert lines[0].endswith(",demonstrated sessions") and lines[1].endswith(f",{ann['demonstrations']}")


def test_attempts_count_for_the_stage_under_way_alone():
    def after(text):  # p, c: passed peg, camera; P, C: not passed; j: a passed drill; ?: not judged
        kinds = {"p": ("peg_transfer", ""), "c": ("camera_clutch", ""), "j": ("peg_transfer", "sudden_jump"), "?": ("peg_transfer", "")}
        attempts = [{"exercise": kinds[k.lower()][0], "drill": kinds[k.lower()][1], "passed": None if k == "?" else k.islower()} for k in text]
        stages, current = curriculum.follow(STAGES, attempts)
        return current, [(s.in_a_row, s.more, s.attempts) for s in stages]
    assert after("") == (0, [(0, 0, 0)] * 3)
    assert after("ccc") == (0, [(0, 0, 0)] * 3), "attempts before their stage do not count"
    assert after("pPp") == (0, [(1, 0, 3), (0, 0, 0), (0, 0, 0)]), "a failure restarts the row"
    assert after("p?p") == (1, [(2, 0, 2), (0, 0, 0), (0, 0, 0)])
    assert after("ppccCc") == (2, [(2, 0, 2), (2, 1, 4), (0, 0, 0)]), "a failure keeps the passes after the row"
    assert after("ppcccjj") == (3, [(2, 0, 2), (2, 1, 3), (2, 0, 2)])


@pytest.mark.parametrize("text", ["", "[]", "{", "null", '{"sessions": 3}', '{"sessions": [1, {"trainee": 2}, {"trainee": "x"}]}'])
def test_a_spoilt_index_is_an_empty_or_shorter_class(tmp_path, text):
    (tmp_path / "index.json").write_text(text)
    assert len(records.Records(tmp_path).the_class(STAGES)) <= 1


def test_an_index_with_foreign_entries_is_read_without_them(folder):
    entries = json.loads((folder / "index.json").read_text())["sessions"]
    for change in ({"start_time_utc": None}, {"directory": None}, {"directory": ["x"]}, {"start_time_utc": 3}):
        entries.append({**entries[0], "trainee": "cay", **change})
    entries.append({**entries[0], "trainee": "@SUM(1)"})
    (folder / "index.json").write_text(json.dumps({"version": 1, "sessions": entries}))
    store = records.Records(folder)
    assert store.trainees() == ["@SUM(1)", "ann", "bea"]
    assert store.class_csv(STAGES).splitlines()[1].startswith("'@SUM(1),1,")


def test_older_sessions_come_behind_the_newest(folder):
    store = records.Records(folder)
    assert [s["name"][:10] for s in store.list(skip=1)] == ["2026-01-01"] and store.list(skip=2) == []
    assert [s["name"][:10] for s in store.list(most=1)] == ["2026-01-02"]


def test_the_history_has_score_time_and_response(folder):
    (folder / "s1").mkdir()
    (folder / "s1" / "session.rlog").write_bytes(b"x")
    (folder / "s1" / "score.json").write_text(json.dumps({"attempts": [{"composite": 0.75}]}))
    history = records.Records(folder).history("ann")
    assert [(a["session"], a["score"], a["time"]) for a in history] == [("s0", None, 10.0), ("s1", 0.75, 11.0), ("s3", None, 13.0)]
    for spoilt in ('{"attempts": [{"composite": "x"}, 3]}', '{"attempts": 3, "hazards": 3}', '{"attempts": {"a": 1}, "hazards": [3]}'):
        (folder / "s1" / "score.json").write_text(spoilt)
        assert [a["score"] for a in records.Records(folder).history("ann")] == [None] * 3


def test_sessions_say_which_hazards_acted_and_who_moved_the_arms(folder):
    name = "2026-01-01T10-00-00Z_ann"
    report = json.loads((folder / name / "report.json").read_text())
    report["hazards"] = [{"scenario": "sudden_jump"}, {"scenario": "camera_drift"}, {"scenario": "sudden_jump"}, 3]
    (folder / name / "report.json").write_text(json.dumps(report))
    (folder / name / "meta.json").write_text('{"motion": "clumsy:dropper"}')
    (folder / "2026-01-02T10-00-00Z_ann" / "report.json").write_text('{"hazards": 3}')
    after, before = records.Records(folder).list()
    assert before["hazards"] == ["sudden_jump", "camera_drift"] and before["driver"] == "clumsy:dropper"
    assert after["hazards"] == [] and after["driver"] == ""


def test_a_history_has_the_hazards_of_each_attempt_and_the_class_its_demonstrations(folder):
    (folder / "s1").mkdir()
    (folder / "s1" / "session.rlog").write_bytes(b"x")
    (folder / "s1" / "meta.json").write_text('{"motion": "expert"}')
    (folder / "s1" / "score.json").write_text(json.dumps({
        "attempts": [{"first_tick": 0, "last_tick": 4999}, {"first_tick": 5000, "last_tick": None}],
        "hazards": [{"scenario": "sudden_jump", "injection_tick": 4999}, {"scenario": "camera_drift", "injection_tick": 9000}, {}]}))
    index = json.loads((folder / "index.json").read_text())
    index["sessions"][1]["attempts"] *= 2
    (folder / "index.json").write_text(json.dumps(index))
    store = records.Records(folder)
    of_s1 = [a for a in store.history("ann") if a["session"] == "s1"]
    assert [(a["hazards"], a["driver"]) for a in of_s1] == [(["sudden_jump"], "expert"), (["camera_drift"], "expert")]
    assert [r["demonstrations"] for r in store.the_class(STAGES)] == [1, 0]


def test_deleting_takes_the_whole_directory_and_nothing_else(folder):
    store = records.Records(folder)
    store.delete("2026-01-01T10-00-00Z_ann")
    assert [s["name"] for s in store.list()] == ["2026-01-02T10-00-00Z_ann"] and (folder / "other").exists()


def test_a_deleted_session_counts_no_longer(folder):
    """The index is locked and exchanged as score_session does it."""
    (folder / "s1").mkdir()
    (folder / "s1" / "session.rlog").write_bytes(b"x")
    store = records.Records(folder)
    before = json.loads((folder / "index.json").read_text())
    with open(folder / "index.json.lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        deleting = threading.Thread(target=store.delete, args=("s1",))
        deleting.start()
        deleting.join(0.2)
        assert deleting.is_alive() and json.loads((folder / "index.json").read_text()) == before, "another program writes the index"
    deleting.join(10)
    assert [a["session"] for a in store.history("ann")] == ["s0", "s3"] and store.the_class(STAGES)[0]["sessions"] == 2
    assert json.loads((folder / "index.json").read_text()) == {"version": 1, "sessions": [before["sessions"][i] for i in (0, 2, 3)]}
    inode = (folder / "index.json").stat().st_ino
    store.delete("2026-01-01T10-00-00Z_ann")  # a guest's
    assert (folder / "index.json").stat().st_ino == inode and not (folder / "index.json.part").exists()


def log_of(exercise):
    header = json.dumps({"format": raven2_session.FORMAT_NAME, "format_version": 1, "exercise": exercise}).encode()
    record = raven2_session.FRAME.pack(raven2_session.MAGIC, 0, 1, len(header), 0) + header
    return record + raven2_session.CRC.pack(zlib.crc32(record))


def test_the_exercise_of_a_session_without_a_report_is_that_of_its_log(folder):
    store, name = records.Records(folder), "2026-01-01T10-00-00Z_ann"
    assert store.exercise(name) == "peg_transfer"
    (folder / name / "report.json").unlink()
    assert store.exercise(name) == "none", "the log has no header"
    (folder / name / "session.rlog").write_bytes(log_of("camera_clutch"))
    assert store.exercise(name) == "camera_clutch"


def test_a_verdict_says_whether_there_is_a_video(folder):
    store, name = records.Records(folder), "2026-01-01T10-00-00Z_ann"
    assert store.verdict(name)["video"] is False
    (folder / name / "video.mp4").touch()
    assert store.verdict(name)["video"] is True


# ---- access


def test_a_login_is_known_until_it_ends_also_after_a_restart(tmp_path, monkeypatch):
    door = access.Access(None, tmp_path / "logins.json")
    token = door.login()
    assert door.knows(token) and not door.knows(token[:-1] + "?") and not door.knows(None) and not door.knows("")
    assert (tmp_path / "logins.json").stat().st_mode & 0o077 == 0
    assert access.Access(None, tmp_path / "logins.json").knows(token)
    (tmp_path / "logins.json").chmod(0o644)
    assert not access.Access(None, tmp_path / "logins.json").knows(token), "others could have written it"
    assert not door.knows("\udcff") and not door.knows("\u00fc"), "a header may have any bytes"
    now = access.time.time()
    monkeypatch.setattr(access.time, "time", lambda: now + access.LIFETIME + 1)
    assert not door.knows(token)


def test_a_login_holds_on_a_full_disk_until_the_station_ends(tmp_path, capsys):
    (tmp_path / "logins.part").symlink_to("/dev/full")
    door = access.Access(None, tmp_path / "logins.json")
    assert door.knows(door.login())
    assert "log in again" in capsys.readouterr().err


def test_wrong_passwords_are_counted_and_then_wait():
    door = access.Access(access.make_hash("right"))
    assert not access.fits("right", "scrypt$nonsense") and not access.fits("right", "") and access.make_hash("a") != access.make_hash("a")
    assert door.needs_password and door.check_password("right") == ""
    for _ in range(access.TRIES):
        assert door.check_password("wrong") == "Wrong password."
    assert "wait" in door.check_password("right")


def test_wrong_passwords_are_forgotten_after_a_minute(monkeypatch):
    door, now = access.Access(access.make_hash("right")), access.time.monotonic()
    for _ in range(access.TRIES):
        door.check_password("wrong")
    monkeypatch.setattr(access.time, "monotonic", lambda: now + access.TRIES_IN + 30.0)
    assert door.check_password("right") == ""


def test_an_address_that_only_looks_local_is_not():
    for address in ("127.0.0.1.evil.example", "127.evil.example", "localhost.evil.example", "127.0.0.256", "", "1"):
        assert not access.is_loopback(address), address
    for address in ("127.0.0.1", "127.255.0.9", "::1", "localhost"):
        assert access.is_loopback(address), address


def test_an_origin_that_is_no_address_is_foreign():
    assert not access.same_origin("http://[", "localhost:8080") and not access.same_origin("http://[::1", "[::1]:8080")


def test_origins_and_names():
    assert access.same_origin("http://localhost:8080", "localhost:8080")
    for origin in (None, "", "null", "http://evil.example", "http://localhost:8081", "https://localhost:8080.evil.example"):
        assert not access.same_origin(origin, "localhost:8080")
    for host in ("localhost:8080", "127.0.0.1:8080", "[::1]:8080", "localhost"):
        assert access.is_local_name(host)
    for host in ("evil.example:8080", "127.0.0.1.evil.example", ""):
        assert not access.is_local_name(host)
    assert access.is_loopback("127.0.0.5") and not access.is_loopback("0.0.0.0")


# ---- messages, frames, words


def test_messages_survive_any_cut():
    sent = [({"t": "a", "n": 1}, b""), ({"t": "picture"}, bytes(range(256)) * 9), ({"t": "b", "text": "line\nend"}, b"")]
    stream = b"".join(wire.encode(m, d) for m, d in sent)
    source = random.Random(3)
    for _ in range(50):
        reader, got, at = wire.Reader(), [], 0
        while at < len(stream):
            step = source.randint(1, 700)
            got += reader.feed(stream[at:at + step])
            at += step
        assert [(m["t"], d) for m, d in got] == [(m["t"], d) for m, d in sent]


def test_a_stream_that_is_no_message_is_an_error():
    with pytest.raises(ValueError):
        wire.Reader().feed(b"garbage\n")
    with pytest.raises(ValueError):
        wire.Reader().feed(b'{"t": "x", "bytes": 99999999999}\n')


def test_tips_are_compared_over_the_chain_of_frames():
    tree = frames.Frames()
    half = math.sqrt(0.5)
    for side, shift in (("model", 0.0), ("robot", 0.003)):
        tree.put(f"{side}/base_link_L", "world", [1, 0, 0], [0, 0, half, half])
        tree.put(f"{side}/grasper1_L", f"{side}/base_link_L", [0.1 + shift, 0, 0], [0, 0, 0, 1], stamp=1)
    assert tree.origin("model/grasper1_L") == pytest.approx([1, 0.1, 0])
    assert tree.apart("L") == pytest.approx(0.003)
    assert tree.apart("R") is None
    tree.put("model/grasper1_L", "model/base_link_L", [0.2, 0, 0], [0, 0, 0, 1], stamp=2)
    assert tree.apart("L") is None, "the robot is gone; its last pose is one of another moment"
    tree.put("loop", "loop", [0, 0, 0], [0, 0, 0, 1])
    assert tree.origin("loop") is None


@pytest.mark.parametrize("said, asked", [("silent", False), ("none configured", False), ("heard", True), (None, True)])
def test_the_real_camera_is_shown_only_if_pictures_come(said, asked):
    calls = []

    async def call(service, arguments, limit=0):
        calls.append((service, arguments))
        return True, "accepted", {}

    station = station_module.Station(None, None)
    station.link = types.SimpleNamespace(call=call)
    if said:
        station.statuses.hear([["robot", 0, "fine"], ["real camera", 0, said]])
    assert asyncio.run(station.do("view", {"real": True}))[0] is asked
    assert asyncio.run(station.do("view", {"real": False}))[0]
    assert calls == [("set_view", {"data": True})] * asked + [("set_view", {"data": False})]


PAGE_OF_A_TRAINEE = {"drive", "leave", "watch"}  # what it may ask for


@pytest.mark.parametrize("what", sorted({*station_module.TRIGGERS, *(name[4:].replace("_", "-") for name in dir(station_module.Station)
                                                                    if name.startswith("_do_"))} - PAGE_OF_A_TRAINEE))
def test_a_trainee_may_not_do_what_is_the_instructors(what):
    calls = []

    async def call(*given, **_):
        calls.append(given)
        return True, "accepted", {}

    station = station_module.Station(None, None)
    station.link = types.SimpleNamespace(call=call)
    assert not asyncio.run(station.do(what, {}, types.SimpleNamespace(role="trainee")))[0] and calls == []


def station_in_a_session(choice=None):
    station = station_module.Station(types.SimpleNamespace(describe=dict, exercises=[]), types.SimpleNamespace(trainees=list))
    station.supervisor = types.SimpleNamespace(phase="running", is_running=True, began_at=0.0, ended_at=0.0, trouble="",
                                               state=lambda: {"choice": choice})
    station.link = types.SimpleNamespace(is_up=True, is_taken=False, send=lambda _: None)
    return station


@pytest.mark.parametrize("role", ["trainee", "instructor"])
def test_a_trainees_page_that_is_opened_in_a_session_does_not_tell_the_hazard(role):
    station = station_in_a_session({**GOOD, "hazard": "sudden_jump", "when": "own", "seed": 7})
    station.newest["session"] = {"t": "session", "directory": "/s1", "exercise": "peg_transfer", "drill": "sudden_jump", "hazard": "sudden_jump"}
    sent = []
    asyncio.run(station.join(types.SimpleNamespace(role=role, number=1, send=sent.append)))
    assert {"session", "station"} <= {message["t"] for message in sent}
    assert ("sudden_jump" in json.dumps(sent)) == (role == "instructor")


@pytest.mark.parametrize("goes", ["closed", "leave"])
def test_the_hands_stay_with_the_page_that_drives_when_another_page_goes(goes):
    station = station_in_a_session()
    driver, other = (types.SimpleNamespace(role="trainee", number=number, send=lambda _: None) for number in (1, 2))
    station.clients, station.driving = {1: driver, 2: other}, driver
    for client, drives in ((other, driver), (driver, None)):
        if goes == "closed":
            station.part(client)
        else:
            assert asyncio.run(station.do("leave", {}, client))[0]
        assert station.driving is drives


@pytest.mark.parametrize("chosen, given, injected", [
    ("own", {}, "drill"), ("none", {"hazard": "own"}, "drill"), ("fk_pos", {}, "fk_pos"), ("own", {"hazard": "fk_vel"}, "fk_vel"), ("none", {}, None)])
def test_inject_takes_the_hazard_of_the_request_else_the_chosen_one(known, chosen, given, injected):
    """`own` is the exercise's drill."""
    calls = []

    async def call(service, arguments):
        calls.append((service, arguments))
        return True, "the hazard acts", {}

    drill = yaml.safe_load((ROOT / "config/exercises" / f"{GOOD['exercise']}.yaml").read_text())["drill"]["scenario"]
    station = station_module.Station(known, None)
    station.link = types.SimpleNamespace(call=call)
    station.supervisor = types.SimpleNamespace(choice=supervisor.Choice({**GOOD, "hazard": chosen, "when": "instructor"}, known))
    assert asyncio.run(station.do("inject", given))[0] == (injected is not None)
    assert calls == ([("inject_hazard", {"name": drill if injected == "drill" else injected})] if injected else [])


def test_a_trainer_of_a_launch_file_has_nothing_of_the_session_before(known):
    """The page names the session by its choice, and Inject takes the hazard of it."""
    calls = []

    async def call(service, arguments):
        calls.append((service, arguments))
        return True, "the hazard acts", {}

    choice = supervisor.Choice({**GOOD, "hazard": "sudden_jump", "when": "instructor"}, known)
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    station.supervisor = types.SimpleNamespace(phase="idle", is_running=False, ended_at=0.0, trouble="", choice=choice,
                                               state=lambda: {"choice": choice.as_dict()})
    station.link = types.SimpleNamespace(call=call, is_up=True, is_taken=False)
    shown = []
    for is_foreign in (True, False):
        station._daemon_heard = time.monotonic() if is_foreign else None
        assert station.is_foreign == is_foreign
        shown.append(station._station(types.SimpleNamespace(role="instructor"))["choice"])
        assert asyncio.run(station.do("inject", {}))[0] != is_foreign
        assert asyncio.run(station.do("inject", {"hazard": "fk_pos"}))[0]
    assert shown == [None, choice.as_dict()]
    assert [arguments["name"] for _, arguments in calls] == ["fk_pos", "sudden_jump", "fk_pos"]


def test_a_trainer_of_a_launch_file_that_goes_silent_is_no_green(known):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    station.supervisor = types.SimpleNamespace(phase="idle", is_running=False, ended_at=0.0, trouble="", choice=None, state=lambda: {"choice": None})
    station.link = types.SimpleNamespace(is_up=True, is_taken=False, send=lambda _: None)
    levels = []
    for heard, phase in ((None, "idle"), (0.0, "idle"), (9.0, "idle"), (0.0, "idle"), (9.0, "idle"), (9.0, "starting"), (9.0, "idle")):
        station._daemon_heard = None if heard is None else time.monotonic() - heard
        station.supervisor.phase = phase
        station.statuses.hear([["robot", 0, "fine"]])
        station.tick(time.monotonic())
        levels.append(station.health()["level"])
    assert levels == [0, 0, 1, 0, 1, 0, 0]


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


@pytest.mark.parametrize("comes", [True, False])
def test_a_session_starts_only_with_a_ros_master(known, monkeypatch, comes):
    monkeypatch.setattr(station_module, "ROS_PATIENCE", 0.2)
    station, started = station_module.Station(known, None), []

    async def begin(given):
        started.append(given)
        return "/s1"

    station.supervisor = types.SimpleNamespace(phase="idle", ended_at=0.0, trouble="", start=begin)
    station.link = types.SimpleNamespace(is_up=False, is_taken=False)

    async def scenario():
        asking = asyncio.ensure_future(station.do("start", GOOD))
        await asyncio.sleep(0.05)
        station.link.is_up = comes
        return await asking

    done, text, _ = asyncio.run(scenario())
    assert done == comes and started == [GOOD] * comes and ("No ROS master" in text) != comes


@pytest.mark.parametrize("shares, trouble", [([], ""), ([0.0], ""), ([0.0, None], "no space left"), ([0.0, None, 0.0], ""), ([0.0, 1.0], "")])
def test_a_verdict_says_whether_the_report_has_failed(tmp_path, shares, trouble):
    """A page that comes later did not hear it."""
    station = station_module.Station(None, Sessions(tmp_path))
    for share in shares:
        station.finished("s1", "report", share, "no space left" if share is None else "")
    station.finished("s2", "report", None, "of another session")
    station.finished("s1", "video", None, "of the video")
    assert asyncio.run(station.do("verdict", {"session": "s1"})) == (True, "", {"trouble": trouble})


class Sessions:
    """Records that a page may not wait for: each call must be in a thread of its pool."""

    def __init__(self, folder, exercise="camera_clutch"):
        self.folder, self.called = folder, []
        self.answers = {"names": ["s1"], "trainees": ["ann"], "history": [], "verdict": {}, "list": [], "exercise": exercise}

    def directory(self, name):
        if name != "s1":
            raise KeyError(name)
        return self.folder / name

    def __getattr__(self, name):
        def call(*_):
            assert threading.current_thread() is not threading.main_thread(), f"{name} holds the hands up"
            self.called.append(name)
            return self.answers[name]
        return call


def test_long_lists_do_not_hold_the_hands_up(tmp_path):
    async def requests():
        station = station_module.Station(types.SimpleNamespace(describe=dict, exercises=[]), Sessions(tmp_path))
        station.supervisor = types.SimpleNamespace(phase="idle", ended_at=0.0, is_running=False, state=lambda: {"choice": None}, trouble="")
        station.link = types.SimpleNamespace(is_up=True, is_taken=False)
        await station.join(types.SimpleNamespace(role="instructor", number=1, send=lambda _: None))
        for what, given in (("sessions", {}), ("verdict", {"session": "s1"}), ("history", {"trainee": "ann"})):
            assert (await station.do(what, given))[0], what
        assert set(station.records.called) == {"trainees", "names", "list", "verdict", "history"}

    asyncio.run(requests())


@pytest.mark.parametrize("name", [None, [], {}, ["s1"], 3, "../s1"])
def test_deleting_needs_a_sessions_name(tmp_path, name):
    station = station_module.Station(None, Sessions(tmp_path))
    assert asyncio.run(station.do("delete", {"session": name, "sure": True})) == (False, "there is no such session", {})


@pytest.mark.parametrize("answer, phase, text", [
    ((True, "accepted", {}), "running", "The picture shows"), ((False, "not_now", {}), "idle", "is not shown. Not possible now"),
    ((False, "s1: no directory of a session", {}), "idle", "is not shown. S1: no directory")])
@pytest.mark.parametrize("exercise, chosen", [("camera_clutch", "camera_clutch"), ("unknown", "none"), ("", "none")])
def test_a_replay_that_is_refused_leaves_no_program_running(known, tmp_path, answer, phase, text, exercise, chosen):
    async def replay():
        station = station_module.Station(known, Sessions(tmp_path / "sessions", exercise))
        station.supervisor = supervised(tmp_path, known, PROGRAM)

        async def call(service, arguments, limit=0):
            assert service == "begin_replay" and arguments["session"].endswith("s1")
            assert station.supervisor.is_replay and station.supervisor.choice.exercise == chosen
            return answer

        station.link = types.SimpleNamespace(call=call, is_up=True, is_taken=False)
        station.newest["mode"] = {"mode": "pedal_up"}
        ok, said, _ = await station.do("replay", {"session": "s1"})
        assert ok == answer[0] and text in said and station.supervisor.phase == phase
        await station.supervisor.close()

    asyncio.run(replay())


def test_a_stop_is_named_next_to_the_mode():
    station = station_module.Station(None, None)
    station.link = types.SimpleNamespace(is_taken=False, is_up=True)
    station.supervisor = types.SimpleNamespace(phase="running", is_running=True, ended_at=0.0, trouble="")
    station._daemon_heard = time.monotonic()
    for mode, level, status in (("teleoperating", 0, 0), ("stopped", 1, 0), ("stopped", 1, 1), ("stopped", 2, 2)):
        station.newest = {"mode": {"mode": mode}}
        station.statuses.hear([["recorder", status, "disk full"]])
        assert station.health()["level"] == level
        assert ("Clear the stop" in station.health()["text"]) == (level == 1)


def test_health_names_the_worst_and_a_remedy():
    assert words.health([("robot", 0, "fine"), ("recorder", 0, "")]) == (0, "Everything works.", "")
    assert words.health([("robot", 1, "late"), ("recorder", 2, "disk full")]) == (
        2, "The session is not recorded completely. Free disk space, or record to a faster disk.", "recorder: disk full")
    assert words.health([("a new state", 1, "odd")]) == (1, "Something does not work as it should.", "a new state: odd")
    assert "no picture" in words.health([("live picture", 2, "failed; the daemon's stderr says why")])[1]
    assert "Switch the robot on" not in words.health([("robot", 1, "PEDAL_UP; it refuses our fault plan (its own words say why)")])[1]
    assert words.health([])[0] == 2


def test_each_state_of_the_trainer_has_a_sentence():
    """Names on /diagnostics, from the sources that send them."""
    source = "".join(path.read_text() for path in (ROOT / "src/ros").rglob("*.cpp"))
    names = set(re.findall(r'\bstatus\("([^"]+)"', source)) | {f"{name} link" for name in re.findall(r'linkStatus\("([^"]+)"', source)}
    names |= {f"{name} loop" for name in re.findall(r'"(\w+)"', (ROOT / "include/raven2_trainer/core/record.h").read_text().split(
        "kLoopNames{")[1].split("}")[0])}
    names |= set(re.findall(r's\.name = "raven2_trainer: ([^"]+)"', source)) | {"master left", "master right"}
    assert len(names) > 10 and set(words.PROBLEMS) == names and set(words.ADVICE) == names
    assert {state for state, _, _ in words.CAUSES} <= names


def test_statuses_of_the_console_replace_none_of_the_daemons_and_are_no_sign_of_its_life(known, monkeypatch):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    of_daemon = {"t": "diagnostics", "status": [["recorder", 2, "disk full"], ["real camera", 0, "heard"]]}
    of_console = {"t": "diagnostics", "status": [["master left", 0, "engaged"], ["master right", 0, "engaged"]]}
    station.heard(of_console, b"")
    assert not station.is_heard
    station.heard(of_daemon, b"")
    station.heard(of_console, b"")
    assert station.is_heard and words.health(station.statuses.all)[0] == 2 and station.statuses.message("real camera") == "heard"
    now[0] += 2.0
    station.heard(of_console, b"")
    assert not station.is_heard, "the console's alone"
    now[0] += 2.0
    station.heard(of_console, b"")
    assert [status[0] for status in station.statuses.all] == ["master left", "master right"], "the daemon's are old"


def test_the_instructor_sees_the_state_of_the_robot(known):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    station.supervisor = types.SimpleNamespace(is_running=True, phase="running", ended_at=0.0, state=lambda: {"choice": None})
    station.link = types.SimpleNamespace(is_up=True, is_taken=False)
    got = {"instructor": [], "trainee": []}
    for number, role in enumerate(got):
        station.clients[number] = types.SimpleNamespace(role=role, number=number, send=got[role].append)
    for message in ("INIT", "PEDAL_UP", "PEDAL_UP; it refuses our fault plan (its own words say why)", "E-STOP", "no robot", "robot refused: it speaks"):
        station.heard({"t": "diagnostics", "status": [["robot", 0, message]]}, b"")
    assert [m["text"] for m in got["instructor"] if m["t"] == "robot"] == [
        words.ROBOT["INIT"], words.ROBOT["PEDAL_UP"], words.ROBOT["E-STOP"], words.ROBOT["no robot"], "The robot is refused."]
    station._show_state(station.clients[0])
    station._show_state(station.clients[1])
    assert got["instructor"][-3] == {"t": "robot", "text": "The robot is refused."} and "robot" not in {m["t"] for m in got["trainee"]}
    header = (ROOT / "include/raven2_trainer/core/state.h").read_text()
    assert set(re.findall(r'"([^"]+)"', header.split("kRunLevelNames{")[1].split("}")[0])) == set(words.ROBOT) - {"no robot"}


def test_a_page_learns_again_of_a_trainer_of_a_launch_file_that_was_silent(known):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    station.supervisor = types.SimpleNamespace(phase="idle", is_running=False, ended_at=0.0, trouble="", choice=None, state=lambda: {"choice": None})
    station.link = types.SimpleNamespace(is_up=True, is_taken=False, send=lambda _: None)
    got = []
    station.clients[1] = types.SimpleNamespace(role="instructor", number=1, send=got.append)
    for heard in (0.0, 9.0, 0.0):
        station._daemon_heard = time.monotonic() - heard
        station.newest["robot"] = {"t": "robot", "text": "ready"}
        got.clear()
        station.tick(time.monotonic())
        assert ({"t": "robot", "text": "ready"} in got) == (heard == 0.0), heard


def test_a_message_that_was_sent_in_part_ends_the_link():
    ours, theirs = socket.socketpair()
    ours.setblocking(False)
    ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    link = ros_link.RosLink(None, None)
    link._connection, link.is_up = ours, True
    assert link.send({"t": "hands"})
    assert not link.send({"t": "hands", "text": "x" * (1 << 20)})
    theirs.settimeout(5)
    while theirs.recv(1 << 16):
        pass
    assert not link.send({"t": "hands"}), "the end of the stream was read: no later message is taken for the rest"
    ours.close()
    theirs.close()


def test_a_trainee_sees_health_without_the_trainers_own_words(known):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    message = {"t": "health", "level": 1, "text": "A sentence.", "detail": "robot: it refuses our fault plan"}
    for role, detail in (("trainee", ""), ("instructor", message["detail"])):
        assert station._for(types.SimpleNamespace(role=role), message) == {**message, "detail": detail}


def test_answers_say_what_is_known_of_the_session(known):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    station.newest["mode"] = {"mode": "stopped", "pedal": True}
    assert station._answer_to("clear-stop", "not_now") == words.CLEAR_FIRST
    station.newest["mode"]["pedal"] = False
    assert station._answer_to("clear-stop", "not_now") == words.MODEL_STOPPED
    assert station._answer_to("clear-stop", "accepted") == "Done."
    station.statuses.hear([["robot", 0, "E-STOP"]])
    assert station._answer_to("clear-stop", "not_now") == words.ROBOT_STOPPED
    assert station._answer_to("clear-stop", "accepted") == f"Your stop is cleared. {words.ROBOT_STOPPED}"
    assert station._answer_to("restart-exercise", "not_now") == words.NO_EXERCISE
    station.newest["exercise"] = {"status": "running"}
    assert station._answer_to("restart-exercise", "not_now") == words.PLANNING_ANSWERS["not_now"]
    station.link = types.SimpleNamespace()

    async def cancelled(service, *_, **__):
        return True, "accepted", {"was": was}

    station.link.call = cancelled
    for was, says in (("idle", words.NO_PLAN), ("armed", "Done.")):
        assert asyncio.run(station.do("cancel-plan", {}))[1] == says


def test_each_mode_and_each_clumsy_surgeon_is_in_words():
    clumsy = {name for path in (ROOT / "config/exercises").glob("*.yaml") for name in yaml.safe_load(path.read_text()).get("clumsy", {})}
    assert clumsy == set(words.CLUMSY), "each clumsy surgeon in words"
    header = (ROOT / "include/raven2_trainer/core/mode.h").read_text()
    names = header.split("kModeNames{")[1].split("}")[0].replace('"', "").replace("\n", "").split(",")
    assert {n.strip() for n in names} == set(words.MODES)


def test_the_page_names_the_elements_that_scripts_use():
    page = (ROOT / "scripts/raven2_station/page/instructor.html").read_text() + (
        ROOT / "scripts/raven2_station/page/trainee.html").read_text()
    for name in ("trainee exercise hazard driver start stop emergency-stop clear-stop inject next picture mode health verdict report "
                 "class-table take-hands pedal").split():
        assert f'data-test="{name}"' in page, name
    assert "http://" not in page and "https://" not in page and " style=" not in page and "<script>" not in page


def test_the_station_takes_its_folders_from_where_it_is():
    text = (ROOT / "scripts/raven2_station/station").read_text()
    module = types.ModuleType("entry")
    module.__file__ = str(ROOT / "scripts/raven2_station/station")
    exec(compile(text.split("if __name__")[0], module.__file__, "exec"), module.__dict__)  # noqa: S102
    share, programs, scripts = module.places()
    assert share == ROOT and scripts == ROOT / "scripts" and programs.name == "raven2_trainer"
    for wrong in (["--port", "0"], ["--port", "70000"], ["--tls-key", "x"], ["--nonsense"]):
        with pytest.raises(SystemExit):
            module.parse(wrong)
    with pytest.raises(SystemExit, match="password"):
        module.password_hash(module.parse(["--bind", "0.0.0.0"]))


# ---- the ends of programs


def test_the_station_ends_without_waiting_for_pages(monkeypatch):
    monkeypatch.setattr(server, "CLOSE_LIMIT", 0.05)

    async def close(**_):
        await asyncio.sleep(3600)

    pages = {number: types.SimpleNamespace(socket=types.SimpleNamespace(close=close)) for number in range(3)}
    asyncio.run(asyncio.wait_for(server.close_pages(types.SimpleNamespace(clients=pages)), 5))


@contextlib.contextmanager
def running(*command, **options):
    """A process that ends with the test, even if the test fails."""
    with subprocess.Popen(command, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def survivors(pids):
    """Those that still run. Kills them."""
    found = [psutil.Process(pid) for pid in pids if psutil.pid_exists(pid)]
    alive = psutil.wait_procs(found, timeout=5)[1]
    for process in alive:
        process.kill()
    return alive


# The station with a session of programs that need a second to end.
SERVER = """
import pathlib, sys, types
sys.path.insert(0, sys.argv[1])
from aiohttp import web
from raven2_station import server
folder = pathlib.Path(sys.argv[2])
options = types.SimpleNamespace(share=sys.argv[3], programs=folder / "programs", scripts=folder, sessions=folder / "sessions", config="",
                                robot="", scale=None, password_hash=None, local=True, port=int(sys.argv[4]))
app = server.make_app(options)
app[server.STATION].link._command = ["sleep", "60"]

async def begin(_):
    await app[server.STATION].supervisor.start({"driver": "browser"})
app.on_startup.append(begin)
web.run_app(app, host="127.0.0.1", port=options.port, print=lambda _: print("serves", flush=True))
"""


def test_a_second_signal_leaves_no_program_running(known, tmp_path):
    supervised(tmp_path, known, PROGRAM.replace("exec sleep 60", "trap 'sleep 0.5; exit' TERM; while :; do sleep 0.05; done"))
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-c", SERVER, str(ROOT / "scripts"), str(tmp_path), str(ROOT), str(port)]
    with running(*command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "serves\n"
        listed = json.loads((tmp_path / "sessions/station_logs/processes.json").read_text())["processes"]
        pids = [pid for pid, _ in listed.values()]
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
        connection.request("GET", "/")
        cookie = connection.getresponse().getheader("Set-Cookie")
        process.send_signal(signal.SIGINT)
        said = process.stdout.readline()
        for number in (signal.SIGINT, signal.SIGTERM):
            process.send_signal(number)
        status = process.wait(30)
    assert len(pids) == 3 and survivors(pids) == []
    assert status == 0 and "ends the session" in said
    assert cookie.startswith(f"raven2_station_{port}=") and "SameSite=Lax" in cookie and "HttpOnly" in cookie


COMMON = """ROOT={folder} LOGS={folder}
step() {{ :; }}; configure_and_build() {{ :; }}; source_ros() {{ :; }}; free_port() {{ echo 12345; }}; say() {{ echo "$*"; }}
"""


def test_a_killed_ros_master_starts_again_on_its_port(tmp_path):
    """scripts/station with other programs: rosmaster and the station only note that they were started."""
    (tmp_path / "scripts/raven2_station").mkdir(parents=True)
    shutil.copy(ROOT / "scripts/station", tmp_path / "scripts/station")
    (tmp_path / "scripts/common.sh").write_text(COMMON.format(folder=tmp_path))
    for path in ("rosmaster", "scripts/raven2_station/station"):
        (tmp_path / path).write_text(f"#!/bin/sh\necho $$ $* >> {tmp_path}/{pathlib.Path(path).name}.started\nexec sleep 60\n")
        (tmp_path / path).chmod(0o755)

    def started(name, count):
        until = time.monotonic() + 20
        lines = []
        while len(lines) < count and time.monotonic() < until:
            time.sleep(0.05)
            lines = (tmp_path / f"{name}.started").read_text().splitlines() if (tmp_path / f"{name}.started").exists() else []
        return [line.split() for line in lines]

    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    with running("bash", str(tmp_path / "scripts/station"), env=environment) as process:
        first, stations = started("rosmaster", 1), started("station", 1)
        os.kill(int(first[0][0]), signal.SIGKILL)
        masters = started("rosmaster", 2)
        process.terminate()
        status = process.wait(20)
    assert survivors([int(pid) for pid, *_ in masters + stations]) == [] and status == 0
    assert [master[1:] for master in masters] == [["--core", "-p", "12345"]] * 2 and len(stations) == 1


# ---- scripts of the pages that need no browser


def run_page_script(name, code):
    """A page's module and `code` in node. @return what it prints, read as JSON."""
    if not shutil.which("node"):
        pytest.skip("node is not installed")
    module = (ROOT / "scripts/raven2_station/page" / name).read_text(encoding="utf-8")
    done = subprocess.run(["node", "--input-type=module"], input=module + code, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_keys_that_the_browser_needs_move_no_arm():
    given = ["ControlLeft", "ControlRight", "AltLeft", "AltRight", "MetaLeft", "OSLeft", "Tab", "Enter", "NumpadEnter", "",
             "KeyK", "Space", "ShiftLeft", "Numpad0", "F2"]
    usable = run_page_script("input.js", f"console.log(JSON.stringify({json.dumps(given)}.map(isUsable)));")
    assert usable == [False] * 10 + [True] * 5
    stored = json.dumps({"pedal": "ControlLeft", "jaw": "KeyK"})
    keys = run_page_script("input.js", f"globalThis.localStorage = {{ getItem: () => {json.dumps(stored)} }};\n"
                                       "console.log(JSON.stringify(loadKeys()));")
    assert keys["pedal"] == "Space" and keys["jaw"] == "KeyK" and keys["arm"] == "KeyX"


@pytest.mark.parametrize("mappings, used, text", [
    (["", "standard"], "pad 1", "Gamepad: pad 1"), (["standard", ""], "pad 0", "Gamepad: pad 0"),
    ([""], None, "Gamepad not used"), ([], None, "")])
def test_a_gamepad_with_a_known_layout_comes_first(mappings, used, text):
    pads = [None, *({"connected": True, "id": f"pad {i}", "mapping": mapping, "axes": [], "buttons": []} for i, mapping in enumerate(mappings))]
    code = (f"Object.defineProperty(globalThis, 'navigator', {{ value: {{ getGamepads: () => {json.dumps(pads)} }}, configurable: true }});\n"
            "globalThis.window = globalThis; globalThis.addEventListener = () => {};\n"
            "const hands = new Hands({ addEventListener() {} }, {});\n"
            "const text = hands.gamepad(0.1); console.log(JSON.stringify([hands.pad ? hands.pad.id : null, text]));")
    found, said = run_page_script("input.js", code)
    assert found == used and said.startswith(text) and bool(said) == bool(text)


HANDS = """
const screen = { addEventListener() {} };
globalThis.window = { addEventListener() {} };
globalThis.document = { pointerLockElement: screen };
Object.defineProperty(globalThis, "navigator", { value: { getGamepads: () => [pad] }, configurable: true });
const pad = { connected: true, id: "pad", mapping: "standard", axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, () => ({ pressed: false, value: 0 })) };
const hands = new Hands(screen, {});
"""


@pytest.mark.parametrize("arm, other, stick, trigger, shoulder", [("gold", "green", 0, 6, 4), ("green", "gold", 2, 7, 5)])
def test_each_side_of_a_gamepad_moves_its_arm_alone(arm, other, stick, trigger, shoulder):
    """doc/station.md. A stick that is pushed away has a negative value in the browser's standard layout."""
    sent = run_page_script("input.js", HANDS + f"""
      pad.axes[{stick}] = 0.5; pad.axes[{stick} + 1] = -0.8; pad.buttons[{trigger}].value = 1; pad.buttons[{shoulder}].pressed = true;
      hands.gamepad(0.1); console.log(JSON.stringify(hands.take(0.1)));""")
    assert sent["pedal"] is True
    assert sent["arms"][arm]["move"] == pytest.approx([0.0125, 0.02, 0.0]) and sent["arms"][arm]["jaw"] == 0, "0.25 m/s at the stick's end"
    assert sent["arms"][other]["move"] == [0, 0, 0] and sent["arms"][other]["jaw"] > 0.5


@pytest.mark.parametrize("arm, other", [("gold", "green"), ("green", "gold")])
def test_mouse_and_its_left_button_are_of_the_chosen_arm_alone(arm, other):
    sent = run_page_script("input.js", HANDS + f"""
      hands.arm = "{arm}"; hands.button({{ button: 0 }}, true); hands.mouse({{ movementX: 5, movementY: 0 }});
      console.log(JSON.stringify(hands.take(0.1)));""")
    assert sent["arms"][arm]["jaw"] == 0 and sent["arms"][arm]["move"] == pytest.approx([0.005, 0, 0])
    assert sent["arms"][other]["jaw"] > 0.5 and sent["arms"][other]["move"] == [0, 0, 0]


@pytest.mark.parametrize("held, chosen", [("gold", "green"), ("green", "gold")])
def test_the_left_button_opens_the_jaws_that_it_has_closed(held, chosen):
    """Even if the other arm is chosen meanwhile, whose jaws hold something."""
    jaws = run_page_script("input.js", HANDS + f"""
      hands.jaws.{chosen} = 0; hands.arm = "{held}"; hands.button({{ button: 0 }}, true);
      hands.arm = "{chosen}"; hands.button({{ button: 0 }}, false); console.log(JSON.stringify(hands.jaws));""")
    assert jaws[held] > 0.5 and jaws[chosen] == 0


# A browser that shows nothing: elements keep what they are given. Requests of the page go to `asked`.
NO_BROWSER = """
const elements = new Map();
class Node {
  constructor() {
    Object.assign(this, { value: "", textContent: "", className: "", hidden: false, checked: true, dataset: {}, style: {}, children: [], heard: {} });
    this.classes = new Set();
    this.classList = { toggle: (name, isOn) => this.classes[isOn ? "add" : "delete"](name), remove: (name) => this.classes.delete(name) };
  }
  get options() { return this.children.flatMap((child) => (child.children.length ? child.children : [child])); }
  addEventListener(what, run) { (this.heard[what] = this.heard[what] || []).push(run); }
  fire(what) { for (const run of this.heard[what] || []) run({ preventDefault() {} }); }
  focus() {}
  replaceChildren(...children) {
    this.children = children.filter(Boolean);
    if (!this.options.some((option) => option.value === this.value)) this.value = this.options[0]?.value ?? "";
  }
  append(...children) { this.children.push(...children); }
  setAttribute() {}
  getContext() { return {}; }
}
const element = (id) => { if (!elements.has(id)) elements.set(id, new Node()); return elements.get(id); };
const asked = [];
class WebSocket {
  static OPEN = 1;
  constructor() { this.readyState = 1; this.bufferedAmount = 0; }
  send(text) { asked.push(JSON.parse(text)); }
}
Object.assign(globalThis, { Node, WebSocket, location: { protocol: "http:", host: "" }, setInterval() {}, document: Object.assign(new Node(), {
  getElementById: element, createElement: () => new Node() }) });
const hear = (message) => link.socket.onmessage({ data: JSON.stringify(message) });
const answers = async (id, more) => { hear({ t: "reply", id, ok: true, text: "", more }); await new Promise((resolve) => setTimeout(resolve)); };
const idle = { t: "station", phase: "idle", trouble: "", session: null, replay: false, choice: null, last: null, drives: null,
  hands_away: false, foreign: false };
"""


def run_instructors_page(known, code):
    """The instructor's page in node, connected, and then `code`. @return what it prints, read as JSON."""
    if not shutil.which("node"):
        pytest.skip("node is not installed")
    modules = [(ROOT / "scripts/raven2_station/page" / name).read_text(encoding="utf-8") for name in ("link.js", "charts.js", "instructor.js")]
    page = re.sub(r"(?m)^import .*$|^export ", "", "".join(modules))
    begin = f'link.socket.onopen(); hear({{ t: "library", ...{json.dumps(known.describe())}, trainees: [] }}); hear(idle);\n'
    done = subprocess.run(["node", "--input-type=module"], input=NO_BROWSER + page + begin + code, capture_output=True, text=True, check=False,
                          timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


# The trainee's page also needs a window, a lock of the mouse, sounds, and a clock, which `tick` moves.
OF_A_TRAINEE = """
let tick, tones = 0;
globalThis.Worker = class { set onmessage(run) { tick = run; } };
globalThis.window = Object.assign(new Node(), { isSecureContext: true });
globalThis.localStorage = { getItem: () => null };
globalThis.AudioContext = class {
  currentTime = 0;
  state = "running";
  async resume() {}
  createOscillator() { tones += 1; return { frequency: {}, connect: (node) => node, start() {}, stop() {} }; }
  createGain() { return { gain: {}, connect: (node) => node }; }
};
Object.defineProperty(globalThis, "navigator", { value: { getGamepads: () => [] }, configurable: true });
Object.assign(document, { hasFocus: () => true, pointerLockElement: null,
  exitPointerLock() { document.pointerLockElement = null; document.fire("pointerlockchange"); } });
let now = 1000;
Object.defineProperty(globalThis, "performance", { value: { now: () => now } });
element("gamepad").textContent = "No gamepad.";
for (const id of ["banner", "push-gold", "push-green"]) element(id).hidden = true;
"""
DRIVES = """
link.socket.onopen();
hear({ t: "hello", number: 7 });
hear({ t: "library", steps: {}, tracks: {} });
hear({ ...idle, phase: "running", choice: { driver: "browser" }, drives: 7 });
document.pointerLockElement = element("screen");
const pedal = (isDown) => window.heard[isDown ? "keydown" : "keyup"].forEach((run) => run({ code: "Space", preventDefault() {}, stopImmediatePropagation() {} }));
const later = (ms) => { now += ms; tick(); };
document.fire("click");
"""


def run_trainees_page(code):
    if not shutil.which("node"):
        pytest.skip("node is not installed")
    modules = [(ROOT / "scripts/raven2_station/page" / name).read_text(encoding="utf-8") for name in ("link.js", "input.js", "trainee.js")]
    page = re.sub(r"(?m)^import .*$|^export ", "", "".join(modules))
    done = subprocess.run(["node", "--input-type=module"], input=NO_BROWSER.replace("asked", "requests") + OF_A_TRAINEE + page + DRIVES + code, capture_output=True, text=True,
                          check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_ticks_that_come_in_a_bunch_are_one_message_of_the_hands():
    sent = run_trainees_page("""
      pedal(true); requests.length = 0;
      later(16); tick(); tick(); later(16);
      console.log(JSON.stringify(requests.filter((a) => a.do === "hands").map((a) => a.with.pedal)));""")
    assert sent == [True, True]


@pytest.mark.parametrize("ends", ["link.socket.onclose();", 'hear({ ...idle, phase: "running", choice: { driver: "browser" }, hands_away: true });'])
def test_a_page_that_lost_the_hands_shows_no_pedal_and_gives_the_mouse_back(ends):
    shown = run_trainees_page(f"""
      hear({{ t: "mode", mode: "teleoperating", pedal: true, text: "The hands move the robot" }});
      pedal(true); later(16);
      const before = element("pedal").dataset.down;
      {ends}
      pedal(true); later(16);
      console.log(JSON.stringify([before, element("pedal").dataset.down, document.pointerLockElement, element("mode").textContent,
        element("drive").textContent, element("picture-note").textContent]));
      process.exit(0);""")
    is_cut = "onclose" in ends
    assert shown == ["yes", "no", None, "No connection" if is_cut else "The hands move the robot", "Take the hands",
                     "No connection to the station." if is_cut else "No picture comes from the trainer."]


def test_a_page_that_heard_nothing_for_a_moment_goes_on_as_the_station_says():
    """For the station it is still the page that drives, and the station says so."""
    shown = run_trainees_page("""
      const state = { ...idle, phase: "running", choice: { driver: "browser" }, drives: 7 };
      link.isSilent = true; link.onOpen(false);
      const without = [drives, element("mode").textContent];
      requests.length = 0; hear({ t: "alive", level: 0, text: "" });
      const asks = requests.some((r) => r.do === "watch");
      hear({ t: "mode", mode: "pedal_up", pedal: false, text: "Ready: press the pedal" }); hear(state);
      console.log(JSON.stringify([without, asks, drives, element("mode").textContent, element("drive").textContent]));""")
    assert shown == [[False, "No connection"], True, True, "Ready: press the pedal", "Give the hands back"]


@pytest.mark.parametrize("arm, push, angle", [
    ("gold", [1, 0, 0], -90), ("gold", [0, 0, 1], 0), ("gold", [-1, 0, 0], 90), ("gold", [0, 0, -1], 180),
    ("green", [1, 0, 0], -90), ("green", [0, 0, 1], 180), ("green", [-1, 0, 0], 90), ("green", [0, 0, -1], 0)])
def test_an_arrow_points_where_the_hand_is_pushed(arm, push, angle):
    """core/frames.h: gold x up, z right; green x up, z left. In CSS a positive angle turns clockwise from the right."""
    turned, is_forced = run_trainees_page(f"""
      const rest = {{ gold: [0, 0, 0], green: [0, 0, 0] }};
      hear({{ t: "strips", force: {{ gold: 0, green: 0, {arm}: 2 }}, push: {{ ...rest, {arm}: {push} }} }});
      console.log(JSON.stringify([element("push-{arm}").style.transform, element("screen").classes.has("forced")]));""")
    found = math.degrees(float(re.search(r"rotate\((.*?)rad", turned)[1]))
    assert (found - angle) % 360 == pytest.approx(0, abs=1e-6) and is_forced


@pytest.mark.parametrize("newtons, sound, arrow, tones", [(0.49, True, False, 0), (0.5, True, True, 1), (2.0, False, True, 0)])
def test_a_force_shows_from_half_a_newton_and_sounds_unless_muted(newtons, sound, arrow, tones):
    found = run_trainees_page(f"""
      element("sound").checked = {json.dumps(sound)};
      hear({{ t: "strips", force: {{ gold: {newtons}, green: 0 }}, push: {{ gold: [{newtons}, 0, 0], green: [0, 0, 0] }} }});
      console.log(JSON.stringify([!element("push-gold").hidden, !element("push-green").hidden, element("screen").classes.has("forced"), tones]));""")
    assert found == [arrow, False, arrow, tones]


@pytest.mark.parametrize("mode, banner", [("stopped", "STOPPED"), ("paused", "PAUSED"), ("teleoperating", None)])
def test_stopped_and_paused_cover_the_pictures_edge(mode, banner):
    found = run_trainees_page(f"""
      hear({{ t: "mode", mode: "{mode}", pedal: false, text: "" }});
      console.log(JSON.stringify([element("banner").hidden ? null : element("banner").textContent, tones]));""")
    assert found == [banner, 1 if banner else 0]


def test_each_failed_attempt_has_its_cross_in_the_curve():
    """Also one that broke off before its timer, which has neither time nor score."""
    attempts = [{"passed": False, "time": None, "score": None}] * 3 + [{"passed": False, "time": 20.0, "score": 0.4}, {"passed": True, "time": 9.0, "score": 1.0},
                                                                       {"passed": None, "time": 8.0, "score": None}]
    ends = run_page_script("charts.js", f"""
      const drawn = [];
      const context = new Proxy({{}}, {{ get: (_, name) => (name === "moveTo" ? (x, y) => drawn.push([x, y]) : () => {{}}), set: () => true }});
      drawCurve({{ getContext: () => context, width: 648, height: 260 }}, {json.dumps(attempts)});
      console.log(JSON.stringify(drawn));""")
    crosses = [x for x, y in ends if y in (242, 254)]
    assert sorted(crosses) == [x for i in range(4) for x in 2 * [24 + 100 * i + 44]], ends


@pytest.mark.parametrize("improve, shown", [([], "Nothing: every figure is well within its band."), ([{"what": "Time", "how": ""}], "")])
def test_where_there_is_nothing_to_improve_the_page_says_so(known, improve, shown):
    found = run_instructors_page(known, f"""
      hear({{ ...idle, last: "s1" }});

      await answers(asked.find((a) => a.do === "verdict").id, {{ headline: "Passed", passed: true, trouble: "", video: false, improve: {json.dumps(improve)},
        no_advice: "Nothing: every figure is well within its band." }});
      console.log(JSON.stringify([element("no-advice").textContent, element("improve").children.map((c) => c.textContent)]));""")
    assert found == [shown, [i["what"] for i in improve]]


def test_a_page_shows_why_its_messages_are_not_read(known):
    assert run_instructors_page(known, """
      hear({ t: "reply", id: null, ok: false, text: "too many messages" });
      console.log(JSON.stringify(element("said").textContent));""") == "too many messages"


def test_an_answer_about_a_trainee_who_is_no_longer_chosen_shows_nothing(known):
    found = run_instructors_page(known, """
      element("history-trainee").value = "ann"; element("history-trainee").fire("change");
      await answers(asked.find((a) => a.do === "sessions").id, { trainees: ["ann", "bob"], sessions: [] });
      const late = asked.find((a) => a.do === "history");
      element("history-trainee").value = "bob"; element("history-table").children = ["bob's"];
      await answers(late.id, { attempts: [] });
      console.log(JSON.stringify([late.with.trainee, element("history-table").children]));""")
    assert found == ["ann", ["bob's"]]


def test_the_tab_trainee_opens_with_the_trainee_of_the_last_session(known):
    found = run_instructors_page(known, f"""
      hear({{ ...idle, last: "s1", choice: {json.dumps({**GOOD, "trainee": "zoe", "curriculum": ""})} }});
      asked.length = 0; openTab("history");
      await answers(asked.find((a) => a.do === "sessions").id, {{ trainees: ["ann", "zoe"], sessions: [] }});
      console.log(JSON.stringify(asked.find((a) => a.do === "history").with.trainee));""")
    assert found == "zoe"


def test_a_history_can_be_of_one_exercise_alone(known):
    """Times of two exercises cannot be compared."""
    attempts = [{"start": "", "exercise": name, "hazards": [], "drill": "", "driver": "browser", "passed": True, "time": time, "score": None,
                 "response": None} for name, time in (("track_wire", 50), ("pick_hand_over_place", 30), ("track_wire", 40))]
    found = run_instructors_page(known, f"""
      element("curve").getContext = () => new Proxy({{}}, {{ get: () => () => ({{}}), set: () => true }});
      const rowsOf = async (exercise) => {{
        asked.length = 0; element("history-exercise").value = exercise; element("history-exercise").fire("change");
        await answers(asked.find((a) => a.do === "sessions").id, {{ trainees: ["ann"], sessions: [] }});
        await answers(asked.find((a) => a.do === "history").id, {{ attempts: {json.dumps(attempts)} }});
        return element("history-table").children.slice(1).map((row) => row.children[1].textContent);
      }};
      const all = await rowsOf("");
      console.log(JSON.stringify([all, element("history-exercise").options.map((o) => o.value), await rowsOf("track_wire")]));""")
    assert found == [["track wire", "pick hand over place", "track wire"], ["", "pick_hand_over_place", "track_wire"], ["track wire"] * 2]


def test_a_plan_is_executed_with_the_robot_only_by_its_own_button(known):
    found = run_instructors_page(known, """
      for (const id of ["execute", "execute-robot"]) element(id).fire("click");
      console.log(JSON.stringify(asked.filter((a) => a.do === "execute").map((a) => a.with.on_robot)));""")
    assert found == [False, True]


def test_a_page_that_heard_nothing_for_a_moment_asks_for_the_verdict_again(known):
    """Its buttons are of that session still."""
    found = run_instructors_page(known, """
      hear({ ...idle, last: "s1" });
      link.isSilent = true; showOpen(false); asked.length = 0;
      hear({ t: "alive", level: 0, text: "" });
      element("video").fire("click");
      console.log(JSON.stringify(asked.map((a) => [a.do, a.with.session])));""")
    assert ["verdict", "s1"] in found and ["video", "s1"] in found and "watch" in [what for what, _ in found]


def test_the_class_is_that_of_the_curriculum_that_is_chosen(known):
    names = known.names("curricula")
    found = run_instructors_page(known, f"""
      for (const tab of TABS) element(tab).hidden = tab !== "class";
      asked.length = 0; element("curriculum").value = "{names[-1]}"; element("curriculum").fire("change");
      console.log(JSON.stringify([asked.filter((a) => a.do === "class").map((a) => a.with), element("class-csv").href]));""")
    assert found == [[{"curriculum": names[-1]}], f"/class.csv?curriculum={names[-1]}"]


@pytest.mark.parametrize("chosen, given", [("none", "drill"), ("sudden_jump", None)])
def test_inject_takes_the_exercises_own_hazard_of_set_up(known, chosen, given):
    """Another exercise, or none, may run."""
    exercise = known.exercise("pick_hand_over_place")
    running = {**GOOD, "exercise": "none", "hazard": chosen, "when": "instructor", "curriculum": ""}
    found = run_instructors_page(known, f"""
      hear({{ ...idle, phase: "running", choice: {json.dumps(running)} }});
      element("exercise").value = "{exercise['name']}"; showChoices(); element("hazard").value = "own"; asked.length = 0;
      element("inject").fire("click"); console.log(JSON.stringify(asked.map((a) => a.with)));""")
    assert found == [{"hazard": exercise["drill"]} if given else {}]


@pytest.mark.parametrize("trouble, text", [("", "The report is being written."), ("no space left", "There is no report.")])
def test_a_page_that_comes_later_knows_of_a_report_that_failed(known, trouble, text):
    found = run_instructors_page(known, f"""
      hear({{ ...idle, last: "s1" }});
      await answers(asked.at(-1).id, {{ headline: "No report yet", improve: [], passed: null, video: false, trouble: "{trouble}" }});
      console.log(JSON.stringify([element("verdict").textContent, element("progress-text").textContent]));""")
    assert found == [text, f"The report failed: {trouble}" if trouble else ""]


@pytest.mark.parametrize("said, what, share, shown", [
    ("The emergency stop is not confirmed.", "video", 0.5, None), ("The hazard acts", "video", 0.5, None), ("The hazard acts", "report", 0.0, None),
    ("The video is being rendered.", "video", 0.5, "Video of s2: 50 %"), ("Video of s2: 49 %", "video", 0.5, "Video of s2: 50 %"),
    ("", "video", 0.5, "Video of s2: 50 %"), ("The hazard acts", "video", 1, "The video of s2 is ready."),
    ("The report is being written.", "report", None, "The report of s2 failed: no space left")])
def test_work_on_a_listed_session_says_its_end_and_its_percents_hide_no_other_text(known, said, what, share, shown):
    found = run_instructors_page(known, f"""
      element("said").textContent = "{said}";
      hear({{ t: "progress", session: "s2", what: "{what}", share: {json.dumps(share)}, text: "no space left" }});
      console.log(JSON.stringify(element("said").textContent));""")
    assert found == (shown or said)


GUIDES = ("doc/station.md", "doc/tutorials/surgeon_assistant.md", "doc/tutorials/educator.md")


def page_text():
    """All texts that the pages can show: those of their files, and the sentences of the station."""
    folder = ROOT / "scripts/raven2_station"
    files = [*sorted((folder / "page").iterdir()), *(folder / f"{name}.py" for name in ("words", "station", "supervisor")), ROOT / "src/ros/bridge/services.cpp"]
    text = " ".join(p.read_text(encoding="utf-8") for p in files if p.is_file())
    titles = " ".join(c["title"] for c in library.Library(ROOT).curricula)
    return re.sub(r"<[^>]+>|\s+", " ", text + " " + titles).lower()


@pytest.mark.parametrize("guide", GUIDES)
def test_guides_name_what_the_pages_show(guide):
    """The italic words in the numbered steps are texts of a page."""
    steps = re.findall(r"(?ms)^\d+\. .*?(?=^\d+\. |^\n|^#)", (ROOT / guide).read_text(encoding="utf-8").split("## Appendix")[0])
    named = [" ".join(name.split()) for step in steps for name in re.findall(r"(?<!\*)\*([^*]+)\*(?!\*)", step)]
    assert len(named) >= 1
    text = page_text()
    assert [name for name in named if name.lower() not in text] == []
