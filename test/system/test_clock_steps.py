"""The wall clock jumps by an hour, ten times, while robot, daemon and console run. Only the time labels change."""

import calendar
import os
import shutil
import struct
import subprocess
import sys
import time

import pytest

from stack import ROOT, Stack, effort, robot_states

sys.path.insert(0, os.path.join(ROOT, "scripts"))
import raven2_session  # noqa: E402

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "stepped_clock.c")
STEPS = 10
BETWEEN = effort(0.3, 3.0)  # [s]
PEDAL_DOWN = 3
HOUR = 3600  # [s]


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler for the clock that steps")
def test_steps_of_the_wall_clock_cost_no_tick_and_no_link(tmp_path):
    library = str(tmp_path / "stepped_clock.so")
    subprocess.run(["cc", "-O1", "-shared", "-fPIC", "-o", library, SOURCE], check=True)
    clock = str(tmp_path / "clock")

    def step_to(seconds):
        with open(clock, "r+b" if os.path.exists(clock) else "wb") as file:  # in place: the programs have mapped it
            file.write(struct.pack("<q", seconds))

    step_to(10 * HOUR)
    with Stack(environment={"LD_PRELOAD": library, "STEPPED_CLOCK": clock}) as stack:
        stack.start_robot()
        reader = robot_states(stack.state_port)
        stack.start_daemon("--hazard", "none")
        stack.start_console()
        first = reader.wait_for(PEDAL_DOWN, 60)
        for step in range(STEPS):
            step_to((10 + (step + 1) % 2) * HOUR)
            end = time.monotonic() + BETWEEN
            while time.monotonic() < end:
                last = reader.state()  # every frame: a slow reader is dropped
        assert stack.stop("simulator")[0] == 0, stack.log_text("simulator")
        stack.assert_counters_add_up()
        label = calendar.timegm(time.strptime(stack.meta()["start_time_utc"], "%Y-%m-%dT%H:%M:%SZ"))
        assert abs(label - time.time() - 10 * HOUR) < 300, "the programs had the clock that steps"

        # the robot's own clock and cycles went on together
        elapsed = (last["time_ns"] - first["time_ns"]) / 1e6
        assert elapsed >= 900 * STEPS * BETWEEN
        assert abs(last["cycle"] - first["cycle"] - elapsed) <= 250
        # no tick was lost, and the daemon's ticks went on with its clock
        timing = stack.metrics()["timing"]
        for loop in ("physics", "haptic"):
            assert timing[loop]["time_slips"] == 0 and timing[loop]["lost_ticks"] == 0, timing
        ticks = raven2_session.Session(stack.output).log.ticks
        ran = (ticks["model"]["time_ns"][-1] - ticks["model"]["time_ns"][0]) / 1e6
        assert abs(len(ticks) - 1 - ran) <= 250
        # model and robot stayed linked, whenever the pedal was down
        session = ticks[ticks["model"]["session_tick"] > 200]
        down = session[(session["model"]["pedal"] == 1) & (session["robot"]["runlevel"] == PEDAL_DOWN)]
        stale = int((session["model"]["robot_fresh"] == 0).sum())
        print(f"{len(ticks)} ticks, {len(down)} of them with the pedal down, {stale} with a stale robot; "
              f"time slips {timing['physics']['time_slips']}, lost ticks {timing['physics']['lost_ticks']}")
        assert len(down) > 500 and (down["model"]["linked"] == 1).all()
        assert (session["robot"]["connected"] == 1).all()
        assert stale <= 0.05 * len(session), "only a busy machine makes states stale"
