#!/usr/bin/python3
"""Modes, pedals as sensor_msgs/Joy, the real camera and the exercise's topics, over real sockets. The test is the
console, the pedals and the camera."""
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import xmlrpc.client

import rosbag
import rospy
import rostest
from pedal_stops import PEDAL_DN, PEDAL_UP, newest_session
from planning_clients import Console, Newest, until
from robot_frames import connect
from sensor_msgs.msg import CompressedImage, Image, Joy
from std_srvs.srv import SetBool
from training_clients import Trainer

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))
import raven2_session  # noqa: E402

MASTER_PORT, STATE_PORT = 27190, 27193
PEDALS = ("planning", "simulation", "trial", "view", "camera", "tool_change", "stop")  # numbers of config/network.yaml
SILENCE = 0.5  # s, config/network.yaml: joy/timeout, and config/render.yaml: real_camera/stale_after
REAL, VIRTUAL = (64, 48), (160, 90)  # px: of this test's camera, and of the renderer as run_rostest sets it


class Repeater(threading.Thread):
    """Publishes 20 times a second, as a driver does, while it is on. `make` returns the message."""

    def __init__(self, topic, kind, make):
        super().__init__(daemon=True)
        self.on, self.make, self.sent_at, self.sent, self.stamp = True, make, 0.0, 0, None
        self._publisher = rospy.Publisher(topic, kind, queue_size=10)

    def run(self):
        while True:
            if self.on:
                self.sent_at, self.stamp = time.monotonic(), rospy.Time.now()
                self._publisher.publish(self.make())
                self.sent += 1
            time.sleep(0.05)


class View:
    """Sizes of the pictures of view/image_raw, with the time of their receipt, and the compressed ones' frames."""

    def __init__(self):
        self.seen, self.frames = [], []
        self._subscribers = [
            rospy.Subscriber("view/image_raw", Image, self._hear, queue_size=2),
            rospy.Subscriber("view/image_raw/compressed", CompressedImage, lambda m: self.frames.append(m.header.frame_id))]

    def _hear(self, picture):
        self.seen.append((time.monotonic(), (picture.width, picture.height)))

    def frames_within(self, seconds):
        first, end = len(self.frames), time.monotonic() + seconds
        until(lambda: time.monotonic() > end and len(self.frames) >= first + 5, 20, "five compressed pictures")
        return set(self.frames[first:])

    def await_size(self, size, seconds=5):
        """@return when the next picture of this size came."""
        first = len(self.seen)
        return until(lambda: next((at for at, seen in self.seen[first:] if seen == size), None), seconds,
                     f"pictures of {size[0]} x {size[1]}")

    def sizes_within(self, seconds):
        """Sizes of the pictures of so many seconds, of at least five pictures."""
        first, end = len(self.seen), time.monotonic() + seconds
        until(lambda: time.monotonic() > end and len(self.seen) >= first + 5, 20, "five pictures")
        return {size for _, size in self.seen[first:]}

    def close(self):
        for subscriber in self._subscribers:
            subscriber.unregister()


def real_picture():
    picture = Image(width=REAL[0], height=REAL[1], encoding="rgb8", step=3 * REAL[0], data=bytes(3 * REAL[0] * REAL[1]))
    picture.header.stamp = rospy.Time.now()
    return picture


class TrainingModes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("training_modes_test", disable_signals=True)
        cls.console = Console(MASTER_PORT)
        cls.console.start()
        cls.robot = connect(STATE_PORT)
        cls.trainer = Trainer()
        cls.held = set()
        cls.pedals = Repeater("pedals", Joy, lambda: Joy(buttons=[int(name in cls.held) for name in PEDALS]))
        cls.camera = Repeater("real_camera/image_raw", Image, real_picture)
        assert cls.robot.wait(lambda s: s.runlevel == PEDAL_UP and s.homed, 60), "never homed"
        cls.pedals.start()
        cls.camera.start()
        until(lambda: cls.trainer.mode == "pedal_up", 10, "the daemon is ready")
        time.sleep(1.0)  # publishers and subscribers find each other

    def setUp(self):
        self.held.clear()
        self.pedals.on, self.camera.on = True, True
        self.console.pedal, self.console.step_um = 0, (0, 0, 0)
        self.trainer.await_mode("pedal_up")

    def stays(self, mode, seconds):
        """Waits for the mode. @return whether it is still the same after so many seconds."""
        self.trainer.await_mode(mode)
        end = time.monotonic() + seconds
        while self.trainer.mode == mode and time.monotonic() < end:
            time.sleep(0.01)
        return self.trainer.mode == mode

    def tap(self, name):
        for change in (self.held.add, self.held.discard):
            change(name)
            sent = self.pedals.sent
            until(lambda: self.pedals.sent >= sent + 3, 5, "three messages, the first of which may have been made before")

    def test_1_services_change_the_mode_or_say_why_not(self):
        call = self.trainer.call
        self.assertEqual(call("end_simulation"), "not_now")
        self.assertEqual(call("begin_simulation"), "accepted")
        self.trainer.await_mode("simulation_held")
        first = len(self.robot.states)
        self.console.pedal, self.console.step_um = 1, (10, 10, 0)
        self.trainer.await_mode("simulating")
        self.assertEqual(call("end_simulation"), "not_now", "the pedal is down")
        self.assertEqual(call("set_camera_pedal", True), "accepted")
        self.trainer.await_mode("camera_moving")
        self.assertEqual(call("set_camera_pedal", False), "accepted")
        self.trainer.await_mode("simulating")
        self.console.release()
        self.trainer.await_mode("simulation_held")
        self.assertEqual(call("end_simulation"), "accepted")
        self.trainer.await_mode("pedal_up")
        self.assertIn("returning", [m.mode for m in self.trainer.modes.messages])
        self.assertEqual({s.runlevel for s in self.robot.states[first:]}, {PEDAL_UP}, "the robot was engaged")
        self.assertEqual(call("gold/tool_change"), "accepted")
        for is_on in (False, True):
            self.assertTrue(rospy.ServiceProxy("green/set_collisions", SetBool)(is_on).success)
        self.assertEqual(call("begin_trial"), "accepted")
        self.assertEqual(call("discard_trial"), "accepted")
        self.trainer.await_mode("pedal_up")

    def test_2_an_emergency_stop_holds_until_it_is_cleared(self):
        self.assertEqual(self.trainer.call("clear_stop"), "not_now")
        self.console.pedal = 1
        self.assertIsNotNone(self.robot.wait(lambda s: s.runlevel == PEDAL_DN), "the robot did not engage")
        asked = time.monotonic_ns()
        self.assertEqual(self.trainer.call("emergency_stop"), "accepted")
        up = self.robot.wait(lambda s: s.time_ns > asked and s.runlevel == PEDAL_UP, 5)
        print(f"PEDAL_UP {1e-6 * (up.time_ns - asked):.1f} ms after emergency_stop was called")
        self.trainer.await_mode("stopped")
        self.assertEqual(self.trainer.call("begin_simulation"), "not_now")
        self.assertEqual(self.trainer.call("clear_stop"), "not_now", "the pedal is down")
        self.console.release()
        time.sleep(0.1)
        self.assertEqual(self.trainer.call("clear_stop"), "accepted")
        self.trainer.await_mode("pedal_up")

    def test_3_pedals_that_come_as_joy_do_what_those_of_the_packet_do(self):
        self.tap("simulation")
        self.trainer.await_mode("simulation_held")
        self.tap("simulation")
        self.trainer.await_mode("pedal_up")
        self.tap("trial")
        self.trainer.await_mode("trial_held")
        self.tap("trial")
        self.trainer.await_mode("trial_ready")
        self.assertEqual(self.trainer.call("discard_trial"), "accepted")
        self.trainer.await_mode("pedal_up")
        self.tap("planning")
        self.trainer.await_mode("choosing")
        self.tap("stop")
        self.trainer.await_mode("stopped")
        self.tap("stop")
        self.assertEqual(self.trainer.mode, "stopped", "no pedal clears it")
        self.assertEqual(self.trainer.call("clear_stop"), "accepted")
        self.trainer.await_mode("pedal_up")
        self.tap("tool_change")
        self.tap("view")
        until(lambda: self.trainer.modes.message.view == "real", 5, "the real view is published")
        self.tap("view")
        until(lambda: self.trainer.modes.message.view == "virtual", 5, "the virtual view is published")

    def test_4_pedals_that_fall_silent_are_released(self):
        self.held.add("camera")
        # A busy machine may delay our own messages for so long, so there are five attempts.
        self.assertTrue(any(self.stays("camera_moving", 1.0) for _ in range(5)), "held for longer than the silence that releases it")
        first = len(self.trainer.modes.messages)
        self.pedals.on = False
        up = until(lambda: next((m for m in self.trainer.modes.messages[first:] if m.mode == "pedal_up"), None), 5, "pedal_up")
        silent = (up.header.stamp - self.pedals.stamp).to_sec()  # the daemon's: this process may hear of it late
        print(f"released {silent:.3f} s after the last message")
        self.assertGreater(silent, SILENCE - 0.01)
        self.assertLess(silent, SILENCE + 0.5)
        self.pedals.on = True  # and the camera pedal is still held
        self.trainer.await_mode("camera_moving")
        self.held.clear()
        self.trainer.await_mode("pedal_up")

    def test_5_the_view_is_the_cameras_while_it_is_asked_for_and_fresh(self):
        self.view = View()  # pictures are drawn while somebody subscribes to them
        self.addCleanup(self.view.close)
        self.view.await_size(VIRTUAL, 20)
        self.assertEqual(self.view.sizes_within(0.5), {VIRTUAL})
        self.assertEqual(self.trainer.call("set_view", True), "accepted")
        self.view.await_size(REAL)
        self.assertEqual(self.view.sizes_within(0.5), {REAL})
        self.assertEqual(self.view.frames_within(0.5), {""}, "those of the test's camera")
        # WHEN the camera is silent
        self.camera.on = False
        stood_in = self.view.await_size(VIRTUAL)
        silent = stood_in - self.camera.sent_at
        print(f"the virtual scene replaces it {silent:.3f} s after the last picture")
        self.assertGreater(silent, SILENCE - 0.01)
        self.assertLess(silent, SILENCE + 1.0)
        self.assertEqual(self.view.sizes_within(0.5), {VIRTUAL})
        self.assertEqual(self.view.frames_within(0.5), {"endoscope_optical_frame"})
        # WHEN it is back
        self.camera.on = True
        self.view.await_size(REAL)
        self.assertEqual(self.view.sizes_within(0.5), {REAL})
        self.assertEqual(self.trainer.call("set_view", False), "accepted")
        self.view.await_size(VIRTUAL)
        self.assertEqual(self.view.sizes_within(0.5), {VIRTUAL})

    def test_6_the_exercise_is_told_and_begins_anew(self):
        state = until(lambda: self.trainer.progress.message, 5, "exercise/state")
        self.assertEqual((state.exercise, state.tracks, state.steps), ("camera_clutch", ["left", "right"], 4))
        attempt = state.attempt
        self.assertEqual(self.trainer.call("start_exercise"), "accepted")
        until(lambda: self.trainer.progress.message.attempt == attempt + 1, 5, "the next attempt")
        state = self.trainer.progress.message
        self.assertEqual((state.status, state.failure, state.step), ("waiting", "none", 1))
        self.assertEqual((state.current, state.elapsed), (["look", ""], 0.0))
        self.console.pedal = 1
        until(lambda: self.trainer.progress.message.status == "running", 5, "the timer starts with the pedal")
        first = len(self.trainer.progress.messages)
        until(lambda: len(self.trainer.progress.messages) > first + 20, 5, "ten messages a second")
        times = [m.elapsed for m in self.trainer.progress.messages[first:first + 21]]
        self.assertEqual(times, sorted(times))
        self.assertAlmostEqual(times[-1] - times[0], 2.0, delta=0.3)
        self.assertEqual(self.trainer.call("start_exercise"), "not_now", "while the hand moves")

    def test_7_a_recorded_session_is_shown(self):
        """The session that runs, as far as it is written."""
        running = newest_session("training_modes")
        refused = self.trainer.begin_replay("/dev")
        self.assertEqual((refused.success, refused.error_code), (False, 99999))
        self.assertIn("/dev/session.rlog", refused.status)
        self.assertEqual(self.trainer.call("end_replay"), "not_now")
        answer = self.trainer.begin_replay(os.path.basename(running))
        self.assertEqual((answer.success, answer.status, answer.error_code), (True, "accepted", 1))
        self.trainer.await_mode("replaying")
        self.assertEqual(self.trainer.begin_replay(running).status, "not_now")
        time.sleep(0.5)
        self.assertEqual(self.trainer.mode, "replaying", "the refused call ended the replay")
        self.assertEqual(self.trainer.call("end_replay"), "accepted")
        self.trainer.await_mode("pedal_up")

    def test_8_what_is_told_can_be_recorded_and_is_what_the_session_holds(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "training.bag")
            recorder = subprocess.Popen(["rosbag", "record", "-O", path, "mode", "exercise/state", "exercise/events"])
            daemon = xmlrpc.client.ServerProxy(rospy.get_master().lookupNode("/raven2_simulator")[2])
            until(lambda: self.is_read_by(daemon, "/record"), 30, "rosbag records all three topics")
            begun = len(self.trainer.events.messages)
            for k in range(3):
                self.assertEqual(self.trainer.call("start_exercise"), "accepted")
                self.console.pedal = 1
                self.trainer.await_mode("teleoperating")
                until(lambda: [m.event for m in self.trainer.events.messages[begun:]].count("began") > k, 5, "it begins")
                self.console.release()
                self.trainer.await_mode("pedal_up")
            time.sleep(0.5)
            recorder.send_signal(signal.SIGINT)
            self.assertEqual(recorder.wait(20), 0)
            until(lambda: os.path.exists(path), 20, "the bag is whole")  # its writer ends after the script
            with rosbag.Bag(path) as bag:
                told = [(m.topic, m.message) for m in bag.read_messages()]
        heard = self.trainer.events.messages[begun:]
        self.assertEqual([m.event for m in heard].count("started"), 3)
        self.assertEqual([m.event for m in heard].count("began"), 3)
        self.assertEqual([m.number for t, m in told if t == "exercise/events" or t == "/exercise/events"],
                         [m.number for m in heard])
        self.assertIn("running", [m.status for t, m in told if t.endswith("exercise/state")])
        self.assertIn("teleoperating", [m.mode for t, m in told if t.endswith("mode")])
        self.check_events(raven2_session.Session(newest_session("training_modes")).log)

    @staticmethod
    def is_read_by(daemon, node):
        """Whether subscribers of that name are connected for modes, states and events."""
        time.sleep(0.1)
        topics = {topic for _, name, _, _, topic, *_ in daemon.getBusInfo("/training_modes_test")[2] if name.startswith(node)}
        return topics >= {"/mode", "/exercise/state", "/exercise/events"}

    def check_events(self, log):
        """Each received event equals the log's event of the same number. No event was missed."""
        numbers = [m.number for m in self.trainer.events.messages]
        self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))))
        kinds = log.names("exercise", "event.kind")
        for message in self.trainer.events.messages:
            record = log.exercise_events[message.number - 1]
            self.assertEqual((message.tick, message.event), (record["tick"], kinds[record["event"]["kind"]]))
        kinds = log.names("request", "request.kind")
        asked = [kinds[r["request"]["kind"]] for r in log.requests if r["request"]["id"] == 0]
        self.assertEqual(asked.count("tool_change"), 1, "the pedal's")
        arms = log.names("request", "request.arm")
        switched = [(arms[r["request"]["arm"]], bool(r["request"]["enabled"])) for r in log.requests
                    if kinds[r["request"]["kind"]] == "set_collisions"]
        self.assertEqual(switched, [("green", False), ("green", True)])


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "training_modes", TrainingModes)
