"""Tests that the station has a sentence for every answer, mode and state, and that guides name what its pages show."""

import pathlib
import re
import sys

import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from raven2_station import library, words  # noqa: E402


def test_a_disengaged_robot_is_said():
    assert [words.mode(name, True) for name in ("pedal_up", "teleoperating")] == ["Ready: press the pedal", "The hands move the robot"]
    assert all("disengaged" in words.mode(name, False) for name in ("pedal_up", "teleoperating"))
    assert words.mode("paused", False) == words.mode("paused") and words.mode("some_mode", False) == "some mode"


def test_answers_are_sentences():
    assert words.answer("accepted") == "Done." and words.answer("the hazard acts") == "The hazard acts."
    assert words.clear_refused("stopped", True, True) == words.CLEAR_FIRST and words.clear_refused("stopped", False, True) == words.ROBOT_STOPPED
    assert words.clear_refused("stopped", False, False) == words.MODEL_STOPPED and words.clear_refused("pedal_up", False, False) == "Nothing is stopped."
    assert not any("bracket" in sentences for _, _, sentences in words.CAUSES), "a trainee sees none"
    assert words.sentence("the trainer is not running") == "The trainer is not running." and words.sentence("Done.") == "Done."


@pytest.mark.parametrize("header, array, sentences", [
    ("state.h", "kPlanningAnswerNames", words.PLANNING_ANSWERS), ("command.h", "kPlanStatusNames", words.PLAN_STATUSES)])
def test_each_answer_of_the_trainer_has_a_sentence(header, array, sentences):
    text = (ROOT / "include/raven2_trainer/core" / header).read_text()
    names = re.findall(r'"(\w+)"', text.split(array + "{")[1].split("}")[0])
    assert len(names) > 5 and set(names) == set(sentences)
    for name in [*names, "no answer", "accepted; the planner is still ending"]:
        assert re.fullmatch(r"[A-Z].*\.", words.answer(name)), name


@pytest.mark.parametrize("driver, is_one", [("expert", True), ("clumsy:hasty", True), ("scripted-over-wan", True), ("expert-over-net_delay_2", True),
                                            ("browser", False), ("own_console", False), ("own_console-over-wan", False), ("master:omni", False)])
def test_a_simulated_surgeon_is_known_by_its_name_also_over_a_link(driver, is_one):
    assert words.is_demonstration(driver) == is_one


def test_health_names_the_worst_and_a_remedy():
    assert words.health([("robot", 0, "fine"), ("recorder", 0, "")]) == (0, "Everything works.", "")
    assert words.health([("robot", 1, "late"), ("recorder", 2, "disk full")]) == (
        2, "The session is not recorded completely. Free disk space, or record to a faster disk.", "recorder: disk full")
    assert words.health([("a new state", 1, "odd")]) == (1, "Something does not work as it should.", "a new state: odd")
    assert "no picture" in words.health([("live picture", 2, "failed; the daemon's stderr says why")])[1]
    assert "Switch the robot on" not in words.health([("robot", 1, "PEDAL_UP; it refuses our fault plan (its own words say why)")])[1]
    assert words.health([])[0] == 2


def test_each_state_of_the_trainer_has_a_sentence():
    """Names on /diagnostics, from the sources that send them."""
    source = "".join(path.read_text() for path in (ROOT / "src/ros").rglob("*.cpp"))
    names = set(re.findall(r'\bstatus\("([^"]+)"', source)) | {f"{name} link" for name in re.findall(r'linkStatus\("([^"]+)"', source)}
    names |= {f"{name} loop" for name in re.findall(r'"(\w+)"', (ROOT / "include/raven2_trainer/core/record.h").read_text().split(
        "kLoopNames{")[1].split("}")[0])}
    names |= set(re.findall(r's\.name = "raven2_trainer: ([^"]+)"', source)) | {"master left", "master right"}
    assert len(names) > 10 and set(words.PROBLEMS) == names and set(words.ADVICE) == names
    assert {state for state, _, _ in words.CAUSES} <= names


def test_each_mode_and_each_clumsy_surgeon_is_in_words():
    clumsy = {name for path in (ROOT / "config/exercises").glob("*.yaml") for name in yaml.safe_load(path.read_text()).get("clumsy", {})}
    assert clumsy == set(words.CLUMSY), "each clumsy surgeon in words"
    header = (ROOT / "include/raven2_trainer/core/mode.h").read_text()
    names = header.split("kModeNames{")[1].split("}")[0].replace('"', "").replace("\n", "").split(",")
    assert {n.strip() for n in names} == set(words.MODES)


def test_the_page_names_the_elements_that_scripts_use():
    page = (ROOT / "scripts/raven2_station/page/instructor.html").read_text() + (
        ROOT / "scripts/raven2_station/page/trainee.html").read_text()
    for name in ("trainee exercise hazard driver start stop emergency-stop clear-stop inject next picture mode health verdict report "
                 "class-table take-hands pedal").split():
        assert f'data-test="{name}"' in page, name
    assert "http://" not in page and "https://" not in page and " style=" not in page and "<script>" not in page


GUIDES = ("doc/station.md", "doc/tutorials/surgeon_assistant.md", "doc/tutorials/educator.md")


def page_text():
    """All texts that the pages can show: those of their files, and the sentences of the station."""
    folder = ROOT / "scripts/raven2_station"
    files = [*sorted((folder / "page").iterdir()), *(folder / f"{name}.py" for name in ("words", "station", "supervisor")), ROOT / "src/ros/bridge/services.cpp"]
    texts = [p.read_text(encoding="utf-8") for p in files if p.is_file()]
    texts = [re.sub(r"<[^>]+>", " ", text) if text.startswith("<!doctype") else text for text in texts]  # a script's < begins no tag
    titles = [c["title"] for c in library.Library(ROOT).curricula]
    return " ".join(" ".join(texts + titles).split()).lower()


@pytest.mark.parametrize("guide", GUIDES)
def test_guides_name_what_the_pages_show(guide):
    """The italic words in the numbered steps are texts of a page."""
    steps = re.findall(r"(?ms)^\d+\. .*?(?=^\d+\. |^\n|^#)", (ROOT / guide).read_text(encoding="utf-8").split("## Appendix")[0])
    named = [" ".join(name.split()) for step in steps for name in re.findall(r"(?<!\*)\*([^*]+)\*(?!\*)", step)]
    assert len(named) >= 1
    text = page_text()
    assert [name for name in named if name.lower() not in text] == []
