"""Tests how the station's programs find their folders, and how they end or start again after signals."""

import asyncio
import contextlib
import http.client
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import time
import types

import psutil
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from raven2_station import access, server  # noqa: E402
from station_parts import PROGRAM, supervised  # noqa: E402


def test_the_station_takes_its_folders_from_where_it_is():
    text = (ROOT / "scripts/raven2_station/station").read_text()
    module = types.ModuleType("entry")
    module.__file__ = str(ROOT / "scripts/raven2_station/station")
    exec(compile(text.split("if __name__")[0], module.__file__, "exec"), module.__dict__)  # noqa: S102
    share, programs, scripts = module.places()
    assert share == ROOT and scripts == ROOT / "scripts" and programs.name == "raven2_trainer"
    for wrong in (["--port", "0"], ["--port", "70000"], ["--tls-key", "x"], ["--nonsense"]):
        with pytest.raises(SystemExit):
            module.parse(wrong)
    with pytest.raises(SystemExit, match="password"):
        module.password_hash(module.parse(["--bind", "0.0.0.0"]))


def test_the_station_ends_without_waiting_for_pages(monkeypatch):
    monkeypatch.setattr(server, "CLOSE_LIMIT", 0.05)

    async def close(**_):
        await asyncio.sleep(3600)

    pages = {number: types.SimpleNamespace(socket=types.SimpleNamespace(close=close)) for number in range(3)}
    asyncio.run(asyncio.wait_for(server.close_pages(types.SimpleNamespace(clients=pages)), 5))


@contextlib.contextmanager
def running(*command, **options):
    """A process that ends with the test, even if the test fails."""
    with subprocess.Popen(command, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def survivors(pids):
    """Those that still run. Kills them."""
    found = [psutil.Process(pid) for pid in pids if psutil.pid_exists(pid)]
    alive = psutil.wait_procs(found, timeout=5)[1]
    for process in alive:
        process.kill()
    return alive


# The station with a session of programs that need a second to end.
SERVER = """
import pathlib, sys, types
sys.path.insert(0, sys.argv[1])
from aiohttp import web
from raven2_station import server
folder = pathlib.Path(sys.argv[2])
options = types.SimpleNamespace(share=sys.argv[3], programs=folder / "programs", scripts=folder, sessions=folder / "sessions", config="",
                                robot="", scale=None, password_hash=None, local=True, port=int(sys.argv[4]))
app = server.make_app(options)
app[server.STATION].link._command = ["sleep", "60"]

async def begin(_):
    await app[server.STATION].supervisor.start({"driver": "browser"})
app.on_startup.append(begin)
web.run_app(app, host="127.0.0.1", port=options.port, print=lambda _: print("serves", flush=True))
"""


def test_a_second_signal_leaves_no_program_running(known, tmp_path):
    supervised(tmp_path, known, PROGRAM.replace("exec sleep 60", "trap 'sleep 0.5; exit' TERM; while :; do sleep 0.05; done"))
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-c", SERVER, str(ROOT / "scripts"), str(tmp_path), str(ROOT), str(port)]
    with running(*command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "serves\n"
        listed = json.loads((tmp_path / "sessions/station_logs/processes.json").read_text())["processes"]
        pids = [pid for pid, _ in listed.values()]
        (tmp_path / "sessions/station_logs/hands_away").touch()
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
        connection.request("GET", "/")
        cookie = connection.getresponse().getheader("Set-Cookie")
        process.send_signal(signal.SIGINT)
        said = process.stdout.readline()
        for number in (signal.SIGINT, signal.SIGTERM):
            process.send_signal(number)
        status = process.wait(30)
    assert len(pids) == 3 and survivors(pids) == []
    assert status == 0 and "ends the session" in said
    assert not (tmp_path / "sessions/station_logs/hands_away").exists(), "the next session begins with the hands"
    token = cookie.split("=", 1)[1].split(";")[0]
    assert access.Access(None, tmp_path / "sessions/station_logs/logins.json").knows(token), "a station that starts again knows its pages"
    assert cookie.startswith(f"raven2_station_{port}=") and "SameSite=Lax" in cookie and "HttpOnly" in cookie


COMMON = """ROOT={folder} LOGS={folder}
step() {{ :; }}; configure_and_build() {{ :; }}; source_ros() {{ :; }}; free_port() {{ echo 12345; }}; say() {{ echo "$*"; }}
"""


def started(folder, name, count):
    """Process number and arguments of each start that substitutes() noted, once there are `count`."""
    until = time.monotonic() + 20
    file, lines = folder / f"{name}.started", []
    while len(lines) < count and time.monotonic() < until:
        time.sleep(0.05)
        lines = file.read_text().splitlines() if file.exists() else []
    return [line.split() for line in lines]


def substitutes(tmp_path, end="exec sleep 60"):
    """scripts/station with other programs: rosmaster and the station only note that they were started. @return its environment."""
    (tmp_path / "scripts/raven2_station").mkdir(parents=True)
    shutil.copy(ROOT / "scripts/station", tmp_path / "scripts/station")
    (tmp_path / "scripts/common.sh").write_text(COMMON.format(folder=tmp_path))
    for path in ("rosmaster", "scripts/raven2_station/station"):
        ends = end if path.endswith("station") else "exec sleep 60"
        (tmp_path / path).write_text(f"#!/bin/sh\necho $$ $* >> {tmp_path}/{pathlib.Path(path).name}.started\n{ends}\n")
        (tmp_path / path).chmod(0o755)
    return {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}


def test_a_killed_ros_master_starts_again_on_its_port_and_a_killed_station_too(tmp_path):
    environment = substitutes(tmp_path)
    with running("bash", str(tmp_path / "scripts/station"), env=environment) as process:
        first, stations = started(tmp_path, "rosmaster", 1), started(tmp_path, "station", 1)
        os.kill(int(first[0][0]), signal.SIGKILL)
        masters = started(tmp_path, "rosmaster", 2)
        assert len(stations) == 1
        os.kill(int(stations[0][0]), signal.SIGKILL)
        stations = started(tmp_path, "station", 2)
        process.terminate()
        status = process.wait(20)
    assert survivors([int(pid) for pid, *_ in masters + stations]) == [] and status == 0
    assert [master[1:] for master in masters] == [["--core", "-p", "12345"]] * 2 and len(stations) == 2


def test_a_station_that_cannot_start_is_not_started_again(tmp_path):
    environment = substitutes(tmp_path, end="exit 2")
    with running("bash", str(tmp_path / "scripts/station"), env=environment) as process:
        assert process.wait(20) == 2
    assert len(started(tmp_path, "station", 1)) == 1


def test_a_password_file_that_others_can_read_is_refused(tmp_path):
    text = (ROOT / "scripts/raven2_station/station").read_text()
    module = types.ModuleType("entry")
    module.__file__ = str(ROOT / "scripts/raven2_station/station")
    exec(compile(text.split("if __name__")[0], module.__file__, "exec"), module.__dict__)  # noqa: S102
    file = tmp_path / "password"
    file.write_text("scrypt$a$b\n")
    options = module.parse(["--bind", "0.0.0.0", "--password-file", str(file)])
    for mode in (0o640, 0o604, 0o660):
        file.chmod(mode)
        with pytest.raises(SystemExit, match="chmod 600"):
            module.password_hash(options)
    file.chmod(0o600)
    assert module.password_hash(options) == "scrypt$a$b"
