"""Tests the scripts of the instructor's page in Node.js: its tabs, verdicts, histories and requests."""

import json
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from station_parts import GOOD, NO_BROWSER, run_page_script  # noqa: E402


def run_instructors_page(known, code):
    """The instructor's page in node, connected, and then `code`. @return what it prints, read as JSON."""
    if not shutil.which("node"):
        pytest.skip("node is not installed")
    names = ("link.js", "charts.js", "instructor_parts.js", "set_up.js", "verdict.js", "tabs.js", "instructor.js")  # as they import each other
    modules = [(ROOT / "scripts/raven2_station/page" / name).read_text(encoding="utf-8") for name in names]
    page = re.sub(r"(?m)^import .*$|^export ", "", "".join(modules))
    begin = f'link.socket.onopen(); hear({{ t: "library", ...{json.dumps(known.describe())}, trainees: [] }}); hear(idle);\n'
    done = subprocess.run(["node", "--input-type=module"], input=NO_BROWSER + page + begin + code, capture_output=True, text=True, check=False,
                          timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_each_failed_attempt_has_its_cross_in_the_curve():
    """Also one that broke off before its timer, which has neither time nor score."""
    attempts = [{"passed": False, "time": None, "score": None}] * 3 + [{"passed": False, "time": 20.0, "score": 0.4}, {"passed": True, "time": 9.0, "score": 1.0},
                                                                       {"passed": None, "time": 8.0, "score": None}]
    ends = run_page_script("charts.js", f"""
      const drawn = [];
      const context = new Proxy({{}}, {{ get: (_, name) => (name === "moveTo" ? (x, y) => drawn.push([x, y]) : () => {{}}), set: () => true }});
      drawCurve({{ getContext: () => context, width: 648, height: 260 }}, {json.dumps(attempts)});
      console.log(JSON.stringify(drawn));""")
    crosses = [x for x, y in ends if y in (242, 254)]
    assert sorted(crosses) == [x for i in range(4) for x in 2 * [24 + 100 * i + 44]], ends


@pytest.mark.parametrize("improve, shown", [([], "Nothing: every figure is well within its band."), ([{"what": "Time", "how": ""}], "")])
def test_where_there_is_nothing_to_improve_the_page_says_so(known, improve, shown):
    found = run_instructors_page(known, f"""
      hear({{ ...idle, last: "s1" }});

      await answers(asked.find((a) => a.do === "verdict").id, {{ headline: "Passed", passed: true, trouble: "", video: false, improve: {json.dumps(improve)},
        no_advice: "Nothing: every figure is well within its band." }});
      console.log(JSON.stringify([element("no-advice").textContent, element("improve").children.map((c) => c.textContent)]));""")
    assert found == [shown, [i["what"] for i in improve]]


def test_a_page_shows_why_its_messages_are_not_read(known):
    assert run_instructors_page(known, """
      hear({ t: "reply", id: null, ok: false, text: "too many messages" });
      console.log(JSON.stringify(element("said").textContent));""") == "too many messages"


def test_an_answer_about_a_trainee_who_is_no_longer_chosen_shows_nothing(known):
    found = run_instructors_page(known, """
      element("history-trainee").value = "ann"; element("history-trainee").fire("change");
      await answers(asked.find((a) => a.do === "sessions").id, { trainees: ["ann", "bob"], sessions: [] });
      const late = asked.find((a) => a.do === "history");
      element("history-trainee").value = "bob"; element("history-table").children = ["bob's"];
      await answers(late.id, { attempts: [] });
      console.log(JSON.stringify([late.with.trainee, element("history-table").children]));""")
    assert found == ["ann", ["bob's"]]


def test_the_tab_trainee_opens_with_the_trainee_of_the_last_session(known):
    found = run_instructors_page(known, f"""
      hear({{ ...idle, last: "s1", choice: {json.dumps({**GOOD, "trainee": "zoe", "curriculum": ""})} }});
      asked.length = 0; openTab("history");
      await answers(asked.find((a) => a.do === "sessions").id, {{ trainees: ["ann", "zoe"], sessions: [] }});
      console.log(JSON.stringify(asked.find((a) => a.do === "history").with.trainee));""")
    assert found == "zoe"


def test_a_history_can_be_of_one_exercise_alone(known):
    """Times of two exercises cannot be compared."""
    attempts = [{"start": "", "exercise": name, "hazards": [], "drill": "", "driver": "browser", "passed": True, "time": time, "score": None,
                 "response": None} for name, time in (("track_wire", 50), ("pick_hand_over_place", 30), ("track_wire", 40))]
    found = run_instructors_page(known, f"""
      element("curve").getContext = () => new Proxy({{}}, {{ get: () => () => ({{}}), set: () => true }});
      const rowsOf = async (exercise) => {{
        asked.length = 0; element("history-exercise").value = exercise; element("history-exercise").fire("change");
        await answers(asked.find((a) => a.do === "sessions").id, {{ trainees: ["ann"], sessions: [] }});
        await answers(asked.find((a) => a.do === "history").id, {{ attempts: {json.dumps(attempts)} }});
        return element("history-table").children.slice(1).map((row) => row.children[1].textContent);
      }};
      const all = await rowsOf("");
      console.log(JSON.stringify([all, element("history-exercise").options.map((o) => o.value), await rowsOf("track_wire")]));""")
    assert found == [["track wire", "pick hand over place", "track wire"], ["", "pick_hand_over_place", "track_wire"], ["track wire"] * 2]


def test_a_plan_is_executed_with_the_robot_only_by_its_own_button(known):
    found = run_instructors_page(known, """
      for (const id of ["execute", "execute-robot", "repeat-trial", "repeat-robot"]) element(id).fire("click");
      console.log(JSON.stringify(["execute", "repeat-trial"].map((what) => asked.filter((a) => a.do === what).map((a) => a.with.on_robot))));""")
    assert found == [[False, True], [False, True]]


def test_a_session_starts_as_it_was_set_up(known):
    chosen = {"trainee": "ann", "curriculum": "frs_basics", "exercise": "peg_transfer", "hazard": "sudden_jump", "when": "instructor", "link": "wifi",
              "driver": "expert"}
    found = run_instructors_page(known, f"""
      asked.length = 0;
      for (const [id, value] of Object.entries({json.dumps(chosen)})) element(id).value = value;
      element("form").fire("submit");
      console.log(JSON.stringify(asked.filter((a) => a.do === "start").map((a) => a.with)));""")
    assert found == [{**chosen, "seed": -1}]


def test_buttons_that_change_something_over_ask_for_the_other_state(known):
    found = run_instructors_page(known, """
      asked.length = 0;
      for (const away of [false, true]) { hear({ ...idle, phase: "running", hands_away: away }); element("take-hands").fire("click"); }
      for (const view of ["virtual", "real"]) { hear({ t: "mode", mode: "pedal_up", pedal: false, text: "", view }); element("view").fire("click"); }
      const shown = ["pedal_up", "stopped"].map((mode) => { hear({ t: "mode", mode, pedal: false, text: "" }); return !element("clear-stop").hidden; });
      console.log(JSON.stringify([asked.filter((a) => a.do === "take-hands" || a.do === "view").map((a) => a.with), shown]));""")
    assert found == [[{"away": True}, {"away": False}, {"real": True}, {"real": False}], [False, True]]


def test_a_page_that_heard_nothing_for_a_moment_asks_for_the_verdict_again(known):
    """Its buttons are of that session still."""
    found = run_instructors_page(known, """
      hear({ ...idle, last: "s1" });
      link.isSilent = true; showOpen(false); asked.length = 0;
      hear({ t: "alive", level: 0, text: "" });
      element("video").fire("click");
      console.log(JSON.stringify(asked.map((a) => [a.do, a.with.session])));""")
    assert ["verdict", "s1"] in found and ["video", "s1"] in found and "watch" in [what for what, _ in found]


def test_the_class_is_that_of_the_curriculum_that_is_chosen(known):
    names = known.names("curricula")
    found = run_instructors_page(known, f"""
      for (const tab of TABS) element(tab).hidden = tab !== "class";
      asked.length = 0; element("curriculum").value = "{names[-1]}"; element("curriculum").fire("change");
      console.log(JSON.stringify([asked.filter((a) => a.do === "class").map((a) => a.with), element("class-csv").href]));""")
    assert found == [[{"curriculum": names[-1]}], f"/class.csv?curriculum={names[-1]}"]


@pytest.mark.parametrize("chosen, given", [("none", "drill"), ("sudden_jump", None)])
def test_inject_takes_the_exercises_own_hazard_of_set_up(known, chosen, given):
    """Another exercise, or none, may run."""
    exercise = known.exercise("pick_hand_over_place")
    running = {**GOOD, "exercise": "none", "hazard": chosen, "when": "instructor", "curriculum": ""}
    found = run_instructors_page(known, f"""
      hear({{ ...idle, phase: "running", choice: {json.dumps(running)} }});
      element("exercise").value = "{exercise['name']}"; showChoices(); element("hazard").value = "own"; asked.length = 0;
      element("inject").fire("click"); console.log(JSON.stringify(asked.map((a) => a.with)));""")
    assert found == [{"hazard": exercise["drill"]} if given else {}]


@pytest.mark.parametrize("trouble, text", [("", "The report is being written."), ("no space left", "There is no report.")])
def test_a_page_that_comes_later_knows_of_a_report_that_failed(known, trouble, text):
    found = run_instructors_page(known, f"""
      hear({{ ...idle, last: "s1" }});
      await answers(asked.at(-1).id, {{ headline: "No report yet", improve: [], passed: null, video: false, trouble: "{trouble}" }});
      console.log(JSON.stringify([element("verdict").textContent, element("progress-text").textContent]));""")
    assert found == [text, f"The report failed: {trouble}" if trouble else ""]


@pytest.mark.parametrize("said, what, share, shown", [
    ("The emergency stop is not confirmed.", "video", 0.5, None), ("The hazard acts", "video", 0.5, None), ("The hazard acts", "report", 0.0, None),
    ("The video is being rendered.", "video", 0.5, "Video of s2: 50 %"), ("Video of s2: 49 %", "video", 0.5, "Video of s2: 50 %"),
    ("", "video", 0.5, "Video of s2: 50 %"), ("The hazard acts", "video", 1, "The video of s2 is ready."),
    ("The report is being written.", "report", None, "The report of s2 failed: no space left")])
def test_work_on_a_listed_session_says_its_end_and_its_percents_hide_no_other_text(known, said, what, share, shown):
    found = run_instructors_page(known, f"""
      element("said").textContent = "{said}";
      hear({{ t: "progress", session: "s2", what: "{what}", share: {json.dumps(share)}, text: "no space left" }});
      console.log(JSON.stringify(element("said").textContent));""")
    assert found == (shown or said)


def test_strips_have_each_arms_distance_in_millimetres_and_its_force(known):
    heard = [{"t": "strips", "apart": {"gold": 0.002, "green": 0.0035}, "force": {"gold": 0.5, "green": 1.5}},
             {"t": "strips", "apart": {"gold": None, "green": 0}, "force": {"gold": 0, "green": 0}}]
    found = run_instructors_page(known, f"{json.dumps(heard)}.forEach(hear);" """
      console.log(JSON.stringify([...strips.apart.samples, ...strips.force.samples].map(([, values]) => values)));""")
    assert found == [{"gold": 2, "green": 3.5}, {"gold": None, "green": 0}, *(message["force"] for message in heard)]


@pytest.mark.parametrize("when, says", [("own", "It comes by itself."), ("instructor", "It comes when you press Inject now.")])
def test_the_page_says_how_the_chosen_hazard_comes(known, when, says):
    running = {**GOOD, "hazard": "sudden_jump", "when": when, "curriculum": ""}
    found = run_instructors_page(known, f"""
      hear({{ ...idle, phase: "running", choice: {json.dumps(running)} }});
      console.log(JSON.stringify(element("armed").textContent));""")
    assert found == f'{next(h["title"] for h in known.hazards if h["name"] == "sudden_jump")}. {says}'


def test_a_history_is_in_percent_and_seconds(known):
    attempt = {"start": "", "exercise": "track_wire", "hazards": ["sudden_jump"], "drill": "sudden_jump", "driver": "clumsy:dropper",
               "passed": False, "time": 61.5, "score": 0.75, "response": 1.5}
    found = run_instructors_page(known, f"""
      element("curve").getContext = () => new Proxy({{}}, {{ get: () => () => ({{}}), set: () => true }});
      asked.length = 0; element("history-trainee").value = "ann"; element("history-trainee").fire("change");
      await answers(asked.find((a) => a.do === "sessions").id, {{ trainees: ["ann"], sessions: [] }});
      await answers(asked.find((a) => a.do === "history").id, {{ attempts: [{json.dumps(attempt)}] }});
      console.log(JSON.stringify(element("history-table").children[1].children.map((cell) => cell.textContent)));""")
    assert found == ["", "track wire", "sudden jump", "demonstration: surgeon who drops things", "not passed", "75.0 %", "61.5 s", "1.5 s"]
