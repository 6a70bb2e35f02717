"""The record of a session after its process was killed, its disk was full, or its log was damaged."""

import json
import os
import random
import select
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest.mock

import numpy as np
import pytest

from stack import BUILD, PROGRAMS, ROOT, Stack, effort, wait_until

sys.path.insert(0, os.path.join(ROOT, "scripts"))
sys.dont_write_bytecode = True

import raven2_session  # noqa: E402

# The promises are for a machine that is not overloaded. A busy machine gets more time in proportion.
HEAD_ROOM = max(1.0, os.getloadavg()[0] / os.cpu_count())
KINDS = ("ticks", "haptic", "commands", "requests", "plans", "contacts")
REPORTS = os.path.join(BUILD, "test_results")


class Forces:
    """The daemon's force packets. Their sequence numbers count its haptic ticks. The daemon records each tick before it
    sends it. So the newest number shows from outside which ticks are committed."""

    def __init__(self, port):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self._socket.bind(("127.0.0.1", port))
        self._socket.setblocking(False)

    def newest(self, seconds=0.0):
        """Sequence number of the newest received packet, or 0. Waits up to `seconds` for a packet."""
        newest = 0
        select.select([self._socket], [], [], seconds)
        while True:
            try:
                newest = struct.unpack_from("<I", self._socket.recv(256))[0]
            except BlockingIOError:
                return newest

    def close(self):
        self._socket.close()


def arrays(directory):
    log = raven2_session.Session(directory).log
    return log, [getattr(log, kind) for kind in KINDS]


def assert_whole(log, newest_force):
    """The log has no gap, no record twice, and all records that were committed before `newest_force` was sent."""
    assert log.bad_bytes == 0 and log.lost == 0
    ticks = log.ticks["model"]["tick"]
    assert np.array_equal(ticks, np.arange(ticks[0], ticks[0] + len(ticks)))
    assert len(log.haptic) >= newest_force, "committed haptic records are missing"
    assert ticks[-1] >= log.haptic["haptic"]["tick"][-1] - 1, "committed ticks are missing"


def report(name, figures):
    """Writes figures to a file, for the documentation. The callers assert on them."""
    os.makedirs(REPORTS, exist_ok=True)
    with open(os.path.join(REPORTS, name + ".json"), "w", encoding="utf-8") as file:
        json.dump(figures, file, indent=1)
    print(name, figures)


def cpu_seconds(pid):
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def start_ticking(stack, forces):
    """Starts the daemon and waits for its first force. Returns (process, wall seconds, CPU seconds)."""
    begin = time.monotonic()
    process = stack.start_daemon("--hazard", "none")
    while forces.newest(0.05) == 0:
        assert process.poll() is None and time.monotonic() < begin + 60, stack.log_text("simulator")
    return process, time.monotonic() - begin, cpu_seconds(process.pid)


def kill_at_a_random_moment(stack, forces, source):
    process, wall, cpu = start_ticking(stack, forces)
    time.sleep(source.uniform(0.0, 0.7))
    process.kill()
    process.wait()
    return forces.newest(), wall, cpu


def test_a_killed_daemon_loses_no_committed_record_and_the_next_start_recovers_it():
    source = random.Random(2017)
    figures = {"kills": 0, "from_flight_recorder": [], "restart_s": [], "restart_cpu_s": []}
    with Stack(configure={"runtime": {"start_timeout": 0.0}}) as stack:
        forces = Forces(stack.force_port)
        before = None
        for n in range(effort(5, 100)):
            stack.output = os.path.join(stack.folder, "sessions", str(n))
            newest, wall, cpu = kill_at_a_random_moment(stack, forces, source)
            # The next start recovers this session. If that start is killed too early, the start after it does.
            log, found = arrays(stack.output)
            assert_whole(log, newest)
            assert not log.clean and not log.recovered
            figures["kills"] += 1
            figures["from_flight_recorder"].append(log.from_flight_recorder)
            figures["restart_s"].append(round(wall, 3))
            figures["restart_cpu_s"].append(cpu)
            if before is None:
                before = (stack.output, found)
        # One more start, which runs until all sessions are recovered. Its records must equal those of the reader.
        stack.output = os.path.join(stack.folder, "sessions", "last")
        start_ticking(stack, forces)
        folders = [os.path.join(stack.folder, "sessions", str(n)) for n in range(figures["kills"])]
        wait_until(lambda: all(os.path.exists(os.path.join(f, "recovered.json")) for f in folders), 120, "recovered")
        assert stack.stop("simulator")[0] == 0, stack.log_text("simulator")
        for folder in folders:
            log, _ = arrays(folder)
            assert log.recovered and not log.clean and log.bad_bytes == 0 and log.truncated_bytes == 0
            assert not os.path.lexists(os.path.join(folder, "flight_recorder"))
        for ours, theirs in zip(before[1], arrays(before[0])[1], strict=True):
            assert ours.tobytes() == theirs.tobytes()
        assert raven2_session.Session(stack.output).log.clean
        assert not os.path.exists(os.path.join(stack.output, "recovered.json"))
        forces.close()
    report("record_kills", figures)
    assert max(figures["restart_cpu_s"]) <= 2.0, "at most 2 s of processor time to the first tick"


def test_a_recovered_session_serves_every_tool():
    with Stack() as stack:
        forces = Forces(stack.force_port)
        kill_at_a_random_moment(stack, forces, random.Random(3))
        forces.close()
        found = arrays(stack.output)[1]

        def run(name, *arguments):
            path = next(p for p in (os.path.join(PROGRAMS, name), os.path.join(ROOT, "scripts", name))
                        if os.path.exists(p))
            return subprocess.run([path, *arguments, stack.output], capture_output=True, text=True, check=False)

        done = run("recover_session")
        assert done.returncode == 0 and "was recovered" in done.stderr, done.stderr
        assert "nothing to recover" in run("recover_session").stderr
        log, again = arrays(stack.output)
        assert log.recovered and [a.tobytes() for a in found] == [a.tobytes() for a in again]
        assert run("export_session").returncode == 0
        done = run("session_report")
        assert done.returncode == 0, done.stderr
        assert stack.metrics()["complete"] is False
        with open(os.path.join(stack.output, "recovered.json"), encoding="utf-8") as file:
            assert json.load(file)["ended"] == "unclean"


def test_recovering_a_session_that_runs_is_refused():
    with Stack() as stack:
        forces = Forces(stack.force_port)
        start_ticking(stack, forces)
        done = subprocess.run([os.path.join(PROGRAMS, "recover_session"), stack.output], capture_output=True, text=True,
                              check=False)
        assert done.returncode == 1 and "running program" in done.stderr
        assert stack.stop("simulator")[0] == 0
        forces.close()
        log = raven2_session.Session(stack.output).log
        assert log.clean and not log.recovered and log.lost == 0


def faults_of_loops(pid):
    """{thread: (minor, major) page faults} of the 1 kHz threads."""
    found = {}
    for task in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{task}/stat", encoding="utf-8") as file:
            name, rest = file.read().split("(", 1)[1].rsplit(")", 1)
        if name in ("physics", "haptic"):
            found[name] = (int(rest.split()[7]), int(rest.split()[9]))
    return found


def test_the_queues_in_the_mapped_file_cost_the_loops_no_page_fault():
    with Stack(configure={"runtime": {"start_timeout": 0.0}}) as stack:
        forces = Forces(stack.force_port)
        process, _, _ = start_ticking(stack, forces)
        assert stack.meta()["flight_recorder"].startswith("/dev/shm/"), stack.meta()
        start = forces.newest(0.5)
        wait_until(lambda: forces.newest(0.1) > start + 500, 30, "warm")
        before, start = faults_of_loops(process.pid), forces.newest(0.5)
        # More ticks than the queues hold, so that each of their pages is written again.
        wait_until(lambda: forces.newest(0.1) > start + effort(3000, 60000), 200, "ticks")
        after = faults_of_loops(process.pid)
        report("record_page_faults", {"before": before, "after": after})
        assert stack.stop("simulator")[0] == 0  # a kill would leave the queues' file
        for name in ("physics", "haptic"):
            assert after[name][0] - before[name][0] <= 1 and after[name][1] == before[name][1], (before, after)
        forces.close()


class SmallDisk:
    """A small tmpfs in a separate mount namespace, which a sleeping process keeps alive."""

    def __init__(self, folder, size):
        self.folder = folder
        os.makedirs(folder)
        self._holder = subprocess.Popen(["unshare", "-m", "sh", "-c",
                                         f"mount -t tmpfs -o size={size} tmpfs '{folder}' && echo up && exec sleep 600"],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.works = self._holder.stdout.readline() == b"up\n"
        self.inside = ("nsenter", "-t", str(self._holder.pid), "-m")

    def path(self, *names):
        """Path of a file on the disk, from outside the namespace."""
        return os.path.join(f"/proc/{self._holder.pid}/root", self.folder.lstrip("/"), *names)

    def remount(self, options):
        subprocess.run([*self.inside, "mount", "-o", "remount," + options, self.folder], check=True)

    def close(self):
        self._holder.kill()
        self._holder.wait()
        self._holder.stdout.close()


@pytest.fixture(name="disk")
def small_disk():
    folder = tempfile.mkdtemp(prefix="raven2_disk_")
    disk = SmallDisk(os.path.join(folder, "disk"), "4m") if os.geteuid() == 0 else None
    if disk is None or not disk.works:
        pytest.skip("needs root, and mounts in a separate namespace")
    yield disk
    disk.close()
    shutil.rmtree(folder, ignore_errors=True)


def start_on(disk, stack):
    stack.output = os.path.join(disk.folder, "session")
    stack.start_daemon("--hazard", "none", prefix=disk.inside)
    return disk.path("session", "session.rlog")


def wait_for_alarm(stack, log_path):
    """Waits for the alarm. Returns the seconds from the last growth of the log to the alarm."""
    grown, size, end = time.monotonic(), 0, time.monotonic() + 60
    while "cannot be written" not in stack.log_text("simulator"):
        assert time.monotonic() < end, "no alarm"
        now = os.stat(log_path).st_size if os.path.exists(log_path) else 0
        if now != size:
            grown, size = time.monotonic(), now
        time.sleep(0.005)
    return time.monotonic() - grown


def missing(numbers):
    """How many numbers an ascending sequence skips."""
    steps = np.diff(numbers)
    assert np.all(steps >= 1)
    return int((steps - 1).sum())


def test_a_full_and_a_read_only_disk_cost_only_the_records_that_the_log_says(disk):
    with Stack() as stack:
        forces = Forces(stack.force_port)
        log_path = start_on(disk, stack)
        alarm = wait_for_alarm(stack, log_path)
        start = forces.newest(0.5)
        wait_until(lambda: forces.newest(0.1) > start + 3000, 60, "the loops go on while the disk is full")
        disk.remount("ro")
        start = forces.newest(0.5)
        wait_until(lambda: forces.newest(0.1) > start + 1000, 60, "the loops go on while the disk is read-only")
        size = os.stat(log_path).st_size
        disk.remount("rw,size=64m")
        back = time.monotonic()
        wait_until(lambda: os.stat(log_path).st_size > size, 20, "the log goes on")
        resumed = time.monotonic() - back
        time.sleep(0.5)
        code, _ = stack.stop("simulator")
        assert code == 0, stack.log_text("simulator")
        newest = forces.newest()
        forces.close()
        log = raven2_session.Session(disk.path("session")).log
        report("record_disk_full", {"alarm_s": alarm, "resumed_s": resumed, "gaps": len(log.gaps), "lost": log.lost})
        assert log.clean and log.bad_bytes == 0 and log.truncated_bytes == 0
        assert alarm <= 1.0 * HEAD_ROOM and resumed <= 2.0 * HEAD_ROOM
        lost = log.gaps["lost"].sum(axis=0)
        assert missing(log.ticks["model"]["tick"]) == lost[0] > 1000
        silent = int(log.counts["force_silent"][0])  # packets at the end, which have no tick
        assert len(log.haptic) + lost[1] >= newest - silent
        assert log.names("gap", "reason").index("not_written") in log.gaps["reason"]
        assert stack.log_text("simulator").count("cannot be written") == 1


def test_a_session_that_ends_on_a_full_disk_has_its_footer_and_metrics(disk):
    with Stack() as stack:
        forces = Forces(stack.force_port)
        wait_for_alarm(stack, start_on(disk, stack))
        start = forces.newest(0.5)
        wait_until(lambda: forces.newest(0.1) > start + 500, 60, "ticks")
        code, _ = stack.stop("simulator")
        assert code == 0, stack.log_text("simulator")
        forces.close()
        session = raven2_session.Session(disk.path("session"))
        assert session.log.clean and session.log.bad_bytes == 0 and session.log.truncated_bytes == 0
        physics = session.log.counts["loops"]["ticks"][0, 0]
        assert len(session.log.ticks) + session.log.gaps["lost"].sum(axis=0)[0] == physics
        assert session.metrics["records_dropped"] == session.log.lost > 0
        assert session.meta["wall_duration_s"] > 0


def test_damaged_logs_are_read_alike_in_both_languages_and_lose_only_what_was_hit():
    tool = os.path.join(BUILD, "test_bin", "log_summary")
    if not os.path.exists(tool):
        pytest.skip("the tests are not built")
    folder = tempfile.mkdtemp(prefix="raven2_damage_")
    try:
        base = os.path.join(folder, "base.rlog")
        subprocess.run([tool, "--make", base], check=True)
        with open(base, "rb") as file:
            data = file.read()
        ends, records = record_ends(data)
        assert max(records) > 50 and records.count(1) > 50, "chunks and plain records"
        source = random.Random(2017)
        paths, expected = [], []
        for n in range(effort(200, 1000)):
            at = source.randrange(ends[0], len(data))
            flipped = bytearray(data)
            flipped[at] ^= 1 << source.randrange(8)
            cut = source.randrange(ends[0], len(data))
            hit = next(i for i, end in enumerate(ends) if at < end)
            for name, content, left in ((f"flip{n}", bytes(flipped), sum(records) - records[hit]),
                                        (f"cut{n}", data[:cut], sum(count for end, count in zip(ends, records) if end <= cut))):
                paths.append(os.path.join(folder, name))
                expected.append(left)
                with open(paths[-1], "wb") as file:
                    file.write(content)
        lines = subprocess.run([tool], input="\n".join(paths), capture_output=True, text=True, check=True).stdout
        for path, left, line in zip(paths, expected, lines.splitlines(), strict=True):
            log = raven2_session.SessionLog(path)
            ours = [len(getattr(log, kind)) for kind in (*KINDS, "gaps", "counts")]
            ours += [log.bad_bytes, log.truncated_bytes]
            assert ours == [int(word) for word in line.split()], path
            assert sum(ours[:8]) == left, path
            size = os.path.getsize(path)
            assert (log.bad_bytes + log.truncated_bytes > 0) == (size == len(data) or size not in ends), path
        report("record_damage", {"flips": len(paths) // 2, "cuts": len(paths) // 2})
    finally:
        shutil.rmtree(folder)


def test_formulas_give_the_same_bits_in_both_languages():
    tool = os.path.join(BUILD, "test_bin", "log_summary")
    if not os.path.exists(tool):
        pytest.skip("the tests are not built")
    with tempfile.TemporaryDirectory(prefix="raven2_formulas_") as folder:
        path = os.path.join(folder, "moves.rlog")
        subprocess.run([tool, "--move", path], check=True)
        with unittest.mock.patch.object(raven2_session, "_add_formulas", wraps=raven2_session._add_formulas) as add:
            ticks = raven2_session.SessionLog(path).ticks
            used = [np.count_nonzero(call.args[0].orders & raven2_session.FORMULA_BIT) for call in add.call_args_list]
        assert len(ticks) == 1500 and len(used) == 5 and min(used) > 40, used
        assert subprocess.run([tool, "--ticks", path], check=True, capture_output=True).stdout == ticks.tobytes()


def record_ends(data):
    """Where each record ends, and how many it stands for: 0 the header, a chunk those up to the next one's number."""
    ends, numbers, position = [], [], 0
    while position < len(data):
        size, number = struct.unpack_from("<IQ", data, position + 8)
        position += 24 + size
        ends.append(position)
        numbers.append(number)
    counts = [after - number for number, after in zip(numbers, numbers[1:] + [numbers[-1] + 1])]
    return ends, [0] + counts[1:]
