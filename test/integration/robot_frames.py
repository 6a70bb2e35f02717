"""The robot's TCP link, read with struct and zlib alone (doc/wire.md), packets to the robot, and its process."""
import gc
import os
import signal
import socket
import struct
import sys
import threading
import time
import xmlrpc.client
import zlib

import rospy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "support"))
from state_frame import State  # noqa: E402

# The collector would search ten thousands of frames for reference cycles, in vain, and stop all threads for half a
# second. A console in this process would be silent for so long.
gc.disable()

HEADER = struct.Struct("<4sHHII")
PLAN_HEAD = struct.Struct("<III")  # generation, session, rows
VERSION = 0x400
HELLO, STATE_TYPE, PLAN = 1, 2, 3


class FrameReader:
    """Reads the hello and every state frame, in order, in a separate thread."""

    def __init__(self, port, address="127.0.0.1"):
        self._socket = socket.create_connection((address, port), timeout=10)
        self._sequence = 0
        self.hello = None
        self.states = []
        self.changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _take(self, size):
        data = b""
        while len(data) < size:
            part = self._socket.recv(size - len(data))
            if not part:
                raise EOFError
            data += part
        return data

    def _run(self):
        try:
            while True:
                head = self._take(HEADER.size)
                magic, version, kind, size, _ = HEADER.unpack(head)
                crc, = struct.unpack("<I", self._take(4))
                payload = self._take(size)
                assert magic == b"RV2T" and version == VERSION and crc == zlib.crc32(payload, zlib.crc32(head))
                with self.changed:
                    if kind == HELLO:
                        self.hello = payload
                    elif kind == STATE_TYPE:
                        self.states.append(State(payload))
                    self.changed.notify_all()
        except (EOFError, OSError):
            pass

    def wait(self, condition, seconds=30.0):
        """Waits until condition(newest state) holds and returns that state; None after the deadline."""
        seen = len(self.states)
        with self.changed:
            if self.states and condition(self.states[-1]):
                return self.states[-1]

            def look():
                nonlocal seen
                for state in self.states[seen:]:
                    seen += 1
                    if condition(state):
                        look.found = state
                        return True
                return False

            look.found = None
            self.changed.wait_for(look, seconds)
            return look.found

    def ended(self, seconds):
        """Waits for the other side to close. Returns whether it did."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def send_plan(self, fault_id=1):
        """A plan of one fault that never begins (first tick in the far future)."""
        payload = PLAN_HEAD.pack(1, 1, 1) + struct.pack(
            "<I5B2bBIQ6q5d", fault_id, 0, 13, 34, 1, 0, 0, 0, 0, 1, 0, 10**12, 300, 0, 1, 0, 0, 0.0, 1.0, 0.0, 0.0, 0.0)
        self._sequence += 1
        head = HEADER.pack(b"RV2T", VERSION, PLAN, len(payload), self._sequence)
        self._socket.sendall(head + struct.pack("<I", zlib.crc32(payload, zlib.crc32(head))) + payload)

    def close(self):
        self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()


def connect(port):
    """Connects to the robot and waits for its first state: a dying process may still accept a connection."""
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        try:
            reader = FrameReader(port)
            if reader.wait(lambda s: True, 1.0):
                return reader
        except OSError:  # nobody listens, or a dying process resets the connection
            time.sleep(0.02)
    raise AssertionError("no robot")


def kill_robot():
    """Kills (-9) the virtual Raven's process. The launch file starts it again."""
    uri = rospy.get_master().lookupNode("/virtual_raven")[2]
    os.kill(xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())[2], signal.SIGKILL)


class Master:
    """ITP packets to a robot (raven2.md 1.1), numbered from 1."""

    PACKET = struct.Struct("<3I6i8d6i")

    def __init__(self, port, address="127.0.0.1"):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._peer = (address, port)
        self.sequence = 0

    def send(self, pedal, gold_um=(0, 0, 0), green_um=(0, 0, 0)):
        self.sequence += 1
        x, y, z = gold_um
        u, v, w = green_um
        checksum = pedal + sum(gold_um) + sum(green_um) + self.sequence
        self._socket.sendto(self.PACKET.pack(self.sequence, 0, 0, x, u, y, v, z, w, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0,
                                             pedal, checksum), self._peer)
