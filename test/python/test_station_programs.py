"""Tests how the station starts, watches, adopts and ends the programs of a session, a replay and a next attempt."""

import asyncio
import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import psutil
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from raven2_station import curriculum, records, supervisor  # noqa: E402
from station_parts import PROGRAM, supervised  # noqa: E402

WAITS = "#!/bin/sh\nexec sleep 60\n"  # a daemon that has no log yet


def break_robot(folder):
    """From now on the virtual Raven ends at once, before the daemon's log begins."""
    (folder / "programs/virtual_raven").write_text("#!/bin/false\n")
    (folder / "programs/simulator").write_text(WAITS)


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
    (tmp_path / "programs/master_console").write_text(f"#!/bin/sh\nwhile [ ! -e '{tmp_path}/started' ]; do sleep 0.05; done\n{end}\n")

    async def session():
        await made.start({"exercise": "pick_hand_over_place", "driver": "expert"})
        (tmp_path / "started").touch()
        while made.phase != "idle":
            await asyncio.sleep(0.05)
        return made.trouble

    assert bool(asyncio.run(asyncio.wait_for(session(), 30))) == crash


def test_the_next_attempt_has_other_random_numbers(known, tmp_path):
    made, seeds = supervised(tmp_path, known, PROGRAM), []

    async def begin(choice):
        seeds.append(choice.seed)

    async def attempts():
        await made.start({"driver": "scripted", "seed": 7})
        await made.next()

    made._start, made._watch = begin, lambda: None
    asyncio.run(attempts())
    assert seeds[0] == 7 and len(seeds) == 2 and seeds[1] != 7
