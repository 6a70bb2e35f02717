#!/usr/bin/python3
"""A CRTK client against daemon and virtual Raven, without a console.

Written from CRTK's own documents (collaborative-robotics.github.io, crtk_msgs 1.3.0) alone: the test imports nothing of
the package. Debian has no crtk_msgs, so its messages are made from their published text (test/support).
"""
import math
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import xmlrpc.client

import rosgraph
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Empty, Float64, Float64MultiArray
from tf2_msgs.msg import TFMessage

HERE = pathlib.Path(__file__).resolve().parent
MESSAGES = HERE.parent / "support/crtk_messages.py"
sys.path.insert(0, str(MESSAGES.parent))
from crtk_messages import (  # noqa: E402
    OperatingState, QueryForwardKinematics, QueryInverseKinematics, StringStamped)

ARMS = ("arm1", "arm2")
RATE = 200  # Hz, of CRTK's example clients
SETTLE = 12  # s at most; doc/crtk.md has 6: until the integral of a Raven's tool joints overcomes their dry friction
NEAR, NEAR_TURN = 0.5e-3, math.radians(0.2)  # m, rad: measured from set point, at rest
STILL, STILL_TURN = 0.1e-3, math.radians(0.1)  # m, rad
SAME = 1e-5  # m: the set point is still
HOME = (math.radians(30), math.radians(90), 0.40, 0.0, 0.0, 0.0)  # after homing (raven2.md)


ONE_MESSAGE = """
import sys
import rospy
from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import JointState

rospy.init_node("one_message", anonymous=True)
twist = TwistStamped()
twist.twist.linear.z = 2e-3
message = {"servo_cv": twist, "servo_jv": JointState(velocity=[0.01, 0, 0, 0, 0, 0])}[sys.argv[1].split("/")[-1]]
publisher = rospy.Publisher(sys.argv[1], type(message), queue_size=10)
while publisher.get_num_connections() == 0:
    rospy.sleep(0.01)
publisher.publish(message)
print("sent", flush=True)
rospy.spin()
"""


def until(condition, seconds, words):
    """Polls. @return what `condition` gave, once it is true."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        found = condition()
        if found:
            return found
        time.sleep(0.005)
    raise AssertionError(f"not within {seconds} s: {words}")


def within(condition, seconds, hold=0.0):
    """Polls. @return whether `condition` came true and stayed so for `hold` seconds."""
    now = time.monotonic()
    deadline, since = now + seconds, None
    while now < deadline:
        is_true = condition()
        now = time.monotonic()
        since = (since or now) if is_true else None
        if is_true and now - since >= hold:
            return True
    return False


def vector(v):
    return (v.x, v.y, v.z)


def distance(a, b):
    return math.dist(vector(a.pose.position), vector(b.pose.position))


def turn(a, b):
    """Angle between two poses' orientations."""
    p, q = a.pose.orientation, b.pose.orientation
    w = abs(p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w)
    return 2 * math.acos(min(1.0, w))


def rotate(q, v):
    """Vector v turned by quaternion q."""
    u = (q.x, q.y, q.z)
    cross = lambda a, b: (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])  # noqa: E731
    t = [2 * c for c in cross(u, v)]
    return tuple(v[i] + q.w * t[i] + cross(u, t)[i] for i in range(3))


def along(way, axis):
    return sum(a * b for a, b in zip(way, axis)) / math.hypot(*axis)


def angle(a, b):
    return math.acos(max(-1.0, min(1.0, along(a, b) / math.hypot(*a))))


def smooth(share):
    """0 to 1 from rest to rest."""
    return 0.5 - 0.5 * math.cos(math.pi * share)


class Topic:
    """The newest 20,000 messages of a topic. Python receives only some thousand a second: not all topics at once."""

    def __init__(self, name, kind):
        self.messages = []
        self._subscriber = rospy.Subscriber(name, kind, self._take, queue_size=2000, buff_size=1 << 20, tcp_nodelay=True)

    def _take(self, message):
        self.messages.append(message)
        if len(self.messages) > 20000:
            del self.messages[:10000]

    @property
    def newest(self):
        return self.messages[-1] if self.messages else None

    def close(self):
        self._subscriber.unregister()

    def since(self, count, word, seconds=5):
        """The first after the first `count` whose text has the word."""
        return until(lambda: next((m.string for m in self.messages[count:] if word in m.string), None), seconds,
                     f"\"{word}\" on {self._subscriber.name}; there was {[m.string for m in self.messages[count:]]}")


class Device:
    """One arm, by its namespace."""

    KEPT = {"operating_state": OperatingState, "info": StringStamped, "warning": StringStamped, "error": StringStamped}
    HEARD = {**KEPT, "measured_js": JointState, "setpoint_js": JointState, "measured_cp": PoseStamped, "setpoint_cp": PoseStamped,
             "goal_cp": PoseStamped, "jaw/measured_js": JointState, "jaw/setpoint_js": JointState,
             "local/measured_cp": PoseStamped, "local/setpoint_cp": PoseStamped, "jacobian": Float64MultiArray,
             "spatial/jacobian": Float64MultiArray}
    SAID = {"state_command": StringStamped, "servo_jp": JointState, "servo_jr": JointState, "servo_cp": PoseStamped,
            "servo_cr": PoseStamped, "servo_cv": TwistStamped, "move_jp": JointState, "move_cp": PoseStamped, "hold": Empty,
            "free": Empty, "jaw/servo_jp": JointState, "jaw/move_jp": JointState, "local/servo_cp": PoseStamped}

    def __init__(self, name):
        self.name = name
        self.topics = {topic: Topic(f"{name}/{topic}", kind) for topic, kind in self.KEPT.items()}
        self._publishers = {topic: rospy.Publisher(f"{name}/{topic}", kind, queue_size=200, tcp_nodelay=True)
                            for topic, kind in self.SAID.items()}

    def publishers_of(self, topic):
        return [self._publishers[topic]]

    def connected(self):
        return all(p.get_num_connections() > 0 for p in self._publishers.values()) and self.state is not None

    def __getitem__(self, topic):
        return self.topics[topic]

    @property
    def state(self):
        return self["operating_state"].newest

    def say(self, topic, message):
        self._publishers[topic].publish(message)

    def command(self, word):
        self.say("state_command", StringStamped(string=word))

    def await_state(self, state, seconds=5):
        until(lambda: self.state.state == state, seconds, f"{self.name} {state}, it is {self.state.state}")

    def finish(self, send, seconds):
        """Sends a move, and waits until the arm was busy and is not any more. Misses no message, however late it looks."""
        count = self.count("operating_state")
        send()
        until(lambda: any(m.is_busy for m in self["operating_state"].messages[count:]), 2, "is_busy")
        until(lambda: not self.state.is_busy, seconds, "not busy any more")

    def count(self, topic):
        return len(self[topic].messages)

    def joints(self, topic, positions):
        self.say(topic, JointState(position=positions))

    def next(self, topic):
        """A message from now on."""
        return rospy.wait_for_message(f"{self.name}/{topic}", self.HEARD[topic], 5)

    def position(self, topic="setpoint_js"):
        return list(self.next(topic).position)

    def pose(self, topic="setpoint_cp"):
        return self.next(topic)


def moved(pose, by):
    """The pose, shifted."""
    message = PoseStamped()
    message.header.frame_id = pose.header.frame_id
    message.pose.orientation = pose.pose.orientation
    p = message.pose.position
    p.x, p.y, p.z = (a + b for a, b in zip(vector(pose.pose.position), by))
    return message


class Crtk(unittest.TestCase):
    bases = {}  # frame and rotation, by the arm's name

    @classmethod
    def setUpClass(cls):
        rospy.init_node("crtk_test", disable_signals=True)
        cls.arms = [Device(name) for name in ARMS]
        until(lambda: all(arm.connected() for arm in cls.arms), 40, "all topics of both arms")
        cls.diagnostics = Topic("/diagnostics", DiagnosticArray)

    def settle(self):
        """Waits until both arms rest at their set points, at most SETTLE. The caller asserts whether they do."""
        last = [arm.pose() for arm in self.arms]

        def is_near(arm, i):
            time.sleep(0.05)  # each look connects to three topics
            before, last[i] = last[i], arm.pose()
            found = arm.pose("measured_cp")  # held to 0.9 of the limits, so that a later look passes as well
            return (distance(before, last[i]) < SAME and distance(last[i], found) < 0.9 * NEAR
                    and turn(last[i], found) < 0.9 * NEAR_TURN)

        # with hold: an arm may swing through the set point, and tool joints stick before they slip
        begin = time.monotonic()
        within(lambda: all([is_near(arm, i) for i, arm in enumerate(self.arms)]), SETTLE, hold=0.8)
        print(f"settled after {time.monotonic() - begin:.1f} s")

    def await_still(self):
        """Waits until neither arm moves, at most SETTLE."""
        last = [arm.pose("measured_cp") for arm in self.arms]

        def is_still(arm, i):
            before, last[i] = last[i], arm.pose("measured_cp")
            return distance(before, last[i]) < 0.3 * STILL and turn(before, last[i]) < 0.3 * STILL_TURN

        def are_still():
            time.sleep(0.3)
            return all([is_still(arm, i) for i, arm in enumerate(self.arms)])

        within(are_still, SETTLE, hold=0.3)

    @staticmethod
    def stream(seconds, send):
        """Calls send(share) 200 times a second, with a share that goes smoothly from 0 to 1."""
        rate = rospy.Rate(RATE)
        steps = int(seconds * RATE)
        for i in range(steps + 1):
            send(smooth(i / steps))
            rate.sleep()

    def stream_joints(self, goals, topic="servo_jp", seconds=1.0):
        """Streams both arms from their set points to the goals."""
        source = "setpoint_js" if topic == "servo_jp" else "jaw/setpoint_js"
        starts = [arm.position(source) for arm in self.arms]

        def send(share):
            for arm, start, goal in zip(self.arms, starts, goals):
                arm.joints(topic, [a + share * (b - a) for a, b in zip(start, goal)])

        self.stream(seconds, send)

    def stream_poses(self, goals, seconds=1.0):
        """Streams both tips to the goals, without rotation."""
        starts = [arm.pose() for arm in self.arms]

        def send(share):
            for arm, start, goal in zip(self.arms, starts, goals):
                way = [share * (b - a) for a, b in zip(vector(start.pose.position), vector(goal.pose.position))]
                arm.say("servo_cp", moved(start, way))

        self.stream(seconds, send)

    def check_settled(self, what):
        """The measured pose is at the set point. Prints the joints' differences as well."""
        for arm in self.arms:
            wanted, found = arm.pose(), arm.pose("measured_cp")
            off, off_turn = distance(wanted, found), turn(wanted, found)
            joints = [a - b for a, b in zip(arm.position("measured_js"), arm.position())]
            print(f"{what}, {arm.name}: {1e3 * off:.3f} mm, {math.degrees(off_turn):.3f} degrees from the set point; joints "
                  + ", ".join(f"{1e3 * j:.2f}" for j in joints) + " mrad, mm")
            self.assertLess(off, NEAR, f"{what}, {arm.name}")
            self.assertLess(off_turn, NEAR_TURN, f"{what}, {arm.name}")

    def assert_stands(self, seconds, act):
        """Calls act(). That many seconds later, neither arm has moved."""
        before = [arm.pose("measured_cp") for arm in self.arms]
        act()
        time.sleep(seconds)
        for arm, pose in zip(self.arms, before):
            now = arm.pose("measured_cp")
            self.assertLess(distance(pose, now), STILL, arm.name)
            self.assertLess(turn(pose, now), STILL_TURN, arm.name)

    def test_01_each_arm_has_crtks_topics_and_none_for_what_it_cannot_do(self):
        publishers, subscribers, _ = rosgraph.Master("/crtk_test").getSystemState()
        types = dict(rospy.get_published_topics())
        told = {name for name, nodes in publishers if "/raven2_simulator" in nodes}
        heard = {name for name, nodes in subscribers if "/raven2_simulator" in nodes}
        wanted = {**Device.HEARD, "measured_cv": TwistStamped, "measured_cf": WrenchStamped,
                  "local/setpoint_cp": PoseStamped, "local/measured_cv": TwistStamped}
        for arm in ARMS:
            for name, kind in wanted.items():
                self.assertIn(f"/{arm}/{name}", told)
                self.assertEqual(types[f"/{arm}/{name}"], kind._type)
            for name in [*Device.SAID, "local/servo_cr", "local/servo_cv", "local/move_cp", "jaw/servo_jr"]:
                self.assertIn(f"/{arm}/{name}", heard)
            for name in ("measured_js", "measured_cp", "setpoint_cp", "jaw/measured_js", "local/measured_cp", "measured_cf"):
                self.assertIn(f"/model/{arm}/{name}", told)
            for name in ("move_cr", "interpolate_jp", "interpolate_cp"):
                self.assertNotIn(f"/{arm}/{name}", heard)

    def test_02_before_enable_it_is_disabled_and_says_why_it_does_not_move(self):
        arm = self.arms[0]
        self.assertEqual([a.state.state for a in self.arms], ["DISABLED"] * 2)
        count = arm.count("warning")
        arm.joints("servo_jp", arm.position())
        self.assertIn("servo_jp", arm["warning"].since(count, "DISABLED"))
        count = arm.count("warning")
        arm.command("pause")
        arm["warning"].since(count, "pause")
        self.assertEqual(arm.state.state, "DISABLED")

    def test_03_enable_leads_to_enabled_and_homed_on_both_arms(self):
        self.arms[0].command("enable")
        for arm in self.arms:
            until(lambda: arm.state.state == "ENABLED" and arm.state.is_homed and not arm.state.is_busy, 40,
                  f"{arm.name} enabled and homed: {arm.state}")
        count = self.arms[0].count("warning")
        self.arms[0].command("home")  # no effect: a Raven homes when it is started
        self.settle()
        self.assertEqual(self.arms[0].count("warning"), count)
        self.assertTrue(self.arms[0].state.is_homed)
        self.check_settled("after homing")

    def test_04_states_come_with_what_crtk_wants_in_them(self):
        arm = self.arms[1]
        js, cp, jaw = arm.next("measured_js"), arm.next("measured_cp"), arm.next("jaw/measured_js")
        self.assertEqual([len(js.name), len(js.position), len(js.velocity), len(js.effort)], [6] * 4)
        self.assertEqual([len(jaw.name), len(jaw.position), len(jaw.velocity), len(jaw.effort)], [1] * 4)
        self.assertEqual((js.header.frame_id, cp.header.frame_id), ("world", "world"))
        topics = {name: Topic(f"{arm.name}/{name}", arm.HEARD[name])
                  for name in ("measured_js", "measured_cp", "setpoint_js", "setpoint_cp", "jaw/measured_js")}
        time.sleep(1.5)
        for topic in topics.values():
            topic.close()
        stamps = {name: [m.header.stamp for m in topic.messages] for name, topic in topics.items()}
        for name, topic in topics.items():
            pairs = list(zip(topic.messages, topic.messages[1:]))
            missed = [(a.header.stamp, b.header.stamp) for a, b in pairs if b.header.seq != a.header.seq + 1]  # by this process
            due = {stamp for stamp in stamps["measured_js"] if stamps[name][0] <= stamp <= stamps[name][-1]
                   and not any(first < stamp < last for first, last in missed)}
            self.assertGreater(len(due), 100, name)
            self.assertLessEqual(due, set(stamps[name]), name)
        age = (rospy.Time.now() - arm.next("measured_js").header.stamp).to_sec()
        self.assertLess(abs(age), 0.5, "stamps are the time of the tick")

    def test_06_local_is_the_world_seen_from_the_arms_base(self):
        frames = Topic("/tf_static", TFMessage)
        for arm in self.arms:
            local = arm.pose("local/measured_cp")
            base = local.header.frame_id
            X = until(lambda: next((t.transform for m in frames.messages for t in m.transforms if t.child_frame_id == base),
                                   None), 5, f"{base} on /tf_static")
            world = arm.pose("measured_cp")
            expected = [a + b for a, b in zip(rotate(X.rotation, vector(local.pose.position)), vector(X.translation))]
            self.assertLess(math.dist(expected, vector(world.pose.position)), 2e-4, "at rest, up to the robot's noise")
            self.bases[arm.name] = base, X.rotation
            self.check_spatial_jacobian(arm, vector(world.pose.position))

    def check_spatial_jacobian(self, arm, tip):
        """Its linear part is the velocity of the body's point at the world's origin: v + p x w."""
        about_tip, about_origin = ([arm.next(name).data[6 * row:6 * row + 6] for row in range(6)]
                                   for name in ("jacobian", "spatial/jacobian"))
        for j in range(6):
            v, w = ([about_tip[row][j] for row in rows] for rows in (range(3), range(3, 6)))
            lever = [tip[(i + 1) % 3] * w[(i + 2) % 3] - tip[(i + 2) % 3] * w[(i + 1) % 3] for i in range(3)]
            found = [about_origin[row][j] for row in range(6)]
            self.assertLess(math.dist(found, [*(a + b for a, b in zip(v, lever)), *w]), 1e-3, f"{arm.name}, joint {j}")

    def test_07_a_stream_in_joint_space_moves_both_arms(self):
        starts = [arm.position() for arm in self.arms]
        away = ((0.15, 0.1, 0.02, 0.3, 0.2, 0.2), (-0.1, 0.15, 0.03, -0.3, -0.2, 0.1))  # each arm differently
        velocities = {(arm.name, name): Topic(f"{arm.name}/{name}", TwistStamped)
                      for arm in self.arms for name in ("measured_cv", "local/measured_cv")}
        until(lambda: all(topic.newest for topic in velocities.values()), 5, "velocities")
        self.stream_joints_to([[a + b for a, b in zip(start, by)] for start, by in zip(starts, away)])
        for arm in self.arms:
            self.check_velocities(velocities[arm.name, "measured_cv"], velocities[arm.name, "local/measured_cv"], *self.bases[arm.name])
        self.settle()
        self.check_settled(f"joints by {away}")
        self.check_models()
        self.stream_joints_to(starts)

    def check_models(self):
        """The model of each arm is where that arm is, and both have the torques of that model."""
        def mean(name):
            topic = Topic(name, JointState)
            until(lambda: len(topic.messages) > 20, 5, name)
            topic.close()
            rows = [[*m.position[:3], *m.effort[:3]] for m in topic.messages]
            return [sum(column) / len(rows) for column in zip(*rows)]

        own, model = ([mean(f"{above}{arm.name}/measured_js") for arm in self.arms] for above in ("", "model/"))
        print("torques at rest:", own, model)
        for arm, a, b in zip(self.arms, own, model):
            self.assertLess(math.dist(a[:3], b[:3]), 0.02, arm.name)
            self.assertLess(math.dist(a[3:], b[3:]), 0.2 * math.dist(own[0][3:], own[1][3:]), arm.name)

    def check_velocities(self, in_world, in_base, base, rotation):
        """The same in both frames. @param rotation: of the arm's base in the world."""
        for topic in (in_world, in_base):
            topic.close()
        world, local = ({m.header.stamp: m for m in topic.messages} for topic in (in_world, in_base))
        both = [(world[stamp], local[stamp]) for stamp in world if stamp in local]
        self.assertGreater(sum(math.hypot(*vector(m.twist.linear)) > 1e-3 for m, _ in both), 20, "it has moved")
        for m, other in both:
            self.assertEqual((m.header.frame_id, other.header.frame_id), ("world", base))
            for part in ("linear", "angular"):
                expected = rotate(rotation, vector(getattr(other.twist, part)))
                self.assertLess(math.dist(expected, vector(getattr(m.twist, part))), 1e-6)

    def stream_joints_to(self, goals):
        """Streams joints and checks the set points."""
        self.stream_joints(goals)
        for arm, goal in zip(self.arms, goals):
            until(lambda: all(abs(a - b) < 2e-4 for a, b in zip(arm.position(), goal)), 5,
                  f"set point of {arm.name}: {goal}, is {arm.position()}")

    def test_08_a_stream_of_poses_moves_both_tips(self):
        type(self).starts = starts = [arm.pose() for arm in self.arms]
        away = ((0.015, 0.01, -0.01), (-0.01, 0.01, 0.005))  # each arm differently
        self.stream_poses_to([moved(start, by) for start, by in zip(starts, away)])
        self.settle()
        self.check_settled(f"poses by {away}")

    def stream_poses_to(self, goals):
        """Streams poses and checks the set points."""
        self.stream_poses(goals)
        for arm, goal in zip(self.arms, goals):
            until(lambda: distance(arm.pose(), goal) < 5e-5, 5, f"{arm.name}: the set point is where it was asked to be")

    def test_09_increments_add_up(self):
        arm = self.arms[0]
        start = arm.pose()
        by = PoseStamped()
        by.pose.position.z, by.pose.orientation.w = 2e-5, 1.0
        rate = rospy.Rate(RATE)
        poses = Topic(f"{arm.name}/setpoint_cp", PoseStamped)
        until(lambda: poses.newest, 5, "setpoint_cp")
        for k in range(1, 251):
            arm.say("servo_cr", by)
            rate.sleep()
            if k % 50 == 0:  # the daemon queues 100
                until(lambda: abs(poses.newest.pose.position.z - start.pose.position.z - 2e-5 * k) < 5e-5, 5, f"{k} increments")
        poses.close()
        self.settle()
        end = arm.pose()
        self.assertAlmostEqual(end.pose.position.z - start.pose.position.z, 5e-3, delta=5e-5)
        self.assertLess(abs(end.pose.position.x - start.pose.position.x), 5e-5)
        self.check_settled("increments")
        on = TwistStamped()
        on.twist.linear.z = 0.01
        begun = time.monotonic()
        for _ in range(100):
            arm.say("servo_cv", on)
            rate.sleep()
        took = time.monotonic() - begun  # 0.5 s, or longer on a busy machine
        arm.say("servo_cv", TwistStamped())
        self.settle()
        way = arm.pose().pose.position.z - end.pose.position.z
        self.assertAlmostEqual(way, 0.01 * took, delta=1.5e-3)
        self.assertGreater(way, 3.5e-3)
        self.check_settled("a twist")
        self.stream_poses_to(self.starts)  # those of test 08, back along each axis

    def test_10_a_move_is_busy_until_it_is_there(self):
        arm, other = self.arms
        goal = moved(arm.pose(), (0.0, 0.0, 0.03))  # farther than a servo command may go
        count = arm.count("operating_state")
        arm.say("move_cp", goal)
        until(lambda: any(m.is_busy for m in arm["operating_state"].messages[count:]), 2, "is_busy")
        self.assertLess(distance(arm.next("goal_cp"), goal), 1e-5)
        until(lambda: not arm.state.is_busy, 10, "not busy any more")
        self.assertLess(distance(arm.pose(), goal), 5e-5)
        self.assertFalse(other.state.is_busy)
        self.settle()
        self.check_settled("move_cp")
        # WHEN the arm is held during the move back
        start = moved(goal, (0.0, 0.0, -0.03))
        poses, ratio = Topic(f"{arm.name}/setpoint_cp", PoseStamped), Topic(f"{arm.name}/trajectory_j/ratio", Float64)
        slow = rospy.Publisher(f"{arm.name}/trajectory_j/set_ratio", Float64, queue_size=1)
        until(lambda: slow.get_num_connections() > 0 and poses.newest and ratio.newest, 5, "the daemon")
        slow.publish(Float64(data=0.2))  # 7 s for the move: a hold that is late comes in time
        until(lambda: ratio.newest.data == 0.2, 5, "the ratio")
        arm.say("move_cp", start)
        until(lambda: distance(poses.newest, goal) > 0.01, 5, "a third of the move")
        arm.say("hold", Empty())
        until(lambda: not arm.state.is_busy, 2, "not busy any more")
        held = poses.newest.header.stamp
        until(lambda: (poses.newest.header.stamp - held).to_sec() > 6.0, 20, "longer than the rest of the move would take")
        self.assertGreater(distance(arm.pose(), start), 0.005, "the move went on after hold")
        slow.publish(Float64(data=1.0))
        until(lambda: ratio.newest.data == 1.0, 5, "the ratio")
        slow.unregister()
        for topic in (poses, ratio):
            topic.close()
        arm.joints("move_jp", arm.position())
        arm.say("move_cp", start)
        until(lambda: distance(arm.pose(), start) < 5e-5, 10, "back at the start")

    def test_11_the_jaws_open_and_close(self):
        # a Raven keeps the jaw opening wanted before homing, up to 45 degrees off, until that opening meets its bound
        self.stream_joints([[-0.174], [-0.174]], "jaw/servo_jp")
        for opening in (0.4, 1.2):
            self.stream_joints([[opening], [opening]], "jaw/servo_jp")
            within(lambda: all(abs(arm.position("jaw/measured_js")[0] - opening) < math.radians(0.4) for arm in self.arms),
                   SETTLE, hold=0.3)
            for arm in self.arms:
                wanted, found = arm.position("jaw/setpoint_js")[0], arm.position("jaw/measured_js")[0]
                print(f"jaw of {arm.name} at {opening}: set point {wanted:.4f}, measured {found:.4f} rad")
                self.assertAlmostEqual(wanted, opening, delta=2e-3)
                self.assertAlmostEqual(found, wanted, delta=math.radians(0.5))

    def check_refused(self, arm, topic, message, words):
        arm.say("hold", Empty())  # a refused message is no command: after release_after the pedal would go up
        time.sleep(0.1)
        count = arm.count("warning")
        self.assert_stands(0.3, lambda: arm.say(topic, message))
        said = arm["warning"].since(count, words[0])
        self.assertIn(topic, said)
        for word in words:
            self.assertIn(word, said)

    def test_12_what_makes_no_sense_is_refused_in_words_and_moves_nothing(self):
        time.sleep(3.0)  # creeping tool joints pause between steps, which await_still() takes for rest
        self.await_still()
        arm = self.arms[1]
        here, joints = arm.pose(), arm.position()
        millimetres = moved(here, (83.0, 0.0, 0.0))
        elsewhere = moved(here, (0.001, 0.0, 0.0))
        elsewhere.header.frame_id = "camera"
        unfilled = PoseStamped(header=here.header)
        late = moved(here, (0.001, 0.0, 0.0))
        late.header.stamp = rospy.Time.now() - rospy.Duration(2.0)
        faults = []
        for topic, message, words in (
                ("servo_cp", millimetres, ("83", "0.02 m", "metres")),
                ("servo_cp", elsewhere, ("camera", "world")),
                ("move_cp", unfilled, ("quaternion",)),
                ("servo_jp", JointState(position=joints[:5]), ("5 positions",)),
                ("servo_jr", JointState(position=[float("nan")] * 6), ("finite",)),
                ("move_jp", JointState(position=[math.degrees(q) for q in joints]), ("rad", "radians")),
                ("state_command", StringStamped(string="go"), ("go", "enable")),
                ("servo_cp", late, ("stamped", "0.5 s"))):  # last: a topic repeats a warning once a second at most
            try:  # rosunit counts the failures in a subTest but does not print them
                self.check_refused(arm, topic, message, words)
            except AssertionError as error:
                faults.append(f"{topic} {words}: {error}")
        self.assertEqual(faults, [])
        self.assertEqual(arm.state.state, "ENABLED")

    def test_13_what_a_client_stored_before_a_broken_connection_is_not_done_again(self):
        arm = self.arms[0]
        start = arm.position("jaw/setpoint_js")[0]
        latching = rospy.Publisher(f"{arm.name}/jaw/servo_jr", JointState, queue_size=1, latch=True)

        def is_at(opening):
            return abs(arm.position("jaw/setpoint_js")[0] - opening) < 2e-3

        latching.publish(JointState(position=[-0.1]))  # before it is connected: the daemon has not had it
        self.assertTrue(within(lambda: is_at(start - 0.1), 5), "a new client's latched command is executed")
        count = arm.count("warning")
        for connection in list(latching.impl.connections):
            connection.close()
        said = arm["warning"].since(count, "latches")
        self.assertIn("jaw/servo_jr", said)
        self.assertIn(rospy.get_name(), said)
        time.sleep(0.5)
        self.assertTrue(is_at(start - 0.1), "the latched command is not executed again")
        latching.publish(JointState(position=[0.1]))
        self.assertTrue(within(lambda: is_at(start), 5), "the client's next command is executed")
        latching.unregister()

    def test_14_paused_it_refuses_to_move_and_resumed_it_moves(self):
        self.arms[1].command("pause")
        for arm in self.arms:
            arm.await_state("PAUSED")
        self.await_still()  # until the brakes hold
        count = self.arms[0].count("warning")
        froms = [arm.position() for arm in self.arms]

        def ask():
            rate = rospy.Rate(RATE)
            for _ in range(100):
                for arm, start in zip(self.arms, froms):
                    arm.joints("servo_jp", [start[0] + 0.05] + start[1:])
                rate.sleep()

        self.assert_stands(0.5, ask)
        self.assertIn("resume", self.arms[0]["warning"].since(count, "PAUSED"))
        self.assertLess(self.arms[0].count("warning") - count, 10, "a stream of commands causes few warnings")
        self.arms[0].command("resume")
        for arm in self.arms:
            arm.await_state("ENABLED")
        self.stream_joints([[start[0] + 0.05] + start[1:] for start in froms], seconds=1.0)
        self.settle()
        self.check_settled("resumed")

    def test_15_disabled_it_stands(self):
        self.arms[0].command("disable")
        for arm in self.arms:
            arm.await_state("DISABLED")
        self.assertTrue(self.arms[0].state.is_homed)
        self.await_still()
        self.assert_stands(0.5, lambda: self.arms[0].joints("servo_jr", [0.05] * 6))
        status = until(lambda: next((s for m in self.diagnostics.messages[-20:] for s in m.status
                                     if s.name.endswith(": crtk") and s.message == "DISABLED"), None), 5, "a status crtk")
        counts = ("received", "applied", "refused", "unread", "lost")
        numbers = {pair.key: int(pair.value) for pair in status.values if pair.key in counts}
        self.assertEqual(status.level, 0, status)
        self.assertEqual(numbers["received"], sum(numbers[key] for key in counts[1:]))
        self.assertEqual(numbers["lost"], 0)
        self.assertGreater(numbers["applied"], 1000)
        self.assertGreater(numbers["refused"], 100)

    def test_15a_a_dvrk_client_finds_all_that_it_connects_to(self):
        """As dvrk_python's arm and psm: topics, services, queues of crtk_python_client's utils; check_connections."""
        name = ARMS[0]
        said = {"state_command": StringStamped, "hold": Empty, "free": Empty, "servo_jp": JointState, "servo_jr": JointState,
                "servo_cp": PoseStamped, "servo_jf": JointState, "servo_jv": JointState, "servo_cf": WrenchStamped,
                "servo_cv": TwistStamped, "move_jp": JointState,
                "move_jr": JointState, "move_cp": PoseStamped, "spatial/servo_cf": WrenchStamped,
                "body/servo_cf": WrenchStamped, "body/set_cf_orientation_absolute": Bool, "use_gravity_compensation": Bool,
                "trajectory_j/set_ratio": Float64, "jaw/servo_jp": JointState, "jaw/move_jp": JointState,
                "jaw/servo_jf": JointState, "emulate_tool_present": Bool}
        heard = {"operating_state": OperatingState, "setpoint_js": JointState, "setpoint_cp": PoseStamped,
                 "measured_js": JointState, "measured_cp": PoseStamped, "measured_cv": TwistStamped,
                 "spatial/measured_cf": WrenchStamped, "spatial/jacobian": Float64MultiArray,
                 "body/measured_cf": WrenchStamped, "body/jacobian": Float64MultiArray, "local/measured_cp": PoseStamped,
                 "local/setpoint_cp": PoseStamped, "trajectory_j/ratio": Float64, "jaw/measured_js": JointState,
                 "jaw/setpoint_js": JointState}
        newest = {}
        settings = {"body/set_cf_orientation_absolute", "use_gravity_compensation", "trajectory_j/set_ratio", "emulate_tool_present"}
        publishers = {topic: rospy.Publisher(f"{name}/{topic}", kind, queue_size=1 if topic in settings else 10,
                                             latch=topic == "state_command" or topic in settings)
                      for topic, kind in said.items()}
        subscribers = [rospy.Subscriber(f"{name}/{topic}", kind, lambda m, topic=topic: newest.__setitem__(topic, m),
                                        queue_size=10) for topic, kind in heard.items()]
        until(lambda: all(p.get_num_connections() > 0 for p in [*publishers.values(), *subscribers]), 5,
              f"not connected: {[t for t, p in publishers.items() if not p.get_num_connections()]}")
        until(lambda: set(newest) == set(heard), 5, "a message on each topic")
        arm = self.arms[0]
        arm.command("enable")
        arm.await_state("ENABLED")
        time.sleep(1.0)

        forward = rospy.ServiceProxy(f"{name}/forward_kinematics", QueryForwardKinematics)
        inverse = rospy.ServiceProxy(f"{name}/inverse_kinematics", QueryInverseKinematics)
        joints = arm.position("measured_js")
        found = forward(jp=joints)
        self.assertTrue(found.result, found.message)
        measured = arm.pose("measured_cp")
        self.assertLess(math.dist(vector(found.cp.position), vector(measured.pose.position)), 2e-4)
        back = inverse(cp=found.cp, jp=joints)
        self.assertTrue(back.result, back.message)
        self.assertLess(max(abs(a - b) for a, b in zip(back.jp, joints)), 1e-5)
        self.assertFalse(inverse(cp=PoseStamped().pose, jp=joints).result)
        local = rospy.ServiceProxy(f"{name}/local/forward_kinematics", QueryForwardKinematics)(jp=joints)
        self.assertLess(math.dist(vector(local.cp.position), vector(arm.pose("local/measured_cp").pose.position)), 2e-4)
        back = rospy.ServiceProxy(f"{name}/local/inverse_kinematics", QueryInverseKinematics)(cp=local.cp, jp=joints)
        self.assertTrue(back.result, back.message)
        self.assertLess(max(abs(a - b) for a, b in zip(back.jp, joints)), 1e-5)

        publishers["trajectory_j/set_ratio"].publish(Float64(data=0.5))
        until(lambda: newest["trajectory_j/ratio"].data == 0.5, 5, "the new ratio published")
        publishers["trajectory_j/set_ratio"].publish(Float64(data=1.0))
        until(lambda: newest["trajectory_j/ratio"].data == 1.0, 5, "the old ratio published")
        start = arm.position()
        arm.finish(lambda: publishers["move_jr"].publish(JointState(position=[0.05, 0.0, 0.0, 0.0, 0.0, 0.0])), 5)
        self.assertAlmostEqual(arm.position()[0] - start[0], 0.05, delta=1e-3)
        for topic, message, words in (("servo_jf", JointState(effort=[0.0] * 6), "positions"),
                                      ("body/servo_cf", WrenchStamped(), "positions"),
                                      ("jaw/servo_jf", JointState(effort=[0.0]), "positions"),
                                      ("emulate_tool_present", Bool(data=True), "tool")):
            count = arm.count("warning")
            publishers[topic].publish(message)
            self.assertIn(words, arm["warning"].since(count, topic.split("/")[-1]), topic)
        self.assertEqual(arm.state.state, "ENABLED")
        for publisher in publishers.values():
            publisher.unregister()
        for subscriber in subscribers:
            subscriber.unregister()

    def test_15b_one_twist_goes_on_as_the_reference_example_wants_it(self):
        """crtk_servo_cv_example.py: one twist of 1 mm/s along x, 10 s of sleep (here 3), one twist of zero."""
        arm = self.arms[0]
        timeout = rospy.wait_for_message(f"{arm.name}/twist_timeout", Float64, 5).data
        self.assertGreater(timeout, 10.5, "longer than the example sleeps")
        client = rospy.Publisher(f"{arm.name}/servo_cv", TwistStamped, queue_size=10)
        until(lambda: client.get_num_connections() > 0, 5, "the daemon")
        poses = Topic(f"{arm.name}/setpoint_cp", PoseStamped)
        until(lambda: poses.newest, 5, "setpoint_cp")
        start, count = poses.newest, arm.count("warning")

        def rests():
            now = poses.newest
            old = next((m for m in reversed(list(poses.messages)) if (now.header.stamp - m.header.stamp).to_sec() >= 0.2), None)
            return old is not None and distance(old, now) < SAME

        twist = TwistStamped()
        twist.header.stamp = rospy.Time.now()
        twist.twist.linear.x = 1e-3
        begun = time.monotonic()
        client.publish(twist)
        rospy.sleep(3.0)
        took = time.monotonic() - begun  # a busy machine may wake this process late
        client.publish(TwistStamped())
        until(rests, 5, "a twist of zero ends it")
        poses.close()
        way = poses.newest.pose.position.x - start.pose.position.x
        print(f"one twist of 1 mm/s for {took:.3f} s: {1e3 * way:.2f} mm")
        client.unregister()  # before any assertion: the next test needs to be the only client
        said = [m.string for m in arm["warning"].messages[count:]]
        self.assertAlmostEqual(way, 1e-3 * took, delta=1.5e-4, msg=f"warnings: {said}")
        self.assertEqual(said, [])

    @staticmethod
    def send_once(*topics):
        """Sends one message on each topic, by a separate client, and kills the clients after half a second."""
        clients = [subprocess.Popen([sys.executable, "-c", ONE_MESSAGE, topic], stdout=subprocess.PIPE, text=True) for topic in topics]
        for client in clients:
            client.stdout.readline()
        time.sleep(0.5)
        for client in clients:
            with client:
                client.kill()

    def test_15c_a_twist_and_joint_rates_end_with_their_client(self):
        """This process goes on as another publisher of servo_cv."""
        arm, other = self.arms
        start, joints = arm.pose(), other.position()
        self.send_once(f"{arm.name}/servo_cv", f"{other.name}/servo_jv")
        time.sleep(1.0)
        before, joints_before = arm.pose(), other.position()
        self.assertGreater(distance(start, before), 0.5e-3, "it has moved")
        self.assertGreater(joints_before[0] - joints[0], 3e-3, "it has moved")
        time.sleep(0.5)
        self.assertLess(distance(before, arm.pose()), SAME, "the arm stops long before the twist's time-out")
        self.assertLess(math.dist(joints_before, other.position()), 1e-4)

    def test_15d_what_is_local_is_along_the_axes_of_the_arms_base(self):
        for arm in self.arms:
            kinds = {"local/servo_cv": TwistStamped, "local/move_cp": PoseStamped}
            said = {name: rospy.Publisher(f"{arm.name}/{name}", kind, queue_size=10) for name, kind in kinds.items()}
            poses = Topic(f"{arm.name}/local/setpoint_cp", PoseStamped)
            until(lambda: poses.newest and all(p.get_num_connections() > 0 for p in said.values()), 5, "the daemon")
            start, twist = poses.newest, TwistStamped()
            twist.twist.linear.x = 4e-3
            begun = time.monotonic()
            said["local/servo_cv"].publish(twist)
            time.sleep(0.5)
            took = time.monotonic() - begun
            said["local/servo_cv"].publish(TwistStamped())
            time.sleep(0.5)
            x, y, z = (b - a for a, b in zip(vector(start.pose.position), vector(poses.newest.pose.position)))
            self.assertAlmostEqual(x, 4e-3 * took, delta=0.5e-3, msg=arm.name)
            self.assertLess(math.hypot(y, z), 1e-4, arm.name)
            goal = moved(poses.newest, (0.0, 0.0, 5e-3))
            goal.header.frame_id = ""
            arm.finish(lambda: said["local/move_cp"].publish(goal), 5)
            self.assertLess(distance(arm.pose("local/setpoint_cp"), goal), 5e-5, arm.name)
            poses.close()
            for publisher in said.values():
                publisher.unregister()
        self.arms[0].command("disable")
        self.arms[0].await_state("DISABLED")

    def test_16_the_client_of_the_documentation_draws_its_circle(self):
        text = (HERE.parents[1] / "doc/crtk.md").read_text()
        (program,) = re.findall(r"(?s)```python\n(.*?)```", text)
        topics = {name: Topic(f"{ARMS[0]}/{name}", PoseStamped) for name in ("setpoint_cp", "measured_cp")}
        count = self.arms[0].count("operating_state")
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "crtk_msgs").mkdir()
            (pathlib.Path(folder) / "crtk_msgs/msg.py").symlink_to(MESSAGES)
            paths = [folder, os.environ.get("PYTHONPATH", "")]
            run = subprocess.run([sys.executable, "-"], input=program, text=True, timeout=60, capture_output=True,
                                 env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)})
        for topic in topics.values():
            topic.close()
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.assertNotIn("WARN", run.stdout + run.stderr, "nothing was refused")
        for arm in self.arms:
            arm.await_state("DISABLED")
        states = [m for m in self.arms[0]["operating_state"].messages[count:] if m.state == "ENABLED"]
        begin, end = states[0].header.stamp + rospy.Duration(0.2), states[-1].header.stamp  # the brakes are off by then
        for name, near in (("setpoint_cp", 2e-4), ("measured_cp", 1.5e-3)):
            way = [vector(m.pose.position) for m in topics[name].messages if begin <= m.header.stamp <= end]
            x, y, z = (max(p[i] for p in way) - min(p[i] for p in way) for i in range(3))
            print(f"the circle of 20 mm by {name}: {1e3 * x:.2f} mm in x, {1e3 * y:.2f} in y, {1e3 * z:.2f} in z")
            for width, wanted in ((x, 0.02), (y, 0.0), (z, 0.02)):
                self.assertAlmostEqual(width, wanted, delta=near, msg=name)

    def test_17_without_its_robot_it_pauses_and_says_that_the_model_goes_on_alone(self):
        arm = self.arms[0]
        arm.command("enable")
        arm.await_state("ENABLED")
        time.sleep(1.0)
        node = xmlrpc.client.ServerProxy(rosgraph.Master("/crtk_test").lookupNode("/virtual_raven"))
        self.assertTrue(rospy.wait_for_message(f"{arm.name}/is_valid", Bool, 5).data)
        measured = Topic(f"{arm.name}/measured_cp", PoseStamped)
        until(lambda: measured.newest, 5, "measured_cp")
        os.kill(node.getPid("/crtk_test")[2], signal.SIGKILL)
        killed = time.time()
        arm.await_state("PAUSED")
        count = arm.count("warning")
        arm.command("resume")
        arm.await_state("ENABLED")
        self.assertIn("model", arm["warning"].since(count, "alone"))
        start = arm.pose()
        self.stream_poses([moved(a.pose(), (0.0, 0.0, 0.004)) for a in self.arms], seconds=0.5)
        time.sleep(0.5)
        model = rospy.wait_for_message(f"model/{arm.name}/measured_cp", PoseStamped, 5)
        self.assertAlmostEqual(model.pose.position.z - start.pose.position.z, 0.004, delta=2e-4)
        measured.close()
        last = measured.newest
        self.assertLess(math.dist(vector(last.pose.position), vector(start.pose.position)), 2e-3, "the robot's pose")
        self.assertLess(last.header.stamp.to_sec(), killed + 0.1, "the stamp of the last state")
        with self.assertRaises(rospy.ROSException):
            rospy.wait_for_message(f"{arm.name}/measured_cp", PoseStamped, 0.5)
        self.assertFalse(rospy.wait_for_message(f"{arm.name}/is_valid", Bool, 5).data)
        self.assertTrue(any("no state of the robot" in m.string for m in arm["warning"].messages))

    def test_18_forces_move_the_model_alone_along_the_axes_that_were_asked_for(self):
        """crtk_haptic_example.py --body sets the orientation absolute; without, body/servo_cf is along the tip's axes."""
        arm = self.arms[0]
        kinds = {"servo_cf": WrenchStamped, "body/servo_cf": WrenchStamped, "body/set_cf_orientation_absolute": Bool,
                 "move_jp": JointState}
        publishers = {t: rospy.Publisher(f"{arm.name}/{t}", kind, queue_size=10) for t, kind in kinds.items()}
        until(lambda: all(p.get_num_connections() > 0 for p in publishers.values()), 5, "the daemon")

        poses = Topic(f"model/{arm.name}/measured_cp", PoseStamped)
        until(lambda: poses.newest is not None, 5, "a pose of the model")

        def rest():
            """Waits until the tip has not moved for 0.2 s."""
            count = len(poses.messages)

            def stands():
                new, newest = poses.messages[count:], poses.newest
                ago = [(newest.header.stamp - m.header.stamp).to_sec() for m in new]
                return any(a > 0.2 for a in ago) and all(distance(newest, m) < 1e-4 for m, a in zip(new, ago) if a <= 0.2)

            until(stands, 5, "the tip does not move")

        def push(topic, force):
            """The tip's first 5 mm, always from the same pose: a force at the tip turns the wrist, too."""
            arm.finish(lambda: publishers["move_jp"].publish(JointState(position=begin)), 5)
            wrench = WrenchStamped()
            wrench.wrench.force.x, wrench.wrench.force.y, wrench.wrench.force.z = force
            start = poses.newest
            count = len(poses.messages)

            def far():
                publishers[topic].publish(wrench)
                return next((m for m in poses.messages[count:] if distance(start, m) > 5e-3), None)

            end = until(far, 2, "5 mm of way")
            # ROS keeps the order of messages within a topic only. So the last force, which may come after the hold, is 0, and
            # rest() waits for a late hold, which would end the next move.
            publishers[topic].publish(WrenchStamped())
            arm.say("hold", Empty())
            rest()
            way = tuple(b - a for a, b in zip(vector(start.pose.position), vector(end.pose.position)))
            print(f"{topic}, {tuple(round(f, 1) for f in force)} N: {tuple(round(1e3 * w, 2) for w in way)} mm")
            return way

        up, down = (0.0, 0.0, 15.0), (0.0, 0.0, -15.0)
        begin = arm.position("setpoint_js")
        own_down = rotate(poses.newest.pose.orientation, down)
        world = push("servo_cf", up)
        publishers["body/set_cf_orientation_absolute"].publish(Bool(data=True))
        absolute = push("body/servo_cf", up)
        publishers["body/set_cf_orientation_absolute"].publish(Bool(data=False))
        body, same = push("body/servo_cf", down), push("servo_cf", own_down)
        self.assertGreater(along(world, up), 1e-3)
        self.assertGreater(along(body, own_down), 1e-3)
        self.assertLess(angle(world, absolute), math.radians(15))
        self.assertLess(angle(body, same), math.radians(15))
        self.assertGreater(angle(world, body), math.radians(30))
        poses.close()
        for publisher in publishers.values():
            publisher.unregister()

    def test_19_what_the_models_tip_presses_on_is_a_force_at_the_tip(self):
        arm = self.arms[0]
        topics = {t: Topic(f"model/{arm.name}/{t}", WrenchStamped) for t in ("measured_cf", "body/measured_cf", "spatial/measured_cf")}
        poses = Topic(f"model/{arm.name}/measured_cp", PoseStamped)
        other = Topic(f"model/{self.arms[1].name}/measured_cf", WrenchStamped)
        arm.finish(lambda: arm.joints("move_jp", HOME), 10)  # above the dome
        down = TwistStamped()
        down.twist.linear.z = -0.03

        def presses():
            arm.say("servo_cv", down)
            return topics["measured_cf"].newest is not None and topics["measured_cf"].newest.wrench.force.z > 2.0

        until(presses, 10, "the dome touched")
        arm.say("hold", Empty())
        time.sleep(0.2)
        at = {name: {m.header.stamp: m for m in topic.messages} for name, topic in {**topics, "pose": poses}.items()}
        same = [stamp for stamp in at["measured_cf"] if all(stamp in found for found in at.values())]
        pressed = [stamp for stamp in same if at["measured_cf"][stamp].wrench.force.z > 1.0]
        self.assertGreater(len(pressed), 10)
        for stamp in pressed:
            force, torque = (vector(v) for v in (at["measured_cf"][stamp].wrench.force, at["measured_cf"][stamp].wrench.torque))
            pose, along_tip = at["pose"][stamp].pose, at["body/measured_cf"][stamp].wrench
            self.assertLess(math.dist(rotate(pose.orientation, vector(along_tip.force)), force), 1e-6)
            self.assertLess(math.dist(rotate(pose.orientation, vector(along_tip.torque)), torque), 1e-6)
            p = vector(pose.position)
            lever = tuple(p[(i + 1) % 3] * force[(i + 2) % 3] - p[(i + 2) % 3] * force[(i + 1) % 3] for i in range(3))
            about_origin = at["spatial/measured_cf"][stamp].wrench
            self.assertLess(math.dist(vector(about_origin.force), force), 1e-6)
            self.assertLess(math.dist(vector(about_origin.torque), tuple(a + b for a, b in zip(torque, lever))), 1e-6)
        self.assertEqual({vector(m.wrench.force) for m in other.messages}, {(0.0, 0.0, 0.0)})
        for topic in (*topics.values(), poses, other):
            topic.close()
        self.check_force_is_told_alone(self.arms[1], down)

    def check_force_is_told_alone(self, arm, down):
        """While nobody listens to the other arm's."""
        force = Topic(f"model/{arm.name}/measured_cf", WrenchStamped)
        arm.finish(lambda: arm.joints("move_jp", HOME), 10)

        def presses():
            arm.say("servo_cv", down)
            return force.newest is not None and force.newest.wrench.force.z > 2.0

        until(presses, 10, "the dome touched")
        arm.say("hold", Empty())
        force.close()


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "crtk", Crtk)
