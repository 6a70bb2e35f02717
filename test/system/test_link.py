"""The TCP link between robot and daemon when a side stalls, when the network breaks, and when many clients connect.

Robot, daemon and test run on one computer and share its CLOCK_MONOTONIC. So `robot.time_ns` in the log shows the true
age of a state when a tick used it."""

import os
import random
import signal
import socket
import struct
import sys
import threading
import time
import zlib

import numpy as np
import pytest

from namespace import Namespace, missing
from stack import ROOT, RobotStates, Stack, effort, itp, listens, wait_until

sys.path.insert(0, os.path.join(ROOT, "scripts"))
import raven2_session  # noqa: E402

PEDAL_UP, PEDAL_DOWN = 2, 3
MS = 1_000_000  # ns
FRAME_AGE = 50 * MS  # an older state must not be used
FRESH_AGE = 20 * MS  # stale_after


class Master(threading.Thread):
    """A console at about 1 kHz. Pedal and increment may change at any time."""

    def __init__(self, port, make_socket=socket.socket):
        super().__init__(daemon=True)
        self.pedal, self.gold = False, (0, 0, 0)
        self._socket = make_socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", port))
        self._stopped, self._sent, self.pressed_ns = False, 0, 0
        self.start()

    def run(self):
        was_down = False
        while not self._stopped:
            pedal, gold = self.pedal, self.gold
            if pedal and not was_down:
                self.pressed_ns = now()  # before the first packet with the pressed pedal
            was_down = pedal
            self._sent += 1
            try:
                self._socket.send(itp(self._sent, pedal, gold))
            except ConnectionRefusedError:
                pass  # the daemon is not up yet
            time.sleep(0.001)

    def play(self, packets, pedal, gold=(0, 0, 0)):
        """So many packets, at least a millisecond apart."""
        self.pedal, self.gold = pedal, gold
        last = self._sent + 1 + packets
        wait_until(lambda: self._sent >= last, 30, "packets")

    def stop(self):
        self._stopped = True
        self.join()
        self._socket.close()


class Ticks:
    """The ticks of a finished session on the shared clock."""

    def __init__(self, stack):
        log = raven2_session.Session(stack.output).log
        self.model, self.robot = log.ticks["model"], log.ticks["robot"]
        self.time = self.model["time_ns"]
        self.fresh = self.model["robot_fresh"] == 1
        self.age = self.time - self.robot["time_ns"]
        self.has_robot = self.robot["frame"] > 0

    def between(self, begin, end):
        return (self.time >= begin) & (self.time < end)

    def first(self, condition, begin):
        """Time [ns] from `begin` to the first tick for which the condition holds."""
        found = self.time[condition & (self.time >= begin)]
        assert len(found) > 0
        return int(found[0] - begin)

    def assert_nothing_old_was_used(self):
        """No tick used a state older than FRAME_AGE, for whatever reason."""
        used = self.age[self.fresh & self.has_robot]
        assert used.max() <= FRAME_AGE, f"a state {used.max() / MS:.1f} ms old was used"
        return used.max() / MS

    def late_share(self, part):
        """Share of the ticks, in a part of the session, that began more than 2 ms after the previous tick."""
        gaps = np.diff(self.time[part])
        return float((gaps > 2 * MS).mean())

    def reach(self, part, arm=0):
        """Largest distance [mm] of the tip from its place in the first tick: (robot, model)."""
        return [1e3 * np.linalg.norm(s["arms"]["p_BT"][part, arm] - s["arms"]["p_BT"][part, arm][0], axis=1).max()
                for s in (self.robot, self.model)]


def ready(stack, prefix=(), inside=lambda function, *arguments: function(*arguments)):
    """Starts the robot, waits until it is homed, and starts the daemon."""
    stack.start_robot(prefix=prefix)
    wait_until(lambda: inside(listens, stack.state_port), 20, "the robot listens")
    states = inside(RobotStates, stack.state_port)
    end = time.monotonic() + 30
    while states.state()["runlevel"] != PEDAL_UP:  # every frame: a reader that skips frames is too slow
        assert time.monotonic() < end, "never homed"
    states.close()
    stack.start_daemon("--hazard", "none", prefix=prefix)
    wait_until(lambda: os.path.exists(os.path.join(stack.output, "session.rlog")), 20, "the daemon runs")


def finish(stack):
    assert stack.stop("simulator")[0] == 0, stack.log_text("simulator")
    stack.assert_counters_add_up()
    assert stack.stop("virtual_raven")[0] == 0, stack.log_text("virtual_raven")  # the code is 1 if frames do not add up
    return Ticks(stack)


def now():
    return time.monotonic_ns()


def pause(process, seconds, meanwhile=lambda: None):
    """Stops a program for `seconds`. Returns the times [ns] of stop and continuation."""
    process.send_signal(signal.SIGSTOP)
    begin = now()
    meanwhile()
    time.sleep(max(0.0, seconds - (now() - begin) / 1e9))
    end = now()
    process.send_signal(signal.SIGCONT)
    return begin, end


def test_a_stalled_robot_is_flagged_and_dropped_and_nothing_old_is_used_after_it():
    """N5: the robot stalls. Also the reverse: the daemon stalls."""
    seconds = effort(2, 10)
    with Stack() as stack:
        ready(stack)
        time.sleep(1.0)
        robot_stop, robot_on = pause(stack.processes["virtual_raven"], seconds)
        time.sleep(1.0)
        dropped = []

        def drop():  # the robot then has one descriptor less
            robot = stack.processes["virtual_raven"]
            begin, held = now(), descriptors(robot)
            wait_until(lambda: descriptors(robot) < held, 3, "the robot drops a daemon that takes nothing")
            dropped.append(now() - begin)

        _, daemon_on = pause(stack.processes["simulator"], seconds, drop)
        time.sleep(1.0)
        ticks = finish(stack)
        stale = stack.metrics()["packets"]["robot_to_daemon"]["rejected"]["stale"]

    flagged = ticks.first(~ticks.fresh, robot_stop)
    lost = ticks.first(ticks.robot["connected"] == 0, robot_stop)
    back = ticks.first(ticks.fresh, robot_on)
    again = ticks.first(ticks.fresh, daemon_on)
    oldest = ticks.assert_nothing_old_was_used()
    before = ticks.late_share(ticks.between(robot_stop - 800 * MS, robot_stop))
    during = ticks.late_share(ticks.between(robot_stop, robot_on))
    print(f"\nN5 robot stopped {seconds} s: flagged after {flagged / MS:.1f} ms, lost after {lost / MS:.0f} ms, fresh "
          f"{back / MS:.0f} ms after it went on; late ticks {100 * before:.2f} % before, {100 * during:.2f} % during; "
          f"daemon stopped {seconds} s: dropped after {dropped[0] / MS:.0f} ms, fresh after {again / MS:.0f} ms, "
          f"{stale} stale frames rejected; oldest state used {oldest:.1f} ms")
    # Every tick judges the age. The daemon's age lacks the fastest transport of a frame: at most 2 ms.
    too_old = ticks.fresh & ticks.has_robot & (ticks.age > FRESH_AGE + 2 * MS)
    assert not too_old.any(), f"{ticks.age[too_old].max() / MS:.1f} ms counted as fresh"
    tick = np.diff(ticks.time[ticks.between(robot_stop - 5 * MS, robot_stop + 50 * MS)]).max()
    seen = ticks.age[~ticks.fresh & (ticks.time >= robot_stop)][0]
    assert seen <= FRESH_AGE + tick + 2 * MS, f"{seen / MS:.1f} ms"
    assert lost <= 2500 * MS and dropped[0] <= 2500 * MS
    assert during <= before + 0.02, "the loop is not disturbed"
    assert back <= 1000 * MS and again <= 1000 * MS
    assert stale > 0, "frames that waited for the daemon are stale"


@pytest.fixture(name="space")
def _space():
    why = missing()
    if why:
        pytest.skip(why)
    with Namespace() as space:
        yield space


def test_a_broken_network_is_found_out_and_heals_without_motion(space):
    """N6: half-open connections; N4: partition, heal, pedal cycle."""
    cycles, dark = effort(2, 20), random.Random(4)
    with Stack(configure={"runtime": {"plan_at": -1.0}}) as stack:  # -1: no plan, which would move the model
        ready(stack, space.prefix, space.run)
        cut = [f"tcp dport {stack.state_port}", f"tcp sport {stack.state_port}", f"udp dport {stack.robot_port}"]
        master = Master(stack.master_port, lambda *kind: space.run(socket.socket, *kind))
        time.sleep(0.5)
        found, events = [], []
        for number in range(cycles):
            master.play(400, True, ((-1, 1)[number % 2], 0, 0))  # the model follows it during the cut
            broken = now()
            space.cut(*cut)
            if number == 0:
                gone = space.connections(stack.state_port)
                assert len(gone) == 1
                wait_until(lambda: not set(gone) & set(space.connections(stack.state_port)), 6, "the robot finds out")
                found.append(now() - broken)
            else:
                time.sleep(dark.uniform(0.3, 2.5))
            space.heal()
            healed = now()
            master.play(1000, False)
            master.play(300, True)
            master.play(200, True, ((5, -5)[number % 2], 0, 0))
            events.append((broken, healed, master.pressed_ns, now()))
        master.stop()
        ticks = finish(stack)

    ticks.assert_nothing_old_was_used()
    lost = [ticks.first(ticks.robot["connected"] == 0, events[0][0])]
    linked = (ticks.model["linked"] == 1) & (ticks.robot["runlevel"] == PEDAL_DOWN)
    fresh = [ticks.first(ticks.fresh, healed) for _, healed, _, _ in events]
    usable = [ticks.first(linked, pressed) for _, _, pressed, _ in events]
    robot_motion, model_motion = np.transpose([ticks.reach(ticks.between(pressed, pressed + 290 * MS))
                                               for _, _, pressed, _ in events])
    moved = [ticks.reach(ticks.between(pressed + 300 * MS, end))[0] for _, _, pressed, end in events]
    print(f"\nN6 found after {lost[0] / MS:.0f} ms by the daemon, {found[0] / MS:.0f} ms by the robot; N4 {cycles} "
          f"cycles: fresh {max(fresh) / MS:.0f} ms after the heal, linked and PEDAL_DN {max(usable) / MS:.0f} ms after "
          f"the pedal, robot moved {robot_motion.max():.4f} mm and model {model_motion.max():.4f} mm in 290 ms of it, "
          f"then followed {min(moved):.2f} mm")
    assert lost[0] <= 4000 * MS and found[0] <= 4000 * MS
    assert max(fresh) <= 1000 * MS
    assert max(usable) <= 100 * MS
    assert robot_motion.max() <= 0.1 and model_motion.max() <= 0.1
    assert min(moved) > 0.05, "the robot follows again"


class Loris(threading.Thread):
    """Clients that each begin a frame, send a byte of it every 0.1 s and never finish. Records how long each lived."""

    FRAME = struct.pack("<4sHHII", b"RV2T", 0x400, 3, 12, 1)

    def __init__(self, port, count):
        super().__init__(daemon=True)
        self.port, self.count, self.lived = port, count, []
        self.start()

    def run(self):
        clients = {}
        for _ in range(self.count):
            client = socket.create_connection(("127.0.0.1", self.port), timeout=5)
            clients[client] = [time.monotonic(), 0]
            self._send(client, clients[client])
            client.setblocking(False)
        dribble = time.monotonic()
        end = dribble + 5
        while clients and time.monotonic() < end:
            for client in [each for each in clients if self._is_closed(each)]:
                self.lived.append(time.monotonic() - clients.pop(client)[0])
                client.close()
            if time.monotonic() > dribble + 0.1:
                dribble = time.monotonic()
                for client, state in clients.items():
                    self._send(client, state)
            time.sleep(0.005)

    def _send(self, client, state):
        try:
            client.send(self.FRAME[state[1]:state[1] + 1])
            state[1] += 1
        except OSError:
            pass  # closed: the next read notices it

    @staticmethod
    def _is_closed(client):
        try:
            while True:
                if not client.recv(65536):
                    return True
        except BlockingIOError:
            return False
        except OSError:
            return True


def served_after(port, seconds=5):
    """Time [s] until a new reader has its first state. It connects repeatedly, as the daemon does."""
    begin = time.monotonic()
    while time.monotonic() < begin + seconds:
        try:
            states = RobotStates(port)
            states.state()
            states.close()
            return time.monotonic() - begin
        except (EOFError, OSError):
            time.sleep(0.1)
    return seconds


def descriptors(process):
    return len(os.listdir(f"/proc/{process.pid}/fd"))


def cycles_of(states, stop):
    """Starts a reader in the background. Returns its list of received cycles, and its thread."""
    cycles = []

    def run():
        while not stop.is_set():
            cycles.append(states.state()["cycle"])

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    return cycles, thread


def test_crowds_that_dribble_and_storms_of_connections_disturb_nobody():
    """N7 and N8."""
    storms = effort(200, 1000)
    with Stack() as stack:
        ready(stack)
        robot = stack.processes["virtual_raven"]
        time.sleep(0.2)
        states, stop = RobotStates(stack.state_port, buffer=1 << 22), threading.Event()
        states.state()
        start = descriptors(robot)
        cycles, reading = cycles_of(states, stop)

        loris = Loris(stack.state_port, 64)
        served = []
        while loris.is_alive():
            served.append(served_after(stack.state_port))
            time.sleep(0.02)
        wait_until(lambda: descriptors(robot) == start, 2, "descriptors back")

        dice = random.Random(8)
        begin = time.monotonic()
        for _ in range(storms):
            visitor = socket.create_connection(("127.0.0.1", stack.state_port), timeout=5)
            visitor.send(dice.randbytes(dice.randrange(1, 700)))
            if dice.random() < 0.5:
                visitor.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            visitor.close()
        storm = time.monotonic() - begin
        after = served_after(stack.state_port)
        wait_until(lambda: descriptors(robot) == start, 2, "descriptors back")
        assert reading.is_alive() and len(cycles) > 100, "a good reader was dropped"
        stop.set()
        reading.join()
        states.close()
        end = now()
        ticks = finish(stack)
        words = stack.log_text("virtual_raven").splitlines()[-1]

    print(f"\nN7 64 dribblers lived {max(loris.lived):.3f} s at most; {len(served)} good readers served within "
          f"{1e3 * max(served):.0f} ms; N8 {storms} connections in {storm:.2f} s, the next reader served within "
          f"{1e3 * after:.0f} ms; descriptors {start} again; {words}")
    assert len(loris.lived) == 64 and max(loris.lived) <= 1.0
    assert len(served) > 5 and max(served) <= 0.1
    assert after <= 1.0
    assert (np.diff(cycles) == 1).all(), "a good reader lost a frame"
    assert ticks.robot["connected"][ticks.has_robot & (ticks.time < end)].all(), "the daemon lost its place"


def test_bad_frames_close_the_connection_and_are_counted():
    """N9: a simple robot in this test sends frames with a wrong length or CRC."""
    hello = frame(1, b"virtual\0", 1)
    damaged = bytearray(hello)
    damaged[-1] ^= 1
    too_long = bytearray(hello)
    too_long[8:12] = struct.pack("<I", 4097)
    with Stack() as stack, socket.create_server(("127.0.0.1", stack.state_port)) as server:
        server.settimeout(10)
        stack.start_daemon("--hazard", "none")
        for bad in (bytes(damaged), bytes(too_long), b"x" * 64):
            link, _ = server.accept()
            link.settimeout(5)
            for part in (hello[:7], hello[7:] + bad):
                link.sendall(part)
                time.sleep(0.02)
            wait_until(lambda link=link: _ended(link), 1, "closed")
            link.close()
        stack.stop("simulator")
        link = stack.assert_counters_add_up()["robot_to_daemon"]
    assert link["rejected"]["bad_frame"] == 3
    assert link["applied"] == 3, "one hello of each connection"


def frame(kind, payload, sequence):
    head = struct.pack("<4sHHII", b"RV2T", 0x400, kind, len(payload), sequence)
    return head + struct.pack("<I", zlib.crc32(payload, zlib.crc32(head))) + payload


def _ended(link):
    try:
        return not link.recv(4096)
    except ConnectionResetError:
        return True
