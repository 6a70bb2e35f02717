"""The state of the station and its actions. Joins the pages, the link to ROS, the programs and the sessions. No HTTP here."""

import asyncio
import collections
import time

from . import hands, words
from .past import PastSessions
from .statuses import Statuses
from .supervisor import Refused

DAEMON_SILENT = 1.5  # [s] without a message of the daemon
DAEMON_START = 4.0   # [s] until the first message of the daemon
LAST_WORDS = 0.5     # [s] after the end of an own daemon in which its last messages come
TICK = 0.02          # [s]
STATUS_PERIOD = 1.0  # [s]
ALIVE_PERIOD = 0.5   # [s] between messages that show pages that the station works
STOP_LIMIT = 2.0     # [s] for the trainer's answer to an emergency stop
TRAINEE_MAY = {"drive", "leave", "hands", "watch"}
ROS_PATIENCE = 3.0   # [s] for the ROS master, before a session starts
FOREIGN_GONE = "The trainer of the launch file does not answer any more. If its session has ended, choose and press Start."
NOT_RUNNING = "the trainer is not running"  # as ros_side.py has it
TRIGGERS = {"end-replay": "end_replay", "stop-hazard": "stop_hazard", "emergency-stop": "emergency_stop", "clear-stop": "clear_stop", "pause": "pause",
            "restart-exercise": "start_exercise", "press-start": "virtual_raven/press_start", "begin-simulation": "begin_simulation",
            "end-simulation": "end_simulation", "begin-trial": "begin_trial", "end-trial": "end_trial", "discard-trial": "discard_trial",
            "engage": "engage", "disengage": "disengage"}


class Station(PastSessions):
    """@param supervisor, link, records, finisher, known: see their modules."""

    def __init__(self, known, records):
        self.known, self.records = known, records
        self.supervisor = self.link = self.finisher = None  # set by the server, which makes all of them
        self.clients = {}
        self.hands = hands.Hands()
        self.driving = None          # the client that moves the hands
        self.away = hands.Away()     # the instructor took them; the server gives it a file
        self.refused = collections.Counter()
        self.newest = {}             # message by kind, for pages that come later
        self.progress = {}           # (session, what) -> (share, text)
        self._daemon_heard = self._hands_sent = None
        self._second_asked = None    # whether the trainer was asked for the second picture
        self.statuses = Statuses()
        self._last_health = None
        self._was_foreign = self._foreign_gone = False
        self._status_at = self._alive_at = 0.0

    # ---- pages

    async def join(self, client):
        trainees = await asyncio.to_thread(self.records.trainees) if client.role == "instructor" else []
        self.clients[client.number] = client
        client.send({"t": "hello", "role": client.role, "number": client.number})
        if client.role == "instructor":
            client.send({"t": "library", **self.known.describe(), "trainees": trainees})
        else:
            client.send({"t": "library", **{key: {e["name"]: e[key] for e in self.known.exercises} for key in ("steps", "tracks")}})
        self._show_state(client)

    def _show_state(self, client):
        for kind in ("mode", "exercise", "plan", "session", "axes", *(["robot"] if client.role == "instructor" else [])):
            if kind in self.newest and (kind == "exercise" or self.supervisor.is_running or self.is_foreign):
                client.send(self._for(client, self.newest[kind]))
        client.send({"t": "station", **self._station(client)})
        client.send(self._for(client, {"t": "health", **self.health()}))

    def part(self, client):
        self.clients.pop(client.number, None)
        if self.driving is client:
            self.stop_driving()

    def broadcast(self, message, only=None):
        for client in list(self.clients.values()):
            if only is None or client.role == only:
                shown = self._for(client, message)
                if shown is not None:
                    client.send(shown)

    def _for(self, client, message):
        """A trainee must not learn which hazard will come."""
        if client.role == "trainee" and message["t"] == "session":
            return {**message, "drill": "", "hazard": "", "directory": ""}
        if client.role == "trainee" and message["t"] in ("health", "alive"):
            return {**message, "detail": ""}
        return message

    def _station(self, client):
        state = self.supervisor.state()
        if self.is_foreign:  # the newest choice is of a session of this station
            state = {**state, "choice": None}
        if client.role == "trainee" and state["choice"]:
            state = {**state, "choice": {**state["choice"], "hazard": "", "when": "", "seed": 0}}
        return {**state, "drives": self.driving.number if self.driving else None, "hands_away": self.away.is_on,
                "ros": self.link.is_up, "foreign": self.is_foreign}

    @property
    def is_heard(self):
        return self._daemon_heard is not None and time.monotonic() - self._daemon_heard <= DAEMON_SILENT

    @property
    def is_foreign(self):
        """Whether a trainer answers that the station did not start, for example one of a launch file."""
        return self.is_heard and self.supervisor.phase == "idle" and self._daemon_heard > self.supervisor.ended_at + LAST_WORDS

    def changed(self):
        if self.supervisor.phase == "starting":
            self.newest.clear()  # of the session before
            self.statuses.clear()
        if self.driving and self.supervisor.is_running and not self.browser_may_drive:
            self.driving = None  # somebody else has the hands in this session
            self.hands.release()
        for client in list(self.clients.values()):
            client.send({"t": "station", **self._station(client)})

    # ---- from ROS

    def heard(self, message, data):
        kind = message["t"]
        if kind == "alive":
            return
        if kind == "asked":
            asyncio.ensure_future(self._answer(message))
            return
        if kind == "diagnostics":
            if self.statuses.hear(message["status"]):
                self._daemon_heard = time.monotonic()
            self._show_robot()
            return
        self._daemon_heard = time.monotonic()
        if kind == "picture":
            for client in list(self.clients.values()):
                client.show(message["which"], data)
            return
        if kind == "mode":
            message["text"] = words.mode(message["mode"], message.get("engaged", True))
            self.hands.see(message["mode"], message["pedal"])
        elif kind == "exercise":
            message["text"] = words.exercise(message["status"], message["failure"])
            message["mistakes"] = [[words.mistake(name), count] for name, count in message["mistakes"].items() if count]
        elif kind == "event" and message["mistake"]:
            message["text"] = words.mistake(message["mistake"])
        if kind != "strips":
            self.newest[kind] = message
        self.broadcast(message)

    def _show_robot(self):
        message = self.statuses.message("robot")
        shown = {"t": "robot", "text": words.robot(message)}
        if message and shown != self.newest.get("robot"):
            self.newest["robot"] = shown
            self.broadcast(shown, only="instructor")

    async def _answer(self, message):
        ok, text, session = await self.do(message["do"], message["with"])
        self.link.send({"t": "answer", "number": message["number"], "ok": ok, "text": text,
                        "session": session if isinstance(session, str) else ""})

    def health(self):
        """Level 0 is green, 1 a warning, 2 an error. Detail: the trainer's own words, for the instructor."""
        return {"detail": "", **self._health()}

    def _health(self):
        if self.link.is_taken:
            return {"level": 2, "text": "Another station runs with this ROS master. End one of them."}
        if not self.link.is_up:
            return {"level": 2, "text": "No ROS master: the station waits for one. If this lasts, start the station again."}
        silent = not self.is_heard
        if silent and self.supervisor.phase == "running" and DAEMON_START > time.monotonic() - self.supervisor.began_at:
            return {"level": 0, "text": "The session starts."}
        if silent and self.supervisor.phase == "running":
            return {"level": 2, "text": "The trainer does not answer. Stop the session and start it again."}
        if self._foreign_gone and self.supervisor.phase == "idle":
            return {"level": 1, "text": FOREIGN_GONE}
        if self.supervisor.phase != "running" and not self.is_foreign:
            return {"level": 2 if self.supervisor.trouble else 0,
                    "text": self.supervisor.trouble or {"starting": "The session starts.", "ending": "The session ends."}.get(
                        self.supervisor.phase, "No session: choose and press Start.")}
        level, text, detail = words.health(self.statuses.all)
        if level < 2 and self.newest.get("mode", {}).get("mode") == "stopped":
            level, text, detail = 1, words.STOPPED, ""
        return {"level": min(level, 2), "text": text, "detail": detail}

    # ---- what pages and ROS services ask for

    async def do(self, what, given, client=None):
        """@return (whether it happened, a sentence, more)."""
        try:
            if not isinstance(what, str):
                raise Refused("unknown request")
            method = getattr(self, "_do_" + what.replace("-", "_"), None)
            if not isinstance(given, dict):
                raise Refused("expected settings by name")
            if what in TRIGGERS and (client is None or client.role != "trainee"):
                done, text, more = await self.link.call(TRIGGERS[what], limit=STOP_LIMIT if what == "emergency-stop" else 20.0)
                if not done and self.supervisor.phase == "idle" and not self.is_foreign:
                    text = "no session is running"
                return done, self._answer_to(what, text), more
            if method is None:
                raise Refused("unknown request")
            if client is not None and client.role == "trainee" and what not in TRAINEE_MAY:
                raise Refused("that is the instructor's")
            return await method(given, client)
        except Refused as reason:
            return False, str(reason), {}
        except KeyError:
            return False, "there is no such session", {}

    def _answer_to(self, what, text):
        """In a sentence, by what is known of the session."""
        mode, robot_is_stopped = self.newest.get("mode", {}), self.statuses.message("robot").startswith("E-STOP")
        if (what, text) == ("clear-stop", "not_now"):
            return words.clear_refused(mode.get("mode"), mode.get("pedal"), robot_is_stopped)
        if (what, text) == ("clear-stop", "accepted") and robot_is_stopped:
            return f"Your stop is cleared. {words.ROBOT_STOPPED}"
        if what == "press-start" and text == NOT_RUNNING and self.is_heard:
            return words.NO_START if self.supervisor.state()["virtual"] and not self.is_foreign else words.REAL_START
        modes, no = words.NOT_NOW.get(what, ((), ""))
        if text == "not_now" and mode.get("mode") in modes:
            return no
        if (what, text) == ("restart-exercise", "not_now") and self.newest.get("exercise", {}).get("status", "none") == "none":
            return words.NO_EXERCISE
        return words.answer(text)

    def _refuse_running(self, name):
        """@throw Refused for a session that is being recorded, by this station's trainer or a foreign one."""
        foreign = self.newest.get("session", {}).get("directory", "") if self.is_foreign else ""
        if name and name in (self.supervisor.state()["session"], foreign.rstrip("/").rpartition("/")[2]):
            raise Refused("this session is running")

    async def _await_ros(self):
        """Before a session: without a ROS master no page could see it. @throw Refused."""
        until = time.monotonic() + ROS_PATIENCE
        while not self.link.is_up:
            if time.monotonic() > until:
                raise Refused(self.health()["text"])
            await asyncio.sleep(TICK)
        if self.is_foreign:
            raise Refused("a trainer runs that this station did not start, for example from a launch file: end it there first")

    async def _do_start(self, given, _):
        await self._await_ros()
        directory = await self.supervisor.start(given)
        return True, "The session runs.", str(directory)

    async def _do_stop(self, _, __):
        await self.supervisor.end()
        return True, "The session has ended.", {}

    _do_end = _do_stop

    async def _do_next(self, _, __):
        await self._await_ros()
        directory = await self.supervisor.next()
        return True, "The next attempt runs.", str(directory)

    async def _do_inject(self, given, _):
        choice = None if self.is_foreign else self.supervisor.choice
        name = given.get("hazard") or (choice and choice.hazard) or ""
        if name == "own" and choice:
            name = (self.known.exercise(choice.exercise) or {}).get("drill") or ""
        if name in ("", "none"):
            raise Refused("choose a hazard first")
        if name not in self.known.names("hazards"):
            raise Refused("that hazard is unknown")
        done, text, more = await self.link.call("inject_hazard", {"name": name})
        return done, words.sentence(words.injected(text, done and not self.newest.get("mode", {}).get("pedal"))), more

    async def _do_view(self, given, _):
        real = given.get("real") is True
        if real and self.statuses.message("real camera") in ("silent", "none configured"):
            raise Refused("no picture comes from a real camera")
        done, text, more = await self.link.call("set_view", {"data": real})
        return done, words.answer(text), more

    async def _do_plan(self, given, _):
        arm = given.get("arm", "")
        if arm not in ("", "gold", "green"):
            raise Refused("the arm is gold or green")
        done, text, more = await self.link.call("plan", {"arm": arm, "default_goal": True}, limit=60.0)
        return done, words.answer(text), more

    async def _do_execute(self, given, _):
        done, text, more = await self.link.call("execute_plan", {"on_robot": given.get("on_robot") is True})
        return done, words.answer(text), more

    async def _do_repeat_trial(self, given, _):
        done, text, more = await self.link.call("repeat_trial", {"on_robot": given.get("on_robot") is True})
        return done, words.TRIAL_ANSWERS.get(text) or self._answer_to("repeat-trial", text), more

    async def _do_cancel_plan(self, _, __):
        done, text, more = await self.link.call("cancel_plan")
        return done, words.NO_PLAN if done and more.get("was") == "idle" else words.answer(text), more

    async def _do_take_hands(self, given, _):
        self.away.set(given.get("away") is not False)
        if self.away.is_on:
            self.stop_driving()
        self.changed()
        return True, "The page moves no arm now." if self.away.is_on else "A page may move the arms again.", {}

    @property
    def is_hand_device(self):
        """Whether the console listens to the station: it has the family `browser` (config/masters/browser.yaml). A foreign
        trainer's console may have it, too; if not, it ignores the page."""
        choice = self.supervisor.choice
        return self.is_foreign or (self.supervisor.is_running and choice is not None and choice.driver == "browser")

    @property
    def browser_may_drive(self):
        return self.is_hand_device and not self.supervisor.is_replay

    async def _do_drive(self, _, client):
        if not self.browser_may_drive:
            raise Refused("the instructor has not given the hands to the browser")
        if self.away.is_on:
            raise Refused("the instructor has taken the hands away")
        if self.driving not in (None, client):
            raise Refused("another page drives")
        self.driving = client
        self.changed()
        return True, "You have the hands.", {}

    async def _do_leave(self, _, client):
        if self.driving is client:
            self.stop_driving()
        return True, "", {}

    async def _do_watch(self, given, client):
        """With `acknowledges` the page sends `shown` for each picture; only a few are sent ahead."""
        wants = given.get("pictures")
        if not isinstance(wants, list) or any(w not in ("view", "second") for w in wants):
            raise Refused("pictures are view and second")
        client.wants = set(wants)
        client.acknowledges = given.get("acknowledges") is True
        self._show_state(client)  # to a page that heard nothing for a moment
        return True, "", {}

    # ---- hands

    def take_hands_message(self, client, message):
        """From the page that drives, some 60 a second; counted where they are refused."""
        if client is not self.driving:
            self.refused["hands_of_a_page_that_does_not_drive"] += 1
            return
        if not self.browser_may_drive:  # between two sessions; the next one may be this page's again
            self.hands.release()
            return
        try:
            self.hands.apply(message, time.monotonic())
        except ValueError:
            self.refused["hands_malformed"] += 1
            return
        self._send_hands()

    def stop_driving(self):
        self.driving = None
        self.hands.release()
        self._send_hands()
        self.changed()

    def _send_hands(self):
        self._hands_sent = time.monotonic()
        self.link.send({"t": "hands", "pedal": self.hands.console_pedal, "camera": self.hands.camera_pedal(self._hands_sent),
                        "arms": self.hands.poses()})

    # ---- the clock

    async def run(self):
        """For ever: lifts the pedal of a silent page, watches health, publishes the station's status on /diagnostics."""
        while True:
            await asyncio.sleep(TICK)
            self.tick(time.monotonic())

    def tick(self, now):
        self.hands.watch(now)
        if self.supervisor.phase != "idle":
            self._foreign_gone = False
        if self.is_foreign != self._was_foreign:
            self._foreign_gone = self._was_foreign and self.supervisor.phase == "idle"
            self._was_foreign = self.is_foreign
            self.changed()
            for client in list(self.clients.values()):  # what the page has forgotten of a trainer that comes back
                self._show_state(client)
        drives = self.is_hand_device and (self.supervisor.is_running or self.driving is not None)
        if drives and (self._hands_sent is None or now - self._hands_sent >= TICK):
            self._send_hands()
        self._ask_for_second()
        health = self.health()
        if health != self._last_health:
            self._last_health = health
            self.broadcast({"t": "health", **health})
        if now - self._alive_at >= ALIVE_PERIOD:
            self._alive_at = now
            self.broadcast({"t": "alive", **health})
        if now - self._status_at >= STATUS_PERIOD:
            self._status_at = now
            self.link.send({"t": "status", "level": 0, "text": f"{len(self.clients)} pages",
                            "values": {"pages": len(self.clients), "refused": sum(self.refused.values()),
                                       **{f"refused_{k}": v for k, v in sorted(self.refused.items())}}})

    def _ask_for_second(self):
        """The trainer draws the second picture only while a page shows it."""
        wanted = any("second" in client.wants for client in self.clients.values())
        if not self.link.is_up:
            self._second_asked = None
        elif wanted != self._second_asked and self.link.send({"t": "pictures", "second": wanted}):
            self._second_asked = wanted

    def finished(self, name, what, share, text):
        """Progress of report and video."""
        self.progress[name, what] = share, text
        self.broadcast({"t": "progress", "session": name, "what": what, "share": share, "text": text}, only="instructor")
