"""Tests what an instructor can choose, and the arguments with which the station then starts its programs."""

import asyncio
import datetime
import json
import pathlib
import shutil
import sys
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from raven2_station import curriculum, library, supervisor, words  # noqa: E402
from station_parts import GOOD  # noqa: E402


def test_the_steps_of_each_track_are_counted(known):
    for exercise in known.exercises:
        assert sum(exercise["tracks"]) == len(exercise["steps"]) and all(exercise["tracks"])


def test_what_the_page_offers_is_what_the_configuration_has(known):
    assert {e["name"] for e in known.exercises} == {p.stem for p in (ROOT / "config/exercises").glob("*.yaml")}
    assert {h["name"] for h in known.hazards} == {p.stem for p in (ROOT / "config/faults").glob("*.yaml")}
    assert all(h["title"] and h["expected"] and h["response"] for h in known.hazards)
    severities = [words.SEVERITIES.index(h["severity"]) for h in known.hazards]
    assert severities == sorted(severities) and severities[0] == 0
    assert known.links[0]["name"] == "none" and "browser" not in known.names("masters")
    json.dumps(known.describe())


def test_a_good_choice_is_taken(known):
    choice = supervisor.Choice(GOOD, known)
    assert choice.is_drill and choice.seed > 0
    assert supervisor.Choice({}, known).exercise == "none"
    assert supervisor.Choice({**GOOD, "seed": 7}, known).seed == 7


@pytest.mark.parametrize("change, words_of_it", [
    ({"trainee": "Ann Smith"}, "not an ID"), ({"trainee": "a" * 33}, "not an ID"), ({"trainee": "../x"}, "not an ID"), ({"trainee": "ann\n"}, "not an ID"),
    ({"driver": "expert\n"}, "driver"),
    ({"exercise": "nonsense"}, "exercise"), ({"hazard": "nonsense"}, "hazard"), ({"link": "nonsense"}, "link"),
    ({"driver": "nonsense"}, "driver"), ({"driver": "clumsy:nonsense"}, "clumsy"), ({"driver": "master:nonsense"}, "hand device"),
    ({"driver": "expert; rm -rf /"}, "driver"), ({"exercise": "none"}, "drill"), ({"exercise": "none", "hazard": "none"}, "exercise"),
    ({"when": "never"}, "when"), ({"curriculum": "nonsense"}, "curriculum"), ({"seed": "1"}, "seed"), ({"seed": 1 << 60}, "seed"),
    ({"seed": True}, "seed"), ({"extra": 1}, "unknown setting"), ({"trainee": 5}, "not a text"), ({"trainee": None, "link": []}, "link")])
def test_a_choice_that_cannot_be_is_refused_in_words(known, change, words_of_it):
    with pytest.raises(supervisor.Refused) as refused:
        supervisor.Choice({**GOOD, **change}, known)
    assert words_of_it in str(refused.value) and len(str(refused.value)) > 10


def supervise(folder, known, stages=(), current=0):
    return supervisor.Supervisor(folder, folder, known, lambda: None, lambda trainee, curriculum: (list(stages), current))


def test_an_educators_own_configuration_is_offered_and_used(known, tmp_path):
    shutil.copytree(ROOT / "config", tmp_path / "ours")
    own = (tmp_path / "ours/curricula/frs_basics.yaml").read_text()
    (tmp_path / "ours/curricula/tuesday.yaml").write_text(own.replace("title:", "title: Tuesday, not", 1))
    ours = library.Library(ROOT, tmp_path / "ours")
    assert set(ours.names("curricula")) - set(known.names("curricula")) == {"tuesday"}
    assert ours.curriculum("tuesday")["title"].startswith("Tuesday")
    boss = supervisor.Supervisor(tmp_path, tmp_path, ours, lambda: None, lambda *_: ([], 0), config=tmp_path / "ours/trainer.yaml")
    used = boss._arguments(supervisor.Choice({**GOOD, "curriculum": "tuesday"}, ours))
    assert used[:2] == ["--config", str(tmp_path / "ours/trainer.yaml")] and used[used.index("--curriculum") + 1] == "tuesday"
    assert boss._profile("wifi") == str(tmp_path / "ours/impairments/wifi.yaml") and supervise(tmp_path, known)._profile("wifi") == "wifi"
    (tmp_path / "ours/curricula/tuesday.yaml").write_text("title: [")
    with pytest.raises(ValueError, match="tuesday.yaml"):
        library.Library(ROOT, tmp_path / "ours")
    (tmp_path / "ours/curricula/tuesday.yaml").write_text("stages: []")
    with pytest.raises(ValueError, match="lacks 'title'"):
        library.Library(ROOT, tmp_path / "ours")


def test_programs_get_what_was_chosen(known, tmp_path):
    boss = supervise(tmp_path, known)
    drill = boss._arguments(supervisor.Choice({**GOOD, "seed": 3}, known))
    assert drill == ["--seed", "3", "--trainee", "ann", "--exercise", "pick_hand_over_place", "--drill", "own", "--hazard", "none"]
    by_hand = boss._arguments(supervisor.Choice({**GOOD, "seed": 3, "hazard": "sudden_jump", "when": "instructor"}, known))
    assert "--drill" not in by_hand and by_hand[-2:] == ["--hazard", "none"]
    free = boss._arguments(supervisor.Choice({"hazard": "sudden_jump", "seed": 3}, known))
    assert free == ["--seed", "3", "--exercise", "none", "--hazard", "sudden_jump"]
    assert boss._hands(supervisor.Choice({"driver": "browser"}, known)) == ["--master", "browser"]
    assert boss._hands(supervisor.Choice({**GOOD, "driver": "master:omni_pair"}, known)) == ["--master", "omni_pair"]


def programs_of(boss, choice):
    """{name: arguments} of a session's programs, without starting them."""
    launched = {}

    async def launch(name, arguments):
        launched[name] = arguments

    async def await_log():
        pass

    boss._launch, boss._await_log = launch, await_log
    asyncio.run(boss._start(choice))
    return launched


@pytest.mark.parametrize("robot", ["", "192.168.0.102"])
def test_with_a_real_robot_the_trainer_is_strict(known, tmp_path, robot):
    """As launch/hardware.launch starts it."""
    boss = supervisor.Supervisor(tmp_path, tmp_path, known, lambda: None, lambda *_: ([], 0), robot=robot)
    launched = programs_of(boss, supervisor.Choice({}, known))
    assert ("virtual_raven" in launched) == (not robot)
    assert ("--strict" in launched["simulator"]) == bool(robot)
    assert '<arg name="strict" default="true"' in (ROOT / "launch/hardware.launch").read_text()


@pytest.mark.parametrize("driver, robot, forced, scale", [
    ("master:mtm", "", None, "0.2"), ("master:mtm", "192.168.0.102", None, "0.2"), ("browser", "", None, "0.1"),
    ("scripted", "", None, None), ("scripted", "192.168.0.102", None, "0.05"), ("expert", "192.168.0.102", None, "0.05"),
    ("master:omni_pair", "192.168.0.102", 0.02, "0.02"), ("scripted", "192.168.0.102", 0.02, "0.02")])
def test_console_and_daemon_have_the_same_motion_scale(known, tmp_path, driver, robot, forced, scale):
    """doc/hardware.md: with different ones, forces and record are wrong."""
    boss = supervisor.Supervisor(tmp_path, tmp_path, known, lambda: None, lambda *_: ([], 0), robot=robot, scale=forced)
    launched = programs_of(boss, supervisor.Choice({**GOOD, "driver": driver, **({"exercise": "none", "hazard": "none"} if driver == "scripted" else {})}, known))
    for name in ("master_console", "simulator"):
        given = launched[name]
        assert (given[given.index("--scale") + 1] if "--scale" in given else None) == scale
    assert "--scale" not in launched.get("virtual_raven", [])
    slow = f"""name="scale" default="$(eval '{library.SLOW}' if console"""
    assert slow in (ROOT / "launch/hardware.launch").read_text()


@pytest.mark.parametrize("sender, stream, hearer", [("master_console", "--master-port", "simulator"), ("simulator", "--force-port", "master_console"),
                                                    ("simulator", "--sight-port", "master_console")])
def test_a_bad_link_carries_each_stream_to_its_hearer(known, tmp_path, sender, stream, hearer):
    """config/network.yaml: motion goes to the daemon, forces and sight come from it."""
    launched = programs_of(supervise(tmp_path, known), supervisor.Choice({**GOOD, "link": "wifi"}, known))
    ways = dict(word.split(":127.0.0.1:") for word in launched["impair"] if ":127.0.0.1:" in word)
    sent, heard = (launched[name][launched[name].index(stream) + 1] for name in (sender, hearer))
    assert len(ways) == 3 and ways[sent] == heard != sent


def test_all_programs_of_a_session_have_its_seed(known, tmp_path):
    launched = programs_of(supervise(tmp_path, known), supervisor.Choice({**GOOD, "link": "wifi", "seed": 9}, known))
    assert sorted(launched) == ["impair", "master_console", "simulator", "virtual_raven"]
    assert {name: words[words.index("--seed") + 1] for name, words in launched.items()} == dict.fromkeys(launched, "9")


def test_sessions_have_the_time_of_utc_in_their_names(known, tmp_path, monkeypatch):
    monkeypatch.setenv("TZ", "Asia/Tokyo")
    time.tzset()
    try:
        name = supervise(tmp_path, known)._new_directory(supervisor.Choice(GOOD, known)).name
        told = datetime.datetime.strptime(name.split("_")[0], "%Y-%m-%dT%H-%M-%SZ").replace(tzinfo=datetime.timezone.utc)
        assert abs((datetime.datetime.now(datetime.timezone.utc) - told).total_seconds()) < 60
    finally:
        monkeypatch.undo()
        time.tzset()


def test_a_curriculum_chooses_exercise_and_hazard(known, tmp_path):
    asked = {"trainee": "ann", "curriculum": "frs_basics", "seed": 3, "when": "instructor", "driver": "expert"}
    stages = curriculum.stages_of(known.curriculum("frs_basics"))
    drills = [i for i, stage in enumerate(stages) if stage.drill]
    assert drills and drills[0] > 0
    for current in (0, drills[0]):
        boss = supervise(tmp_path, known, stages, current)
        choice = supervisor.Choice(boss._with_stage(asked), known)
        drill = ["--drill", stages[current].drill] if stages[current].drill else []
        assert boss._arguments(choice) == ["--seed", "3", "--curriculum", "frs_basics", "--trainee", "ann", "--exercise",
                                           stages[current].exercise, *drill, "--hazard", "none"]
        assert boss._with_stage(choice.as_dict()) == choice.as_dict(), "the next attempt asks again"
    with pytest.raises(supervisor.Refused, match="all stages"):
        supervise(tmp_path, known, stages, len(stages))._with_stage(asked)
    assert supervise(tmp_path, known)._with_stage({"curriculum": "nonsense"}) == {"curriculum": "nonsense"}
