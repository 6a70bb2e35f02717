#!/usr/bin/python3
"""console_view on an X display in memory: the window shows the topic's picture, pixel for pixel."""
import os
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import unittest

import numpy as np
import rospy
import rostest
from sensor_msgs.msg import Image

PROGRAM = os.path.join(os.environ["RAVEN2_TRAINER_BUILD"], "devel", "lib", "raven2_trainer", "console_view")
WIDTH, HEIGHT = 320, 240
SCREEN = (800, 600)


def fields(shift=0):
    """Four fields of one colour each."""
    colours = np.array([[200, 30, 40], [20, 180, 60], [30, 50, 220], [240, 240, 235]], np.uint8)
    picture = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    for n in range(4):
        v, u = (n // 2) * HEIGHT // 2, (n % 2) * WIDTH // 2
        picture[v:v + HEIGHT // 2, u:u + WIDTH // 2] = colours[(n + shift) % 4]
    return picture


def message(picture):
    image = Image(width=WIDTH, height=HEIGHT, encoding="rgb8", step=3 * WIDTH, data=picture.tobytes())
    image.header.stamp = rospy.Time.now()
    return image


class Screen:
    """An X server whose screen is a file (X window dump)."""

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory()
        read, write = os.pipe()
        self._server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{SCREEN[0]}x{SCREEN[1]}x24", "-fbdir",
             self._folder.name, "-nolisten", "tcp"], pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as number:
            self.display = ":" + number.readline().strip()

    def pixels(self):
        with open(os.path.join(self._folder.name, "Xvfb_screen0"), "rb") as file:
            data = file.read()
        header = struct.unpack(">25I", data[:100])
        size, height, width, line, colours = header[0], header[5], header[4], header[12], header[19]
        rows = np.frombuffer(data, np.uint8, count=height * line, offset=size + 12 * colours).reshape(height, line)
        return rows[:, :4 * width].reshape(height, width, 4)[:, :, 2::-1]

    def close(self):
        self._server.terminate()
        self._server.wait()
        self._folder.cleanup()


class ConsoleView(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("console_view_test", disable_signals=True)
        cls.publisher = rospy.Publisher("view/image_raw", Image, queue_size=1)

    def await_picture(self, screen, picture, seconds=15):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.publisher.publish(message(picture))
            time.sleep(0.1)
            if np.array_equal(screen.pixels()[:HEIGHT, :WIDTH], picture):
                return True
        return False

    @unittest.skipUnless(shutil.which("Xvfb"), "Xvfb is not installed")
    def test_the_window_shows_the_newest_picture(self):
        screen = Screen()
        self.addCleanup(screen.close)
        program = subprocess.Popen([PROGRAM], env=dict(os.environ, DISPLAY=screen.display))
        self.addCleanup(program.kill)
        for shift in (0, 1):
            self.assertTrue(self.await_picture(screen, fields(shift)), f"picture {shift}")
        rest = screen.pixels().copy()
        rest[:HEIGHT, :WIDTH] = 0
        self.assertEqual(rest.max(), 0, "nothing is drawn outside the window")
        program.send_signal(signal.SIGTERM)
        self.assertEqual(program.wait(timeout=5), 0)

    def test_without_a_display_it_says_so(self):
        environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
        for display in (None, "", ":4711"):
            env = environment if display is None else dict(environment, DISPLAY=display)
            done = subprocess.run([PROGRAM], env=env, timeout=10, stderr=subprocess.PIPE, text=True, check=False)
            self.assertEqual(done.returncode, 1)
            self.assertIn("no display", done.stderr)


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "console_view", ConsoleView)
