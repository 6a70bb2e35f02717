"""The station over its WebSocket, with real programs and ROS master: hands, hazards, what is killed. Judges times."""

import asyncio
import json
import os
import subprocess
import sys
import threading
import time

import numpy as np
import psutil
import pytest
from stack import ROOT, urgent, wait_until
from station_rig import Page, drive, end_session, engage, start, stop

sys.path.insert(0, os.path.join(ROOT, "scripts"))
import raven2_session  # noqa: E402
from raven2_station import priority  # noqa: E402

DEMONSTRATION = {"exercise": "pick_hand_over_place", "driver": "expert", "trainee": "ann", "seed": 1}


def test_a_session_from_start_to_verdict(station):
    async def scenario():
        async with Page(station.url) as page, Page(station.url, "trainee") as trainee:
            await start(page, **DEMONSTRATION, hazard="sudden_jump", when="instructor")
            assert set(station.programs()) == {"virtual_raven", "master_console", "simulator"}
            assert {os.sched_getscheduler(pid) for pid in station.programs().values()} == {os.SCHED_OTHER}, "they choose for themselves"
            await page.until(lambda: page.mode() == "teleoperating", 20, "the expert moves")
            await page.until(lambda: page.newest.get("exercise", {}).get("status") == "running", 30, "the exercise runs")
            assert page.newest["exercise"]["title"].startswith("The ring")
            asked = time.monotonic()
            answer = await page.ask("inject")
            took = time.monotonic() - asked
            assert answer["ok"] and took < 1.0, (answer, took)
            await page.until(lambda: page.newest.get("strips", {}).get("force", {}).get("gold", 0) > 0.5, 10, "the hazard is felt")
            assert (await page.ask("stop-hazard"))["ok"]
            assert page.pictures > 10 and trainee.pictures > 10
            assert "sudden_jump" not in json.dumps(trainee.messages), "the trainee gets no hint"
            assert not (await trainee.ask("inject"))["ok"] and not (await trainee.ask("stop"))["ok"]
            assert (await page.ask("emergency-stop"))["ok"]
            await page.until(lambda: page.mode() == "stopped", 2, "stopped")
            await stop(page)
            last = page.newest["station"]["last"]
            await page.until(lambda: any(m["t"] == "progress" and m["what"] == "report" and m["share"] == 1.0 for m in page.messages),
                             60, "the report is written")
            verdict = (await page.ask("verdict", session=last))["more"]
            assert verdict["headline"].startswith(("Not passed", "Not judged")) and len(verdict["improve"]) <= 3
            listed = (await page.ask("sessions"))["more"]
            assert listed["sessions"][0]["name"] == last and listed["trainees"] == ["ann"]
            rows = (await page.ask("class"))["more"]["rows"]
            assert [r["trainee"] for r in rows] == ["ann"]
            async with page.http.get(f"{station.url}/sessions/{last}/report.html") as report:
                assert report.status == 200 and "sandbox" in report.headers["Content-Security-Policy"]
            assert (await page.ask("delete", session=last))["ok"] is False
            assert (await page.ask("delete", session=last, sure=True))["ok"]
            assert not os.path.exists(os.path.join(station.sessions, last))
    asyncio.run(scenario())


def test_the_station_runs_before_ordinary_programs_and_after_the_real_time_loops(station):
    if "DEGRADED_RT: " in station.log():
        pytest.skip(station.log().strip())
    server = psutil.Process(station.process.pid)

    def priorities():
        ours = [server, *(p for p in server.children() if "raven2_station.ros_side" in p.cmdline())]
        return [(os.sched_getscheduler(p.pid) & ~os.SCHED_RESET_ON_FORK, os.sched_getparam(p.pid).sched_priority) for p in ours]
    wait_until(lambda: priorities() == 2 * [(os.SCHED_FIFO, priority.PRIORITY)], 10, "server and ROS side have their priority")


def test_hands_of_a_page_move_the_robot_and_let_go_with_it(station):
    async def scenario():
        async with Page(station.url) as page:
            await start(page, driver="browser", exercise="none", hazard="none")
            async with Page(station.url, "trainee") as trainee:
                assert (await trainee.ask("drive"))["ok"]
                await page.until(lambda: page.newest.get("mode", {}).get("mode") == "pedal_up", 20, "the robot is ready")
                await asyncio.sleep(0.5)

                async def drive_again():
                    begun = len(page.messages)
                    with urgent():
                        await drive(trainee, 20, pedal=False)
                        await drive(trainee, 40)
                    # Among all modes since: the page is silent now, so the newest one may be the next.
                    await page.until(lambda: any(m["t"] == "mode" and m["mode"] == "teleoperating" for m in page.messages[begun:]),
                                     2, "it drives again")

                with urgent():  # 0.1 s without a message releases the pedal
                    await engage(page, trainee)
                    await drive(trainee, 60, move=[0.001, 0, 0])
                    assert page.mode() == "teleoperating"
                assert (await page.ask("take-hands", away=True))["ok"]
                await page.until(lambda: page.mode() == "pedal_up", 2, "the instructor took the hands")
                assert not (await trainee.ask("drive"))["ok"]
                assert (await page.ask("take-hands", away=False))["ok"] and (await trainee.ask("drive"))["ok"]
                await drive_again()
                await asyncio.sleep(0.4)
                assert page.mode() == "pedal_up", "a silent page holds no pedal"
                await drive_again()
            await page.until(lambda: page.mode() == "pedal_up", 2, "a closed page holds no pedal")
            assert page.newest["station"]["drives"] is None
            await stop(page)
    asyncio.run(scenario())


def test_a_page_moves_the_robot_smoothly(station):
    """A fast sweep at 60 messages a second. No ITP step exceeds 0.5 mm in a millisecond, and all motion arrives."""
    async def scenario():
        async with Page(station.url) as page, Page(station.url, "trainee") as trainee:
            await start(page, driver="browser", exercise="none", hazard="none")
            assert (await trainee.ask("drive"))["ok"]
            await page.until(lambda: page.mode() == "pedal_up", 20, "the robot is ready")
            await asyncio.sleep(0.5)
            tries = []  # again if a busy machine silenced the page so long that the pedal came up, or its messages were late
            for _ in range(4):
                await engage(page, trainee)
                begun, longest = len(page.messages), 0.0
                with urgent():
                    for sign in (1, -1, 1, -1):
                        longest = max(longest, await drive(trainee, 30, move=[sign * 0.012, 0, 0]))
                await drive(trainee, 20)
                tries.append((longest, all(m["pedal"] for m in page.messages[begun:] if m["t"] == "mode")))
                if tries[-1][0] < 0.025 and tries[-1][1]:
                    break
            else:
                raise AssertionError(f"in each sweep: longest gap between messages [s], whether the pedal stayed down: {tries}")
            directory = os.path.join(station.sessions, page.newest["station"]["session"])
            await stop(page)
        return directory
    commands = raven2_session.SessionLog(os.path.join(asyncio.run(scenario()), "session.rlog")).commands["command"]
    steps = np.linalg.norm(commands["dp_I"][:, 0], axis=1)
    steps = steps[last_press(commands["pedal"])]
    moving = np.flatnonzero(steps > 0)
    assert 1e3 * steps.max() <= 0.5, "mm"
    assert 1e3 * steps.sum() == pytest.approx(4 * 30 * 0.1 * 12.0, rel=0.05), "a tenth of the hand's motion"
    assert len(moving) > 0.8 * (moving[-1] - moving[0]), "motion is spread over the milliseconds between messages"


def last_press(pedal):
    """The span of the last press of the pedal."""
    edges = np.diff(np.concatenate([[0], (pedal != 0).astype(int), [0]]))
    return slice(np.flatnonzero(edges > 0)[-1], np.flatnonzero(edges < 0)[-1])


def test_a_killed_station_finds_its_session_again_within_3_s(station):
    async def scenario():
        async with Page(station.url) as page:
            await start(page, exercise="none", hazard="none", driver="scripted")
            await page.until(lambda: page.mode() == "teleoperating", 20, "the session moves")
        programs, took = station.programs(), []
        while len(took) < 3 and min(took, default=9.0) > 3.0:  # a busy machine may start Python late
            station.kill()
            time.sleep(0.5)
            assert station.programs() == programs, "the session goes on"
            begun = time.monotonic()
            station.start()
            async with Page(station.url) as page:
                await page.until(lambda: page.mode() is not None and page.phase() == "running", 10, "the session is found again")
                took.append(time.monotonic() - begun)
        assert min(took) <= 3.0, took
        async with Page(station.url) as page:
            await page.until(lambda: page.phase() == "running", 5, "the session still runs")
            await stop(page)
        assert station.programs() == {}
    asyncio.run(scenario())


# Prints the trainer's mode whenever it changes.
MODES = """
import rospy
from raven2_trainer.msg import TrainerMode
rospy.init_node("modes", anonymous=True, disable_signals=True)
rospy.Subscriber("mode", TrainerMode, lambda message: print(message.mode, flush=True))
rospy.spin()
"""


def test_the_pedal_comes_up_if_the_station_is_killed(station):
    """No page can see that: a node hears the trainer's mode."""
    async def scenario(modes):
        async with Page(station.url) as page:
            await start(page, driver="browser", exercise="none", hazard="none")
            async with Page(station.url, "trainee") as trainee:
                assert (await trainee.ask("drive"))["ok"]
                await page.until(lambda: page.mode() == "pedal_up", 25, "the robot is ready")
                await engage(page, trainee)
                assert modes() == "teleoperating"
                station.kill()
                wait_until(lambda: modes() == "pedal_up", 2, "the pedal is up")

    listener = station.master.popen(sys.executable, "-c", MODES, stdout=subprocess.PIPE)
    heard = []
    threading.Thread(target=lambda: heard.extend(iter(listener.stdout.readline, "")), daemon=True).start()
    try:
        asyncio.run(scenario(lambda: heard[-1].strip() if heard else ""))
    finally:
        listener.kill()
        listener.wait()
    station.start()
    asyncio.run(end_session(station))


def test_what_is_killed_is_named_within_2_s_and_over_by_itself(station):
    async def scenario():
        async with Page(station.url) as page:
            await start(page, exercise="none", hazard="none", driver="scripted")
            await page.until(lambda: page.mode() == "teleoperating", 20, "the session moves")
            for program in ("virtual_raven", "simulator"):
                os.kill(station.programs()[program], 9)
                await page.until(lambda: page.newest["health"]["level"] == 2 and program in page.newest["station"]["trouble"], 2, "it is named")
                await page.until(lambda: page.phase() == "idle", 15, "the session has ended")
                if program == "virtual_raven":
                    await start(page, exercise="none", hazard="none", driver="scripted")
                    await page.until(lambda: page.mode() == "teleoperating", 20, "the next session moves")
            station.master.kill()
            await page.until(lambda: "No ROS master" in page.newest["health"]["text"], 2, "a killed master is named")
            assert not (await page.ask("emergency-stop"))["ok"]
            station.master.start()
            await page.until(lambda: page.newest["station"]["ros"], 10, "the master that came back is used")
            await start(page, exercise="none", hazard="none", driver="scripted")
            await page.until(lambda: page.mode() == "teleoperating", 20, "the next session moves")
            await stop(page)
    asyncio.run(scenario())


def test_a_stalled_page_gives_the_hands_back(station):
    """A page that reads nothing any more, its connection open: the messages of the station have nowhere to go."""
    async def scenario():
        async with Page(station.url) as page:
            await start(page, driver="browser")
            async with Page(station.url, "trainee") as trainee:
                assert (await trainee.ask("drive"))["ok"]
                await trainee.ask("watch", pictures=["view", "second"])
                trainee._reader.cancel()
                transport = trainee.socket._response.connection.transport
                transport.pause_reading()
                await page.until(lambda: page.newest["station"]["drives"] is None, 60, "nobody drives")
                transport.abort()
            await stop(page)
    asyncio.run(scenario())
