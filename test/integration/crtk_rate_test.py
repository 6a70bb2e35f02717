#!/usr/bin/python3
"""The rate of a CRTK device. A busy machine cannot keep it, so this test runs alone; crtk_test.py has the rest."""
import statistics
import time
import unittest

import rospy
import rostest
from crtk_test import ARMS, Device, Topic, until
from sensor_msgs.msg import JointState


class CrtkRate(unittest.TestCase):
    def test_measured_js_comes_500_times_a_second_at_least(self):
        rospy.init_node("crtk_rate_test", disable_signals=True)
        arm = Device(ARMS[0])
        until(arm.connected, 40, "all topics of the arm")
        arm.command("enable")
        arm.await_state("ENABLED", 40)
        topic = Topic(f"{ARMS[0]}/measured_js", JointState)
        time.sleep(4.5)
        topic.close()
        headers = [message.header for message in topic.messages]
        seconds = (headers[-1].stamp - headers[0].stamp).to_sec()
        # roscpp numbers its messages, so those that this process is too slow for are counted as well
        published, taken = (headers[-1].seq - headers[0].seq) / seconds, len(headers) / seconds
        gaps = [(b.stamp - a.stamp).to_sec() for a, b in zip(headers, headers[1:]) if b.seq == a.seq + 1]
        print(f"measured_js: {published:.1f} Hz published, {taken:.1f} Hz received by Python, "
              f"stamps {1e3 * statistics.median(gaps):.3f} ms apart, {1e3 * max(gaps):.1f} ms at most")
        self.assertGreater(seconds, 4.0)
        self.assertGreater(len(gaps), 1000)
        self.assertGreater(min(gaps), 0.0, "each tick is published once")
        self.assertLess(statistics.median(gaps), 2.05e-3)
        self.assertGreaterEqual(published, 490)
        self.assertLess(published, 550)


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "crtk_rate", CrtkRate)
