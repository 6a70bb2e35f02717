"""Tests how the station answers requests of its pages, and which state and messages each page gets."""

import asyncio
import json
import pathlib
import re
import sys
import threading
import time
import types

import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from raven2_station import supervisor, words  # noqa: E402
from raven2_station import station as station_module  # noqa: E402
from station_parts import GOOD, PROGRAM, supervised  # noqa: E402


@pytest.mark.parametrize("said, asked", [("silent", False), ("none configured", False), ("heard", True), (None, True)])
def test_the_real_camera_is_shown_only_if_pictures_come(said, asked):
    calls = []

    async def call(service, arguments, limit=0):
        calls.append((service, arguments))
        return True, "accepted", {}

    station = station_module.Station(None, None)
    station.link = types.SimpleNamespace(call=call)
    if said:
        station.statuses.hear([["robot", 0, "fine"], ["real camera", 0, said]])
    assert asyncio.run(station.do("view", {"real": True}))[0] is asked
    assert asyncio.run(station.do("view", {"real": False}))[0]
    assert calls == [("set_view", {"data": True})] * asked + [("set_view", {"data": False})]


def recording(station, answer=(True, "accepted", {})):
    """@return a list of the calls of the trainer from now on: service, arguments, limit."""
    calls = []

    async def call(service, arguments=None, limit=None):
        calls.append((service, arguments, limit))
        return answer

    station.link = types.SimpleNamespace(call=call, is_up=True, is_taken=False, send=lambda _: None)
    return calls


@pytest.mark.parametrize("what", sorted(station_module.TRIGGERS))
def test_each_button_calls_its_own_service(what):
    station = station_in_a_session()
    calls = recording(station)
    assert asyncio.run(station.do(what, {}))[0]
    service = {"restart-exercise": "start_exercise", "press-start": "virtual_raven/press_start"}.get(what, what.replace("-", "_"))
    assert calls == [(service, None, 2.0 if what == "emergency-stop" else 20.0)]


@pytest.mark.parametrize("what, service", [("repeat-trial", "repeat_trial"), ("execute", "execute_plan")])
def test_only_what_asks_for_the_robot_moves_it(what, service):
    station = station_in_a_session()
    calls = recording(station)
    for given in ({"on_robot": False}, {}, {"on_robot": "yes"}, {"on_robot": True}):
        asyncio.run(station.do(what, given))
    assert [(name, arguments["on_robot"]) for name, arguments, _ in calls] == [(service, False)] * 3 + [(service, True)]


@pytest.mark.parametrize("arm", ["", "gold", "green"])
def test_a_plan_leads_to_the_goal_of_the_configuration(arm):
    station = station_in_a_session()
    calls = recording(station)
    assert asyncio.run(station.do("plan", {"arm": arm}))[0]
    assert [call[:2] for call in calls] == [("plan", {"arm": arm, "default_goal": True})]


def given_to_a_browser():
    station = station_in_a_session()
    station.supervisor.choice, station.supervisor.is_replay = types.SimpleNamespace(driver="browser"), False
    return station, [types.SimpleNamespace(role="trainee", number=number, send=lambda _: None) for number in (1, 2)]


def test_a_page_takes_the_hands_from_no_other_page():
    station, (driver, other) = given_to_a_browser()
    for client, drives in ((driver, True), (other, False), (driver, True)):
        assert asyncio.run(station.do("drive", {}, client))[0] == drives
        assert station.driving is driver


def test_hands_that_the_instructor_takes_move_nothing_any_more():
    station, (driver, _) = given_to_a_browser()
    down = {"pedal": True, "camera": False, "arms": {"gold": {"move": [0.001, 0, 0], "turn": [0, 0, 0], "jaw": 0.5}}}
    assert asyncio.run(station.do("drive", {}, driver))[0]
    station.take_hands_message(driver, down)
    assert station.hands.pedal
    assert asyncio.run(station.do("take-hands", {}))[0]
    assert station.driving is None and not station.hands.pedal
    station.take_hands_message(driver, down)
    assert not station.hands.pedal and station.refused["hands_of_a_page_that_does_not_drive"] == 1
    assert asyncio.run(station.do("drive", {}, driver)) == (False, "the instructor has taken the hands away", {})


PAGE_OF_A_TRAINEE = {"drive", "leave", "watch"}  # what it may ask for


@pytest.mark.parametrize("what", sorted({*station_module.TRIGGERS, *(name[4:].replace("_", "-") for name in dir(station_module.Station)
                                                                    if name.startswith("_do_"))} - PAGE_OF_A_TRAINEE))
def test_a_trainee_may_not_do_what_is_the_instructors(what):
    calls = []

    async def call(*given, **_):
        calls.append(given)
        return True, "accepted", {}

    station = station_module.Station(None, None)
    station.link = types.SimpleNamespace(call=call)
    assert not asyncio.run(station.do(what, {}, types.SimpleNamespace(role="trainee")))[0] and calls == []


def station_in_a_session(choice=None):
    station = station_module.Station(types.SimpleNamespace(describe=dict, exercises=[]), types.SimpleNamespace(trainees=list))
    station.supervisor = types.SimpleNamespace(phase="running", is_running=True, began_at=0.0, ended_at=0.0, trouble="",
                                               state=lambda: {"choice": choice})
    station.link = types.SimpleNamespace(is_up=True, is_taken=False, send=lambda _: None)
    return station


@pytest.mark.parametrize("role", ["trainee", "instructor"])
def test_a_trainees_page_that_is_opened_in_a_session_does_not_tell_the_hazard(role):
    station = station_in_a_session({**GOOD, "hazard": "sudden_jump", "when": "own", "seed": 7})
    station.newest["session"] = {"t": "session", "directory": "/s1", "exercise": "peg_transfer", "drill": "sudden_jump", "hazard": "sudden_jump"}
    sent = []
    asyncio.run(station.join(types.SimpleNamespace(role=role, number=1, send=sent.append)))
    assert {"session", "station"} <= {message["t"] for message in sent}
    assert ("sudden_jump" in json.dumps(sent)) == (role == "instructor")


@pytest.mark.parametrize("goes", ["closed", "leave"])
def test_the_hands_stay_with_the_page_that_drives_when_another_page_goes(goes):
    station = station_in_a_session()
    driver, other = (types.SimpleNamespace(role="trainee", number=number, send=lambda _: None) for number in (1, 2))
    station.clients, station.driving = {1: driver, 2: other}, driver
    for client, drives in ((other, driver), (driver, None)):
        if goes == "closed":
            station.part(client)
        else:
            assert asyncio.run(station.do("leave", {}, client))[0]
        assert station.driving is drives


@pytest.mark.parametrize("chosen, given, injected", [
    ("own", {}, "drill"), ("none", {"hazard": "own"}, "drill"), ("fk_pos", {}, "fk_pos"), ("own", {"hazard": "fk_vel"}, "fk_vel"), ("none", {}, None)])
def test_inject_takes_the_hazard_of_the_request_else_the_chosen_one(known, chosen, given, injected):
    """`own` is the exercise's drill."""
    calls = []

    async def call(service, arguments):
        calls.append((service, arguments))
        return True, "the hazard acts", {}

    drill = yaml.safe_load((ROOT / "config/exercises" / f"{GOOD['exercise']}.yaml").read_text())["drill"]["scenario"]
    station = station_module.Station(known, None)
    station.link = types.SimpleNamespace(call=call)
    station.supervisor = types.SimpleNamespace(choice=supervisor.Choice({**GOOD, "hazard": chosen, "when": "instructor"}, known))
    assert asyncio.run(station.do("inject", given))[0] == (injected is not None)
    assert calls == ([("inject_hazard", {"name": drill if injected == "drill" else injected})] if injected else [])


def test_a_trainer_of_a_launch_file_has_nothing_of_the_session_before(known):
    """The page names the session by its choice, and Inject takes the hazard of it."""
    calls = []

    async def call(service, arguments):
        calls.append((service, arguments))
        return True, "the hazard acts", {}

    choice = supervisor.Choice({**GOOD, "hazard": "sudden_jump", "when": "instructor"}, known)
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    station.supervisor = types.SimpleNamespace(phase="idle", is_running=False, ended_at=0.0, trouble="", choice=choice,
                                               state=lambda: {"choice": choice.as_dict()})
    station.link = types.SimpleNamespace(call=call, is_up=True, is_taken=False)
    shown = []
    for is_foreign in (True, False):
        station._daemon_heard = time.monotonic() if is_foreign else None
        assert station.is_foreign == is_foreign
        shown.append(station._station(types.SimpleNamespace(role="instructor"))["choice"])
        assert asyncio.run(station.do("inject", {}))[0] != is_foreign
        assert asyncio.run(station.do("inject", {"hazard": "fk_pos"}))[0]
    assert shown == [None, choice.as_dict()]
    assert [arguments["name"] for _, arguments in calls] == ["fk_pos", "sudden_jump", "fk_pos"]


def test_a_trainer_of_a_launch_file_that_goes_silent_is_no_green(known):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    station.supervisor = types.SimpleNamespace(phase="idle", is_running=False, ended_at=0.0, trouble="", choice=None, state=lambda: {"choice": None})
    station.link = types.SimpleNamespace(is_up=True, is_taken=False, send=lambda _: None)
    levels = []
    for heard, phase in ((None, "idle"), (0.0, "idle"), (9.0, "idle"), (0.0, "idle"), (9.0, "idle"), (9.0, "starting"), (9.0, "idle")):
        station._daemon_heard = None if heard is None else time.monotonic() - heard
        station.supervisor.phase = phase
        station.statuses.hear([["robot", 0, "fine"]])
        station.tick(time.monotonic())
        levels.append(station.health()["level"])
    assert levels == [0, 0, 1, 0, 1, 0, 0]


@pytest.mark.parametrize("comes", [True, False])
def test_a_session_starts_only_with_a_ros_master(known, monkeypatch, comes):
    monkeypatch.setattr(station_module, "ROS_PATIENCE", 60.0 if comes else 0.2)  # one that comes is not missed by a late test
    station, started = station_module.Station(known, None), []

    async def begin(given):
        started.append(given)
        return "/s1"

    station.supervisor = types.SimpleNamespace(phase="idle", ended_at=0.0, trouble="", start=begin)
    station.link = types.SimpleNamespace(is_up=False, is_taken=False)

    async def scenario():
        asking = asyncio.ensure_future(station.do("start", GOOD))
        await asyncio.sleep(0.05)
        station.link.is_up = comes
        return await asking

    done, text, _ = asyncio.run(scenario())
    assert done == comes and started == [GOOD] * comes and ("No ROS master" in text) != comes


@pytest.mark.parametrize("shares, trouble", [([], ""), ([0.0], ""), ([0.0, None], "no space left"), ([0.0, None, 0.0], ""), ([0.0, 1.0], "")])
def test_a_verdict_says_whether_the_report_has_failed(tmp_path, shares, trouble):
    """A page that comes later did not hear it."""
    station = station_module.Station(None, Sessions(tmp_path))
    for share in shares:
        station.finished("s1", "report", share, "no space left" if share is None else "")
    station.finished("s2", "report", None, "of another session")
    station.finished("s1", "video", None, "of the video")
    assert asyncio.run(station.do("verdict", {"session": "s1"})) == (True, "", {"trouble": trouble})


class Sessions:
    """Records that a page may not wait for: each call must be in a thread of its pool."""

    def __init__(self, folder, exercise="camera_clutch"):
        self.folder, self.called = folder, []
        self.answers = {"names": ["s1"], "trainees": ["ann"], "history": [], "verdict": {}, "list": [], "exercise": exercise}

    def directory(self, name):
        if name != "s1":
            raise KeyError(name)
        return self.folder / name

    def __getattr__(self, name):
        def call(*_):
            assert threading.current_thread() is not threading.main_thread(), f"{name} holds the hands up"
            self.called.append(name)
            return self.answers[name]
        return call


def test_long_lists_do_not_hold_the_hands_up(tmp_path):
    async def requests():
        station = station_module.Station(types.SimpleNamespace(describe=dict, exercises=[]), Sessions(tmp_path))
        station.supervisor = types.SimpleNamespace(phase="idle", ended_at=0.0, is_running=False, state=lambda: {"choice": None}, trouble="")
        station.link = types.SimpleNamespace(is_up=True, is_taken=False)
        await station.join(types.SimpleNamespace(role="instructor", number=1, send=lambda _: None))
        for what, given in (("sessions", {}), ("verdict", {"session": "s1"}), ("history", {"trainee": "ann"})):
            assert (await station.do(what, given))[0], what
        assert set(station.records.called) == {"trainees", "names", "list", "verdict", "history"}

    asyncio.run(requests())


@pytest.mark.parametrize("name", [None, [], {}, ["s1"], 3, "../s1"])
def test_deleting_needs_a_sessions_name(tmp_path, name):
    station = station_module.Station(None, Sessions(tmp_path))
    assert asyncio.run(station.do("delete", {"session": name, "sure": True})) == (False, "there is no such session", {})


@pytest.mark.parametrize("answer, phase, text", [
    ((True, "accepted", {}), "running", "The picture shows"), ((False, "not_now", {}), "idle", "is not shown. Not possible now"),
    ((False, "s1: no directory of a session", {}), "idle", "is not shown. S1: no directory")])
@pytest.mark.parametrize("exercise, chosen", [("camera_clutch", "camera_clutch"), ("unknown", "none"), ("", "none")])
def test_a_replay_that_is_refused_leaves_no_program_running(known, tmp_path, answer, phase, text, exercise, chosen):
    async def replay():
        station = station_module.Station(known, Sessions(tmp_path / "sessions", exercise))
        station.supervisor = supervised(tmp_path, known, PROGRAM)

        async def call(service, arguments, limit=0):
            assert service == "begin_replay" and arguments["session"].endswith("s1")
            assert station.supervisor.is_replay and station.supervisor.choice.exercise == chosen
            return answer

        station.link = types.SimpleNamespace(call=call, is_up=True, is_taken=False)
        station.newest["mode"] = {"mode": "pedal_up"}
        ok, said, _ = await station.do("replay", {"session": "s1"})
        assert ok == answer[0] and text in said and station.supervisor.phase == phase
        await station.supervisor.close()

    asyncio.run(replay())


def test_a_stop_is_named_next_to_the_mode():
    station = station_module.Station(None, None)
    station.link = types.SimpleNamespace(is_taken=False, is_up=True)
    station.supervisor = types.SimpleNamespace(phase="running", is_running=True, ended_at=0.0, trouble="")
    station._daemon_heard = time.monotonic()
    for mode, level, status in (("teleoperating", 0, 0), ("stopped", 1, 0), ("stopped", 1, 1), ("stopped", 2, 2)):
        station.newest = {"mode": {"mode": mode}}
        station.statuses.hear([["recorder", status, "disk full"]])
        assert station.health()["level"] == level
        assert ("Clear the stop" in station.health()["text"]) == (level == 1)


def test_statuses_of_the_console_replace_none_of_the_daemons_and_are_no_sign_of_its_life(known, monkeypatch):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    of_daemon = {"t": "diagnostics", "status": [["recorder", 2, "disk full"], ["real camera", 0, "heard"]]}
    of_console = {"t": "diagnostics", "status": [["master left", 0, "engaged"], ["master right", 0, "engaged"]]}
    station.heard(of_console, b"")
    assert not station.is_heard
    station.heard(of_daemon, b"")
    station.heard(of_console, b"")
    assert station.is_heard and words.health(station.statuses.all)[0] == 2 and station.statuses.message("real camera") == "heard"
    now[0] += 2.0
    station.heard(of_console, b"")
    assert not station.is_heard, "the console's alone"
    now[0] += 2.0
    station.heard(of_console, b"")
    assert [status[0] for status in station.statuses.all] == ["master left", "master right"], "the daemon's are old"


def test_the_instructor_sees_the_state_of_the_robot(known):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    station.supervisor = types.SimpleNamespace(is_running=True, phase="running", ended_at=0.0, state=lambda: {"choice": None})
    station.link = types.SimpleNamespace(is_up=True, is_taken=False)
    got = {"instructor": [], "trainee": []}
    for number, role in enumerate(got):
        station.clients[number] = types.SimpleNamespace(role=role, number=number, send=got[role].append)
    for message in ("INIT", "PEDAL_UP", "PEDAL_UP; it refuses our fault plan (its own words say why)", "E-STOP", "no robot", "robot refused: it speaks"):
        station.heard({"t": "diagnostics", "status": [["robot", 0, message]]}, b"")
    assert [m["text"] for m in got["instructor"] if m["t"] == "robot"] == [
        words.ROBOT["INIT"], words.ROBOT["PEDAL_UP"], words.ROBOT["E-STOP"], words.ROBOT["no robot"], "The robot is refused."]
    station._show_state(station.clients[0])
    station._show_state(station.clients[1])
    assert got["instructor"][-3] == {"t": "robot", "text": "The robot is refused."} and "robot" not in {m["t"] for m in got["trainee"]}
    header = (ROOT / "include/raven2_trainer/core/state.h").read_text()
    assert set(re.findall(r'"([^"]+)"', header.split("kRunLevelNames{")[1].split("}")[0])) == set(words.ROBOT) - {"no robot"}


def test_a_page_learns_again_of_a_trainer_of_a_launch_file_that_was_silent(known):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    station.supervisor = types.SimpleNamespace(phase="idle", is_running=False, ended_at=0.0, trouble="", choice=None, state=lambda: {"choice": None})
    station.link = types.SimpleNamespace(is_up=True, is_taken=False, send=lambda _: None)
    got = []
    station.clients[1] = types.SimpleNamespace(role="instructor", number=1, send=got.append, wants={"view"})
    for heard in (0.0, 9.0, 0.0):
        station._daemon_heard = time.monotonic() - heard
        station.newest["robot"] = {"t": "robot", "text": "ready"}
        got.clear()
        station.tick(time.monotonic())
        assert ({"t": "robot", "text": "ready"} in got) == (heard == 0.0), heard


def test_a_trainee_sees_health_without_the_trainers_own_words(known):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    message = {"t": "health", "level": 1, "text": "A sentence.", "detail": "robot: it refuses our fault plan"}
    for role, detail in (("trainee", ""), ("instructor", message["detail"])):
        assert station._for(types.SimpleNamespace(role=role), message) == {**message, "detail": detail}


def test_answers_say_what_is_known_of_the_session(known):
    station = station_module.Station(known, types.SimpleNamespace(trainees=list))
    station.newest["mode"] = {"mode": "stopped", "pedal": True}
    assert station._answer_to("clear-stop", "not_now") == words.CLEAR_FIRST
    station.newest["mode"]["pedal"] = False
    assert station._answer_to("clear-stop", "not_now") == words.MODEL_STOPPED
    assert station._answer_to("clear-stop", "accepted") == "Done."
    station.statuses.hear([["robot", 0, "E-STOP"]])
    assert station._answer_to("clear-stop", "not_now") == words.ROBOT_STOPPED
    assert station._answer_to("clear-stop", "accepted") == f"Your stop is cleared. {words.ROBOT_STOPPED}"
    assert station._answer_to("restart-exercise", "not_now") == words.NO_EXERCISE
    station.newest["exercise"] = {"status": "running"}
    assert station._answer_to("restart-exercise", "not_now") == words.PLANNING_ANSWERS["not_now"]
    assert station._answer_to("press-start", "the trainer is not running") == "The trainer is not running."
    station._daemon_heard = time.monotonic()
    for phase, is_virtual, says in (("running", True, words.NO_START), ("running", False, words.REAL_START), ("idle", True, words.REAL_START)):
        station.supervisor = types.SimpleNamespace(phase=phase, ended_at=0.0, state=lambda virtual=is_virtual: {"virtual": virtual})
        assert station._answer_to("press-start", "the trainer is not running") == says
    assert station._answer_to("engage", "") == "Done."
    for what, mode, other in (("end-simulation", "pedal_up", "camera_moving"), ("end-trial", "paused", "trial"), ("discard-trial", "stopped", "executing"),
                              ("repeat-trial", "trial_held", "armed")):
        station.newest["mode"] = {"mode": mode}
        assert station._answer_to(what, "not_now") == words.NOT_NOW[what][1]
        station.newest["mode"] = {"mode": other}
        assert station._answer_to(what, "not_now") == words.PLANNING_ANSWERS["not_now"]
    station.link = types.SimpleNamespace()

    async def cancelled(service, *_, **__):
        return True, "accepted", {"was": was}

    station.link.call = cancelled
    for was, says in (("idle", words.NO_PLAN), ("armed", "Done.")):
        assert asyncio.run(station.do("cancel-plan", {}))[1] == says


def test_a_trial_is_repeated_by_model_or_robot(known):
    station, asked = station_module.Station(known, types.SimpleNamespace(trainees=list)), []

    async def call(service, arguments):
        asked.append((service, arguments))
        return len(asked) == 1, "accepted" if len(asked) == 1 else "moved", {}

    station.link = types.SimpleNamespace(call=call)
    assert asyncio.run(station.do("repeat-trial", {}))[:2] == (True, "Done.")
    assert asyncio.run(station.do("repeat-trial", {"on_robot": True}))[:2] == (False, words.TRIAL_ANSWERS["moved"])
    assert asked == [("repeat_trial", {"on_robot": False}), ("repeat_trial", {"on_robot": True})]


def test_the_trainer_draws_the_second_picture_only_while_a_page_shows_it(known):
    """Asked once for each change, again after the link to ROS was lost, and again if the request was not sent."""
    station, sent = station_module.Station(known, types.SimpleNamespace(trainees=list)), []
    accepts = True

    def send(message):
        if message["t"] == "pictures":
            sent.append(message["second"])
        return accepts

    station.link = types.SimpleNamespace(is_up=True, is_taken=False, send=send)
    station.supervisor = types.SimpleNamespace(phase="idle", ended_at=0.0, is_running=False, is_replay=False, choice=None, trouble="", state=lambda: {"choice": None})
    pages = [types.SimpleNamespace(role=role, number=n, send=lambda _: None, wants={"view"}) for n, role in ((1, "trainee"), (2, "instructor"))]
    station.clients.update({page.number: page for page in pages})

    def ticks():
        sent.clear()
        for _ in range(3):
            station.tick(time.monotonic())
        return list(sent)

    assert ticks() == [False]
    asyncio.run(station.do("watch", {"pictures": ["view", "second"]}, pages[1]))
    assert ticks() == [True] and ticks() == []
    station.link.is_up = False
    assert ticks() == []
    station.link.is_up, accepts = True, False
    assert ticks() == [True] * 3
    accepts = True
    assert ticks() == [True]
    station.part(pages[1])
    assert ticks() == [False]
    assert asyncio.run(station.do("watch", {"pictures": ["camera"]}, pages[0]))[:2] == (False, "pictures are view and second")


def test_what_was_refused_is_on_diagnostics_by_reason(known):
    station, sent = station_module.Station(known, types.SimpleNamespace(trainees=list)), []
    station.link = types.SimpleNamespace(is_up=True, is_taken=False, send=lambda message: sent.append(message) or True)
    station.supervisor = types.SimpleNamespace(phase="idle", ended_at=0.0, is_running=False, is_replay=False, choice=None, trouble="", state=lambda: {"choice": None})
    page = types.SimpleNamespace(role="trainee", number=1, send=lambda _: None, wants=set())
    station.clients[1] = page
    station.take_hands_message(page, {"pedal": True})
    station.refused["foreign_origin"] += 2
    station.tick(time.monotonic())
    status = next(message for message in sent if message["t"] == "status")
    assert status["values"] == {"pages": 1, "refused": 3, "refused_foreign_origin": 2, "refused_hands_of_a_page_that_does_not_drive": 1}


@pytest.mark.parametrize("is_foreign", [False, True])
@pytest.mark.parametrize("what", ["delete", "report", "video", "replay"])
def test_nothing_is_done_to_a_session_that_is_recorded_now(known, tmp_path, what, is_foreign):
    station = station_module.Station(known, Sessions(tmp_path))
    station.supervisor = types.SimpleNamespace(phase="idle" if is_foreign else "running", ended_at=0.0,
                                               state=lambda: {"session": None if is_foreign else "s1"})
    if is_foreign:
        station._daemon_heard = time.monotonic()
        station.newest["session"] = {"directory": f"{tmp_path}/s1/"}
    assert asyncio.run(station.do(what, {"session": "s1", "sure": True})) == (False, "this session is running", {})
    assert station.records.called == []


def test_a_session_whose_report_is_being_written_is_not_deleted(known, tmp_path):
    station = station_module.Station(known, Sessions(tmp_path))
    station.supervisor = types.SimpleNamespace(phase="idle", ended_at=0.0, state=lambda: {"session": None})
    station.finisher = types.SimpleNamespace(is_busy=lambda name: name == "s1")
    done, text, _ = asyncio.run(station.do("delete", {"session": "s1", "sure": True}))
    assert not done and "being written" in text and station.records.called == []
