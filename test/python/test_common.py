"""scripts/common.sh: the functions that scripts/run, scripts/test and scripts/station share."""

import os
import pathlib
import socket
import subprocess

import pytest

COMMON = pathlib.Path(__file__).resolve().parents[2] / "scripts/common.sh"
CMAKE = '''#!/bin/bash
set -e
while [ "$1" != -B ]; do shift; done
mkdir -p "$2"
: >"$2/build.ninja"
'''


@pytest.fixture
def common(tmp_path):
    """Runs lines of bash behind common.sh, in a folder of the user. The fake cmake makes what can be built."""
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/cmake").write_text(CMAKE)
    (tmp_path / "bin/cmake").chmod(0o755)
    (tmp_path / "user").mkdir()

    def run(lines, build=tmp_path / "build", **environment):
        return subprocess.run(["bash", "-c", f"source '{COMMON}'\n{lines}"], cwd=tmp_path / "user", capture_output=True, text=True,
                              timeout=60, check=False, env={**os.environ, "PATH": f"{tmp_path}/bin:/usr/bin:/bin",
                                                            "RAVEN2_TRAINER_BUILD": str(build), **environment})
    return run


def test_a_file_of_the_user_is_found_after_the_first_configure_too(common, tmp_path):
    """`scripts/run --impair bad.yaml` looks for bad.yaml after it has built."""
    (tmp_path / "user/bad.yaml").write_text("")
    done = common("configure; [ -r bad.yaml ] && pwd")
    assert done.stdout == f"{tmp_path}/user\n", done.stderr
    assert (tmp_path / "build/build.ninja").exists()


def test_a_build_folder_is_below_the_folder_of_the_user(common, tmp_path):
    done = common("configure; is_configured && echo $LOGS", build="mine")
    assert done.stdout == f"{tmp_path}/user/mine/logs\n", done.stderr
    assert (tmp_path / "user/mine/build.ninja").exists()


def test_the_last_line_says_that_a_log_cannot_be_written(common, tmp_path):
    """A folder in its place also stops root."""
    (tmp_path / "build/logs/install.log").mkdir(parents=True)
    done = common("step dependencies install.log true; echo went on")
    assert done.returncode == 1 and done.stdout == ""
    last = done.stderr.splitlines()[-1]
    assert last.startswith(f"raven2_trainer: {tmp_path}/build/logs/install.log cannot be written"), done.stderr


def test_a_step_that_fails_ends_the_script_with_its_reason(common, tmp_path):
    done = common("step build build.log sh -c 'echo one; echo \"file.cpp:3: error: no such thing\"; exit 3'; echo went on")
    assert done.returncode == 1 and done.stdout == ""
    last = done.stderr.splitlines()[-1]
    assert "file.cpp:3: error: no such thing" in last and f"see {tmp_path}/build/logs/build.log" in last


@pytest.mark.parametrize("name, kind", [("udp", socket.SOCK_DGRAM), ("tcp", socket.SOCK_STREAM)])
def test_a_port_that_is_taken_is_not_chosen(common, name, kind):
    with socket.socket(socket.AF_INET, kind) as own:
        own.bind(("127.0.0.1", 0))
        taken = own.getsockname()[1]
        chosen = common(f"free_port {name} {taken}").stdout.strip()
        assert chosen.isdigit() and int(chosen) != taken
    assert int(common(f"free_port {name} {taken}").stdout) == taken
    assert int(common(f"free_port {name} {taken} {taken}").stdout) != taken, "another program of the session has it"


def test_ros_is_for_this_computer_whatever_the_user_has_set(common, tmp_path):
    (tmp_path / "build/devel").mkdir(parents=True)
    (tmp_path / "build/devel/setup.bash").write_text("")
    done = common('source_ros; echo "$ROS_IP ${ROS_HOSTNAME-unset}"', ROS_HOSTNAME="robot.example", ROS_IP="192.0.2.7")
    assert done.stdout == "127.0.0.1 unset\n", done.stderr
