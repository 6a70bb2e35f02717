"""Addresses of a real robot's computer on the command line. The daemon connects to that address, the bridge serves its
frames there. Needs the built programs, in $RAVEN2_TRAINER_BUILD or build/. Uses the loopback interface only."""

import os
import pathlib
import socket
import subprocess
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"
ROBOT = "127.0.0.3"  # every address of 127.0.0.0/8 is this computer's; the configuration says 127.0.0.1


@pytest.fixture(name="start")
def fixture_start(tmp_path):
    """Starts a program without a ROS master."""
    started = []

    def start(name, *arguments):
        environment = {**os.environ, "ROS_MASTER_URI": "http://127.0.0.1:1", "ROS_HOME": str(tmp_path)}
        started.append(subprocess.Popen([PROGRAMS / name, *arguments], env=environment, cwd=tmp_path,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        return started[-1]

    yield start
    for program in started:
        program.terminate()
        program.wait(timeout=60)


def free_port(kind, address="127.0.0.1"):
    with socket.socket(socket.AF_INET, kind) as free:
        free.bind((address, 0))
        return str(free.getsockname()[1])


def test_the_daemon_looks_for_the_robot_there(start, tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as robot:
        robot.bind((ROBOT, 0))
        robot.listen()
        robot.settimeout(60)
        udp = [free_port(socket.SOCK_DGRAM) for _ in range(3)]
        start("simulator", "--robot-host", ROBOT, "--state-port", str(robot.getsockname()[1]), "--master-port", "0",
              "--robot-port", udp[0], "--force-port", udp[1], "--sight-port", udp[2], "--hazard", "none", "--no-render",
              "--output", str(tmp_path / "session"))
        link, _ = robot.accept()
        link.close()


def test_the_bridge_serves_its_frames_there_and_nowhere_else(start):
    port = free_port(socket.SOCK_STREAM, ROBOT)
    program = start("raven_state_bridge", "--bind-address", ROBOT, "--state-port", port)
    for _ in range(600):
        try:
            with socket.create_connection((ROBOT, int(port)), timeout=5) as link:
                assert link.recv(4) != b"", "a hello"
                break
        except ConnectionRefusedError:
            assert program.poll() is None
            time.sleep(0.1)
    else:
        pytest.fail("nobody listens")
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", int(port)), timeout=5)


@pytest.mark.parametrize("name, option", [("simulator", "--robot-host"), ("raven_state_bridge", "--bind-address")])
def test_what_is_no_address_is_refused(name, option):
    result = subprocess.run([PROGRAMS / name, option, "raven.local"], capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode != 0 and option in result.stderr
