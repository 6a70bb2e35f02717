#!/usr/bin/python3
"""Figures of doc/session.md: bytes of a log a second, and how long the Python reader takes for a tick."""

import os
import pathlib
import sys
import tempfile
import time

BUILD = os.environ.get("RAVEN2_TRAINER_BUILD", "build")
sys.path.insert(0, os.path.join(BUILD, "devel/lib/python3/dist-packages"))
import raven2_trainer  # noqa: E402

READS = 5


def teleoperation(simulation):
    simulation.start()
    simulation.step(ticks=20000)


def pedal_up(simulation):
    simulation.start()
    simulation.step({"pedal": False}, ticks=60000)  # homing counts for little


def main():
    for what, drive, options in (("scripted strokes", teleoperation, {"motion": "scripted"}),
                                 ("expert, pick_hand_over_place", teleoperation, {"exercise": "pick_hand_over_place", "motion": "expert"}),
                                 ("pedal up", pedal_up, {})):
        with tempfile.TemporaryDirectory() as folder:
            with raven2_trainer.Simulation(output=pathlib.Path(folder) / "session", **options) as simulation:
                drive(simulation)
            log = pathlib.Path(folder) / "session/session.rlog"
            ticks = len(raven2_trainer.SessionLog(log).ticks)
            begin = time.process_time()
            for _ in range(READS):
                raven2_trainer.SessionLog(log)
            reading = (time.process_time() - begin) / READS
            print(f"{what}: {log.stat().st_size / ticks / 1000:.2f} MB a second, read in {1e6 * reading / ticks:.1f} us a tick")


main()
