"""The programs of an attempt: virtual Raven, console, bad link and daemon. Starts, ends and adopts them.

The programs outlive the station. A station that was killed finds them again by the file `processes.json`. The file has process numbers
and start times, so that a number of another process is not mistaken for ours.
"""

import asyncio
import contextlib
import difflib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import sys
import time

import psutil

from . import library, words

PATIENCE = 8.0      # [s] from SIGTERM to SIGKILL: the daemon writes its last records
POLL = 0.1          # [s]
START_LIMIT = 20.0  # [s] until the daemon's session directory has a log
DRIVERS = r"browser|scripted|expert|clumsy:[a-z0-9_]+|master:[A-Za-z0-9_]+"


class Refused(Exception):
    """A request that cannot be served. The text is a sentence for the user; nothing has changed, or the text says so."""


def free_port(kind, preferred, taken):
    for port in (preferred, 0):
        with socket.socket(socket.AF_INET, kind) as s:
            try:
                if port in taken:
                    continue
                s.bind(("127.0.0.1", port))
            except OSError:
                continue
            found = s.getsockname()[1]
            if found not in taken:
                taken.add(found)
                return found
    raise Refused("no free network port")


class Choice:
    """The instructor's choice, checked against the library."""

    FIELDS = ("trainee", "curriculum", "exercise", "hazard", "when", "link", "driver", "seed")

    def __init__(self, given, known):
        if not isinstance(given, dict) or set(given) - set(self.FIELDS):
            raise Refused(f"unknown setting {sorted(set(given) - set(self.FIELDS))[0]}" if isinstance(given, dict)
                          else "expected settings by name")
        text = {}
        for field in self.FIELDS[:-1]:
            text[field] = "" if given.get(field) is None else given[field]
            if not isinstance(text[field], str):
                raise Refused(f"{field} is not a text")
        self.trainee, self.curriculum, self.driver = text["trainee"], text["curriculum"], text["driver"] or "scripted"
        self.exercise, self.hazard = text["exercise"] or "none", text["hazard"] or "none"
        self.when, self.link = text["when"] or "own", text["link"] or "none"
        self._check(known)
        self.seed = self._seed(given.get("seed"))

    def _check(self, known):
        if self.trainee and not re.fullmatch(library.TRAINEE, self.trainee):
            raise Refused(f"trainee \"{self.trainee[:40]}\" is not an ID: use 1 to 32 of a-z, 0-9, _ and -")
        self._known("curriculum", self.curriculum, [""] + known.names("curricula"))
        self._known("exercise", self.exercise, ["none"] + known.names("exercises"))
        self._known("hazard", self.hazard, ["none", "own"] + known.names("hazards"))
        self._known("link", self.link, known.names("links"))
        self._known("when", self.when, ["own", "instructor"])
        if not re.fullmatch(DRIVERS, self.driver):
            raise Refused(f"driver \"{self.driver[:40]}\" is unknown")
        exercise = known.exercise(self.exercise)
        if self.hazard == "own" and exercise is None:
            raise Refused("a drill needs an exercise")
        if self.driver.startswith("master:"):
            self._known("hand device", self.driver[7:], known.names("masters"))
        if self.driver in ("expert",) or self.driver.startswith("clumsy:"):
            if exercise is None:
                raise Refused(f"the {self.driver.split(':')[0]} surgeon needs an exercise")
            if self.driver.startswith("clumsy:"):
                self._known("clumsy surgeon", self.driver[7:], exercise["clumsy"])

    @staticmethod
    def _known(what, value, names):
        if value not in names:
            near = difflib.get_close_matches(value[:40], names, 1)
            raise Refused(f"{what} \"{value[:40]}\" is unknown" + (f": did you mean \"{near[0]}\"?" if near else ""))

    @staticmethod
    def _seed(value):
        if value is None or (isinstance(value, int) and not isinstance(value, bool) and value < 0):
            return random.randrange(1, 1 << 31)
        if isinstance(value, bool) or not isinstance(value, int) or value > 1 << 53:
            raise Refused("the seed is a whole number up to 2^53")
        return value

    @property
    def is_drill(self):
        return self.exercise != "none" and self.hazard != "none" and self.when == "own"

    def as_dict(self):
        return {field: getattr(self, field) for field in self.FIELDS}


class Supervisor:
    """@param programs: folder of the programs. @param sessions: folder for session directories.
    @param robot: "" starts a virtual Raven for each attempt; an address: a real robot there, which is never touched.
    @param changed: called without arguments at each change of state().
    @param progress: progress(trainee, curriculum) as Records.progress(). @param config: root file for the programs; "": the packaged.
    @param scale: motion scale of every session [-]; None: the driver's."""

    def __init__(self, programs, sessions, known, changed, progress, robot="", logs=None, config="", scale=None):
        self._programs, self._sessions = pathlib.Path(programs), pathlib.Path(sessions)
        self._known, self._changed, self._progress, self._robot = known, changed, progress, robot
        self._config, self._scale = pathlib.Path(config) if config else None, scale
        self._logs = pathlib.Path(logs or self._sessions / "station_logs")
        self._replay = self._logs / "replay"
        self._processes = {}
        self._ends = {}          # name -> task with the exit status
        self._closed = False
        self._choice = self._directory = None
        self._kept_choice = None  # of the newest session that was no replay
        self._lock = asyncio.Lock()
        self._watcher = None
        self.phase = "idle"      # idle, starting, running, ending
        self.trouble = ""        # why the last attempt ended early
        self.last = None         # directory of the newest session that has ended
        self.began_at = self.ended_at = -1e9  # [s] monotonic

    # ---- what pages see

    def state(self):
        return {"virtual": not self._robot, "phase": self.phase, "trouble": self.trouble, "session": self._directory and self._directory.name,
                "replay": self.is_replay, "choice": self._choice and self._choice.as_dict(), "last": self.last and self.last.name}

    @property
    def choice(self):
        return self._choice

    @property
    def is_running(self):
        return self.phase in ("starting", "running")

    @property
    def is_replay(self):
        """Whether the programs run only to show a past session. Their own recording is overwritten by the next replay."""
        return self._directory is not None and self._directory == self._replay

    # ---- what pages and services ask for

    async def start(self, given, replay=False):
        """@return the session directory. @throw Refused."""
        async with self._lock:
            choice = await self._check(given)
            if self.phase != "idle":
                raise Refused("a session is running: stop it first")
            self.phase, self.trouble, self._choice = "starting", "", choice
            self._changed()
            try:
                self._directory = self._empty_replay() if replay else self._new_directory(choice)
                await self._start(choice)
            except (Refused, OSError, psutil.Error) as error:
                await self._end_all()
                self.phase, self._choice, self._directory, self.ended_at = "idle", self._kept_choice, None, time.monotonic()
                self._remember()
                self._changed()
                raise Refused(str(error)) from error
            self._kept_choice = self._kept_choice if replay else choice
            self.phase, self.began_at = "running", time.monotonic()
            self._watch()
            self._changed()
            return self._directory

    async def end(self):
        async with self._lock:
            if self.phase != "running":
                raise Refused("no session is running")
            await self._finish("")

    async def close(self):
        """Ends the session and begins no other: the station ends."""
        self._closed = True
        async with self._lock:
            if self.phase == "running":
                await self._finish("")

    async def next(self):
        """The next attempt with the same settings; of a curriculum, the trainee's stage by then."""
        choice = self._kept_choice
        if choice is None:
            raise Refused("no session has been started yet")
        wanted = {**choice.as_dict(), "seed": -1}
        if not self.is_running:
            return await self.start(wanted)
        await self._check(wanted)
        with contextlib.suppress(Refused):  # it has ended meanwhile
            await self.end()
        try:
            return await self.start(wanted)
        except Refused as reason:  # for example, this attempt was the last of its curriculum
            raise Refused(f"The session has ended. The next attempt did not start: {reason}") from reason

    # ---- starting

    async def _check(self, given):
        """@return the Choice. @throw Refused."""
        choice = Choice(await asyncio.to_thread(self._with_stage, given), self._known)
        if self._closed:
            raise Refused("the station ends")
        return choice

    def _with_stage(self, given):
        """A curriculum chooses exercise and hazard: those of the trainee's stage."""
        curriculum = given.get("curriculum") if isinstance(given, dict) else None
        if not curriculum or curriculum not in self._known.names("curricula"):
            return given
        trainee = given.get("trainee")
        stages, current = self._progress(trainee if isinstance(trainee, str) else "", self._known.curriculum(curriculum))
        if current == len(stages):
            raise Refused(f"{trainee} has done all stages of this curriculum: choose an exercise, or another curriculum")
        return {**given, "exercise": stages[current].exercise, "hazard": stages[current].drill or "none", "when": "own"}

    def _empty_replay(self):
        shutil.rmtree(self._replay, ignore_errors=True)
        return self._replay

    def _new_directory(self, choice):
        now = time.strftime("%Y-%m-%dT%H-%M-%SZ", time.gmtime())
        base = f"{now}_{choice.trainee or 'guest'}"
        for number in range(100):
            directory = self._sessions / (base if number == 0 else f"{base}_{number}")
            if not directory.exists():
                return directory
        raise Refused("the session folder is full of sessions of this second")

    def _arguments(self, choice):
        arguments = ["--config", str(self._config)] if self._config else []
        arguments += ["--seed", str(choice.seed)]
        if choice.curriculum:
            arguments += ["--curriculum", choice.curriculum]
        if choice.trainee:
            arguments += ["--trainee", choice.trainee]
        arguments += ["--exercise", choice.exercise]
        arguments += ["--drill", choice.hazard] if choice.is_drill else []
        at_start = choice.exercise == "none" and choice.when == "own"
        return arguments + ["--hazard", choice.hazard if at_start else "none"]

    async def _start(self, choice):
        taken = set()
        udp, tcp = socket.SOCK_DGRAM, socket.SOCK_STREAM
        master, force, sight = (free_port(udp, port, taken) for port in (36010, 36001, 26002))
        robot, state = (36000, 26100) if self._robot else (free_port(udp, 36000, taken), free_port(tcp, 26100, taken))
        ports = self._ports(master, robot, force, sight, state)
        common = self._arguments(choice)
        if not self._robot:
            await self._launch("virtual_raven", ["--homing", "quick", *common, *ports])
        far = ports
        if choice.link != "none":
            far_master, far_force, far_sight = (free_port(udp, port, taken) for port in (26020, 26021, 26022))
            far = self._ports(far_master, robot, far_force, far_sight, state)
            await self._launch("impair", ["--udp", f"{far_master}:127.0.0.1:{master}", "--udp", f"{force}:127.0.0.1:{far_force}",
                                          "--udp", f"{sight}:127.0.0.1:{far_sight}", "--profile", self._profile(choice.link),
                                          "--seed", str(choice.seed)])
        await self._launch("master_console", [*self._hands(choice), *common, *far, *self._scaled(choice)])
        where = ["--robot-host", self._robot, "--strict"] if self._robot else []  # as launch/hardware.launch
        await self._launch("simulator", ["--duration", "0", "--output", str(self._directory), "--motion-label", choice.driver,
                                         *where, *common, *ports, *self._scaled(choice)])
        await self._await_log()

    def _profile(self, link):
        """For `impair`, which takes a preset of the package or a file."""
        return str(self._config.parent / "impairments" / f"{link}.yaml") if self._config else link

    def _scaled(self, choice):
        scale = self._scale or self._known.scale(choice.driver, bool(self._robot))
        return ["--scale", str(scale)] if scale else []

    @staticmethod
    def _ports(master, robot, force, sight, state):
        return ["--master-port", str(master), "--robot-port", str(robot), "--force-port", str(force), "--sight-port", str(sight),
                "--state-port", str(state)]

    @staticmethod
    def _hands(choice):
        if choice.driver == "browser":
            return ["--master", "browser"]
        if choice.driver.startswith("master:"):
            return ["--master", choice.driver[7:]]
        return ["--motion", choice.driver]

    async def _launch(self, name, arguments):
        self._logs.mkdir(parents=True, exist_ok=True)
        with open(self._logs / f"{name}.log", "wb") as log:
            process = await asyncio.create_subprocess_exec(
                str(self._programs / name), *arguments, stdin=asyncio.subprocess.DEVNULL, stdout=log, stderr=log,
                start_new_session=True)
        self._ends[name] = asyncio.ensure_future(process.wait())
        try:
            self._processes[name] = psutil.Process(process.pid)
        except psutil.NoSuchProcess:  # it has ended already
            raise Refused(self._why(name)) from None
        self._remember()

    async def _await_log(self):
        until = time.monotonic() + START_LIMIT
        while not (self._directory / "session.rlog").exists():
            ended = self._ended()
            if ended:
                raise Refused(self._why(ended))
            if time.monotonic() > until:
                raise Refused("the trainer did not start within 20 s")
            await asyncio.sleep(POLL)

    # ---- watching and ending

    def _alive(self, name):
        try:
            return self._processes[name].is_running() and self._processes[name].status() != psutil.STATUS_ZOMBIE
        except (KeyError, psutil.Error):
            return False

    def _ended(self):
        return next((name for name in self._processes if not self._alive(name)), "")

    def _why(self, name):
        """The last line that the program wrote."""
        try:
            lines = (self._logs / f"{name}.log").read_text(encoding="utf-8", errors="replace").replace("\r", "\n").split("\n")
            said = [line.strip() for line in lines if line.strip()]
        except OSError:
            said = []
        return f"{name} ended" + (f": {said[-1][:200]}" if said else "")

    def _watch(self):
        self._watcher = asyncio.ensure_future(self._watch_all())

    async def _watch_all(self):
        while self.phase == "running":
            await asyncio.sleep(POLL)
            ended = self._ended()
            if not ended or self.phase != "running":
                continue
            async with self._lock:
                if self.phase != "running":
                    return
                await self._finish("" if self._has_finished(ended) else self._why(ended))

    def _has_finished(self, name):
        """Whether it is a simulated surgeon who has done the exercise. The exit status of an adopted program is not known."""
        end = self._ends.get(name)
        status = end.result() if end is not None and end.done() else None
        return name == "master_console" and words.is_demonstration(self._choice.driver) and status in (0, None)

    async def _finish(self, trouble):
        self.phase, self.trouble = "ending", trouble
        self._changed()
        await self._end_all()
        if not self.is_replay and self._directory is not None and (self._directory / "session.rlog").exists():
            self.last = self._directory
        self._choice = self._kept_choice
        self.phase, self._directory, self.ended_at = "idle", None, time.monotonic()
        self._remember()
        self._changed()

    async def _end_all(self):
        """The daemon first: it sends pedal-up and zero forces to the others."""
        for name in ("simulator", "master_console", "impair", "virtual_raven"):
            if name in self._processes:
                await self._end(name)
        self._processes.clear()
        self._ends.clear()
        self._remember()

    async def _end(self, name):
        for number, patience in ((signal.SIGTERM, PATIENCE), (signal.SIGKILL, 2.0)):
            if not self._alive(name):
                return
            try:
                self._processes[name].send_signal(number)
            except psutil.Error:
                return
            until = time.monotonic() + patience
            while self._alive(name) and time.monotonic() < until:
                await asyncio.sleep(POLL / 2)

    # ---- a station that starts again

    def _file(self):
        return self._logs / "processes.json"

    def _remember(self):
        """For a station that starts again. On a full disk it will not find these programs; all else goes on."""
        content = {"processes": {name: [p.pid, self._began(p)] for name, p in self._processes.items()},
                   "choice": self._choice and self._choice.as_dict(), "session": self._directory and str(self._directory)}
        try:
            self._logs.mkdir(parents=True, exist_ok=True)
            part = self._file().with_suffix(".part")
            part.write_text(json.dumps(content), encoding="utf-8")
            os.replace(part, self._file())
        except OSError as error:
            print(f"{self._file()}: cannot be written: {error.strerror}; a station that starts again will not find this session's "
                  "programs", file=sys.stderr)

    @staticmethod
    def _terminate(process):
        try:
            process.terminate()
        except psutil.Error:
            pass  # it has ended

    @staticmethod
    def _began(process):
        try:
            return process.create_time()
        except psutil.Error:
            return 0.0

    def adopt(self):
        """Takes over the programs of an earlier station. Ends those of a start that was not finished.
        @return whether a session is running."""
        try:
            content = json.loads(self._file().read_text(encoding="utf-8"))
            found = {name: psutil.Process(pid) for name, (pid, began) in content["processes"].items()
                     if psutil.pid_exists(pid) and abs(psutil.Process(pid).create_time() - began) < 0.02}
            choice = content["choice"] and Choice(content["choice"], self._known)
        except (OSError, ValueError, KeyError, TypeError, psutil.Error, Refused):
            return False
        self._choice = self._kept_choice = None if content.get("session") == str(self._replay) else choice
        if "simulator" not in found:
            for process in found.values():
                self._terminate(process)
            return False
        self._choice = choice
        self._processes, self._directory, self.phase = found, pathlib.Path(content["session"]), "running"
        self.began_at = time.monotonic()  # for this station
        self._watch()
        return True
