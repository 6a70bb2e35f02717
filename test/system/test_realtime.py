"""Real time as a user meets it: the daemon is stopped and continued, runs without privileges, runs with --strict."""

import ctypes
import json
import os
import shutil
import signal
import socket
import subprocess
import threading
import time

import pytest

from stack import PROGRAMS, ROOT, Stack, RobotStates, effort, free_ports, itp, listens, urgent, wait_until

NOBODY = 65534
PEDAL_UP, PEDAL_DOWN = 2, 3
PTRACE_ATTACH, PTRACE_DETACH, WALL = 16, 17, 0x40000000  # of Linux; Python has no names for them
needs_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root can become nobody, make cgroups and stop a thread")
# [s] The promise is 1 s. A machine that compiles while the test runs needs more: without SCHED_FIFO the daemon has no
# priority.
REFUSED_WITHIN = effort(10.0, 1.0)
SESSION_READER = """
import json, sys
sys.path.insert(0, sys.argv[1])
import numpy as np
import raven2_session
log = raven2_session.SessionLog(sys.argv[2])
model, haptic = log.ticks["model"], log.haptic["haptic"]
paused = model["mode"] == log.names("tick", "model.mode").index("paused")
linked = model["linked"] == 1
result = {"ticks": len(model), "first": int(model["tick"][0]), "last": int(model["tick"][-1]),
          "elapsed_ms": float(model["time_ns"][-1] - model["time_ns"][0]) / 1e6,
          "pauses": int((np.diff(paused.astype(int)) == 1).sum()), "paused": int(paused.sum())}
if paused.any():
    begin = int(np.argmax(paused))
    end = begin + int(np.argmin(paused[begin:])) if not paused[begin:].all() else len(paused)
    clock = model["session_tick"][begin:end]
    result["clock_moved"] = int(clock[-1] - clock[0])
    result["linked_in_pause"] = int(linked[begin:end].sum())
    result["linked_before"] = bool(linked[begin - 1])
    late = haptic["tick"] > model["tick"][begin] + 50
    late &= haptic["tick"] <= model["tick"][end - 1]
    result["forces_late_in_pause"] = float(np.abs(haptic["force_B"][late]).max()) if late.any() else None
    result["goes_on"] = end < len(paused) and bool(linked[end + 50])
print(json.dumps(result))
"""

DIAGNOSTICS_READER = """
import json, os, signal, sys, threading, time
import rospy
from diagnostic_msgs.msg import DiagnosticArray
changed, told = threading.Condition(), {}
def take(message):
    for status in message.status:
        if status.name.endswith("physics loop"):
            with changed:
                told.update({pair.key: float(pair.value) for pair in status.values})
                changed.notify_all()
rospy.init_node("reader", disable_signals=True)
rospy.Subscriber("/diagnostics", DiagnosticArray, take, queue_size=10)
pid, times = int(sys.argv[1]), []
with changed:
    assert changed.wait_for(lambda: "ticks" in told, 30), "no diagnostics"
for _ in range(int(sys.argv[2])):
    time.sleep(0.53)
    os.kill(pid, signal.SIGSTOP)
    time.sleep(0.2)  # far above what the machine itself does
    before = told["late_runs"]
    os.kill(pid, signal.SIGCONT)
    with changed:
        begin = time.monotonic()
        assert changed.wait_for(lambda: told["late_runs"] > before and told["max_late_us"] >= 190000, 10), told
        times.append(time.monotonic() - begin)
print(json.dumps(times))
"""


class Master:
    """Sends a packet every millisecond from a thread: a slow stroke while the pedal is down."""

    def __init__(self, port):
        self.pedal = False
        self._stop = threading.Event()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", port))
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        sequence, due = 0, time.monotonic()
        while not self._stop.is_set():
            sequence += 1
            step = 5 if sequence % 2000 < 1000 else -5
            try:
                self._socket.send(itp(sequence, self.pedal, (step, 0, 0) if self.pedal else (0, 0, 0)))
            except ConnectionRefusedError:
                pass
            due += 0.001
            time.sleep(max(0.0, due - time.monotonic()))

    def stop(self):
        self._stop.set()
        self._thread.join()


def read_session(stack):
    """Figures of the log, from SESSION_READER. It runs in the system's python, which has numpy."""
    done = subprocess.run(["/usr/bin/python3", "-c", SESSION_READER, os.path.join(ROOT, "scripts"),
                           os.path.join(stack.output, "session.rlog")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def teleoperate(stack):
    """Starts robot, daemon and a master, and presses the pedal until the robot follows. Returns the master."""
    stack.start_robot()
    wait_until(lambda: listens(stack.state_port), 10, "the robot listens")
    stack.start_daemon("--hazard", "none")
    wait_for_run_level(stack, PEDAL_UP, 20)
    master = Master(stack.master_port)
    time.sleep(0.3)
    master.pedal = True
    wait_for_run_level(stack, PEDAL_DOWN, 10)
    return master


def run_level(stack):
    """Run level of the robot, from one new frame. On a busy machine, Python is too slow to read every frame."""
    reader = RobotStates(stack.state_port)
    try:
        return reader.state()["runlevel"]
    finally:
        reader.close()


def wait_for_run_level(stack, level, seconds):
    end = time.monotonic() + seconds
    while run_level(stack) != level:
        assert time.monotonic() < end, f"no run level {level} within {seconds} s"
        time.sleep(0.15)


def pause_process(process, seconds):
    with urgent():  # a test that wakes late stops it for longer
        process.send_signal(signal.SIGSTOP)
        time.sleep(seconds)
        process.send_signal(signal.SIGCONT)


def test_stops_of_a_tenth_of_a_second_lose_no_simulated_time():
    """R3: steps executed = milliseconds elapsed, three stops of 100 ms in between."""
    with Stack() as stack:
        master = teleoperate(stack)
        process, length = stack.processes["simulator"], effort(2.0, 600.0)
        for _ in range(3):
            time.sleep(length / 4)
            pause_process(process, 0.1)
        time.sleep(length / 4)
        assert stack.stop("simulator")[0] == 0, stack.log_text("simulator")
        master.stop()
        timing, session = stack.metrics()["timing"]["physics"], read_session(stack)
        print(session, timing)
        assert session["paused"] == 0
        # On a busy machine, the last tick may start some milliseconds late. A larger difference would be lost time.
        assert abs((session["last"] - session["first"]) - session["elapsed_ms"]) < 25, session
        assert timing["time_slips"] == 0 and timing["lost_ticks"] == 0
        assert timing["longest_late_run"] >= 90, "the stops had no effect: the test proves nothing"


def test_a_stop_of_four_tenths_pauses_the_exercise_until_a_new_pedal_down():
    """R3: one time slip, mode paused, session clock stopped, robot released, force 0. A new pedal-down continues."""
    with Stack() as stack:
        master = teleoperate(stack)
        time.sleep(0.5)
        pause_process(stack.processes["simulator"], 0.4)
        time.sleep(0.7)
        assert run_level(stack) == PEDAL_UP, "the robot was not released"
        master.pedal = False
        time.sleep(0.2)
        master.pedal = True
        wait_for_run_level(stack, PEDAL_DOWN, 5)
        time.sleep(0.5)
        stack.stop("simulator")
        master.stop()
        timing, session = stack.metrics()["timing"], read_session(stack)
        print(session, timing["physics"])
        assert timing["physics"]["time_slips"] == 1 and timing["haptic"]["time_slips"] == 1
        assert timing["physics"]["lost_ticks"] >= 380
        assert session["pauses"] == 1
        assert session["linked_before"] and session["linked_in_pause"] == 0
        assert session["clock_moved"] == 0
        assert session["forces_late_in_pause"] == 0.0
        assert session["goes_on"]


def stop_thread(process, name, seconds):
    """Stops one thread of a process for so long, as a debugger does."""
    (tid,) = [int(entry) for entry in os.listdir(f"/proc/{process.pid}/task")
              if open(f"/proc/{process.pid}/task/{entry}/comm", encoding="ascii").read().strip() == name]
    libc = ctypes.CDLL(None, use_errno=True)
    assert libc.ptrace(PTRACE_ATTACH, tid, None, None) == 0, os.strerror(ctypes.get_errno())
    os.waitpid(tid, WALL)
    time.sleep(seconds)
    assert libc.ptrace(PTRACE_DETACH, tid, None, None) == 0, os.strerror(ctypes.get_errno())


@needs_root
def test_time_that_the_haptic_loop_alone_loses_pauses_too():
    """R3: without force the surgeon must not go on."""
    with Stack() as stack:
        master = teleoperate(stack)
        time.sleep(0.5)
        stop_thread(stack.processes["simulator"], "haptic", 0.4)
        wait_for_run_level(stack, PEDAL_UP, 5)
        time.sleep(0.5)
        stack.stop("simulator")
        master.stop()
        timing, session = stack.metrics()["timing"], read_session(stack)
        print(session, timing)
        assert (timing["haptic"]["time_slips"], timing["physics"]["time_slips"]) == (1, 0)
        assert session["pauses"] == 1


def test_a_late_run_is_on_diagnostics_within_a_second():
    """R7: /diagnostics reports a stop of 200 ms, ten times. rospy starts once per process, so another process reads."""
    ros = free_ports(1)[0]
    with Stack() as stack:
        stack.environment.update(ROS_MASTER_URI=f"http://127.0.0.1:{ros}", ROS_IP="127.0.0.1")
        stack.processes["rosmaster"] = subprocess.Popen(["rosmaster", "--core", "-p", str(ros)], env=stack.environment,
                                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_until(lambda: listens(ros), 30, "the ROS master listens")
        stack.start_daemon("--hazard", "none")
        wait_until(lambda: listens(ros) and os.path.exists(os.path.join(stack.output, "session.rlog")), 30, "ticks")
        done = subprocess.run(["/usr/bin/python3", "-c", DIAGNOSTICS_READER, str(stack.processes["simulator"].pid),
                               str(effort(3, 10))], env=stack.environment, capture_output=True, text=True, timeout=120,
                              check=False)
        assert done.returncode == 0, done.stderr
        times = json.loads(done.stdout)
        print("on /diagnostics after " + " ".join(f"{1000 * each:.0f}" for each in times) + " ms")
        assert stack.stop("simulator")[0] == 0, stack.log_text("simulator")
        assert max(times) <= 1.0


def run_daemon(stack, *arguments, prefix=(), environment=None):
    """Starts a daemon that should end at once with a refusal. Returns (exit code, seconds, output)."""
    command = [*prefix, os.path.join(PROGRAMS, "simulator"), "--config", stack.config, "--output", stack.output,
               "--no-render", "--master-port", stack.master_port, *arguments]
    begin = time.monotonic()
    done = subprocess.run([str(word) for word in command], env=dict(stack.environment, **(environment or {})),
                          capture_output=True, text=True, timeout=20, check=False)
    return done.returncode, time.monotonic() - begin, done.stderr


def give_to_nobody(folder):
    for path, folders, files in os.walk(folder):
        for name in [path, *(os.path.join(path, n) for n in folders + files)]:
            os.chown(name, NOBODY, NOBODY)


AS_NOBODY = ("setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups")


@needs_root
def test_without_privileges_it_runs_and_says_so_and_strict_refuses():
    """R8: as nobody."""
    with Stack() as stack:
        stack.environment["HOME"] = stack.folder  # roscpp writes to it
        give_to_nobody(stack.folder)
        code, seconds, text = run_daemon(stack, "--strict", prefix=AS_NOBODY)
        print(code, seconds, text)
        assert code == 1 and seconds < REFUSED_WITHIN
        for thread, priority in (("physics", 80), ("haptic", 79), ("ingest", 78), ("robot_link", 77), ("sender", 76)):
            assert f"{thread}: SCHED_FIFO {priority} refused" in text
        assert "memory not locked" in text and not os.path.exists(stack.output)
        assert_runs_degraded(stack, AS_NOBODY, "memory not locked")


def assert_runs_degraded(stack, prefix, *reasons):
    """A session without --strict starts its threads, ticks and ends cleanly. It reports the missing privileges."""
    stack.start_robot(prefix=prefix)
    wait_until(lambda: listens(stack.state_port), 30, "the robot listens")
    stack.start_daemon(prefix=prefix)
    wait_until(lambda: "WARNING: DEGRADED_RT" in stack.log_text("simulator"), 30, stack.log_text("simulator"))
    time.sleep(1.0)
    assert stack.stop("simulator", seconds=30)[0] == 0, stack.log_text("simulator")
    assert stack.stop("virtual_raven", seconds=30)[0] == 0
    status = stack.meta()["realtime"]
    print(status, stack.log_text("virtual_raven").splitlines()[0])
    assert status.startswith("DEGRADED_RT: physics: SCHED_FIFO 80 refused")
    for reason in reasons:
        assert reason in status
    assert "DEGRADED_RT: raven_control: SCHED_FIFO 82 refused" in stack.log_text("virtual_raven")
    assert stack.metrics()["timing"]["physics"]["ticks"] > 100


@pytest.fixture(name="cgroup")
def _cgroup():
    """Makes a cpu cgroup (version 1) without a real-time budget. Yields its folder."""
    mounted, mount = None, None
    with open("/proc/mounts", encoding="utf-8") as mounts:
        for line in mounts:
            _, place, kind, options = line.split()[:4]
            if kind == "cgroup" and "cpu" in options.split(","):
                mounted = place
    if mounted is None and os.geteuid() == 0:
        mount = f"/tmp/raven2_cgroup_{os.getpid()}"
        os.mkdir(mount)
        done = subprocess.run(["mount", "-t", "cgroup", "-o", "cpu", "none", mount], capture_output=True, check=False)
        if done.returncode == 0:
            mounted = mount
    folder = os.path.join(mounted or "", f"raven2_test_{os.getpid()}")
    try:
        if mounted is None:
            pytest.skip("no cpu cgroup of version 1 can be mounted here")
        try:
            os.mkdir(folder)
            with open(os.path.join(folder, "cpu.rt_runtime_us"), encoding="ascii") as file:
                if file.read().strip() != "0":
                    pytest.skip("this kernel gives new cpu cgroups a real-time budget")
        except OSError as error:
            pytest.skip(f"no cpu cgroup can be made here: {error}")
        yield folder
    finally:
        if os.path.isdir(folder):
            os.rmdir(folder)
        if mount:
            subprocess.run(["umount", mount], capture_output=True, check=False)
            os.rmdir(mount)


@needs_root
def test_in_a_cgroup_without_real_time_budget_it_runs_and_says_so_and_strict_refuses(cgroup):
    """R8: as root. SCHED_FIFO fails because the cgroup has no real-time budget."""
    inside = ("sh", "-c", f'echo $$ > {cgroup}/tasks && exec "$@"', "sh")
    with Stack() as stack:
        code, seconds, text = run_daemon(stack, "--strict", prefix=inside)
        print(code, seconds, text)
        assert code == 1 and seconds < REFUSED_WITHIN
        assert "physics: SCHED_FIFO 80 refused" in text and "memory not locked" not in text
        assert_runs_degraded(stack, inside)


@needs_root
def test_strict_names_preloaded_libraries_and_files_that_anybody_may_write():
    """S14: --strict reports all reasons at once, while SCHED_FIFO is granted."""
    with Stack() as stack:
        share = os.path.dirname(os.path.dirname(stack.config))
        open_to_all = [os.path.join(share, file) for file in
                       ("config/haptics.yaml", "urdf/raven2.urdf", "urdf/frs_trainer.urdf")]
        for file in open_to_all:
            os.chmod(file, 0o666)
        library = os.path.realpath(shutil.which("true"))  # any file: the loader warns and continues
        code, seconds, text = run_daemon(stack, "--strict", environment={"LD_PRELOAD": library})
        print(code, seconds, text)
        assert code == 1 and seconds < REFUSED_WITHIN
        assert f"LD_PRELOAD is {library}" in text
        for file in open_to_all:
            assert f"{file} is writable by everybody" in text
        assert "refused" not in text and not os.path.exists(stack.output)
        for file in open_to_all:
            os.chmod(file, 0o644)
        stack.start_daemon("--strict", "--duration", "1")
        wait_until(lambda: os.path.exists(os.path.join(stack.output, "session.rlog")), 10, "strict starts where all is well")
        assert stack.stop("simulator")[0] == 0, stack.log_text("simulator")
        assert stack.meta()["realtime"] == "SCHED_FIFO; memory locked"
