#!/usr/bin/python3
"""The three rows of Table 1 of Li et al. 2017 over real sockets, each with its outcome and the right reaction.

A sudden jump: release the pedal. A robot that no longer follows: restart it. A robot that is lost for good: convert
without it. The test is the console.
"""
import math
import threading
import time
import unittest

import rospy
import rostest
from geometry_msgs.msg import WrenchStamped
from raven2_trainer.srv import StartHazard
from robot_frames import Master, connect, kill_robot
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

MASTER_PORT, STATE_PORT = 27160, 27163
E_STOP, PEDAL_UP, PEDAL_DN = 0, 2, 3
WAIT = 3.0  # [s] of the scenarios (run_rostest), after the first pedal-down of the robot's process


class Console(threading.Thread):
    """Sends a packet about every millisecond: to and fro by 4 mm while `moving` is set."""

    def __init__(self):
        super().__init__(daemon=True)
        self.pedal, self.moving = 0, False
        self._master = Master(MASTER_PORT)

    def run(self):
        step = 0
        while True:
            um = 0
            if self.moving and self.pedal:
                um = 10 if step % 800 < 400 else -10
                step += 1
            self._master.send(self.pedal, (0, um, 0))
            time.sleep(0.001)


class Newest:
    """The newest message of a topic."""

    def __init__(self, topic, kind):
        self.message = None
        rospy.Subscriber(topic, kind, self._take)

    def _take(self, message):
        self.message = message


def until(condition, seconds, words):
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if condition():
            return
        time.sleep(0.005)
    raise AssertionError(words)


def call(name, kind, *arguments):
    rospy.wait_for_service(name, 20)
    answer = rospy.ServiceProxy(name, kind)(*arguments)
    assert answer.success, f"{name}: {answer.message}"


class Table1(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("table1_test", disable_signals=True)
        cls.force = Newest("haptic/gold/force", WrenchStamped)
        cls.model = Newest("model/joint_states", JointState)
        cls.console = Console()
        cls.console.start()
        cls.robot = connect(STATE_PORT)

    def newton(self):
        message = self.force.message
        f = message.wrench.force if message else None
        return math.sqrt(f.x * f.x + f.y * f.y + f.z * f.z) if f else 0.0

    def engage(self):
        """Waits for homing, presses the pedal and waits until the robot follows."""
        self.console.pedal, self.console.moving = 0, False
        self.assertIsNotNone(self.robot.wait(lambda s: s.runlevel == PEDAL_UP and s.homed, 60))
        time.sleep(0.3)
        self.console.pedal = 1
        self.assertIsNotNone(self.robot.wait(lambda s: s.runlevel == PEDAL_DN), "never engaged")
        self.console.moving = True
        start = self.robot.states[-1]
        self.assertIsNotNone(self.robot.wait(lambda s: self.moved(s, start) > 0.01), "it does not follow")

    @staticmethod
    def moved(state, start):
        return max(abs(a - b) for a, b in zip(state.q[0][:2], start.q[0][:2]))

    def model_moves_and_the_robot_does_not(self):
        """The model moves, and the robot reports no motion."""
        here, joints = self.robot.states[-1], list(self.model.message.position)
        until(lambda: max(abs(a - b) for a, b in zip(joints, self.model.message.position)) > 0.01, 5,
              "the model does not follow the hand")
        self.assertLess(self.moved(self.robot.states[-1], here), 2e-3, "the robot follows")

    def restart_robot(self):
        kill_robot()
        self.assertTrue(self.robot.ended(20))
        type(self).robot = connect(STATE_PORT)

    def test_1_a_sudden_jump_is_felt_and_ends_with_the_pedal(self):
        call("start_hazard", StartHazard, "sudden_jump")
        self.engage()
        self.console.moving = False  # the hand is still: the robot alone moves
        until(lambda: self.newton() > 0.0, WAIT + 17, "the jump was never felt")
        self.assertNotEqual(self.robot.states[-1].runlevel, E_STOP)
        # the right reaction: release the pedal
        self.console.pedal = 0
        self.assertIsNotNone(self.robot.wait(lambda s: s.runlevel == PEDAL_UP), "the pedal did not stop it")
        until(lambda: self.newton() == 0.0, 1.0, "the force stayed")
        call("stop_hazard", Trigger)
        self.engage()
        self.assertEqual(self.newton(), 0.0, "model and robot are together again")

    def test_2_a_robot_that_no_longer_follows_comes_back_after_a_restart(self):
        self.engage()
        call("start_hazard", StartHazard, "unavailable_recoverable")
        # The fault is due 3 s after the first pedal-down, which is past: it begins at once.
        until(lambda: self.robot.states[-1].active_fault != 0, WAIT + 10, "the fault never began")
        time.sleep(1.0)
        self.model_moves_and_the_robot_does_not()
        # the right reaction: stop, and restart the robot
        self.console.moving, self.console.pedal = False, 0
        self.restart_robot()
        self.engage()
        call("stop_hazard", Trigger)

    def test_3_a_robot_lost_for_good_stops_and_a_new_start_does_not_help(self):
        self.engage()
        call("start_hazard", StartHazard, "unavailable_permanent")
        self.assertIsNotNone(self.robot.wait(lambda s: s.runlevel == E_STOP, WAIT + 25), "it never stopped")
        self.console.pedal, self.console.moving = 0, False
        # the team would press start once more: the robot still does not follow
        call("virtual_raven/press_start", Trigger)
        self.assertIsNotNone(self.robot.wait(lambda s: s.runlevel == PEDAL_UP), "the start button did nothing")
        time.sleep(0.3)
        self.console.pedal, self.console.moving = 1, True
        self.assertIsNotNone(self.robot.wait(lambda s: s.runlevel == PEDAL_DN), "never engaged")
        time.sleep(0.5)
        self.model_moves_and_the_robot_does_not()
        # the right reaction: convert. The robot is disengaged and stays where it is
        self.console.pedal, self.console.moving = 0, False
        call("disengage", Trigger)
        gone = self.robot.wait(lambda s: s.runlevel in (PEDAL_UP, E_STOP))
        self.assertIsNotNone(gone, "the pedal did not stop it")
        self.console.pedal = 1  # somebody steps on it by mistake
        self.assertIsNotNone(self.robot.wait(lambda s: s.cycle > gone.cycle + 1000))
        self.assertNotIn(PEDAL_DN, {s.runlevel for s in self.robot.states if s.cycle > gone.cycle + 5})
        self.console.pedal = 0
        until(lambda: self.newton() == 0.0, 1.0, "a disengaged robot still causes a force")


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "table1", Table1)
