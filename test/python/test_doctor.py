"""scripts/doctor: each check reports the faults of an environment made here, and says what to do about them."""

import contextlib
import errno
import json
import os
import pathlib
import socket
import subprocess
import sys
import threading
import xmlrpc.server

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from raven2_doctor import links, machine, ros, software  # noqa: E402
from raven2_doctor.findings import FAIL, OK, WARN, Finding, Machine, fail, ok, warn  # noqa: E402

DOCTOR = ROOT / "scripts/doctor"
SYSTEM = "/usr/bin:/bin:/usr/sbin:/sbin"


def script(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(0o755)


@pytest.fixture
def place(tmp_path):
    """A source tree with a build that is newer than its source."""
    (tmp_path / "src").mkdir()
    (tmp_path / "src/one.cpp").write_text("")
    (tmp_path / "package.xml").write_text("<package><version>1.2.3</version></package>")
    os.utime(tmp_path / "src/one.cpp", (1000, 1000))
    script(tmp_path / "build/devel/lib/raven2_trainer/simulator", "echo 1.2.3\n")
    script(tmp_path / "scripts/install_dependencies",
           'cd "$(dirname "$0")"\n[ "$1" = --list ] && echo stress-ng\n'
           'if [ "$1" = --missing ] && [ -e missing ]; then cat missing; exit 1; fi\nexit 0\n')
    script(tmp_path / "bin/rospack", f"echo {tmp_path}/build/devel/share/raven2_trainer\n")
    (tmp_path / "config").mkdir()
    (tmp_path / "config/trainer.yaml").write_text("network: network.yaml  # addresses\nruntime: runtime.yaml\n")
    (tmp_path / "config/runtime.yaml").write_text(f"flight_recorder: {tmp_path} # folder\n")
    return tmp_path


@pytest.fixture
def here(place):
    return Machine(place, place / "build", place / "config/trainer.yaml", {"PATH": f"{place}/bin:{SYSTEM}"})


def statuses(found):
    return [finding.status for finding in found]


def only(found, status):
    assert statuses(found) == [status], [finding.what for finding in found]
    return found[0]


def test_a_finding_that_is_not_well_says_what_to_do():
    assert (ok("well").status, warn("so so", "rest").remedy, fail("bad", "run").status) == (OK, "rest", FAIL)
    for wrong in ((WARN, "so so", ""), (FAIL, "bad", ""), (OK, "well", "rest"), (FAIL, "two\nlines", "x"), ("MAYBE", "x", "y")):
        with pytest.raises(ValueError):
            Finding(*wrong)


# ---- packages, Python, the build -------------------------------------------------------------------------------------

@pytest.mark.parametrize("version, status", [("12.11", OK), ("13.1", OK), ("13", OK), ("11.9", WARN), ("trixie/sid", WARN), ("", WARN)])
def test_the_systems_that_the_readme_names_are_well(here, place, monkeypatch, version, status):
    assert "You need Debian 12 or 13 " in (ROOT / "README.md").read_text()
    (place / "debian_version").write_text(version + "\n")
    monkeypatch.setattr(software, "DEBIAN", place / "debian_version")
    only(software.system(here), status)


def test_missing_packages_fail_those_of_the_tests_warn(here, place):
    assert only(software.packages(here), OK)
    (place / "scripts/missing").write_text("libode-dev\nstress-ng\n")
    needed, of_tests = software.packages(here)
    assert (needed.status, of_tests.status) == (FAIL, WARN)
    assert "libode-dev" in needed.what and "stress-ng" not in needed.what
    assert "stress-ng" in of_tests.what and str(place) in needed.remedy


def test_a_script_that_cannot_tell_is_not_taken_for_a_list_of_packages(here, place):
    script(place / "scripts/install_dependencies", "echo 'dpkg-query: not found'; exit 1\n")
    assert "dpkg-query: not found" in only(software.packages(here), FAIL).what


def test_a_python_that_shadows_debians_is_found(here, place):
    assert only(software.python(here), OK)
    script(place / "bin/python3", "exit 0\n")
    assert str(place / "bin/python3") in only(software.python(here), WARN).what
    (place / "bin/python3").unlink()
    here.environ["VIRTUAL_ENV"] = "/some/where"
    assert "VIRTUAL_ENV" in only(software.python(here), WARN).remedy


def test_modules_that_debians_python_lacks_are_found(here, place):
    (place / "numpy.py").write_text("raise ImportError('no such thing')\n")
    here.environ["PYTHONPATH"] = str(place)
    assert "no such thing" in only(software.python(here), FAIL).what


def test_a_build_is_there_of_the_version_and_up_to_date(here, place):
    assert "1.2.3" in only(software.build(here), OK).what
    future = (place / "build/devel/lib/raven2_trainer/simulator").stat().st_mtime + 10
    os.utime(place / "src/one.cpp", (future, future))
    assert "src/one.cpp" in only(software.build(here), WARN).what
    (place / "package.xml").write_text("<package><version>1.3.0</version></package>")
    assert "1.3.0" in only(software.build(here), FAIL).what
    script(place / "build/devel/lib/raven2_trainer/simulator", "echo libode.so.8: not found; exit 127\n")
    assert "libode.so.8: not found" in only(software.build(here), FAIL).what
    (place / "build/devel/lib/raven2_trainer/simulator").unlink()
    assert "cmake --build" in only(software.build(here), FAIL).remedy


def test_a_build_for_another_python_is_found(here, place):
    cache = place / "build/CMakeCache.txt"
    cache.write_text("PYTHON_EXECUTABLE:FILEPATH=/usr/bin/python3\n")
    assert statuses(software.build(here)) == [OK]
    cache.write_text("PYTHON_EXECUTABLE:FILEPATH=/opt/conda/bin/python3\n")
    assert "/opt/conda" in software.build(here)[1].what and statuses(software.build(here)) == [OK, FAIL]


def test_ffmpeg_is_there_and_has_the_encoder(here, place):
    script(place / "bin/ffmpeg", "echo ' V..... libx264 H.264'\n")
    assert only(software.ffmpeg(here), OK)
    script(place / "bin/ffmpeg", "echo ' V..... mpeg4'\n")
    assert "libx264" in only(software.ffmpeg(here), FAIL).what
    here.environ["PATH"] = "/dev/null"
    assert "apt-get install ffmpeg" in only(software.ffmpeg(here), FAIL).remedy


@pytest.mark.parametrize("library", ["auto", "osmesa", "egl"])
def test_either_opengl_draws(here, library):
    here.environ["RAVEN2_TRAINER_GL"] = library
    found = software.opengl(here)
    if "neither" in found[0].what:
        pytest.skip(f"NOT CHECKED: {found[0].what}")
    assert library in only(found, OK).what.replace("osmesa", "osmesa auto").replace("egl", "egl auto")


def test_what_it_says_when_nothing_is_drawn(here, monkeypatch, place):
    (place / "probe.py").write_text("import sys\nsys.exit('no context')\n")
    monkeypatch.setattr(software, "PROBE", place / "probe.py")
    assert "no context" in only(software.opengl(here), FAIL).what


def test_a_display_must_answer(here):
    assert "DISPLAY" in only(software.display(here), WARN).remedy
    here.environ["DISPLAY"] = ":4711"
    assert ":4711" in only(software.display(here), WARN).what
    here.environ["DISPLAY"] = "nonsense"
    assert only(software.display(here), WARN)


def test_files_of_the_configuration_must_be_there(here, place):
    assert "network" in only(software.configuration(here), FAIL).what
    here.config = place / "none.yaml"
    assert "none.yaml" in only(software.configuration(here), FAIL).what
    here.config = ROOT / "config/trainer.yaml"
    assert only(software.configuration(here), OK)


# ---- ROS -------------------------------------------------------------------------------------------------------------

def test_the_environment_is_sourced_and_of_this_build(here, place):
    assert only(ros.environment(here), OK)
    script(place / "bin/rospack", "echo /opt/other/share/raven2_trainer\n")
    assert "/opt/other" in only(ros.environment(here), WARN).what
    script(place / "bin/rospack", "echo '[rospack] Error: package not found'; exit 1\n")
    assert f"source {place}/build/devel/setup.bash" in only(ros.environment(here), WARN).remedy
    here.environ["PATH"] = "/dev/null"
    assert only(ros.environment(here), FAIL)


def test_an_installed_package_is_found_beside_its_programs(here, place, monkeypatch):
    here.root = here.build = None
    monkeypatch.setattr(ros, "INSTALLED", place / "share/raven2_trainer")
    script(place / "bin/rospack", f"echo {place}/share/raven2_trainer\n")
    assert only(ros.environment(here), OK), "wherever the configuration is"
    script(place / "bin/rospack", "echo /home/somebody/raven2_trainer\n")
    assert "/home/somebody" in only(ros.environment(here), WARN).what


def test_addresses_must_be_this_computers(here):
    here.environ["ROS_IP"] = "127.0.0.1"
    assert only(ros.addresses(here), OK)
    here.environ["ROS_IP"] = "192.0.2.1"  # of no computer (RFC 5737)
    assert "not this computer" in only(ros.addresses(here), FAIL).what
    here.environ["ROS_HOSTNAME"] = "no-such-host.invalid"  # counts before ROS_IP
    assert "does not resolve" in only(ros.addresses(here), FAIL).what


def test_a_name_of_this_computer_that_does_not_resolve_is_found(here, monkeypatch):
    monkeypatch.setattr(ros.socket, "gethostname", lambda: "no-such-host.invalid")
    assert "/etc/hosts" in only(ros.addresses(here), WARN).remedy


@pytest.fixture
def answering():
    """Port of a server that answers getPid."""
    with xmlrpc.server.SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as server:
        server.register_function(lambda caller: (1, "", 4711), "getPid")
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server.server_address[1]
        server.shutdown()
        thread.join()


def test_a_master_answers_is_not_there_or_is_none(here, answering):
    here.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{answering}"
    assert "4711" in only(ros.master(here), OK).what
    with socket.socket() as idle:
        idle.bind(("127.0.0.1", 0))  # nobody listens, nobody else can
        here.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{idle.getsockname()[1]}"
        assert "roscore" in only(ros.master(here), WARN).remedy
    here.environ["ROS_MASTER_URI"] = "localhost:11311"
    assert "http://HOST:PORT" in only(ros.master(here), FAIL).what
    here.environ["ROS_MASTER_URI"] = "http://no-such-host.invalid:11311"
    assert "does not resolve" in only(ros.master(here), FAIL).what


def test_a_master_that_hangs_is_given_up(here, monkeypatch):
    monkeypatch.setattr(ros, "TIMEOUT", 0.2)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        here.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{silent.getsockname()[1]}"
        assert "no ROS master" in only(ros.master(here), FAIL).what


# ---- ports -----------------------------------------------------------------------------------------------------------

def free_ports():
    """Five that nobody holds now, neither for UDP nor for TCP."""
    with contextlib.ExitStack() as held:
        numbers = [free_for_both(held) for _ in links.PORTS]
    return dict(zip(links.PORTS, numbers))


def free_for_both(held):
    while True:
        with contextlib.ExitStack() as mine:
            pair = [mine.enter_context(socket.socket(socket.AF_INET, kind)) for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM)]
            pair[0].bind(("127.0.0.1", 0))
            number = pair[0].getsockname()[1]
            try:
                pair[1].bind(("127.0.0.1", number))
            except OSError:
                continue
            held.push(mine.pop_all())
            return number


def write_network(place, numbers, address="127.0.0.1"):
    lines = [f"bind_address: {address}   # IPv4"] + [f"{name}: {number}  # [0, 65535]" for name, number in numbers.items()]
    (place / "config/network.yaml").write_text("\n".join(lines) + "\n")


def test_ports_are_free(here, place):
    numbers = free_ports()
    write_network(place, numbers)
    assert str(numbers["state_port"]) in only(links.ports(here), OK).what


@pytest.mark.parametrize("name,kind", links.PORTS.items())
def test_a_port_that_is_held_is_found_with_who_holds_it(here, place, name, kind):
    numbers = free_ports()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM if kind == "udp" else socket.SOCK_STREAM) as link:
        link.bind(("127.0.0.1", 0))
        if kind == "tcp":
            link.listen()
        numbers[name] = link.getsockname()[1]
        write_network(place, numbers)
        found = only(links.ports(here), FAIL)
        assert f"{name} {numbers[name]}" in found.what and f"({os.getpid()})" in found.what
        assert f"kill {os.getpid()}" in found.remedy


@pytest.mark.parametrize("address", ["localhost", "0.0.0.0", "127.0.0.2"])
def test_other_addresses_of_this_computer_are_well(here, place, address):
    write_network(place, free_ports(), address)
    assert only(links.ports(here), OK)


def test_an_address_that_is_not_this_computers_is_told_once(here, place):
    write_network(place, free_ports(), "192.0.2.1")  # of no computer (RFC 5737)
    found = only(links.ports(here), FAIL)
    assert "192.0.2.1 is not this computer's" in found.what and "hostname -I" in found.remedy


@pytest.mark.parametrize("address", ["everywhere", "999.1.1.1"])
def test_an_address_that_is_none_is_found(here, place, address):
    write_network(place, free_ports(), address)
    assert "no IPv4 address" in only(links.ports(here), FAIL).what


@pytest.mark.parametrize("why,words", [(errno.EACCES, "below 1024"), (errno.ENOBUFS, "No buffer space")])
def test_a_port_that_is_refused_is_not_held_by_anybody(here, place, monkeypatch, why, words):
    numbers = free_ports()
    write_network(place, numbers)
    monkeypatch.setattr(links, "refused", lambda address, kind, port: why if port == numbers["force_port"] else 0)
    found = only(links.ports(here), FAIL)
    assert f"force_port {numbers['force_port']}" in found.what and words in found.what
    assert "held" not in found.what and "kill" not in found.remedy


def test_a_session_that_runs_is_no_failure(monkeypatch):
    monkeypatch.setattr(links, "holder", lambda kind, port: ("virtual_raven", 12))
    assert links.held("state_port", "tcp", 1).status == WARN
    monkeypatch.setattr(links, "holder", lambda kind, port: ("raven_state_bri", 12))  # the kernel shortens the name
    assert links.held("state_port", "tcp", 1).status == WARN
    monkeypatch.setattr(links, "holder", lambda kind, port: None)
    assert links.held("state_port", "tcp", 1).status == FAIL


def test_one_port_for_two_things_and_port_0(here, place):
    numbers = free_ports()
    numbers["force_port"] = numbers["robot_port"]
    write_network(place, numbers)
    assert "twice" in only(links.ports(here), FAIL).what
    numbers["force_port"] = 0  # any
    numbers["state_port"] = numbers["robot_port"]  # TCP and UDP do not meet
    write_network(place, numbers)
    assert only(links.ports(here), OK)


# ---- the kernel ------------------------------------------------------------------------------------------------------

def test_priority_that_is_refused_is_found_with_the_reason(here, monkeypatch):
    monkeypatch.setattr(machine, "try_fifo", lambda priority: 0)
    assert only(machine.realtime(here), OK)
    monkeypatch.setattr(machine, "try_fifo", lambda priority: machine.errno.EPERM)
    monkeypatch.setattr(machine, "capable", lambda number: True)
    assert "cgroup" in only(machine.realtime(here), WARN).what
    monkeypatch.setattr(machine, "capable", lambda number: False)
    monkeypatch.setattr(machine.resource, "getrlimit", lambda which: (0, 0))
    assert "rtprio" in only(machine.realtime(here), WARN).remedy


def test_the_probe_of_priority_leaves_this_process_as_it_is():
    before = os.sched_getscheduler(0)
    assert machine.try_fifo(0) == machine.errno.EINVAL  # SCHED_FIFO begins at 1
    assert os.sched_getscheduler(0) == before


def test_memory_that_cannot_be_locked_is_found(here, monkeypatch):
    monkeypatch.setattr(machine, "capable", lambda number: False)
    monkeypatch.setattr(machine.resource, "getrlimit", lambda which: (65536, 65536))
    assert "64 KiB" in only(machine.memory(here), WARN).what
    monkeypatch.setattr(machine, "capable", lambda number: number == 14)
    assert only(machine.memory(here), OK)


def test_the_flight_recorders_folder(here, place):
    assert only(machine.flight_recorder(here), OK if machine.space(place) >= 64e6 else WARN)
    (place / "config/runtime.yaml").write_text(f"flight_recorder: {place}/none\n")
    assert f"{place}/none" in only(machine.flight_recorder(here), FAIL).what
    (place / "config/runtime.yaml").write_text("flight_recorder: none\n")
    assert only(machine.flight_recorder(here), OK)


@pytest.mark.parametrize("free,status", [(0.1e9, FAIL), (1e9, WARN), (50e9, OK)])
def test_space_for_sessions(here, monkeypatch, free, status):
    monkeypatch.setattr(machine, "space", lambda folder: free)
    assert only(machine.sessions(here), status)


def test_space_for_sessions_of_launch_files(here, place, monkeypatch):
    """The home folder is on another disk, which is full. The launch files name the folder that the check names."""
    here.environ["HOME"] = str(place / "home")
    (place / "home").mkdir()
    monkeypatch.setattr(machine, "space", lambda folder: 0 if folder == place / "home" else 50e9)
    of_the_tree, of_the_home = machine.sessions(here)
    assert (of_the_tree.status, of_the_home.status) == (OK, FAIL)
    assert f"{place}/home/{machine.LAUNCHED}" in of_the_home.what and "output:=DIR" in of_the_home.remedy
    for name in ("training", "hardware"):
        assert f'"$(env HOME)/{machine.LAUNCHED}/' in (ROOT / f"launch/{name}.launch").read_text()


def test_a_folder_of_sessions_that_cannot_be_written_to(here, place, monkeypatch):
    def refuse(dir):
        raise OSError(machine.errno.EROFS, "Read-only file system")
    monkeypatch.setattr(machine.tempfile, "TemporaryFile", refuse)
    assert "Read-only" in only(machine.sessions(here), FAIL).what


FIGURES = '{"physics": {"on_time": %s}, "haptic": {"on_time": 0.999}}'


@pytest.mark.parametrize("share,status,expected", [("0.998", 0, OK), ("0.90", 0, WARN), ("0.998", 1, WARN)])
def test_the_loops_rhythm_is_what_timing_check_says(here, place, share, status, expected):
    script(place / "build/devel/lib/raven2_trainer/timing_check",
           f"while [ \"$1\" != --json ]; do shift; done\necho '{FIGURES % share}' >\"$2\"\nexit {status}\n")
    assert f"physics {100 * float(share):.2f} %" in only(machine.timing(here), expected).what


@pytest.mark.parametrize("late", ["physics", "haptic"])
def test_one_loop_that_is_late_is_enough(here, place, late):
    figures = json.dumps({loop: {"on_time": 0.90 if loop == late else 0.999} for loop in ("physics", "haptic")})
    script(place / "build/devel/lib/raven2_trainer/timing_check", f"while [ \"$1\" != --json ]; do shift; done\necho '{figures}' >\"$2\"\n")
    assert f"{late} 90.00 %" in only(machine.timing(here), WARN).what


def test_a_timing_check_that_breaks_is_told(here, place):
    script(place / "build/devel/lib/raven2_trainer/timing_check", "echo 'trainer.yaml:3: unknown key'; exit 1\n")
    assert "unknown key" in only(machine.timing(here), FAIL).what


def test_without_timing_check_sleeps_are_looked_at(here, monkeypatch):
    monkeypatch.setattr(machine, "sleeps", lambda seconds: [1e-4] * 99 + [5e-4])
    assert "500 us at most" in only(machine.timing(here), OK).what
    monkeypatch.setattr(machine, "sleeps", lambda seconds: [2e-3] * 100)
    assert only(machine.timing(here), WARN)


def test_a_clock_that_nothing_keeps_is_found(here, monkeypatch):
    monkeypatch.setattr(machine, "is_unsynchronised", lambda: True)
    assert "synchronised" in machine.clock(here)[-1].what and machine.clock(here)[-1].status == WARN


# ---- all of it -------------------------------------------------------------------------------------------------------

def doctor(*arguments, **environment):
    result = subprocess.run([DOCTOR, *arguments], capture_output=True, text=True, timeout=300, check=False,
                            env={"PATH": SYSTEM, "HOME": "/dev/null", **environment})
    assert result.stderr == ""
    return result


def test_everything_is_looked_at_and_every_trouble_has_a_remedy(place):
    """A bad environment: nothing is built, another Python, no ROS master, a configuration without ports."""
    (place / "config/network.yaml").unlink(missing_ok=True)
    script(place / "bin/python3", "exit 1\n")
    result = doctor("--json", "--config", place / "config/trainer.yaml", PATH=f"{place}/bin:{SYSTEM}", ROS_IP="192.0.2.1",
                    ROS_MASTER_URI="nonsense", RAVEN2_TRAINER_BUILD=str(place / "nowhere"), DISPLAY=":4711")
    found = json.loads(result.stdout)
    assert result.returncode == 1
    assert len({entry["check"] for entry in found}) == 19
    for entry in found:
        assert set(entry) == {"check", "status", "what", "remedy"} and entry["what"]
        assert (entry["status"] == "OK") == (entry["remedy"] == ""), entry
        assert "could not be checked" not in entry["what"], entry
    bad = {entry["check"] for entry in found if entry["status"] == "FAIL"}
    assert {"build", "configuration", "addresses", "master", "ports"} <= bad


def test_lines_and_status(place):
    write_network(place, free_ports())
    result = doctor("--only", "ports,flight_recorder", "--config", place / "config/trainer.yaml")
    assert result.returncode == 0
    assert [line.split()[1] for line in result.stdout.splitlines() if line[0] != " "] == ["ports", "flight_recorder"]
    (place / "config/network.yaml").write_text("bind_address: everywhere\n")
    result = doctor("--only", "ports", "--config", place / "config/trainer.yaml")
    assert result.returncode == 1
    assert result.stdout.startswith("FAIL  ports") and result.stdout.splitlines()[1].strip().startswith("-> ")


def test_a_check_that_breaks_does_not_end_the_others(place):
    (place / "config/network.yaml").write_bytes(b"bind_address: 127.0.0.1\nmaster_port: many\n")
    result = doctor("--json", "--only", "ports,processors", "--config", place / "config/trainer.yaml")
    found = json.loads(result.stdout)
    assert [entry["check"] for entry in found] == ["ports", "processors"]
    assert "many" in found[0]["what"] and found[0]["status"] == "FAIL"


def test_unknown_checks_are_refused():
    result = subprocess.run([DOCTOR, "--only", "ports,nonsense"], capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 2 and "nonsense" in result.stderr
