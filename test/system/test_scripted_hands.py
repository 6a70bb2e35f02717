"""A simulated surgeon does an exercise. Its pictures and its pedals cross the sockets."""

import csv
import os
import re
import sys
import time

from stack import ROOT, Stack, effort

sys.path.insert(0, os.path.join(ROOT, "scripts"))
import raven2_session  # noqa: E402

SECONDS = 180  # time limit; a session takes 10 s, in the long form 20 to 40 s


def first_half(exercise):
    """A stack in which the expert does the first two of its four actions, in the long form all four."""
    return Stack(configure={f"exercises/{exercise}": lambda e: e.update(expert=e["expert"][:effort(2, 4)])})


def run(stack, exercise, *hands):
    """Runs a session until the simulated surgeon has finished. Returns the log and the surgeon's own record."""
    words = ("--exercise", exercise, "--hazard", "none")
    truth = os.path.join(stack.folder, "truth.csv")
    stack.start_robot(*words)
    stack.start_daemon(*words)
    console = stack.start_console(*words, *hands, "--truth", truth)
    end = time.monotonic() + SECONDS
    while console.poll() is None:
        assert time.monotonic() < end, stack.log_text("master_console")
        time.sleep(0.1)
    assert stack.stop("master_console")[0] == 0, stack.log_text("master_console")
    assert stack.stop("simulator")[0] == 0, stack.log_text("simulator")
    stack.assert_counters_add_up()
    with open(truth, encoding="utf-8") as file:
        return raven2_session.Session(stack.output).log, list(csv.DictReader(file))


def pictures(stack):
    """(received, applied, rejected) as the console counted them."""
    found = re.search(r"pictures: (\d+) received = (\d+) applied \+ (\d+) rejected", stack.log_text("master_console"))
    return tuple(int(number) for number in found.groups())


def test_an_expert_sees_the_ring_and_carries_it():
    with first_half("pick_hand_over_place") as stack:
        log, truth = run(stack, "pick_hand_over_place", "--motion", "expert")
        received, applied, rejected = pictures(stack)
        assert received == applied + rejected and rejected == 0 and applied > 100
        verbs = [int(row["verb"]) for row in truth if row["what"] == "begin"]
        assert verbs[:2] == [0, 1], truth
        # The ring was grasped and lifted. The daemon judged this first step done; the surgeon does not receive that.
        assert log.ticks["model"]["exercise"]["step"].max() >= 2, truth


def test_the_camera_pedal_of_scripted_hands_moves_the_camera():
    with first_half("camera_clutch") as stack:
        log, truth = run(stack, "camera_clutch", "--motion", "expert")
        camera = log.names("tick", "model.mode").index("camera_moving")
        assert (log.ticks["model"]["mode"] == camera).sum() > 100, truth
