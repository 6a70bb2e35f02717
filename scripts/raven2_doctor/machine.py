"""Checks of the kernel: real-time priority, locked memory, time, disk space."""

import ctypes
import errno
import json
import os
import pathlib
import re
import resource
import tempfile
import time

from .findings import fail, last_line, ok, text_of, warn

CAP_IPC_LOCK, CAP_SYS_NICE = 14, 23
PRIORITY = 80            # of the physics thread, config/runtime.yaml
DISK_FAIL, DISK_WARN = 0.2e9, 2e9  # [bytes] of sessions: under 5 minutes, under an hour
RECORD = 0.7e6           # [bytes/s] of a session with everything on
LAUNCHED = "raven2_sessions"  # below the home: output of launch/*.launch
LIMITS = ("as root: printf '@realtime - rtprio 98\\n@realtime - memlock unlimited\\n' > "
          "/etc/security/limits.d/raven2.conf; groupadd realtime; usermod -aG realtime USER; log in again")


def capable(number):
    status = pathlib.Path("/proc/self/status").read_text()
    return bool(int(re.search(r"^CapEff:\s*(\w+)", status, re.MULTILINE).group(1), 16) >> number & 1)


def try_fifo(priority):
    """Error number of asking for SCHED_FIFO, 0 if it is given. In a child: this process stays as it is."""
    child = os.fork()
    if child == 0:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        except OSError as error:
            os._exit(error.errno or 255)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def realtime(machine):
    refused = try_fifo(PRIORITY)
    if refused == 0:
        return [ok(f"SCHED_FIFO {PRIORITY} is given")]
    limit = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    may = capable(CAP_SYS_NICE) or limit >= PRIORITY
    if refused == errno.EPERM and may:
        cgroup = pathlib.Path("/proc/self/cgroup").read_text().strip().splitlines()[-1]
        return [warn(f"SCHED_FIFO is refused although it is permitted: the cpu cgroup ({cgroup}) has no real-time budget",
                     "start from another cgroup, or as root give it cpu.rt_runtime_us; else the daemon runs as DEGRADED_RT")]
    return [warn(f"SCHED_FIFO {PRIORITY} is refused ({os.strerror(refused)}; rtprio limit {limit}): "
                 "the daemon runs as DEGRADED_RT", LIMITS)]


def memory(machine):
    limit = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
    if capable(CAP_IPC_LOCK) or limit == resource.RLIM_INFINITY:
        return [ok("memory may be locked")]
    return [warn(f"memory cannot be locked: the limit is {limit // 1024} KiB", LIMITS)]


def flight_recorder(machine):
    """The folder whose content outlives a killed process."""
    folder = text_of(machine.section("runtime"), "flight_recorder", "none")
    if folder == "none":
        return [ok("no flight recorder: the configuration wants none")]
    if not os.access(folder, os.W_OK | os.X_OK):
        return [fail(f"{folder}, for the flight recorder, cannot be written to",
                     "mount a tmpfs there, or set flight_recorder in runtime.yaml")]
    free = space(folder)
    if free < 64e6:
        return [warn(f"{folder} has {free / 1e6:.0f} MB left, for the flight recorder",
                     "remove what is there, or start the container with --shm-size=256m")]
    return [ok(f"{folder} has {free / 1e6:.0f} MB for the flight recorder")]


def space(folder):
    status = os.statvfs(folder)
    return status.f_bavail * status.f_frsize


def existing(folder):
    """The folder, or the nearest above it that is there."""
    while not folder.exists():
        folder = folder.parent
    return folder


def sessions_in(folder, option):
    place = existing(folder)
    try:
        tempfile.TemporaryFile(dir=place).close()
    except OSError as error:
        return fail(f"{place} cannot be written to: {error.strerror}", f"name another folder than {folder} with {option}")
    free = space(place)
    text = f"{free / 1e9:.1f} GB free for {folder}, {free / RECORD / 60:.0f} minutes of sessions"
    remedy = f"remove old sessions, or name a folder on another disk with {option}"
    return fail(text, remedy) if free < DISK_FAIL else warn(text, remedy) if free < DISK_WARN else ok(text)


def sessions(machine):
    """scripts/run writes to sessions/ of the source tree, programs to that of the current folder, launch files below the
    home (which roslaunch needs to have a name)."""
    found = [sessions_in((machine.root or pathlib.Path.cwd()) / "sessions", "--output")]
    home = machine.environ.get("HOME")
    return found + ([sessions_in(pathlib.Path(home) / LAUNCHED, "output:=DIR")] if home else [])


def sleeps(seconds):
    """[s] how late each sleep of 1 ms ended."""
    late = []
    release = time.monotonic()
    end = release + seconds
    while release < end:
        release = max(release, time.monotonic() - 0.25) + 0.001
        time.sleep(max(0.0, release - time.monotonic()))
        late.append(time.monotonic() - release)
    return sorted(late)


def timing(machine):
    """The daemon's loops where timing_check is built, else sleeps of 1 ms."""
    program = machine.program("timing_check")
    if program is None:
        late = sleeps(1.0)
        p99 = late[int(0.99 * len(late))]
        text = f"sleeps of 1 ms end {1e6 * p99:.0f} us late (99 %), {1e6 * late[-1]:.0f} us at most"
        return [warn(text, "end what else runs, and give priority (realtime, above)") if p99 > 0.001 else ok(text)]
    with tempfile.NamedTemporaryFile(suffix=".json") as file:
        status, text = machine.run(program, "--duration", "2", "--calibrate", "1", "--config", machine.config, "--json",
                                   file.name, timeout=60)
        figures = pathlib.Path(file.name).read_text()
    if not figures:
        return [fail(f"timing_check: {last_line(text)}", "run it by hand: rosrun raven2_trainer timing_check")]
    shares = {loop: timing["on_time"] for loop, timing in json.loads(figures).items()}
    words = ", ".join(f"{loop} {100 * share:.2f} %" for loop, share in shares.items())
    if status != 0 or min(shares.values()) < 0.95:
        return [warn(f"loops on time in 2 s: {words}", "end what else runs; rosrun raven2_trainer timing_check for more")]
    return [ok(f"loops on time in 2 s: {words}")]


def processors(machine):
    usable = len(os.sched_getaffinity(0))
    if usable < 2:
        return [warn("one processor: physics and haptic loop take turns", "give this machine two processors or more")]
    governors = {path.read_text().strip() for path in
                 pathlib.Path("/sys/devices/system/cpu").glob("cpu[0-9]*/cpufreq/scaling_governor")}
    if "powersave" in governors:
        return [warn(f"{usable} processors, some with the governor powersave",
                     "as root: echo performance | tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor")]
    return [ok(f"{usable} processors")]


def clock(machine):
    """The clock source is read in every tick; the wall clock stamps sessions and ROS messages."""
    found = []
    source = pathlib.Path("/sys/devices/system/clocksource/clocksource0/current_clocksource")
    name = source.read_text().strip() if source.exists() else "unknown"
    if name in ("hpet", "acpi_pm", "jiffies", "refined-jiffies"):
        found.append(warn(f"clock source {name}: reading the time takes microseconds",
                          f"as root: echo tsc > {source}, if available_clocksource has it"))
    if is_unsynchronised():
        found.append(warn("the wall clock is not synchronised: stamps of several computers do not agree",
                          "as root: apt-get install chrony, where several computers work together"))
    return found or [ok(f"clock source {name}, the wall clock is synchronised")]


def is_unsynchronised():
    """adjtimex(2) gives TIME_ERROR where nothing keeps the clock."""
    buffer = ctypes.create_string_buffer(512)  # struct timex, modes 0: nothing is set
    return ctypes.CDLL(None, use_errno=True).adjtimex(buffer) == 5
