#!/usr/bin/python3
"""master_console --master with each family of haptic devices. It sends motion along the right axes, publishes forces
along the same axes, and reports faults.

The test plays the drivers and the daemon.
"""
import gc
import math
import os
import signal
import socket
import struct
import subprocess
import tempfile
import threading
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from haptic_drivers import Crtk, Gamepad, Geomagic, Omni
from sensor_msgs.msg import Joy

gc.disable()  # as in robot_frames.py

FOOT = """
import rospy
from sensor_msgs.msg import Joy
rospy.init_node("foot", anonymous=True)
pedal = rospy.Publisher("/footpedals/coag", Joy, queue_size=1)
rate, connected = rospy.Rate(20), None
while not rospy.is_shutdown():
    if connected is None and pedal.get_num_connections() > 0:
        connected = rospy.get_time()
    pedal.publish(Joy(buttons=[int(connected is not None and rospy.get_time() - connected > 1)]))
    rate.sleep()
"""  # up for a second after it is connected, then held

STRANGER = """
import rospy
rospy.init_node("stranger")
reader = rospy.Subscriber("/Geomagic/force_feedback", rospy.AnyMsg, lambda message: None)
rospy.spin()
"""

HERE = os.path.dirname(os.path.realpath(__file__))
PROGRAM = os.path.join(os.environ["RAVEN2_TRAINER_BUILD"], "devel", "lib", "raven2_trainer", "master_console")
MASTERS = os.path.join(HERE, "..", "..", "config", "masters")
PEDAL_UP, PEDAL_DN = 2, 3
FORWARD, RIGHT, DOWN = (1, 0, 0), (0, 1, 0), (0, 0, 1)


def minus(v):
    return tuple(-x for x in v)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        return sock.getsockname()[1]


SO_RCVBUFFORCE = 33  # of Linux; Python has no name for it


class Daemon:
    """Replaces the daemon, by doc/wire.md: adds up the motion it receives, sends forces 250 times a second."""

    def __init__(self):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        # On a busy machine this thread may not run for longer than the system's own buffer lasts, 0.25 s.
        try:
            self._socket.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 1 << 22)
        except PermissionError:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(0.2)
        self.port, self.force_port = self._socket.getsockname()[1], free_port()
        self.pedal, self.packets = 0, 0
        self.sum = [[0, 0, 0], [0, 0, 0]]  # [um] gold, green
        self.closed = [0, 0]  # [mrad]
        self.force = [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0)]  # [N] along I
        self._stop = threading.Event()
        self._threads = [threading.Thread(target=body, daemon=True) for body in (self._receive, self._send)]
        for thread in self._threads:
            thread.start()

    def _receive(self):
        while not self._stop.is_set():
            try:
                data = self._socket.recv(512)
            except socket.timeout:
                continue
            fields = struct.unpack("<3I6i8d6i", data)
            self.packets += 1
            self.pedal = fields[21]
            for arm in (0, 1):
                for axis in range(3):
                    self.sum[arm][axis] += fields[3 + 2 * axis + arm]
                self.closed[arm] += fields[19 + arm]

    def _send(self):
        sequence = 0
        while not self._stop.wait(0.004):
            sequence += 1
            force = [round(1000 * self.force[arm][axis]) for axis in range(3) for arm in (0, 1)]
            body = struct.pack("<4I6iiI", sequence, 0, 0, 0, *force, PEDAL_DN if self.pedal else PEDAL_UP, 0)
            total = sum(struct.unpack("<12I", body)) & 0xFFFFFFFF
            self._socket.sendto(body + struct.pack("<I", total), ("127.0.0.1", self.force_port))

    def close(self):
        self._stop.set()
        for thread in self._threads:
            thread.join()
        self._socket.close()


class Console:
    """master_console with a packaged master, whose time-outs are longer because this machine may be busy."""

    def __init__(self, daemon, master, **changes):
        self._folder = tempfile.TemporaryDirectory()
        path = os.path.join(self._folder.name, master + ".yaml")
        with open(os.path.join(MASTERS, master + ".yaml"), encoding="utf-8") as file:
            text = file.read()
        for old, new in {"frozen_after: 2.0": "frozen_after: 0.0", "frozen_after: 0.5": "frozen_after: 0.0",
                         **changes.get("swap", {})}.items():
            text = text.replace(old, new)
        for old in ("silent_after: 0.1 ", "silent_after: 0.3 "):
            text = text.replace(old, f"silent_after: {changes.get('silent_after', 5.0)} ")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        self._log = os.path.join(self._folder.name, "stderr")
        with open(self._log, "wb") as log:
            self.process = subprocess.Popen(
                [PROGRAM, "--master", path, "--master-port", str(daemon.port), "--force-port", str(daemon.force_port)],
                stderr=log)

    def said(self):
        with open(self._log, encoding="utf-8") as file:
            return file.read()

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        status = self.process.wait(timeout=10)
        text = self.said()
        self._folder.cleanup()
        return status, text


class Masters(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("masters_test", disable_signals=True)

    def await_that(self, condition, what, seconds=15):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if condition():
                return
            time.sleep(0.01)
        self.fail(f"{what}\n{self.console.said()}")

    def begin(self, master, drivers, **changes):
        self.drivers = drivers
        self.daemon = Daemon()
        self.console = Console(self.daemon, master, **changes)
        self.addCleanup(self.clean_up)
        for driver in drivers:
            driver.start()
        self.await_that(lambda: self.daemon.packets > 100, "no packets")

    def clean_up(self):
        if self.console.process.poll() is None:
            self.console.process.kill()
            self.console.process.wait()
        for driver in self.drivers:
            driver.close()
        self.daemon.close()

    def settle(self):
        """Lets the console watch trembling drivers until it accepts them; then they rest."""
        self.await_that(lambda: all(d.listener.get_num_connections() > 0 and (d.forces > 0 or d.is_held)
                                    for d in self.drivers), "forces do not come")
        time.sleep(0.8)  # watch is 0.5 s
        for driver in self.drivers:
            driver.trembles = False
        time.sleep(0.3)
        self.assertEqual(self.daemon.sum, [[0, 0, 0], [0, 0, 0]], "the pedal is up")
        self.assertEqual([d.forces for d in self.drivers if d.is_held], [0 for d in self.drivers if d.is_held],
                         "a force takes an arm from the controller that holds it")

    def engage(self, press, release=lambda: None):
        """Presses up to three times: if a busy machine delays a driver's messages, the console wants a new press."""
        for _ in range(3):
            press()
            end = time.monotonic() + 3
            while self.daemon.pedal != 1 and time.monotonic() < end:
                time.sleep(0.01)
            if self.daemon.pedal == 1:
                break
            release()
            time.sleep(0.3)
        self.await_that(lambda: self.daemon.pedal == 1, "not engaged", 3)
        time.sleep(0.1)

    def check_motion(self, axes, scale, ways=(0.006, -0.004)):
        """Moves each device along each of its axes: motion comes along the right axis of ITP and along no other."""
        for axis, direction in enumerate(axes):
            before = [list(arm) for arm in self.daemon.sum]
            for driver, way in zip(self.drivers, ways):
                driver.move(axis, way)
            for arm, way in zip(range(len(self.drivers)), ways):
                wanted = [round(1e6 * scale * way * k) for k in direction]

                def moved(arm=arm, before=before):
                    return [now - then for now, then in zip(self.daemon.sum[arm], before[arm])]
                self.await_that(lambda: all(abs(m - w) <= 1 for m, w in zip(moved(), wanted)),
                                f"axis {axis} of arm {arm}: wanted {wanted}, is {moved()}", 5)

    def check_force(self, axes):
        """For each axis of the device: a newton along its direction in ITP comes out as a newton along that axis."""
        for axis, direction in enumerate(axes):
            self.daemon.force = [tuple(1.0 * k for k in direction), tuple(-0.5 * k for k in direction)]
            for driver, size in zip(self.drivers, (1.0, -0.5)):
                wanted = [0.0, 0.0, 0.0]
                wanted[axis] = size
                self.await_that(lambda d=driver, w=wanted: max(abs(f - g) for f, g in zip(d.force, w)) < 1e-9,
                                f"force along axis {axis}: wanted {wanted}, is {driver.force}", 5)

    def check_release(self, release):
        release()
        self.await_that(lambda: self.daemon.pedal == 0, "not released")
        self.await_that(lambda: all(d.force == (0.0, 0.0, 0.0) for d in self.drivers), "a force with the pedal up")

    def check_end(self, press, release=lambda: None):
        """Ends the console while it renders a force: the last force that each driver receives is zero."""
        self.engage(press, release)
        self.await_that(lambda: all(d.force != (0.0, 0.0, 0.0) for d in self.drivers), "no force")
        status, said = self.console.end()
        self.assertEqual(status, 0, said)
        self.await_that(lambda: all(d.force == (0.0, 0.0, 0.0) for d in self.drivers), "a force was left")
        return said

    def run_family(self, axes, scale, press, release):
        self.settle()
        self.engage(press, release)
        self.check_motion(axes, scale)
        self.check_force(axes)
        self.check_release(release)
        return self.check_end(press, release)

    def check_rates(self):
        """Poses a second, in the diagnostics of this session: each as the driver sends them."""
        rates = [float(v.value) for m in self.diagnostics for s in m.status for v in s.values if v.key == "poses_per_second"]
        print("poses a second:", rates)
        self.assertGreater(len(rates), 5)
        self.assertLess(max(rates), 400, "a driver sends 250")

    def test_omni_pair(self):
        self.diagnostics = []
        heard = rospy.Subscriber("/diagnostics", DiagnosticArray, self.diagnostics.append)
        self.addCleanup(heard.unregister)
        left, right = Omni("left"), Omni("right")
        self.begin("omni_pair", [left, right])
        said = self.run_family((RIGHT, FORWARD, minus(DOWN)), 0.1, lambda: right.press(1), lambda: right.press(0))
        self.assertIn(f"left: force on /left/force_feedback, read by 1: {rospy.get_name()}", said)
        self.assertIn("let go", said)
        self.check_rates()
        for driver in (left, right):  # the last message, with zero force, does not pull a device that locks
            self.assertLess(math.dist(driver.held_at, driver.position), 0.001)
            self.assertGreater(math.hypot(*driver.position), 0.003)

    def test_touch_geomagic(self):
        touch = Geomagic()
        self.begin("touch_geomagic", [touch])
        self.run_family((RIGHT, minus(DOWN), minus(FORWARD)), 0.1, lambda: touch.press(1), lambda: touch.press(0))

    def test_crtk_pair(self):
        left, right = Crtk("left"), Crtk("right")
        self.begin("crtk_pair", [left, right])
        self.run_family((RIGHT, minus(DOWN), minus(FORWARD)), 0.1, lambda: left.press(1), lambda: left.press(0))
        self.assertEqual(left.frame, "left_base")

    def test_mtm(self):
        arms = [Crtk(n, "body/servo_cf", "body/set_cf_orientation_absolute") for n in ("MTML", "MTMR")]
        foot = rospy.Publisher("/footpedals/coag", Joy, queue_size=10, latch=True)
        foot.publish(Joy(buttons=[0]))
        self.begin("mtm", arms)
        self.settle()
        self.assertEqual([arm.is_absolute for arm in arms], [True, True])
        self.assertEqual([arm.is_compensated for arm in arms], [True, True])
        self.engage(lambda: foot.publish(Joy(buttons=[1])), lambda: foot.publish(Joy(buttons=[0])))
        self.check_motion((minus(RIGHT), minus(DOWN), FORWARD), 0.2)
        # the jaws open from where they were to 0.8 rad, then close by half
        time.sleep(1.0)
        opened = self.daemon.closed[1]
        arms[1].angle = 0.4
        self.await_that(lambda: abs(self.daemon.closed[1] - opened - 400) <= 1, "the jaws do not close", 5)
        self.check_release(lambda: foot.publish(Joy(buttons=[0])))
        self.engage(lambda: foot.publish(Joy(buttons=[1])), lambda: foot.publish(Joy(buttons=[0])))
        arms[0].enable("FAULT")
        self.await_that(lambda: self.daemon.pedal == 0, "a fault of the arm does not lift the pedal")
        self.await_that(lambda: "/MTML/operating_state is not ENABLED" in self.console.said(), "fault not reported")
        foot.unregister()
        self.await_that(lambda: "nobody publishes /footpedals/coag" in self.console.said(), "no report of a lost pedal")

    def test_forces_wait_for_the_axes_of_the_base(self):
        names = ("MTML", "MTMR")
        arms = [Crtk(name, "body/servo_cf") for name in names]
        foot = rospy.Publisher("/footpedals/coag", Joy, queue_size=10, latch=True)
        foot.publish(Joy(buttons=[0]))
        self.addCleanup(foot.unregister)
        self.begin("mtm", arms)
        self.settle()
        self.engage(lambda: foot.publish(Joy(buttons=[1])), lambda: foot.publish(Joy(buttons=[0])))
        self.daemon.force = [(1.0, 0.0, 0.0), (1.0, 0.0, 0.0)]
        for name in names:
            self.await_that(lambda n=name: f"nobody reads /{n}/body/set_cf_orientation_absolute: forces stay zero"
                            in self.console.said(), "a missing subscriber is not reported")
        time.sleep(0.5)
        self.assertEqual([arm.force for arm in arms], 2 * [(0.0, 0.0, 0.0)])
        arms[0].await_absolute("body/set_cf_orientation_absolute")
        self.await_that(lambda: math.dist(arms[0].force, (0.0, 0.0, 1.0)) < 1e-9, f"no force: {arms[0].force}")
        self.assertEqual(arms[1].force, (0.0, 0.0, 0.0))

    def test_a_pedal_whose_program_is_killed_is_up(self):
        arms = [Crtk(n, "body/servo_cf", "body/set_cf_orientation_absolute") for n in ("MTML", "MTMR")]
        self.begin("mtm", arms, swap={"  silent_after: 0.0 ": "  silent_after: 2.0 "})  # a busy machine may stall a program
        self.settle()
        foot = subprocess.Popen(["/usr/bin/python3", "-c", FOOT])
        self.addCleanup(foot.wait)
        self.addCleanup(foot.kill)
        self.await_that(lambda: self.daemon.pedal == 1, "not engaged", 30)
        time.sleep(3.0)  # longer than the silence that would lift it
        self.assertEqual(self.daemon.pedal, 1, "a pedal that is held and repeated is up")
        foot.send_signal(signal.SIGKILL)
        self.await_that(lambda: self.daemon.pedal == 0, "a pedal whose program was killed stays down", 5)
        self.await_that(lambda: "nothing came on /footpedals/coag" in self.console.said(), "a silent pedal: no report")
        self.await_that(lambda: all(arm.force == (0.0, 0.0, 0.0) for arm in arms), "a force with the pedal up")

    def test_gamepad(self):
        pad = Gamepad()
        self.begin("gamepad", [pad])
        time.sleep(1.0)

        def hold(value):
            pad.buttons[5] = value
        self.engage(lambda: hold(1), lambda: hold(0))
        left, right = ((1, 0, 0, 1), (0, 0, 1, -1), (7, 0, 2, -1)), ((4, 1, 0, 1), (3, 1, 1, -1), (6, 1, 2, -1))
        for stick, arm, axis, sign in left + right:
            before = [list(values) for values in self.daemon.sum]
            pad.axes[stick] = 1.0
            self.await_that(lambda: sign * (self.daemon.sum[arm][axis] - before[arm][axis]) > 300, f"stick {stick}")
            pad.axes[stick] = 0.0
            time.sleep(0.2)
            moved = [[now - then for now, then in zip(*pair)] for pair in zip(self.daemon.sum, before)]
            moved[arm][axis] = 0
            self.assertEqual(moved, [[0, 0, 0], [0, 0, 0]], f"stick {stick} moves something else")
        opened = self.daemon.closed[0]
        pad.axes[2] = -1.0
        self.await_that(lambda: self.daemon.closed[0] - opened > 500, "the trigger does not close the jaws")
        hold(0)
        self.await_that(lambda: self.daemon.pedal == 0, "not released")

    def test_wrong_units_are_refused_by_name(self):
        touch = Geomagic()
        touch.position = [0.0, 0.0655, 0.051]
        levels = {}

        def hear(array):
            levels.update({status.name: (status.level, status.message) for status in array.status})
        listener = rospy.Subscriber("/diagnostics", DiagnosticArray, hear)
        self.addCleanup(listener.unregister)
        self.begin("touch_geomagic", [touch], swap={"units: mm": "units: m "})
        self.await_that(lambda: "the driver publishes millimetres; units: mm" in self.console.said(), "no report")
        time.sleep(1.0)
        touch.press(1)
        time.sleep(0.5)
        self.assertEqual(self.daemon.pedal, 0)
        name = "raven2_trainer: master left"
        self.await_that(lambda: levels.get(name, (0, ""))[0] == DiagnosticStatus.ERROR, f"diagnostics: {levels}")
        self.assertIn("units: mm", levels[name][1])

    def test_a_driver_that_dies_lifts_the_pedal_and_is_told(self):
        touch = Geomagic()
        self.begin("touch_geomagic", [touch], silent_after=1.0)
        self.settle()
        self.engage(lambda: touch.press(1), lambda: touch.press(0))
        touch.listener.unregister()
        self.await_that(lambda: "read by NOBODY any more" in self.console.said(), "a lost reader is not reported")
        stranger = subprocess.Popen(["/usr/bin/python3", "-c", STRANGER])
        self.addCleanup(stranger.wait)
        self.addCleanup(stranger.kill)
        self.await_that(lambda: "read by 1: /stranger, but not by " + rospy.get_name() in self.console.said(),
                        "another reader is taken for the driver", 30)
        touch.close()
        self.await_that(lambda: self.daemon.pedal == 0, "a silent device does not lift the pedal")
        self.await_that(lambda: "left: nothing came on /Geomagic/pose" in self.console.said(), "no report of silence")


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "masters", Masters)
