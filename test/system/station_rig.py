"""A station with its own ROS master, as a user starts it, and pages as clients of aiohttp."""

import asyncio
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

import aiohttp
from ros_master import RosMaster
from stack import BUILD, ROOT, free_ports, wait_until

sys.path.insert(0, os.path.join(ROOT, "scripts"))
import raven2_lockstep  # noqa: E402

STATION = os.path.join(ROOT, "scripts/raven2_station/station")


def small_pictures(folder):
    """The package's configuration with live pictures of a quarter of the size, half as often, and a robot that homes in 0.5 s:
    what a page does with them does not depend on that. @return its root file."""
    root = raven2_lockstep.copy_of_configuration(pathlib.Path(folder))
    for key, value in (("width", 320), ("height", 180), ("fps", 15)):
        raven2_lockstep.replace(root.parent / "render.yaml", rf"(?s)(\nlive:\n.*?  {key}:) \d+", rf"\1 {value}")
    raven2_lockstep.replace(root.parent / "virtual_raven.yaml", r"(?m)^homing_time: [0-9.]+", "homing_time: 0.5")
    return str(root)


class Station:
    """Use as a context manager. `sessions` is its folder. start() and kill() may be called repeatedly."""

    def __init__(self, *options):
        self._folder = tempfile.TemporaryDirectory(prefix="raven2_station_")
        self.folder = self._folder.name
        self.sessions = os.path.join(self.folder, "sessions")
        self.port = free_ports(1)[0]
        self.url = f"http://localhost:{self.port}"
        self.master = RosMaster(self.folder)
        self.master.know_our_messages()
        self._options, self.process = options, None

    def start(self):
        self.environment = dict(os.environ, ROS_MASTER_URI=self.master.uri, ROS_IP="127.0.0.1", ROS_HOME=self.folder,
                                ROS_LOG_DIR=os.path.join(self.folder, "log"), RAVEN2_TRAINER_BUILD=BUILD,
                                PYTHONPATH=os.path.join(BUILD, "devel/lib/python3/dist-packages"))
        with open(self.log_file, "ab") as log:
            self.process = subprocess.Popen([STATION, "--port", str(self.port), "--sessions", self.sessions, *self._options],
                                            env=self.environment, stdout=log, stderr=log, start_new_session=True)
        wait_until(lambda: self.answers() or self.process.poll() is not None, 20, "the station answers")
        assert self.process.poll() is None, self.log()

    @property
    def log_file(self):
        return os.path.join(self.folder, "station.log")

    def log(self):
        with open(self.log_file, encoding="utf-8", errors="replace") as file:
            return file.read()

    def answers(self):
        import socket
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def kill(self):
        self.process.kill()
        self.process.wait()

    def programs(self):
        """{name: pid} of the session's programs that run, from the station's own list."""
        try:
            with open(os.path.join(self.sessions, "station_logs/processes.json"), encoding="utf-8") as file:
                listed = json.load(file)["processes"]
        except (OSError, ValueError):
            return {}
        return {name: pid for name, (pid, _) in listed.items() if os.path.exists(f"/proc/{pid}")}

    def __enter__(self):
        self.master.start()
        self.start()
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            try:
                self.process.wait(30)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        for pid in self.programs().values():
            os.kill(pid, signal.SIGKILL)
        self.master.kill()
        self._folder.cleanup()


async def start(page, **choice):
    """A session, by an instructor's page."""
    answer = await page.ask("start", **choice)
    assert answer["ok"], answer
    await page.until(lambda: page.phase() == "running", 5, "the session runs")


async def stop(page):
    answer = await page.ask("stop")
    assert answer["ok"], answer
    await page.until(lambda: page.phase() == "idle", 20, "the session has ended")


async def end_session(station):
    async with Page(station.url) as page:
        await page.until(lambda: page.phase() is not None, 5, "the station says its phase")
        if page.phase() == "running":
            await stop(page)


async def engage(page, trainee):
    begun = time.monotonic()
    await drive(trainee, 30, pedal=False)
    while page.mode() != "teleoperating":
        assert time.monotonic() - begun < 10, page.newest["mode"]
        await drive(trainee, 30, pedal=False)
        await drive(trainee, 30)


async def drive(page, count, pedal=True, move=(0, 0, 0)):
    """60 messages a second. @return the longest time [s] between two of them."""
    sent = []
    for _ in range(count):
        sent.append(time.monotonic())
        await page.socket.send_str(json.dumps({"do": "hands", "with": {
            "pedal": pedal, "arms": {"gold": {"move": list(move), "turn": [0, 0, 0], "jaw": 0.6}}}}))
        await asyncio.sleep(max(0.0, sent[0] + len(sent) / 60 - time.monotonic()))
    return max(b - a for a, b in zip(sent, sent[1:]))


class Page:
    """A page's connection to the station, as a browser makes it. Use as an async context manager."""

    def __init__(self, url, page="instructor", origin=None, cookie=True):
        self.url, self.page, self.origin, self.cookie = url, page, origin or url, cookie
        self.newest, self.pictures, self.messages = {}, 0, []
        self._number, self._waiting = 0, {}

    async def __aenter__(self):
        self.http = aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar())
        if self.cookie:
            async with self.http.get(self.url + ("/trainee" if self.page == "trainee" else "/")) as answer:
                assert answer.status == 200
        try:
            self.socket = await self.http.ws_connect(f"{self.url}/ws?page={self.page}", origin=self.origin, max_msg_size=0)
        except aiohttp.WSServerHandshakeError:
            await self.http.close()
            raise
        self._reader = asyncio.ensure_future(self._read())
        return self

    async def __aexit__(self, *_):
        self._reader.cancel()
        await self.socket.close()
        await self.http.close()

    async def _read(self):
        async for message in self.socket:
            if message.type == aiohttp.WSMsgType.BINARY:
                self.pictures += 1
                continue
            content = json.loads(message.data)
            if content["t"] == "reply" and content["id"] in self._waiting:
                self._waiting.pop(content["id"]).set_result(content)
            self.newest[content["t"]] = content
            self.messages.append(content)

    async def ask(self, what, seconds=30, **given):
        self._number += 1
        future = asyncio.get_running_loop().create_future()
        self._waiting[self._number] = future
        await self.socket.send_str(json.dumps({"id": self._number, "do": what, "with": given}))
        return await asyncio.wait_for(future, seconds)

    async def until(self, condition, seconds, what):
        end = asyncio.get_running_loop().time() + seconds
        while not condition():
            if asyncio.get_running_loop().time() >= end:
                raise AssertionError(f"not within {seconds} s: {what}; { {k: v for k, v in self.newest.items() if k != 'library'} }")
            await asyncio.sleep(0.02)

    def mode(self):
        return self.newest.get("mode", {}).get("mode")

    def phase(self):
        return self.newest.get("station", {}).get("phase")
