#!/usr/bin/python3
"""A robot is lost with the pedal down and comes back. Only a new pedal-down engages it again.

The test is the console.
"""
import threading
import time
import unittest

import rospy
import rostest
from robot_frames import Master, connect, kill_robot

MASTER_PORT, STATE_PORT = 27150, 27153
PEDAL_UP, PEDAL_DN = 2, 3
SILENCE = 3.75  # s; after 5 (run_rostest) the daemon takes the pedal as lifted, and the next packet as a new press
ATTEMPTS = 4


class Console(threading.Thread):
    """Sends a packet about every millisecond. The test sets pedal and step. Keeps the longest pause between packets."""

    def __init__(self):
        super().__init__(daemon=True)
        self.pedal, self.step_um, self.sent = 0, 0, 0
        self.longest_silence = 0.0
        self._master = Master(MASTER_PORT)

    def run(self):
        sent = time.monotonic()
        while True:
            self._master.send(self.pedal, (0, self.step_um, 0))
            self.sent += 1
            before, sent = sent, time.monotonic()
            self.longest_silence = max(self.longest_silence, sent - before)
            time.sleep(0.001)

    def hold(self, pedal):
        """Returns after 100 packets with this pedal; one under way may have the old one."""
        self.pedal = pedal
        last = self.sent + 101
        while self.sent < last:
            time.sleep(0.001)


class Relink(unittest.TestCase):
    def lose(self, robot, console):
        """Engages the robot and kills it with the pedal down. Waits until a second after the new robot is ready.
        Returns a reader of the new robot and the cycle in which it was ready."""
        console.pedal, console.step_um = 0, 0
        self.assertIsNotNone(robot.wait(lambda s: s.runlevel == PEDAL_UP and s.homed, 60))
        time.sleep(0.3)
        console.pedal, console.step_um = 1, 10
        self.assertIsNotNone(robot.wait(lambda s: s.runlevel == PEDAL_DN), "never engaged")
        console.longest_silence = 0.0
        kill_robot()
        console.step_um = 0
        self.assertTrue(robot.ended(20))
        robot = connect(STATE_PORT)
        ready = robot.wait(lambda s: s.homed and s.runlevel >= PEDAL_UP, 60)
        self.assertIsNotNone(ready)
        self.assertIsNotNone(robot.wait(lambda s: s.cycle > ready.cycle + 1000))
        return robot, ready.cycle

    def test_a_returning_robot_waits_for_a_new_pedal_down(self):
        rospy.init_node("relink_test", disable_signals=True)
        console = Console()
        console.start()
        robot = connect(STATE_PORT)
        for _ in range(ATTEMPTS):
            robot, since = self.lose(robot, console)
            if console.longest_silence < SILENCE:
                break
            print(f"this console was silent for {console.longest_silence:.3f} s, which counts as a lifted pedal: again")
        self.assertLess(console.longest_silence, SILENCE, "this computer kept the console silent each time")
        # THEN the pedal that is still down does not engage it
        self.assertEqual({s.runlevel for s in robot.states if s.cycle >= since}, {PEDAL_UP})
        self.assertGreater(robot.states[-1].last_sequence, 0, "the relay sends nothing, not even a raised pedal")

        # and a new pedal-down engages it, where it is
        console.hold(0)
        released = robot.states[-1]
        self.assertIsNotNone(robot.wait(lambda s: s.cycle > released.cycle + 300))
        console.pedal = 1
        engaged = robot.wait(lambda s: s.runlevel == PEDAL_DN)
        self.assertIsNotNone(engaged, "the robot did not accept the new pedal-down")
        self.assertIsNotNone(robot.wait(lambda s: s.cycle > engaged.cycle + 300))
        for arm in (0, 1):
            # the tool joints settle by some mrad, their integral working against friction (doc/virtual_raven.md)
            for before, after in zip(engaged.q[arm][:3], robot.states[-1].q[arm][:3]):
                self.assertAlmostEqual(before, after, delta=2e-3, msg="the robot moved without a command")
        console.step_um = 10
        self.assertIsNotNone(robot.wait(lambda s: max(abs(a - b) for a, b in zip(s.q[0], engaged.q[0])) > 0.02))


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "relink", Relink)
