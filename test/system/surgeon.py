"""The console's end of the links: a surgeon that moves and reads forces. Also a reader of the robot's newest state."""

import socket
import struct
import threading
import time

from stack import RobotStates, itp, wait_until


class Surgeon:
    """Sends ITP about every millisecond from a thread. Moves to and fro while `pedal` is true."""

    def __init__(self, stack):
        self.pedal = False
        self.last_force = None
        self._forces = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._forces.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self._forces.bind(("127.0.0.1", stack.force_port))
        self._forces.setblocking(False)
        self._master = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._target = ("127.0.0.1", stack.master_port)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        sequence = 0
        while not self._stop.is_set():
            sequence += 1
            way = 20 if sequence % 400 < 200 else -20
            step = (way, way, 0) if self.pedal else (0, 0, 0)
            self._master.sendto(itp(sequence, self.pedal, step, step), self._target)
            time.sleep(0.001)

    def press(self, is_down, seconds=20):
        """Presses the pedal until `is_down`. If this thread got no processor time for long, the daemon has released the
        robot and needs a new press. This method presses again after a second."""
        pressed = time.monotonic()
        self.pedal = True

        def is_done():
            nonlocal pressed
            if is_down():
                return True
            since = time.monotonic() - pressed
            self.pedal = since < 1.0 or since > 1.2
            if since > 1.2:
                pressed = time.monotonic()
            return False
        wait_until(is_done, seconds, "pedal down")

    def read_forces(self):
        """Forces [mN] of all waiting packets: x, y, z, each gold and green. last_force keeps the newest one."""
        found = []
        while True:
            try:
                found.append(struct.unpack_from("<6i", self._forces.recv(256), 16))
            except BlockingIOError:
                break
        if found:
            self.last_force = found[-1]
        return found

    def feels_force(self):
        return any(any(force) for force in self.read_forces())

    def close(self):
        self._stop.set()
        self._thread.join()
        self._master.close()
        self._forces.close()


class LatestState:
    """Reads all frames of the robot, or of its bridge, in a thread. `state` is the newest one, empty before the first.
    If this machine is too busy, the server drops the reader. It then connects again."""

    def __init__(self, port):
        self.state = {}
        self._port = port
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        while not self._stop.is_set():
            try:
                reader = RobotStates(self._port)
            except OSError:  # the server does not run
                time.sleep(0.01)
                continue
            try:
                while not self._stop.is_set():
                    self.state = reader.state()
            except (EOFError, OSError):
                self.state = {}
            reader.close()

    def runlevel(self):
        return self.state.get("runlevel")

    def close(self):
        self._stop.set()  # the thread ends at the next frame, or after the reader's time-out of 5 s
