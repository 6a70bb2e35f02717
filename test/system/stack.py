"""The programs as a user starts them: virtual Raven, daemon, console, on separate ports, without ROS by default.

Used by the system tests and by scripts that measure the running system."""

import contextlib
import itertools
import json
import os
import random
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import zlib

import yaml

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
BUILD = os.environ.get("RAVEN2_TRAINER_BUILD", os.path.join(ROOT, "build"))
PROGRAMS = os.path.join(BUILD, "devel", "lib", "raven2_trainer")
FULL = os.environ.get("RAVEN2_TRAINER_FULL") == "1"

sys.path.insert(0, os.path.join(ROOT, "test", "support"))
from state_frame import State  # noqa: E402


def effort(quick, full):
    """Number of repetitions: the promised one with scripts/test --full, otherwise a part of it."""
    return full if FULL else quick


# These are below the system's range for outgoing connections, which begins at 32768. In that range, any connection
# could take a port between its choice here and its use. The rostests have 27000 to 27999.
FIRST_PORTS = [first for first in range(20000, 32000, 500) if not 27000 <= first < 28000]
HOMING_TIME = 0.5  # [s] of quick homing, instead of 2.5; the arms end at the same joints


def _take_ports():
    """(lock, ports): 500 ports that no other test run uses while this process lives. The lock is an abstract socket."""
    for first in random.sample(FIRST_PORTS, len(FIRST_PORTS)):
        lock = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            lock.bind(f"\0raven2_trainer_ports_{first}")
        except OSError:
            lock.close()
            continue
        return lock, itertools.cycle(range(first, first + 500))
    raise RuntimeError("all ports for tests are taken by other test runs: end one")


_port_lock, _ports = _take_ports()


def free_ports(count):
    """Ports that are free for UDP and TCP on the loopback interface. A port is returned again only after all others."""
    ports = []
    while len(ports) < count:
        port = next(_ports)
        with socket.socket() as tcp, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
            try:
                tcp.bind(("127.0.0.1", port))
                udp.bind(("127.0.0.1", port))
            except OSError:
                continue
        ports.append(port)
    return ports


def listens(port):
    """Whether a server accepts TCP connections at this port."""
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@contextlib.contextmanager
def urgent():
    """Gives this process real-time priority where that is permitted: in use, a trainee's page has its own computer."""
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(2))
    try:
        yield
    finally:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def wait_until(condition, seconds, what, period=0.01):
    """Polls a condition each `period` seconds. Fails after `seconds`, and names `what` was awaited."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f"not within {seconds} s: {what}"
        time.sleep(period)


def itp(sequence, pedal, gold=(0, 0, 0), green=(0, 0, 0)):
    """One ITP packet (doc/wire.md); increments in um, orientation unchanged."""
    values = [sequence & 0xFFFFFFFF, 0, 0]
    for axis in range(3):
        values += [gold[axis], green[axis]]
    values += [0.0] * 6 + [1.0, 1.0] + [0] * 4 + [1 if pedal else 0]
    total = sum(gold) + sum(green) + values[-1] + sequence
    return struct.pack("<3I6i8d6i", *values, (total + 2**31) % 2**32 - 2**31)


def memory_folder():
    """A file system in memory with room for sessions, or None. A slow disk is the subject of test_record alone."""
    shared = "/dev/shm"
    has_room = os.access(shared, os.W_OK) and shutil.disk_usage(shared).free > 2**30
    return shared if has_room else None


class Stack:
    """Robot, daemon and console of one session, in a separate folder. Use as a context manager."""

    def __init__(self, folder=None, configure=None, environment=None):
        """configure: changes to the files of config/, e.g. {"network": {"auth": "required"}}. A value may also be a
        function that changes the file's content."""
        self.folder = folder or tempfile.mkdtemp(prefix="raven2_", dir=memory_folder())
        self.output = os.path.join(self.folder, "session")
        self.master_port, self.robot_port, self.force_port, self.sight_port, self.state_port = free_ports(5)
        self.environment = dict(os.environ, ROS_MASTER_URI="http://127.0.0.1:1", **(environment or {}))
        self.config = self._write_config(configure or {})
        self.processes = {}

    def _write_config(self, changes):
        target = os.path.join(self.folder, "share")
        for entry in ("config", "urdf", "meshes"):
            shutil.copytree(os.path.join(ROOT, entry), os.path.join(target, entry), dirs_exist_ok=True)
        path = os.path.join(target, "config", "virtual_raven.yaml")
        with open(path, encoding="utf-8") as file:
            text, found = re.subn(r"(?m)^homing_time: [0-9.]+", f"homing_time: {HOMING_TIME}", file.read())
        assert found == 1, path
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        for name, values in changes.items():
            path = os.path.join(target, "config", name + ".yaml")
            with open(path, encoding="utf-8") as file:
                content = yaml.safe_load(file)
            values(content) if callable(values) else content.update(values)
            with open(path, "w", encoding="utf-8") as file:
                yaml.safe_dump(content, file, sort_keys=False)
        return os.path.join(target, "config", "trainer.yaml")

    def start(self, program, *arguments, prefix=(), ports=None, **options):
        """Starts a program of the package with this stack's configuration and ports; its output goes to NAME.log.

        ports: {"master" | "robot" | "force" | "sight" | "state": number} instead of the stack's own, for a proxy."""
        numbers = {"master": self.master_port, "robot": self.robot_port, "force": self.force_port,
                   "sight": self.sight_port, "state": self.state_port, **(ports or {})}
        words = [word for name, number in numbers.items() for word in (f"--{name}-port", number)]
        command = [*prefix, os.path.join(PROGRAMS, program), "--config", self.config, *words, *arguments]
        with open(os.path.join(self.folder, program + ".log"), "ab") as log:
            self.processes[program] = subprocess.Popen([str(word) for word in command], stdout=log, stderr=log,
                                                       env=self.environment, **options)
        return self.processes[program]

    def start_robot(self, *arguments, **options):
        return self.start("virtual_raven", "--homing", "quick", *arguments, **options)

    def start_daemon(self, *arguments, **options):
        return self.start("simulator", "--output", self.output, "--no-render", *arguments, **options)

    def await_ticks(self):
        """Waits until the daemon records its loops."""
        log = os.path.join(self.output, "session.rlog")
        wait_until(lambda: os.path.exists(log) and os.path.getsize(log) > 1 << 17, 60, "the daemon runs")

    def start_console(self, *arguments, **options):
        return self.start("master_console", *arguments, **options)

    def log_text(self, program):
        with open(os.path.join(self.folder, program + ".log"), encoding="utf-8", errors="replace") as file:
            return file.read()

    def stop(self, program, sign=signal.SIGTERM, seconds=10):
        """Ends one program. Returns (exit code, seconds it took)."""
        process = self.processes.pop(program)
        begin = time.monotonic()
        if process.poll() is None:
            process.send_signal(sign)
        code = process.wait(seconds)
        return code, time.monotonic() - begin

    def metrics(self):
        with open(os.path.join(self.output, "metrics.json"), encoding="utf-8") as file:
            return json.load(file)

    def assert_counters_add_up(self):
        """received = applied + rejected, on every link of the finished session."""
        packets = self.metrics()["packets"]
        for name in ("master_to_daemon", "daemon_to_robot", "robot_to_daemon"):
            link = packets[name]
            assert link["received"] == link["applied"] + sum(link["rejected"].values()), (name, link)
        assert self.metrics()["counters_add_up"] is True, self.metrics()
        return packets

    def meta(self):
        with open(os.path.join(self.output, "meta.json"), encoding="utf-8") as file:
            return json.load(file)

    def __enter__(self):
        return self

    def __exit__(self, failure=None, *_):
        for process in self.processes.values():
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.kill()
                process.wait()
        try:  # the counters of every finished session must add up
            recovered = os.path.exists(os.path.join(self.output, "recovered.json"))  # a killed daemon has no counters
            if failure is None and not recovered and os.path.exists(os.path.join(self.output, "metrics.json")):
                self.assert_counters_add_up()
        finally:
            shutil.rmtree(self.folder, ignore_errors=True)


class RobotStates:
    """A reader of the robot's TCP frames (doc/wire.md). state() returns the next state as a dict."""

    HEADER = struct.Struct("<4sHHIII")

    def __init__(self, port, buffer=0):
        """buffer [bytes]: of a reader that must miss nothing, however long a busy machine stalls it."""
        self._socket = socket.socket()
        self._socket.settimeout(5)
        if buffer:  # before it connects: the buffer bounds the window that it offers
            try:
                self._socket.setsockopt(socket.SOL_SOCKET, 33, buffer)  # SO_RCVBUFFORCE
            except PermissionError:
                self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        try:
            self._socket.connect(("127.0.0.1", port))
        except OSError:
            self._socket.close()
            raise
        self._bytes = b""

    def next(self):
        """(type, payload) of the next frame. Checks its CRC."""
        while True:
            if len(self._bytes) >= self.HEADER.size:
                magic, _, kind, size, _, crc = self.HEADER.unpack_from(self._bytes)
                end = self.HEADER.size + size
                if len(self._bytes) >= end:
                    payload = self._bytes[self.HEADER.size:end]
                    assert magic == b"RV2T" and crc == zlib.crc32(payload, zlib.crc32(self._bytes[:16]))
                    self._bytes = self._bytes[end:]
                    return kind, payload
            part = self._socket.recv(65536)
            if not part:
                raise EOFError
            self._bytes += part

    def state(self):
        """State of the next state frame, as a dict."""
        while True:
            kind, payload = self.next()
            if kind == 2:
                return vars(State(payload))

    def close(self):
        self._socket.close()

    def wait_for(self, runlevel, seconds):
        """Reads frames until one has this run level. Returns that state."""
        end = time.monotonic() + seconds
        while True:
            state = self.state()
            if state["runlevel"] == runlevel:
                return state
            assert time.monotonic() < end, f"not within {seconds} s: run level {runlevel}, is {state['runlevel']}"


def robot_states(port, seconds=10):
    """Connects a reader to a robot that may not listen yet."""
    end = time.monotonic() + seconds
    while True:
        try:
            return RobotStates(port)
        except OSError:
            assert time.monotonic() < end, f"not within {seconds} s: the robot listens"
            time.sleep(0.02)


def await_run_level(port, level, seconds=60):
    """Waits until the robot has this run level. Connects again if the robot drops this reader as too slow."""
    end = time.monotonic() + seconds
    while True:
        reader = robot_states(port, max(0.0, end - time.monotonic()))
        try:
            return reader.wait_for(level, end - time.monotonic())
        except (EOFError, OSError):
            pass
        finally:
            reader.close()
