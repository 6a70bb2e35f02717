#!/usr/bin/python3
"""A client of the Raven's own branch `crtk`, with the types, frames and lengths that raven2_CRTK_Python_controller has."""
import math
import time
import unittest

import rospy
import rostest
from crtk_test import OperatingState, QueryForwardKinematics, StringStamped, until, vector
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

OperatingState._type = "crtk_msgs/operating_state"  # the retired name of the same fields: rospy compares names
RATE = 200  # Hz


def turned(name, v):
    """The vector, from the arm's base to the branch's frame: T_crtk_in_r0 of the branch's crtk_motion_api.cpp."""
    x, y, z = v
    return (-y, -z, x) if name == "arm1" else (y, z, x)


def transform_of(pose):
    return pose.transform.translation


def acted(gap):
    """[s] of full speed from a rate until the next one: 0.1 s after a message the arm slows down, in 0.2 s."""
    slow = min(max(gap - 0.1, 0.0), 0.2)
    return min(gap, 0.1) + slow - slow ** 2 / 0.4


class CrtkRaven(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("crtk_raven_test", disable_signals=True)
        cls.states = []
        cls.subscriber = rospy.Subscriber("/arm1/operating_state", OperatingState, cls.states.append)
        until(lambda: cls.states, 40, "the daemon")
        until(lambda: cls.states[-1].is_homed and not cls.states[-1].is_busy, 40, "homed")
        until(lambda: cls.states[-1].state == "PAUSED", 5, "a homed Raven whose pedal is up")
        kinds = {"/state_command": StringStamped, "/arm1/state_command": StringStamped, "/arm1/servo_cp": TransformStamped,
                 "/arm1/servo_cr": TransformStamped, "/arm2/servo_cr": TransformStamped, "/arm1/servo_jr": JointState,
                 "/arm1/servo_jv": JointState, "/arm1/servo_jp": JointState, "/grasp1/servo_jr": JointState,
                 "/grasp2/move_jp": JointState, "/grasp1/servo_jv": JointState, "/grasp1/servo_jp": JointState,
                 "/grasp1/move_jp": JointState}
        cls.say = {topic: rospy.Publisher(topic, kind, queue_size=1, latch=True) for topic, kind in kinds.items()}
        cls.say["/arm1/state_command"].publish(StringStamped(string="resume"))  # the client's first line; latched
        until(lambda: all(p.get_num_connections() for p in cls.say.values()), 40, "all topics")
        until(lambda: cls.states[-1].state == "ENABLED", 5, "resumed")
        rospy.sleep(1.0)

    def next(self, topic, kind):
        return rospy.wait_for_message(topic, kind, 5)

    def stream(self, topic, message, count):
        """Returns when each message was sent [s]."""
        rate, sent = rospy.Rate(RATE), []
        for _ in range(count):
            # On a stalled machine rospy's queue of 1 loses messages before they leave the client.
            until(lambda: not any(c._queue for c in self.say[topic].impl.connections), 5, "the last message is sent")
            sent.append(time.monotonic())
            self.say[topic].publish(message)
            rate.sleep()
        rospy.sleep(1.0)
        return sent

    def test_0_the_parameters_that_crtk_cpp_reads_are_there(self):
        """The robot's roslaunch file loads them. crtk_lib_cpp asserts their types, and ends without them."""
        for arm, grasper in (("arm1", "grasp1"), ("arm2", "grasp2")):
            self.assertEqual(rospy.get_param(f"/{arm}/num_joints"), 7)
            self.assertEqual(rospy.get_param(f"/{arm}/grasper_name"), grasper)
            self.assertEqual(rospy.get_param(f"/{arm}/is_prismatic"), [0, 0, 1, 0, 0, 0, 0])
            joints, tip, turn = (rospy.get_param(f"/{arm}/home_{name}") for name in ("jpos", "pos", "quat"))
            there = rospy.ServiceProxy(f"/{arm}/local/forward_kinematics", QueryForwardKinematics)(jp=joints)
            self.assertLess(math.dist(tip, turned(arm, vector(there.cp.position))), 1e-9)
            measured = self.next(f"/{arm}/measured_cp", TransformStamped).transform
            self.assertLess(math.dist(tip, vector(measured.translation)), 5e-3, "a Raven that was just homed")
            r = measured.rotation
            self.assertGreater(abs(sum(a * b for a, b in zip(turn, (r.x, r.y, r.z, r.w)))), math.cos(0.1), "friction holds its tool")

    def test_1_increments_go_along_the_axes_of_the_turned_base(self):
        by = TransformStamped()
        by.transform.translation.z, by.transform.rotation.w = 2e-5, 1.0  # x of the base: up
        for arm in ("arm1", "arm2"):
            measured = self.next(f"/{arm}/measured_cp", TransformStamped)
            wanted = self.next(f"/{arm}/setpoint_cp", TransformStamped)
            off = math.dist(turned(arm, vector(transform_of(wanted))), vector(transform_of(measured)))
            self.assertLess(off, 5e-4, "setpoint_cp is in the base itself")
            self.stream(f"/{arm}/servo_cr", by, 200)
            now = self.next(f"/{arm}/measured_cp", TransformStamped)
            moved = [b - a for a, b in zip(vector(transform_of(measured)), vector(transform_of(now)))]
            print(f"{arm}: 4 mm asked for, moved by", ", ".join(f"{1e3 * m:.3f}" for m in moved), "mm")
            self.assertLess(math.dist(moved, (0.0, 0.0, 4e-3)), 1e-3)

    def test_2_a_published_pose_can_be_commanded(self):
        goal = self.next("/arm1/measured_cp", TransformStamped)
        goal.header = Header()  # with its stamp it would soon be too old
        goal.transform.translation.z -= 2e-3
        self.stream("/arm1/servo_cp", goal, 50)
        now = self.next("/arm1/measured_cp", TransformStamped)
        self.assertLess(math.dist(vector(transform_of(goal)), vector(transform_of(now))), 7e-4)

    def test_3_joints_are_seven_and_more_of_an_increment_count_for_nothing(self):
        before = self.next("/arm1/measured_js", JointState)
        self.assertEqual((before.name[0], before.name[6], len(before.position)), ("gold_shoulder", "gold_jaw2", 7))
        steps = [0.0] * 15
        steps[0], steps[5], steps[6] = 0.0005, -0.001, -0.001  # graspers both: the jaws close by 0.002
        self.stream("/arm1/servo_jr", JointState(position=steps), 100)
        after = self.next("/arm1/measured_js", JointState)
        self.assertAlmostEqual(after.position[0] - before.position[0], 0.05, delta=5e-3)
        opening = [sum(m.position[5:7]) for m in (before, after)]
        self.assertAlmostEqual(opening[1] - opening[0], -0.2, delta=0.02)
        self.stream("/grasp1/servo_jr", JointState(name=["grasp"], position=[0.002]), 100)  # named as by crtk-cpp
        grasp = self.next("/grasp1/measured_js", JointState)
        self.assertEqual(list(grasp.name), ["gold_grasp", "gold_jaw1", "gold_jaw2"])
        self.assertAlmostEqual(grasp.position[0], opening[0], delta=0.03)

    def test_4_increments_of_the_arm_alone_let_the_jaws_go_on(self):
        def at(topic):
            return self.next(topic, JointState).position[0]

        start, measured, shoulder = at("/grasp1/setpoint_js"), at("/grasp1/measured_js"), at("/arm1/measured_js")
        by = 0.5 if start < 0.7 else -0.5
        self.say["/grasp1/move_jp"].publish(JointState(position=[start + by]))  # 0.5 rad at 0.5 rad/s: 1.9 s
        self.stream("/arm1/servo_jr", JointState(position=[-0.0005] + [0.0] * 14), 100)
        until(lambda: abs(at("/grasp1/setpoint_js") - start - by) < 2e-3, 5, "the set point at the goal")
        until(lambda: abs(at("/grasp1/measured_js") - measured - by) < 0.02, 5, "the jaws at the goal")
        self.assertAlmostEqual(at("/arm1/measured_js") - shoulder, -0.05, delta=5e-3)

    def test_5_one_number_is_the_shoulder_and_rates_are_seven_and_end_with_their_stream(self):
        before = self.next("/arm1/measured_js", JointState)
        self.stream("/arm1/servo_jp", JointState(position=[before.position[0] + 0.03]), 20)
        rates = JointState(velocity=[0.0] * 15)
        rates.velocity[1] = 0.05
        sent = self.stream("/arm1/servo_jv", rates, RATE)  # 1 s, and no zero at its end: the branch's clients send none
        after = self.next("/arm1/measured_js", JointState)
        self.assertAlmostEqual(after.position[0] - before.position[0], 0.03, delta=5e-3)
        lasted = sum(acted(b - a) for a, b in zip(sent, sent[1:])) + acted(math.inf)
        self.assertAlmostEqual(after.position[1] - before.position[1], 0.05 * lasted, delta=5e-3)
        self.assertAlmostEqual(after.position[2], before.position[2], delta=2e-3)

    def test_6_unhome_disables_until_home(self):
        self.say["/arm1/state_command"].publish(StringStamped(string="unhome"))
        until(lambda: self.states[-1].state == "DISABLED" and not self.states[-1].is_homed, 5, "unhomed")
        self.say["/arm1/state_command"].publish(StringStamped(string="home"))
        until(lambda: self.states[-1].state == "PAUSED" and self.states[-1].is_homed, 5, "homed, its pedal up")
        self.say["/arm1/state_command"].publish(StringStamped(string="resume"))
        until(lambda: self.states[-1].state == "ENABLED", 5, "resumed")
        self.say["/arm1/state_command"].publish(StringStamped(string="pause"))  # the client's destructor
        until(lambda: self.states[-1].state == "PAUSED", 5, "paused")

    def test_7_both_arms_have_a_state_and_commands_without_a_namespace(self):
        both = []
        subscriber = rospy.Subscriber("/operating_state", OperatingState, both.append)
        for word, state in (("resume", "ENABLED"), ("pause", "PAUSED")):
            self.say["/state_command"].publish(StringStamped(string=word))
            until(lambda state=state: self.states[-1].state == state and both and both[-1].state == state, 5, state)
        self.say["/state_command"].publish(StringStamped(string="resume"))
        until(lambda: self.states[-1].state == "ENABLED" and both[-1].state == "ENABLED", 5, "resumed")
        rospy.sleep(1.0)
        # WHEN the other arm alone is busy
        begin = len(both), len(self.states)
        start = self.next("/grasp2/setpoint_js", JointState).position[0]
        self.say["/grasp2/move_jp"].publish(JointState(position=[start + (0.5 if start < 0.7 else -0.5)]))
        until(lambda: any(m.is_busy for m in both[begin[0]:]), 5, "busy")
        until(lambda: not both[-1].is_busy, 20, "not busy any more")
        self.assertFalse(any(m.is_busy for m in self.states[begin[1]:]), "the first arm")
        subscriber.unregister()


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "crtk_raven", CrtkRaven)
