#!/usr/bin/python3
"""A client from before crtk_python_client 1.2: its poses are TransformStamped, and operating_state has its retired name."""
import math
import unittest

import rospy
import rostest
from crtk_test import OperatingState, StringStamped, until, vector
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

OperatingState._type = "crtk_msgs/operating_state"  # rospy compares names
RATE = 200  # Hz


class CrtkTransform(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("crtk_transform_test", disable_signals=True)
        cls.states = []
        cls.subscriber = rospy.Subscriber("/arm1/operating_state", OperatingState, cls.states.append)
        until(lambda: cls.states and cls.states[-1].is_homed and not cls.states[-1].is_busy, 60, "homed")
        kinds = {"/arm1/state_command": StringStamped, "/arm1/servo_cp": TransformStamped, "/arm1/move_cp": TransformStamped,
                 "/arm1/local/servo_cp": TransformStamped, "/arm1/jaw/servo_jp": JointState}
        cls.say = {topic: rospy.Publisher(topic, kind, queue_size=10) for topic, kind in kinds.items()}
        until(lambda: all(p.get_num_connections() for p in cls.say.values()), 40, "all topics")
        cls.say["/arm1/state_command"].publish(StringStamped(string="enable"))
        until(lambda: cls.states[-1].state == "ENABLED", 10, "enabled")

    def next(self, topic, kind=TransformStamped):
        return rospy.wait_for_message(topic, kind, 5)

    def above(self, topic, z):
        """The newest pose, `z` m higher."""
        pose = self.next(topic)
        pose.header = Header()  # with its stamp it would soon be too old
        pose.transform.translation.z += z
        return pose

    def place(self, topic):
        return vector(self.next(topic).transform.translation)

    def test_1_a_move_goes_there_and_is_waited_for(self):
        goal = self.above("/arm1/setpoint_cp", 5e-3)
        before = len(self.states)
        self.say["/arm1/move_cp"].publish(goal)
        until(lambda: any(state.is_busy for state in self.states[before:]), 10, "busy")
        until(lambda: not self.states[-1].is_busy, 20, "there")
        there = vector(goal.transform.translation)
        until(lambda: math.dist(self.place("/arm1/setpoint_cp"), there) < 1e-4, 5, "the set point")
        until(lambda: math.dist(self.place("/arm1/measured_cp"), there) < 1e-3, 12, "the robot")

    def test_2_a_stream_moves_the_tip_in_the_world_and_in_the_base(self):
        for prefix in ("", "local/"):
            goal = self.above(f"/arm1/{prefix}setpoint_cp", 2e-3)
            rate = rospy.Rate(RATE)
            for _ in range(RATE // 4):
                self.say[f"/arm1/{prefix}servo_cp"].publish(goal)
                rate.sleep()
            there = vector(goal.transform.translation)
            until(lambda: math.dist(self.place(f"/arm1/{prefix}setpoint_cp"), there) < 1e-4, 5, prefix + "set point")

    def test_3_the_jaws_close_with_a_goal_beyond_closed(self):
        for opening, end in ((0.3, 0.3), (-0.6, math.radians(-10))):
            self.say["/arm1/jaw/servo_jp"].publish(JointState(position=[opening]))
            until(lambda: abs(self.next("/arm1/jaw/setpoint_js", JointState).position[0] - end) < 2e-3, 5, f"jaws at {end}")


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "crtk_transform", CrtkTransform)
