#!/usr/bin/python3
"""Figures of doc/python.md: first step, time of a tick, restoring, pictures, and the scaling of several simulations."""

import os
import statistics
import sys
import time

import numpy as np

sys.path.insert(0, os.path.join(os.environ.get("RAVEN2_TRAINER_BUILD", "build"), "devel/lib/python3/dist-packages"))
import raven2_trainer  # noqa: E402

EXERCISE = "pick_hand_over_place"
COMMAND = np.zeros((2, 7))
COMMAND[:, 0], COMMAND[:, 6] = 1e-4, 0.6


def seconds(work, times=1):
    begin = time.perf_counter()
    for _ in range(times):
        work()
    return (time.perf_counter() - begin) / times


def print_resets():
    try:
        import gymnasium  # PyPI: doc/python.md
        import raven2_trainer.gym  # pylint: disable=unused-import
    except ImportError:
        print("resets: gymnasium is missing")
        return
    for name, options in (("Reach", {}), ("PickRing", {}), ("PickRing", {"hazard": "own"})):
        environment = gymnasium.make(f"raven2_trainer/{name}-v0", **options)
        print(f"reset of {name} {options}: {1e3 * seconds(environment.reset, 50):.1f} ms")
        environment.close()


def main():
    for robot in ("virtual", "none"):
        begin = time.perf_counter()
        simulation = raven2_trainer.Simulation(EXERCISE, robot=robot)
        simulation.step()
        first = time.perf_counter() - begin
        simulation.start()
        tick = seconds(lambda: simulation.step(COMMAND, ticks=10), 300) / 10
        snapshot = simulation.save()
        restoring = statistics.median(seconds(lambda: simulation.restore(snapshot)) for _ in range(20) if simulation.step() is None)
        print(f"robot {robot}: first step after {first:.2f} s, tick {1e6 * tick:.0f} us ({1e-3 / tick:.0f} x real time), "
              f"snapshot {snapshot.size / 1e6:.1f} MB restored in {1e3 * restoring:.2f} ms")
    print(f"picture of 320x240: {1e3 * seconds(lambda: simulation.render('endoscope', 320, 240), 100):.1f} ms")
    one, four = (raven2_trainer.VectorSimulation(n, EXERCISE) for n in (1, 4))
    for some in (one, four):
        some.start()
    alone = seconds(lambda: one.step(None, ticks=3000))
    print(f"four on {len(os.sched_getaffinity(0))} processors: {4 * alone / seconds(lambda: four.step(None, ticks=3000)):.2f} times one")
    print_resets()


main()
