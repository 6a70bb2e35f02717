#!/usr/bin/python3
"""Replays a recorded session into ROS with /clock: a node receives the values of the log, bit for bit."""
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np
import rosgraph
import rospy
import rostest
from geometry_msgs.msg import WrenchStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from raven2_trainer.msg import ExerciseEventStamped, TrainerMode

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))
import raven2_session  # noqa: E402

PROGRAMS = os.path.join(os.environ["RAVEN2_TRAINER_BUILD"], "devel", "lib", "raven2_trainer")
PERIOD = 10  # ticks, config/runtime.yaml: ros_period
SECONDS = 6


def urdf_rates(rates):
    """raven2.md 5.4: the green arm's wrist and both arms' second jaw have the opposite sign in the URDF."""
    gold, green = rates.copy()
    green[4], gold[6], green[6] = -green[4], -gold[6], -green[6]
    return np.concatenate([gold, green])


def urdf_positions(q, d4):
    """As urdf_rates(). In addition, the insertion counts from the remote centre, and the roll from 45 degrees off."""
    out = urdf_rates(q)
    out[[2, 9]] += d4
    out[3] += -np.pi / 4
    out[10] += np.pi / 4
    return out


class Heard:
    """All messages of one topic."""

    def __init__(self, topic, kind):
        self.messages, self._arrivals = [], []
        self.arrivals = []  # [s] of the messages that take() returned last
        self._lock = threading.Lock()
        self._subscriber = rospy.Subscriber(topic, kind, self._hear, queue_size=None, tcp_nodelay=True)

    def is_over(self):
        """Whether no publisher is connected: the last message was read before its connection ended."""
        return self._subscriber.get_num_connections() == 0

    def _hear(self, message):
        with self._lock:
            self.messages.append(message)
            self._arrivals.append(time.monotonic())

    def take(self):
        with self._lock:
            taken, self.messages = self.messages, []
            self.arrivals, self._arrivals = self._arrivals, []
            return taken


class ReplaySession(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("replay_session_test", disable_signals=True)
        cls.folder = tempfile.TemporaryDirectory()
        cls.session = os.path.join(cls.folder.name, "session")
        subprocess.run([os.path.join(PROGRAMS, "simulate"), "--exercise", "camera_clutch", "--motion", "expert",
                        "--homing", "quick", "--seed", "1", "--seconds", str(SECONDS), "--output", cls.session],
                       check=True, stderr=subprocess.DEVNULL)
        cls.log = raven2_session.Session(cls.session).log
        cls.heard = {topic: Heard(topic, kind) for topic, kind in [
            ("/clock", Clock), ("model/joint_states", JointState), ("robot/joint_states", JointState),
            ("haptic/gold/force", WrenchStamped), ("/tf", TFMessage), ("/tf_static", TFMessage),
            ("mode", TrainerMode),
            ("exercise/events", ExerciseEventStamped)]}

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def setUp(self):
        rospy.set_param("/use_sim_time", True)

    def take_all(self):
        """Of a player that has ended."""
        end = time.monotonic() + 30
        while not all(heard.is_over() for heard in self.heard.values()):
            self.assertLess(time.monotonic(), end, "the connections of a player that has ended")
            time.sleep(0.05)
        return {topic: heard.take() for topic, heard in self.heard.items()}

    def play(self, *options, seconds=120):
        for heard in self.heard.values():
            heard.take()
        done = subprocess.run([os.path.join(PROGRAMS, "replay_session"), self.session, "--delay", "2", *options],
                              timeout=seconds, stderr=subprocess.PIPE, text=True, check=False)
        return done, self.take_all()

    def refused(self):
        """Runs a player that refuses to play. @return its messages, and all topics that it published until its end."""
        for heard in self.heard.values():
            heard.take()
        program = subprocess.Popen([os.path.join(PROGRAMS, "replay_session"), self.session], stderr=subprocess.PIPE, text=True)
        master, topics = rosgraph.Master("/replay_session_test"), set()
        while program.poll() is None:
            topics |= {topic for topic, nodes in master.getSystemState()[0] if "/replay_session" in nodes}
        self.assertEqual(program.returncode, 1)
        time.sleep(0.5)
        self.assertEqual([topic for topic, heard in self.heard.items() if heard.take()], [])
        return program.stderr.read(), topics

    def due(self, first=0):
        """Indices of the log's ticks from which a message of each state is published."""
        ticks = self.log.ticks["model"]
        at = [i for i in range(first, len(ticks)) if ticks["time_ns"][i] > 0]
        return at[::PERIOD]  # lockstep misses none

    def check_states(self, heard, due):
        ticks, d4 = self.log.ticks, self.log.header["d4"]
        joints = heard["model/joint_states"]
        self.assertEqual(len(joints), len(due))
        for message, i in zip(joints, due):
            model = ticks["model"][i]
            self.assertEqual(message.header.stamp.to_nsec(), int(model["time_ns"]))
            for got, wanted in [(message.position, urdf_positions(model["arms"]["q"], d4)),
                                (message.velocity, urdf_rates(model["arms"]["dq"])),
                                (message.effort, urdf_rates(model["arms"]["tau"]))]:
                self.assertEqual(np.array(got).tobytes(), wanted.tobytes())
        robots = {m.header.stamp.to_nsec(): m for m in heard["robot/joint_states"]}
        connected = [i for i in due if ticks["robot"]["connected"][i] and ticks["robot"]["frame"][i]]
        self.assertEqual(len(robots), len(connected))
        for i in connected:
            got = robots[int(ticks["model"]["time_ns"][i])].position
            self.assertEqual(np.array(got).tobytes(), urdf_positions(ticks["robot"]["arms"]["q"][i], d4).tobytes())

    def check_forces(self, heard, due):
        haptic = self.log.haptic["haptic"]
        forces = heard["haptic/gold/force"]
        self.assertEqual(len(forces), len(due))
        for message, i in zip(forces, due):
            at = np.searchsorted(haptic["tick"], self.log.ticks["model"]["tick"][i], side="right") - 1
            wanted = haptic["force_B"][at][0] if at >= 0 else np.zeros(3)
            force = message.wrench.force
            self.assertEqual(np.array([force.x, force.y, force.z]).tobytes(), wanted.tobytes())

    def test_what_is_heard_is_what_the_log_says(self):
        done, heard = self.play("--rate", "5")
        self.assertEqual(done.returncode, 0, done.stderr)
        due = self.due()
        self.assertGreater(len(due), SECONDS * 1000 // PERIOD)
        clock = [m.clock.to_nsec() for m in heard["/clock"]]  # rospy subscribes as well and keeps the newest only
        self.assertGreater(len(clock), 10)
        self.assertTrue(all(a < b for a, b in zip(clock, clock[1:])), "/clock runs forward")
        self.assertTrue(set(clock) <= {int(self.log.ticks["model"]["time_ns"][i]) for i in due})
        self.check_states(heard, due)
        self.check_forces(heard, due)
        self.assertEqual([(m.number, m.tick) for m in heard["exercise/events"]],
                         [(n + 1, int(tick)) for n, tick in enumerate(self.log.exercise_events["tick"])
                          if tick <= self.log.ticks["model"]["tick"][due[-1]]])
        self.assertGreater(len(heard["exercise/events"]), 0)
        modes = self.log.names("tick", "model.mode")
        self.assertTrue({m.mode for m in heard["mode"]} <= {modes[m] for m in self.log.ticks["model"]["mode"]})
        self.assertIn("teleoperating", {m.mode for m in heard["mode"]})
        frames = {t.child_frame_id for m in heard["/tf"] for t in m.transforms}
        self.assertTrue({"model/link1_L", "robot/grasper1_R", "endoscope_optical_frame"} <= frames, frames)
        fixed = {t.child_frame_id for m in heard["/tf_static"] for t in m.transforms}
        self.assertTrue({"model/base_link_L", "robot/base_link_R"} <= fixed, fixed)
        self.assertFalse(frames & fixed, "a frame is on both topics")

    def test_it_takes_as_long_as_its_rate_says(self):
        """A busy machine makes messages late, but never early. So the earliest of the first and last third count."""
        for rate in (2.0, 10.0):
            done, heard = self.play("--rate", str(rate), "--from", "1")
            self.assertEqual(done.returncode, 0, done.stderr)
            stamps = np.array([m.header.stamp.to_sec() for m in heard["robot/joint_states"]])
            late = np.array(self.heard["robot/joint_states"].arrivals) - (stamps - stamps[0]) / rate
            third = len(late) // 3
            self.assertAlmostEqual(late[:third].min(), late[-third:].min(), delta=0.15)

    def test_from_a_session_time_on(self):
        done, heard = self.play("--rate", "10", "--from", "3.5")
        self.assertEqual(done.returncode, 0, done.stderr)
        due = self.due(int(np.argmax(self.log.ticks["model"]["session_tick"] == 3500)))
        self.check_states(heard, due)
        self.check_forces(heard, due)
        begin = self.log.ticks["model"]["tick"][due[0]]
        self.assertTrue(all(m.tick >= begin for m in heard["exercise/events"]))

    def test_without_simulated_time_nothing_is_played(self):
        for value in (False, None):
            rospy.delete_param("/use_sim_time")
            if value is not None:
                rospy.set_param("/use_sim_time", value)
            said, topics = self.refused()
            self.assertIn("use_sim_time", said)
            self.assertLessEqual(topics, {"/rosout"}, "a subscriber would receive latched messages of these topics")
        done, heard = self.play("--set-sim-time", "--rate", "20")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(rospy.get_param("/use_sim_time"))
        self.assertEqual(len(heard["model/joint_states"]), len(self.due()))

    def test_a_loop_begins_again_and_ends_with_a_signal(self):
        for heard in self.heard.values():
            heard.take()
        first = self.due(int(np.argmax(self.log.ticks["model"]["session_tick"] == 4000)))[0]
        begin = int(self.log.ticks["model"]["time_ns"][first])
        heard, end = self.heard["model/joint_states"], time.monotonic() + 60
        program = subprocess.Popen([os.path.join(PROGRAMS, "replay_session"), self.session, "--delay", "2", "--rate",
                                    "20", "--from", "4", "--loop"], stderr=subprocess.DEVNULL)
        while sum(m.header.stamp.to_nsec() == begin for m in list(heard.messages)) < 3:
            self.assertLess(time.monotonic(), end, "three loops")
            time.sleep(0.05)
        program.send_signal(signal.SIGINT)
        self.assertEqual(program.wait(timeout=5), 0)
        stamps = [m.header.stamp.to_nsec() for m in self.take_all()["model/joint_states"]]
        self.assertGreater(stamps.count(begin), 2)
        self.assertEqual([b for a, b in zip(stamps, stamps[1:]) if b < a], [begin] * (stamps.count(begin) - 1))


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "replay_session", ReplaySession)
