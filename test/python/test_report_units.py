"""Every number of the report with its unit, against the number in metrics.json, score.json or the log. For both arms,
and on the session's clock, which stops while the exercise is paused."""
import html
import pathlib
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import report_session as made  # noqa: E402

import raven2_figures  # noqa: E402  (in the same folder as raven2_session)
import raven2_session  # noqa: E402
from raven2_report import curves, details, drawing, hazard_page, metric_words, record, scorecard  # noqa: E402
from raven2_report import timeline, verdict, view3d  # noqa: E402
from raven2_report.facts import PHASES, Facts  # noqa: E402

READ = {"-": "", "count": "", "um": " µm", "m/s^3": " m/s³", "Ns": " N s"}  # a unit as a reader sees it


def test_every_mode_has_its_words():
    header = (made.ROOT / "include/raven2_trainer/core/mode.h").read_text(encoding="utf-8")
    names = re.search(r"kModeNames\{(.*?)\}", header, re.S).group(1)
    assert list(PHASES) == re.findall(r'"(\w+)"', names)


def cells(html):
    """Rows of the first table, title row first, without tags."""
    rows = re.findall(r"<tr>(.*?)</tr>", html, re.S)
    return [[re.sub(r"<[^>]+>", "", cell) for cell in re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, re.S)]
            for row in rows]


def column(html, title):
    table = cells(html)
    return [row[table[0].index(title)] for row in table[1:]]


def units():
    """{metric: unit} from doc/scores.md."""
    text = (made.ROOT / "doc/scores.md").read_text(encoding="utf-8")
    found = {}
    for names, unit in re.findall(r"^\| ((?:`\w+`(?:, )?)+) \| ([^|]+) \| (?:lower|higher) \|", text, re.M):
        named, given = re.findall(r"`(\w+)`", names), unit.split(", ")
        found.update(zip(named, given * len(named) if len(given) == 1 else given))
    return found


# ---- score.json -------------------------------------------------------------------------------------------------


def test_the_page_knows_every_metric_of_the_documentation():
    assert set(units()) == set(metric_words.WORDS) and len(units()) == 34


def scored_facts(metrics):
    attempt = {"metrics": metrics, "status": "done"}
    return SimpleNamespace(attempt=attempt, score={"force_limit_N": 3.0}, attempts=[attempt],
                           training={"exercise": "x", "drill": "none"})


@pytest.mark.parametrize("name", list(units()))
def test_a_metric_is_shown_in_its_unit(name):
    unit = units()[name]
    value, mean, deviation, limit = (3.0, 2.0, 1.0, 5.0) if unit == "count" else (3.4567, 2.4567, 1.4567, 5.4567)
    facts = scored_facts({name: made.metric(value, mean, deviation, limit, unit)})
    ((_, _, shown, expert, most, passed),) = scorecard.all_metrics(facts)
    digits = 0 if unit == "count" else metric_words.WORDS[name].digits
    text = lambda number: f"{number:.{digits}f}" + READ.get(unit, f" {unit}")  # noqa: E731
    assert (shown, most, passed) == (text(value), text(limit), "✓ passed")
    spread = f"{deviation:.1f}" if unit == "count" and not float(deviation).is_integer() else text(deviation)
    assert expert == f"{text(mean)} ± {spread}"
    (found,) = record.build(record_facts(facts), [])["metrics"]
    assert [found[key] for key in ("value", "mean", "deviation", "limit", "unit")] == [value, mean, deviation, limit,
                                                                                     unit]
    assert verdict.improvements(SimpleNamespace(**{**vars(facts), "attempt": {**facts.attempt, "improve": [name]}}))


def test_the_metric_that_is_farthest_beyond_its_limit_is_said_first():
    far = {"time": 0.25, "path": 3.0, "drops": 1.5, "idle": -2.0}
    metrics = {name: {"passed": excess <= 0.0, "excess": excess} for name, excess in far.items()}
    assert verdict.failed_metrics(SimpleNamespace(attempt={"metrics": metrics})) == ["path", "drops", "time"]


@pytest.mark.parametrize("drill, verdicts, bad", [
    ("none", ["right", "late", "wrong", "none", "not_judged", "coincidence"], ["late", "wrong", "none"]),
    ("none", ["not_judged"], []), ("x", ["not_judged"], []), ("x", [], []), ("x", ["not_judged", "right"], []),
    ("x", ["late"], ["late"])])
def test_a_late_answer_is_none_and_a_drill_without_a_cue_is_lacking(drill, verdicts, bad):
    facts = SimpleNamespace(attempt={"hazards": [{"verdict": each} for each in verdicts]}, training={"drill": drill})
    assert [hazard["verdict"] for hazard in verdict.badly_answered(facts)] == bad
    assert verdict.lacked_its_drill(facts) == (drill == "x" and verdicts in ([], ["not_judged"]))


@pytest.mark.parametrize("better, side", [("lower", 0), ("higher", 1)])
def test_the_band_is_shaded_on_the_side_where_the_metric_passes(better, side):
    metric = made.metric(3.0, 2.0, 0.5, 4.0, "s", better)
    panel = drawing.Panel(9, 5, 202, 16, scorecard.band_range(metric), (0, 1))
    ends = [panel.x, panel.to_x(4.0), panel.x + panel.width][side:side + 2]
    x, width = re.search(r'<rect x="([\d.]+)"[^>]* width="([\d.]+)"[^>]*fill="#d9dee4"',
                         scorecard.band_svg("time", metric)).groups()
    assert [float(x), float(x) + float(width)] == pytest.approx(ends, abs=0.2)


def test_the_metric_farthest_out_of_its_band_is_named_first():
    limits = {"time": 4.9, "path": 3.0, "drops": 4.0, "idle": 7.0}
    facts = scored_facts({name: made.metric(5.0, 2.0, 1.0, limit) for name, limit in limits.items()})
    assert verdict.failed_metrics(facts) == ["path", "drops", "time"]


@pytest.mark.parametrize("better, said", [("lower", "at most 5.0 s"), ("higher", "at least 5.0 s")])
def test_a_limit_is_said_for_the_side_that_passes(better, said):
    row = scorecard._row("time", {**made.metric(6.0, 4.0, 1.0, 5.0, "s"), "better": better}, {})
    assert re.findall(r'<span class="limit">(.*?)</span>', row) == [said]


@pytest.mark.parametrize("better, limit, whole", [("lower", 2.7, 2), ("lower", 2, 2), ("higher", 2.2, 3), ("higher", 2, 2)])
def test_a_limit_of_counts_is_the_last_whole_number_that_passes(better, limit, whole):
    assert metric_words.limit_of({"unit": "count", "better": better, "limit": limit}) == whole


def record_facts(facts):
    """Adds the facts that build() needs in addition to the metrics."""
    series = SimpleNamespace(runlevel=np.zeros(0), t=np.zeros(0), tracking=np.zeros(0, bool))
    return SimpleNamespace(**{**vars(facts), "score": {}, "name": "s", "meta": {}, "duration": 1.0, "header": {
        "hazard": "none", "seed": 1, "motion": ""}, "training": {"exercise": "x", "drill": "none", "trainee": "",
                                                               "curriculum": "none"}, "phases": [], "steps": [],
        "mistakes": lambda: [], "hazards": [], "deviations": [], "unmerged": False, "faults": [],
        "moments": lambda: [], "series": series,
        "emergency_stop": lambda: None, "session": SimpleNamespace(directory=".")})


JUDGED = {"force_after_ms": 21, "cue_after_ms": 322, "excursion_mm": 12.25, "error_mm": 9.5, "peak_force_N": 2.75,
          "reaction": {"response": "slow", "after_ms": 450}, "deciding": {"response": "pedal_up", "after_ms": 1250},
          "verdict": "right", "touches": {}, "coincidences": []}


@pytest.mark.parametrize("verdict_, seconds", [("right", 0.928), ("late", 0.928), ("wrong", None), ("none", None)])
def test_the_curve_of_answers_counts_from_the_cue_to_the_answer_that_was_right(verdict_, seconds):
    values = curves._values({"metrics": {}, "hazards": [{**JUDGED, "verdict": verdict_}]})
    assert values.get(curves.ANSWER) == (seconds and pytest.approx(seconds))


def hazard_facts(fault=None):
    hazard = {"name": "sudden_jump", "at_s": 1.5, "end_s": 1.9, "fault": fault or {}, "judged": JUDGED}
    facts = SimpleNamespace(hazards=[hazard])
    facts.answers = lambda h: Facts.answers(facts, h)
    facts.reaction = lambda h: Facts.reaction(facts, h)
    return facts, hazard


@pytest.mark.parametrize("fault, error, force", [({}, "9.50 mm", "2.75 N"),
                                                ({"max_error_mm": 10.5, "max_force_N": 3.25}, "10.50 mm", "3.25 N")])
def test_a_hazard_s_row_is_in_the_units_of_its_figures(fault, error, force):
    facts, hazard = hazard_facts(fault)
    table = cells(hazard_page._table(facts))
    assert table[1] == ["1", "sudden jump", "1.500 s", error, "12.25 mm", force, "322 ms",
                        "slowed down after 450 ms, released the pedal after 1,250 ms", "answered rightly"]
    found = record._hazard(facts, hazard)
    assert [found[key] for key in ("at_s", "end_s", "largest_error_mm", "excursion_mm", "largest_force_N", "cue_after_s",
                                  "reaction_after_s")] == [1.5, 1.9, fault.get("max_error_mm", 9.5), 12.25,
                                                           fault.get("max_force_N", 2.75), 0.322, 0.45]


def answer_of(**changes):
    """The page's words for JUDGED with these changes."""
    facts, hazard = hazard_facts()
    hazard["judged"] = {**JUDGED, **changes}
    return html.unescape(hazard_page._answer(facts, hazard))


def test_what_could_not_be_noticed_is_said_with_its_thresholds():
    thresholds = (made.ROOT / "include/raven2_trainer/haptics/perception.h").read_text(encoding="utf-8")
    assert re.search(r"kFeltForce = 0\.5;", thresholds) and re.search(r"kSeenGap = 0\.003;", thresholds)
    assert answer_of(verdict="not_judged", cue=None, cue_after_ms=None) == (
        "No force of 0.5 N and no gap of 3 mm lasted 100 ms: there was nothing to answer, and nothing is judged.")


def test_a_response_long_after_the_injection_may_still_be_too_early_for_the_cue():
    text = answer_of(coincidences=[{"response": "retreat", "after_ms": 400}])
    assert text.endswith("A response before 100 ms after the cue is no reaction and is left out.")
    assert "left out" not in answer_of()


STOP, RELEASE = ({"response": response, "after_ms": 350} for response in ("stop", "pedal_up"))
WHY = {"nothing": "there was nothing to feel or to see in time", "stop": "an emergency stop came before anybody could react",
       "end": "the recording ends, or was paused, before an answer could be seen"}


@pytest.mark.parametrize("cue, early, why", [
    (322, [STOP], "stop"), (322, [RELEASE, STOP], "stop"), (322, [RELEASE], "end"), (322, [], "end"), (322, None, "end"),
    (322, [None, "stop", 3], "end"), (None, [STOP], "nothing"), (None, [], "nothing")])
def test_a_hazard_that_is_not_judged_says_why(cue, early, why):
    changes = {"verdict": "not_judged", "cue_after_ms": cue, "coincidences": early, "reaction": None, "deciding": None}
    judged = {**JUDGED, **changes}
    assert hazard_page.verdict_words(judged) == f"not judged: {WHY[why]}"
    if cue:
        assert answer_of(**changes).startswith(f"The force showed it after 322 ms. Not judged: {WHY[why]}.")
    drill = SimpleNamespace(attempt={"hazards": [{**judged, "cue_after_ms": None}, judged]})
    assert verdict._drill_words(drill) == (
        f"in the drill {WHY[why]}" if cue else "the hazard of the drill gave nothing to feel or to see in time")


def test_a_response_to_a_hazard_that_is_not_judged_is_still_said():
    text = answer_of(verdict="not_judged", deciding=None)
    assert text == f"The force showed it after 322 ms; the surgeon slowed down 450 ms after it began. Not judged: {WHY['end']}."


def test_the_hands_of_older_scores_had_let_go():
    old = {"verdict": "coincidence", "cue_after_ms": 12}
    assert hazard_page.verdict_words(old) == "not judged: the hands had let go before anybody could react"
    assert hazard_page.verdict_words({}) == hazard_page.verdict_words({"verdict": "new"}) == "not judged"


@pytest.mark.parametrize("took, said", [(2960, "not charged with these 3.0 s."), (0, None), (None, None)])
def test_it_says_what_an_attempt_is_not_charged_with(took, said):
    facts, hazard = hazard_facts()
    hazard["judged"] = {**JUDGED, "answer_time_ms": took}
    text = hazard_page._answer(facts, hazard)
    assert (said in html.unescape(text)) if said else ("charged" not in text)


@pytest.mark.parametrize("verdict_, release, needed, said", [
    ("none", 1400, 2000, "up for 1.4 s. A release is an answer from 2.0 s on: less looks like a clutch."),
    ("wrong", 3000, 4100, "up for 3.0 s. A release is an answer from 4.1 s on: twice this surgeon's usual clutch."),
    ("none", 0, 2000, None), ("wrong", 2000, 2000, None), ("right", 400, 2000, None), ("not_judged", 400, 2000, None),
    ("none", None, None, None)])
def test_a_release_that_was_too_short_is_named_with_the_time_that_it_takes(verdict_, release, needed, said):
    text = html.unescape(answer_of(verdict=verdict_, release_ms=release, release_needed_ms=needed))
    assert (said in text) if said else ("pedal was up" not in text)


@pytest.mark.parametrize("verdict_, colour", [("right", "GOOD"), ("late", "BAD"), ("wrong", "BAD"), ("none", "BAD")])
def test_only_a_right_answer_is_drawn_as_one(verdict_, colour):
    facts, hazard = hazard_facts()
    hazard["judged"] = {**JUDGED, "verdict": verdict_}
    lanes = timeline.Lanes(5.0)
    timeline._hazards(facts, lanes)
    marks = re.findall(r'<path [^>]*fill="([^"]+)"[^>]*><title>([^,<]*)', "".join(lanes.parts))
    assert marks == [(drawing.SOFT, "slowed down"), (getattr(drawing, colour), "released the pedal")]


def test_the_timeline_goes_on_to_the_last_hazard():
    quiet = SimpleNamespace(phases=[(0.0, 5.0, "teleoperating"), (5.0, 90.0, "pedal_up")], attempt=None, events=[],
                            hazards=[], duration=90.0)
    assert timeline.shown_until(quiet) == pytest.approx(1.15 * 5.0 + 2.0)
    for end, last in ((25.0, 25.0), (None, 20.0)):
        quiet.hazards = [{"at_s": 20.0, "end_s": end}]
        assert timeline.shown_until(quiet) == pytest.approx(1.15 * last + 2.0)


def test_a_hazard_s_moments_lie_where_they_happened():
    facts, hazard = hazard_facts()
    low, high = -0.5, 2.0
    width = hazard_page.WIDTH - hazard_page.LEFT - hazard_page.RIGHT
    found = {name: (x - hazard_page.LEFT) / width * (high - low) + low
             for x, name, _, _ in hazard_page._moments(facts, hazard, low, high)}
    assert found == pytest.approx({"hazard": 0.0, "first force": 0.021, "noticed": 0.322, "slowed down": 0.45,
                                   "released the pedal": 1.25})


@pytest.mark.parametrize("end, until", [(None, 13.2), (11.0, 13.2), (13.5, 14.5), (60.0, 18.0)])
def test_a_hazard_is_drawn_a_second_past_its_end_and_for_eight_at_most(end, until):
    facts = SimpleNamespace(duration=100.0)
    assert hazard_page._window(facts, {"at_s": 10.0, "end_s": end}) == pytest.approx((9.4, until))
    facts.duration = 12.0
    assert hazard_page._window(facts, {"at_s": 10.0, "end_s": end}) == pytest.approx((9.4, 12.0))


def test_a_hazard_is_shaded_from_its_beginning_to_its_end():
    panel = drawing.Panel(70, 0, 910, 104, (-0.5, 2.5), (0.0, 1.0))
    time = np.array([0.0, 1.0])
    parts = hazard_page._panel({"at_s": 1.5, "end_s": 1.9}, panel, "", time, [(time, drawing.INK, "", "")], None)
    (x, width), = re.findall(rf'<rect x="([\d.]+)"[^>]*width="([\d.]+)"[^>]*fill="{drawing.HAZARD}"', parts)
    assert (float(x), float(x) + float(width)) == pytest.approx((panel.to_x(0.0), panel.to_x(0.4)), abs=0.11)


def advice(**changes):
    """The page's part about improvements for an attempt without any in score.json."""
    facts = scored_facts({"time": made.metric(2.0, 2.0, 0.1, 2.5)})
    facts.attempt.update({"improve": [], "passed": None, **changes})
    return re.sub(r"<[^>]+>", " ", scorecard._improvements(facts)).split("What to improve")[-1].strip()


@pytest.mark.parametrize("changes, said", [
    ({"passed": True}, "Nothing: every figure is well within its band."),
    ({}, "Nothing: every figure is well within its band."),
    ({"metrics": {"time": made.metric(2.0)}}, "Unknown: no figure was judged."),
    ({"passed": False, "status": "failed"}, "The reason is given above. No figure needs work."),
    ({"status": "failed", "metrics": {}}, "The reason is given above. No figure needs work."),
    ({"passed": False, "status": "running"}, "The reason is given above. No figure needs work."),
    ({"status": "running"}, ""), ({"status": "waiting", "metrics": {}}, "")],
    ids=["passed", "not judged", "no band", "failed", "failed without a band", "unfinished", "running", "waiting"])
def test_a_page_without_advice_says_why(changes, said):
    assert advice(**changes) == said


# ---- metrics.json -----------------------------------------------------------------------------------------------

METRICS = {
    "duration_s": 12.5, "ticks": 12500, "on_time_ratio": {"physics": 0.98765, "haptic": 0.87654},
    "model_robot_error_mm": {"mean": 1.234, "std": 0.567, "max": 2.5},
    "haptic": {"max_force_N": 3.21, "max_force_outside_faults_N": 0.45},
    "plan": {"success": True, "status": "success", "cost": 6.543, "waypoints": 14},
    "timing": {name: {"ticks": 12000 + i, "slips": 31 + i, "late_runs": 41 + i, "longest_late_run": 51 + i,
                      "time_slips": 61 + i, "wake_up_us": {"p999": 71234.0 + i}, "run_us": {"p999": 81234.0 + i},
                      "max_late_us": 9120.0 + i, "max_run_us": 9230.0 + i, "stale_reads": 91 + i}
               for i, name in enumerate(("physics", "haptic"))},
    "packets": {"master_to_daemon": {"received": 110, "applied": 108, "used": 107, "rejected": {"duplicate": 2}},
                "daemon_to_robot": {"sent": 209, "failed": 3, "dropped": 4, "received": 202, "applied": 201,
                                    "rejected": {"checksum": 1}},
                "robot_to_daemon": {"received": 305, "applied": 305, "rejected": {}},
                "daemon_to_console": {"sent": 404, "failed": 5, "dropped": 6}}}
FAULTS = [{"name": "sudden_jump", "first_tick": 1234, "last_tick": 1533, "first_cycle": 2345, "last_cycle": 2644,
           "max_error_mm": 10.125, "max_force_N": 2.25, "error_to_force_ms": delay} for delay in (7, 9)]


def engineering(**more):
    header = {"hazard": "sudden_jump"}
    facts = SimpleNamespace(session=None, series=SimpleNamespace(t=np.zeros(12500)), metrics=METRICS, meta={}, log=None,
                            header=header, duration=12.5, faults=FAULTS, deviations=[], unmerged=False, score_broken=False)
    return details.Details(SimpleNamespace(**{**vars(facts), **more}))


def test_the_cards_are_in_the_units_of_metrics_json():
    cards = dict(re.findall(r"<span>(.*?)</span><b>(.*?)</b>", engineering().cards()))
    assert cards == {"Duration": "12.5 s", "Ticks": "12,500", "On time": "98.76 %", "Faults": "2",
                     "Model to robot": "1.23 ± 0.57 mm", "Largest distance": "2.50 mm", "Strongest cue": "3.21 N",
                     "Plan": "success"}
    notes = engineering().cards()
    for text in ("haptic loop 87.65 %", "outside faults 0.45 N<br>9 ms at most", "cost 6.54, 14 waypoints"):
        assert text in notes, text


def test_what_full_queues_lost_is_reported_and_records_apart_from_it():
    log = SimpleNamespace(clean=True, bad_bytes=0, truncated_bytes=0, lost=0)
    queues = {"relay_packets": {"dropped": 1234}, "force_packets": {"dropped": 0}, "tick_records": {"dropped": 5}}
    found = engineering(log=log, metrics={"queues": queues, "records_dropped": 6}).notices()
    assert re.findall(r"<p[^>]*>(.*?)</p>", found) == [
        "6 records are missing from the log.", "Queues were full: 1,234 relay packets were lost."]


def test_what_a_crashed_sessions_gap_records_miss_is_reported():
    log = SimpleNamespace(clean=True, bad_bytes=0, truncated_bytes=0, lost=40)
    found = engineering(log=log, metrics={"records_dropped": 0}).notices()
    assert re.findall(r"<p[^>]*>(.*?)</p>", found) == ["40 records are missing from the log."]


def test_the_faults_are_in_the_units_of_metrics_json():
    rows = cells(engineering().fault_table())[1:]
    assert rows[0] == ["1", "sudden jump", "1.234 s", "300 ms", "2,345 – 2,644", "10.12 mm", "2.25 N", "7 ms"]
    assert rows[1][-1] == "9 ms"


def test_the_loops_times_are_microseconds_shown_as_milliseconds():
    rows = cells(engineering().timing_table())[1:]
    assert rows == [[name, f"12,00{i}", str(31 + i), str(41 + i), f"{51 + i} ms", str(61 + i), f"71.23{4 + i} ms",
                     f"81.23{4 + i} ms", "9.12 ms", "9.23 ms", str(91 + i)]
                    for i, name in enumerate(("physics", "haptic"))]


def test_the_packets_are_those_of_their_link():
    rows = cells(engineering().packet_table())[1:]
    assert [row[1:9] for row in rows] == [
        ["–", "–", "110", "108", "2", "✓", "107", "duplicate 2"],
        ["209", "7", "202", "201", "1", "✓", "–", "checksum 1"],
        ["–", "–", "305", "305", "0", "✓", "–", ""],
        ["404", "11", "–", "–", "–", "", "–", ""]]


def test_what_a_robot_does_not_report_is_said_so():
    unknown = {"received": None, "applied": None, "rejected": None}
    packets = {**METRICS["packets"], "daemon_to_robot": {**METRICS["packets"]["daemon_to_robot"], **unknown}}
    row = cells(engineering(metrics={**METRICS, "packets": packets}).packet_table())[2]
    assert row[1:9] == ["209", "7", "–", "–", "–", "not reported by this robot", "–", ""]


def story_facts(judged, forces=(2.25, 2.25)):
    """FAULTS with these largest forces, and their hazards in score.json."""
    faults = [{**fault, "max_force_N": force} for fault, force in zip(FAULTS, forces)]
    hazards = [{"fault": fault, "judged": entry} for fault, entry in zip(faults, judged)]
    return SimpleNamespace(duration=12.5, faults=faults, hazards=hazards, deviations=[], unmerged=False,
                           emergency_stop=lambda: 4.25)


def test_the_story_has_millimetres_newtons_and_seconds():
    assert verdict.story(story_facts([{"cue": "force", "cue_after_ms": 12}] * 2)) == (
        "A session of 12 s in which the hazard “sudden jump” acted twice: the robot's tip left that of its model by up "
        "to 10.1 mm, and each time the surgeon was warned through the hand controller, with up to 2.2 N. The robot's "
        "emergency stop acted after 4.2 s.")


FELT = {"cue": "force", "cue_after_ms": 12}
SEEN = {"cue": "ghost", "cue_after_ms": 130}
UNNOTICED = {"cue": None, "cue_after_ms": None}
WARNED = "the surgeon was warned through the hand controller, with up to"


@pytest.mark.parametrize("judged, said", [
    ([FELT, FELT], f"and each time {WARNED} 4.5 N"), ([FELT, UNNOTICED], f"and in 1 of 2 cases {WARNED} 1.2 N"),
    ([SEEN, FELT], f"and in 1 of 2 cases {WARNED} 4.5 N"), ([UNNOTICED, UNNOTICED], "and no force warned the surgeon"),
    ([SEEN, UNNOTICED], "and the picture warned the surgeon before any force"),
    ([{"cue_after_ms": 12}, SEEN], f"and in 1 of 2 cases {WARNED} 1.2 N"),
    ([FELT, {}], f"and in 1 of 1 judged cases {WARNED} 1.2 N"), ([{}, {}], "and the largest force on the hand was 4.5 N")],
    ids=["both", "one", "seen and felt", "none", "seen", "older score", "one judged", "no score"])
def test_only_a_force_that_was_a_cue_has_warned_the_surgeon(judged, said):
    """Each fault has a force on the hand. Only score.json knows whether it lasted long enough to be noticed."""
    assert verdict.story(story_facts(judged, (1.25, 4.5))).split(" mm, ")[1].split(". The robot's")[0] == said


@pytest.mark.parametrize("judged, said", [([FELT], f"and {WARNED} 0.8 N"), ([UNNOTICED], "and no force warned the surgeon")])
def test_the_story_of_one_hazard_says_what_its_page_says(judged, said):
    facts = story_facts(judged, (0.75,))
    assert said in verdict.story(facts)
    facts.hazards[0]["judged"] = {**JUDGED, **judged[0], "verdict": "not_judged"}
    facts.answers = lambda hazard: []
    assert ("The force showed it" in hazard_page._answer(facts, facts.hazards[0])) == (judged == [FELT])


def parted_facts(hazards, force=1.26, error=8.37, arm=1):
    """A robot that leaves its model twice within half a second, and once more later."""
    t = np.arange(10000) / 1000.0
    series = SimpleNamespace(t=t, error_mm=np.full((len(t), 2), 0.4), tolerance_mm=3.0, force_t=t, force=np.zeros((len(t), 2)))
    for first, last in ((2000, 2200), (2600, 2700), (7000, 7010)):
        series.error_mm[first:last, arm] = error
        series.force[first:last, arm] = force
    facts = SimpleNamespace(series=series, hazards=hazards, _partings=Facts._partings, _is_of=Facts._is_of)
    return Facts._deviations(facts)


@pytest.mark.parametrize("arm", [0, 1])
def test_what_no_known_fault_explains_is_a_deviation(arm):
    found = parted_facts([], arm=arm)
    assert [(round(d["at_s"], 3), round(d["end_s"], 3), d["arm"], d["error_mm"], d["force_N"]) for d in found] == [
        (2.0, 2.7, ("gold", "green")[arm], 8.37, 1.26), (7.0, 7.01, ("gold", "green")[arm], 8.37, 1.26)]
    assert parted_facts([], force=0.49) == [] and parted_facts([], error=2.9) == []


def test_a_hazard_explains_what_comes_until_half_a_second_behind_its_aftermath():
    hazard = {"name": "x", "at_s": 1.9, "end_s": 2.0, "fault": {}, "judged": {}}
    assert [d["at_s"] for d in parted_facts([hazard])] == [7.0]
    assert [d["at_s"] for d in parted_facts([{**hazard, "end_s": None, "at_s": 1.4}])] == [2.0, 7.0]
    assert parted_facts([{**hazard, "fault": {"end_tick": 6600}}]) == []


@pytest.mark.parametrize("at, left", [(2.05, [7.0]), (2.15, [2.0, 7.0]), (6.95, [2.0]), (8.0, [2.0, 7.0])])
def test_a_hazard_explains_nothing_that_began_more_than_a_tenth_of_a_second_before_it(at, left):
    hazard = {"name": "x", "at_s": at, "end_s": at + 0.01, "fault": {}, "judged": {}}
    assert [d["at_s"] for d in parted_facts([hazard])] == left


@pytest.mark.parametrize("count, said", [(0, "No fault acted on the robot."),
                                         (1, "No fault is known. One deviation of unknown cause is listed above."),
                                         (2, "No fault is known. Two deviations of unknown cause are listed above.")])
def test_faults_are_not_denied_where_a_deviation_has_no_known_cause(count, said):
    assert engineering(faults=[], deviations=parted_facts([])[:count]).fault_table() == f"<p>{said}</p>"


def test_deviations_of_unknown_cause_stand_on_the_page():
    facts = SimpleNamespace(hazards=[], deviations=parted_facts([]), duration=10.0, faults=[], unmerged=False,
                            emergency_stop=lambda: None)
    page = hazard_page.section(facts)
    assert "No fault acted" not in page and cells(page)[1] == ["2.000 s", "700 ms", "green", "8.37 mm", "1.26 N"]
    assert "left its model twice for an unknown cause" in verdict.story(facts)


# ---- the log ----------------------------------------------------------------------------------------------------


def motion_series(lead):
    kind = np.dtype([("model", [("arms", [("v_BT", "f8", 3), ("ik_status", "u1")], 2)])])
    ticks = np.zeros(100, kind)
    arms = ticks["model"]["arms"]
    arms["v_BT"][:, lead] = [0.03, 0.0, -0.04]  # 50 mm/s
    arms["v_BT"][0, lead] = [0.0, 0.2, 0.0]
    arms["v_BT"][:, 1 - lead] = [0.0, 0.01, 0.0]
    arms["ik_status"][:10, lead] = 1
    arms["ik_status"][10:15, lead] = 2
    arms["ik_status"][15:35, lead] = 5  # at a singular wrist the arm still moves
    return SimpleNamespace(t=np.arange(100) / 1000, ticks=ticks, teleoperating=np.ones(100, bool))


@pytest.mark.parametrize("lead", [0, 1])
def test_the_motion_of_either_arm_is_in_millimetres_a_second(lead):
    rows = cells(engineering(series=motion_series(lead)).motion_table())[1:]
    assert [row[0] for row in rows] == ["gold", "green"]
    assert rows[lead][1:] == ["51.5", "51.5", "200.0", "10.00 %", "5.00 %"]
    assert rows[1 - lead][1:] == ["10.0", "10.0", "10.0", "0.00 %", "0.00 %"]


def paused_session(tmp_path):
    """Two seconds from tick 10 on. At session second 1.0 the session's clock stops for half a second of ticks."""
    log = made.log
    ticks = [(t + 10, t) for t in range(1000)] + [(t + 510, t) for t in range(1000, 2000)]
    data = log.header_record() + b"".join(log.record(1, log.tick_payload(tick, t)) for tick, t in ticks)
    for tick, kind in ((510, 1), (1760, 1), (9000, 1)):
        data += log.record(5, log.struct.pack("<qBBI4dddI", tick, kind, 1, 3, 0.0, 0.5, 1.25, 0.0, 3.75, 0.2, 1000))
    data += log.execution(1760, 2010, 1)
    (tmp_path / "session.rlog").write_bytes(data + made.COUNTS)
    session = raven2_session.Session(tmp_path)
    return Facts(session, raven2_figures.Series(session))


def test_plans_and_motions_are_on_the_session_s_clock(tmp_path):
    facts = paused_session(tmp_path)
    behind = details.Details(facts)
    plans = cells(behind.plan_section())[1:]
    assert plans[0] == ["0.500 s", "success", "green", "3", "1.25 s", "3.750", "1,000", "0.200 s"]
    assert [row[0] for row in plans] == ["0.500 s", "1.250 s", "–"], "the session's clock must stop during a pause"
    assert column(behind.execution_section(), "Time") == ["1.250 s"]


@pytest.mark.parametrize("clearance, moved, planned", [(0.0047, "green, model and robot", "4.7 mm"), (0.0, "both arms, model and robot", "–")])
def test_a_repeated_trial_moves_both_arms_without_a_plan(clearance, moved, planned):
    behind = details.Details.__new__(details.Details)
    behind.facts = SimpleNamespace(session_time=lambda tick: tick / 1000)
    execution = {"started": 1000, "ended": 2000, "on_robot": 1, "progress": 1.0, "planned_clearance": clearance, "contact_ticks": 25,
                 "model": {"mean": 0.0012, "largest": 0.0034}, "robot": {"mean": 0.0056, "largest": 0.0078}, "model_clearance": 0.01,
                 "robot_clearance": 0.0043}
    row = behind._execution_row(execution, "finished", "green")
    assert row[1] == moved and row[4:8] == ["1.20", "3.40", "5.60", "7.80"] and row[8:] == [planned, "10.0 mm", "4.3 mm", "25 ms"]
    alone = behind._execution_row({**execution, "on_robot": 0}, "finished", "green")
    assert alone[4:8] == ["1.20", "3.40", "–", "–"] and alone[9:11] == ["10.0 mm", "–"]


def test_an_attempt_spans_its_own_ticks():
    span = lambda attempt: Facts.attempt_span(SimpleNamespace(attempt=attempt, duration=9.0))  # noqa: E731
    assert span({"first_tick": 1500, "last_tick": 4000}) == (1.5, 4.0)
    assert span({"first_tick": 1500, "last_tick": None}) == (1.5, 9.0) and span(None) == (0.0, 9.0)


@pytest.mark.parametrize("scale, length, end", [(1000, "100 mm", 114.0), (2000, "50 mm", 114.0), (400, "100 mm", 54.0)])
def test_the_bar_is_as_long_as_it_says(scale, length, end):
    """`scale` [px/m]."""
    found = view3d._scale_bar(scale, 560)
    xs = [float(x) for x in re.findall(r'x[12]="([\d.]+)"', found)]
    assert length in found and (min(xs), max(xs)) == (14.0, end)


def test_each_arm_has_its_own_force_and_error(monkeypatch):
    t, values = np.arange(3.0), np.array([[1.0, 4.0]] * 3)
    series = SimpleNamespace(t=t, error_mm=values, tolerance_mm=3.0, force_t=t, force=2 * values)
    monkeypatch.setattr(timeline, "contact_force", lambda _: 3 * values)
    panels = []

    class Panel:
        x = width = 0

        def to_y(self, value):
            return value

        def curve(self, _, values, *rest):
            panels.append((rest[-1], float(values[0])))
            return ""

    lanes = SimpleNamespace(parts=[], plot=lambda *_: Panel())
    timeline._forces(SimpleNamespace(series=series, hazards=[]), lanes)
    assert panels == [("gold arm", 1.0), ("green arm", 4.0), ("gold arm", 2.0), ("green arm", 8.0), ("gold arm", 3.0), ("green arm", 12.0)]


@pytest.mark.parametrize("levels, stop", [([0, 0, 1, 2, 3, 3, 0, 0, 1, 0], 0.006), ([-1, 0, 0, 1], None),
                                          ([3, 3, 3], None), ([3, 0, 3, 0], 0.001), ([2, -1, 0], None)])
def test_an_emergency_stop_is_the_first_fall_from_a_higher_run_level(levels, stop):
    series = SimpleNamespace(runlevel=np.array(levels), t=np.arange(len(levels)) / 1000)
    assert Facts.emergency_stop(SimpleNamespace(series=series)) == stop


def test_a_step_begins_where_the_one_before_it_ended_in_each_attempt():
    marks = [("started", 0.0), ("began", 1.0), ("step_done", 2.5), ("failed", 4.0), ("started", 4.5), ("began", 6.0),
            ("step_done", 7.0), ("step_done", 7.25), ("done", 7.25), ("began", 9.0), ("step_done", 9.5)]
    events = [{"kind": kind, "at_s": at, "step": f"to {at}"} for kind, at in marks]
    found = Facts._steps(SimpleNamespace(events=events, duration=12.0))
    assert [(step["name"], step["from_s"], step["to_s"]) for step in found] == [
        ("to 2.5", 1.0, 2.5), ("not finished", 2.5, 4.0), ("to 7.0", 6.0, 7.0), ("to 7.25", 7.0, 7.25),
        ("to 9.5", 9.0, 9.5), ("not finished", 9.5, 12.0)]
    found = Facts._steps(SimpleNamespace(events=events[:9], duration=12.0))
    assert [step["name"] for step in found][-1] == "to 7.25", "no step continues after an attempt ended"


def test_the_first_step_is_not_finished_either_when_the_session_ends_in_it():
    events = [{"kind": "started", "at_s": 0.0}, {"kind": "began", "at_s": 1.0}]
    found = Facts._steps(SimpleNamespace(events=events, duration=12.0))
    assert found == [{"name": "not finished", "from_s": 1.0, "to_s": 12.0}]
    assert Facts._steps(SimpleNamespace(events=events[:1], duration=12.0)) == [], "it never began"


def test_each_hazard_has_the_fault_of_its_own_activation():
    """Three faults: two of one scenario and one of another. score.json judges the two, the later one first."""
    faults = [{"name": name, "first_tick": first, "last_tick": first + 299, "max_error_mm": error}
              for name, first, error in (("jump", 2000, 1.0), ("loss", 4000, 2.0), ("jump", 6000, 3.0))]
    judged = [{"scenario": "jump", "injection_tick": tick} for tick in (5995, 2000)]
    facts = SimpleNamespace(score={"hazards": judged}, faults=faults)
    facts._hazard = lambda *entry: Facts._hazard(facts, *entry)
    assert [(h["name"], h["at_s"], h["end_s"], h["fault"]["max_error_mm"], bool(h["judged"]))
            for h in Facts._hazards(facts)] == [("jump", 2.0, 2.3, 1.0, True), ("loss", 4.0, 4.3, 2.0, False),
                                                ("jump", 5.995, 6.3, 3.0, True)]


BODIES = ["link1_L", "link1_R", "tower", "ring"]


def contact_facts(contacts):
    kind = np.dtype([("tick", "i8"), ("a", "u2"), ("b", "u2"), ("f_W", "f8", 3)])
    ticks = np.zeros(5, np.dtype([("model", [("tick", "i8")])]))
    ticks["model"]["tick"] = [10, 11, 12, 13, 14]
    return SimpleNamespace(log=SimpleNamespace(contacts=np.array(contacts, kind)),
                           series=SimpleNamespace(t=np.arange(5) / 1000, ticks=ticks),
                           header={"body_names": BODIES, "object_names": ["ring"]}, scene={})


def test_the_tools_force_is_of_each_arm_in_each_tick():
    force = timeline.contact_force(contact_facts([
        (10, 0, 2, [0, 3, 4]), (10, 0, 2, [0, 0, -2]), (11, 1, 2, [1, 2, 2]), (12, 0, 1, [6, 0, 0]),
        (13, 0, 3, [9, 0, 0]), (13, 1, 3, [9, 0, 0]), (13, 2, 3, [9, 0, 0]), (9, 0, 2, [9, 0, 0])]))
    assert force.tolist() == [[7, 0], [0, 3], [6, 6], [0, 0], [0, 0]], "objects and earlier ticks do not count"


@pytest.mark.parametrize("arm", [0, 1])
def test_the_arm_of_a_mistake_is_that_of_its_link_or_the_faster_one(arm):
    p_model = np.zeros((200, 2, 3))
    p_model[:, arm, 1] = np.arange(200) * 1e-4
    facts = SimpleNamespace(series=SimpleNamespace(t=np.arange(200) / 1000, p_model=p_model))
    facts.index = lambda seconds: Facts.index(facts, seconds)
    arm_of = lambda a, b: Facts.arm_of(facts, {"a": a, "b": b, "at_s": 0.1})  # noqa: E731
    assert arm_of("link1_L", "tower") == arm_of("ring", "grasper2_L") == 0
    assert arm_of("link1_R", "tower") == arm_of("ring", "grasper2_R") == 1
    assert arm_of("ring", "tower") == arm


@pytest.mark.parametrize("arm", [0, 1])
def test_a_hazard_is_drawn_for_the_arm_that_it_moved_and_along_its_way(arm):
    p_model = np.zeros((1000, 2, 3))
    p_robot = p_model.copy()
    p_robot[300:, arm] = [0.0, -0.02, 0.0]
    p_robot[300:, 1 - arm] = [0.01, 0.0, 0.0]
    distance = 1000 * np.linalg.norm(p_robot - p_model, axis=2)
    facts = SimpleNamespace(series=SimpleNamespace(t=np.arange(1000) / 1000, p_model=p_model, p_robot=p_robot,
                                                   error_mm=distance))
    facts.index = lambda seconds: Facts.index(facts, seconds)
    found, way = Facts.worst_gap(facts, {"at_s": 0.2, "end_s": 0.4})
    assert found == arm and way.tolist() == [0.0, -1.0, 0.0]
    nothing, _ = Facts.worst_gap(facts, {"at_s": 0.0, "end_s": 0.05})
    assert nothing == 0, "the hazard is over before the tips part"


def short_log(arm):
    """One tick before the first pedal-down, ten of the session, five with the session's clock stopped, ten more. The
    robot's tip is 4 mm from the model's, for the other arm 1 mm."""
    place = [("q", "f8", 7), ("p_BT", "f8", 3)]
    ticks = np.zeros(26, [("model", [("tick", "i8"), ("session_tick", "i8"), ("mode", "u1"), ("robot_fresh", "u1"),
                                     ("linked", "u1"), ("faults", [("active", "u4")]), ("arms", place, 2)]),
                          ("robot", [("frame", "u8"), ("runlevel", "i1"), ("active_fault", "u4"), ("arms", place, 2)])])
    model, robot = ticks["model"], ticks["robot"]
    model["tick"] = 100 + np.arange(26)
    model["session_tick"] = [-1, *range(10), *[9] * 5, *range(10, 20)]
    model["robot_fresh"], model["linked"], robot["frame"], robot["runlevel"] = 1, 1, 1, 3
    robot["arms"]["p_BT"][:, arm, 1], robot["arms"]["p_BT"][:, 1 - arm, 2] = 0.004, -0.001
    haptic = np.zeros(4, [("haptic", [("tick", "i8"), ("force_B", "f8", (2, 3))])])["haptic"]
    haptic["tick"] = [99, 105, 113, 120]
    haptic["force_B"][:, arm] = [[9, 9, 9], [0, 3, -4], [0, 0, -2], [1, 2, 2]]
    log = SimpleNamespace(ticks=ticks, haptic={"haptic": haptic}, header={"tolerance": 0.003, "scenarios": ["a", "b"]},
                          names=lambda *_: ["teleoperating", "paused"])
    return log, model, robot


@pytest.mark.parametrize("arm", [0, 1])
def test_the_tips_are_compared_while_both_arms_follow_from_a_common_pose(arm):
    log, model, robot = short_log(arm)
    model["robot_fresh"][2], model["linked"][4], robot["frame"][6], model["mode"][8] = 0, 0, 0, 1
    series = raven2_figures.Series(SimpleNamespace(log=log))
    assert np.flatnonzero(np.isnan(series.error_mm).all(axis=1)).tolist() == [1, 3, 5, 7], "the first tick is omitted"
    assert np.nanmax(series.error_mm[:, arm]) == pytest.approx(4.0) and series.tolerance_mm == 3.0
    assert np.nanmax(series.error_mm[:, 1 - arm]) == pytest.approx(1.0)
    assert series.runlevel.tolist() == [3] * 5 + [-1] + [3] * 19, "without a frame the run level is unknown"


@pytest.mark.parametrize("arm", [0, 1])
def test_the_force_is_of_its_arm_and_stops_with_the_session_s_clock(arm):
    series = raven2_figures.Series(SimpleNamespace(log=short_log(arm)[0]))
    assert series.force_t.tolist() == [0.004, 0.009, 0.014] and series.force[:, arm].tolist() == [5.0, 2.0, 3.0]
    assert not series.force[:, 1 - arm].any()


def test_a_fault_that_follows_another_at_once_has_a_window_of_its_own():
    log, model, robot = short_log(0)
    robot["active_fault"][4:6], robot["active_fault"][6:8], model["faults"]["active"][9:10] = 1, 2, 1
    robot["active_fault"][25] = 3
    series = raven2_figures.Series(SimpleNamespace(log=log))
    assert series.fault_windows == [(0.003, 0.004, "a"), (0.008, 0.008, "a"), (0.005, 0.006, "b"),
                                    (0.019, 0.019, "fault_3")]


# ---- figures ----------------------------------------------------------------------------------------------------


def figure_series():
    """Two arms. Every joint value and position is a different number."""
    n = 20
    q = 0.01 * (1 + np.arange(n * 2 * 7).reshape(n, 2, 7))
    p = 0.001 * (1 + np.arange(n * 2 * 3).reshape(n, 2, 3))
    mask = np.zeros(n, bool)
    return SimpleNamespace(t=np.arange(n) / 1000, q_model=q, q_robot=2 * q, q_asked=3 * q, p_model=p, p_robot=2 * p,
                           fault_windows=[], tracking=mask, teleoperating=~mask, choosing=mask, model_alone=mask,
                           force_t=np.arange(n) / 1000, force=np.stack([np.arange(n), 10.0 + np.arange(n)], 1),
                           error_mm=np.stack([1.0 + np.arange(n), 30.0 + np.arange(n)], 1), tolerance_mm=3.0)


def drawn(axes, label):
    return next(line.get_ydata() for line in axes.get_lines() if line.get_label() == label)


def test_joints_are_degrees_and_millimetres_of_their_arm():
    series = figure_series()
    figure = raven2_figures.joints_figure(series)
    grid = np.array(figure.axes).reshape(len(raven2_figures.JOINTS), 2)
    for arm in (0, 1):
        for joint, (_, unit) in enumerate(raven2_figures.JOINTS):
            scale = 1000.0 if joint == 2 else 180.0 / np.pi
            assert unit == ("mm" if joint == 2 else "deg") and f"[{unit}]" in grid[joint, arm].get_ylabel()
            for label, values in (("operator", series.q_asked), ("model", series.q_model), ("robot", series.q_robot)):
                assert drawn(grid[joint, arm], label) == pytest.approx(scale * values[:, arm, joint])
        error = series.error_mm[:, arm]
        assert f"{error.mean():.2f} ± {error.std():.2f} mm apart" in grid[0, arm].get_title(loc="left")


def test_joint_one_is_gold_s_in_degrees():
    series = figure_series()
    (axes,) = raven2_figures.joint_figure(series).axes
    assert drawn(axes, "model") == pytest.approx(series.q_model[:, 0, 0] * 180.0 / np.pi)
    assert drawn(axes, "robot") == pytest.approx(series.q_robot[:, 0, 0] * 180.0 / np.pi)
    assert "gold" in axes.get_ylabel() and "[deg]" in axes.get_ylabel()


@pytest.mark.parametrize("draw, values, unit", [(raven2_figures.force_figure, "force", "[N]"),
                                                (raven2_figures.error_figure, "error_mm", "[mm]")])
def test_forces_and_distances_are_those_of_their_arm(draw, values, unit):
    series = figure_series()
    (axes,) = draw(series).axes
    assert unit in axes.get_ylabel()
    for i, arm in enumerate(("gold", "green")):
        assert drawn(axes, f"{arm} arm").tolist() == getattr(series, values)[:, i].tolist()


def test_paths_are_millimetres_of_their_arm_over_their_axes():
    series = figure_series()
    grid = np.array(raven2_figures.path_figure(series).axes).reshape(2, 3)
    for arm in (0, 1):
        for axes, (a, b) in zip(grid[arm], ((0, 1), (0, 2), (1, 2))):
            assert (axes.get_xlabel(), axes.get_ylabel()) == (f"{'xyz'[a]} [mm]", f"{'xyz'[b]} [mm]")
            for line, points in zip(axes.get_lines(), (series.p_model, series.p_robot)):
                assert line.get_xdata() == pytest.approx(1000 * points[:, arm, a])
                assert line.get_ydata() == pytest.approx(1000 * points[:, arm, b])


# ---- paths in the world -----------------------------------------------------------------------------------------

BASES = [(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([1.0, 2, 3])),
         (np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), np.array([-4.0, -5, -6]))]


def in_world(arm, x, y, z):
    """Gold is rotated by 90 deg about z, green by 90 deg about x."""
    return [1 - y, 2 + x, 3 + z] if arm == 0 else [-4 + x, -5 - z, -6 + y]


def world_facts():
    """Twenty ticks. The attempt has ticks 2 to 6. Every position is different."""
    series = figure_series()
    facts = SimpleNamespace(series=series, attempt_span=lambda: (0.002, 0.006))
    facts.index = lambda seconds: Facts.index(facts, seconds)
    return facts, series


def test_paths_are_those_of_the_attempt_from_each_arm_s_base_in_the_world():
    facts, series = world_facts()
    found = {(path["arm"], path["who"]): path["points"] for path in view3d.world_paths(facts, BASES)}
    assert len(found) == 4
    for arm, name in enumerate(("gold", "green")):
        for who, places in (("model", series.p_model), ("robot", series.p_robot)):
            for end, tick in ((0, 2), (-1, 6)):
                assert found[name, who][end] == pytest.approx(in_world(arm, *places[tick, arm])), (name, who)


@pytest.mark.parametrize("arm", [0, 1])
def test_marks_are_at_the_tip_of_their_arm_if_they_are_of_the_attempt(arm):
    facts, series = world_facts()
    facts.hazards = [{"name": "jump", "at_s": at} for at in (0.001, 0.004)]
    facts.worst_gap = lambda hazard: (arm, None)
    facts.mistakes = lambda: [{"at_s": at} for at in (0.005, 0.007)]
    facts.mistake_text, facts.arm_of = (lambda event: "wire"), (lambda event: 1 - arm)
    hazard, mistake = view3d.event_marks(facts, BASES)
    assert hazard["point"] == pytest.approx(in_world(arm, *series.p_model[4, arm]))
    assert mistake["point"] == pytest.approx(in_world(1 - arm, *series.p_model[5, 1 - arm]))


@pytest.mark.parametrize("arm", [0, 1])
def test_a_hazard_s_curves_are_of_its_arm_from_where_the_model_was_then(arm):
    facts, series = world_facts()
    way, apart, force = hazard_page._curves(facts, {"at_s": 0.005}, 0.002, 0.012, arm, np.array([0.0, 1.0, 0.0]))
    since = (np.arange(2, 13) - 5) / 1000
    for _, time, _, _ in (way, apart, force):
        assert time == pytest.approx(since)
    shown = lambda curve, i=0: curve[2][i][0]  # noqa: E731
    begin = series.p_model[5, arm, 1]
    assert shown(way) == pytest.approx(1000 * (series.p_model[2:13, arm, 1] - begin)) and "[mm]" in way[0]
    assert shown(way, 1) == pytest.approx(1000 * (series.p_robot[2:13, arm, 1] - begin))
    assert shown(apart).tolist() == series.error_mm[2:13, arm].tolist() and apart[3] == 3.0
    assert shown(force).tolist() == series.force[2:13, arm].tolist() and "[N]" in force[0]


# ---- learning curves --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("better, inside, outside", [("lower", 4.0, 6.0), ("higher", 6.0, 4.0)])
def test_a_point_of_the_curve_passes_on_its_side_of_the_limit(better, inside, outside):
    metric = {"limit": 5.0, "better": better}
    assert curves._within(metric, inside) and curves._within(metric, 5.0) and not curves._within(metric, outside)


@pytest.mark.parametrize("unmerged", [False, True])
def test_faults_of_a_real_robot_are_not_denied(unmerged):
    facts = SimpleNamespace(hazards=[], deviations=[], faults=[], duration=10.0, unmerged=unmerged,
                            emergency_stop=lambda: None)
    assert ("No fault acted" in hazard_page.section(facts)) != unmerged
    assert ("without any injected fault" in verdict.story(facts)) != unmerged
    assert ("No fault acted" in engineering(faults=[], unmerged=unmerged).fault_table()) != unmerged


@pytest.mark.parametrize("frame, virtual, merged, unmerged", [
    (1, 0, False, True), (1, 0, True, False), (1, 1, False, False), (0, 0, False, False)])
def test_what_a_real_robot_had_is_unknown_until_it_is_merged(tmp_path, frame, virtual, merged, unmerged):
    robot = np.array([(frame, virtual)], dtype=[("frame", "u8"), ("is_virtual", "u1")])
    if merged:
        (tmp_path / "usb_truth.json").write_text("{}")
    facts = SimpleNamespace(series=SimpleNamespace(ticks={"robot": robot}),
                            session=SimpleNamespace(directory=str(tmp_path)))
    assert Facts._unmerged(facts) == unmerged


def test_deviations_are_on_the_timeline_and_told_next_to_a_known_fault():
    facts = story_facts([FELT, FELT])
    assert "unknown cause" not in verdict.story(facts)
    facts.deviations = parted_facts([])
    assert "Apart from that, the robot left its model twice for an unknown cause." in verdict.story(facts)
    lanes = timeline.Lanes(10.0)
    timeline._deviations(facts, lanes)
    drawn = "".join(lanes.parts)
    assert "green arm, cause unknown: 2.000 s to 2.700 s, 8.4 mm, 1.3 N" in drawn and "7.000 s to 7.010 s" in drawn


@pytest.mark.parametrize("arm", [0, 1])
def test_a_hazard_s_picture_is_where_the_robot_of_either_arm_is_farthest_off(arm):
    error = np.zeros((1000, 2))
    error[150, arm], error[380, arm], error[800, arm] = 30.0, 9.0, 50.0
    error[300, 1 - arm] = 8.0
    facts = SimpleNamespace(series=SimpleNamespace(t=np.arange(1000) / 1000, error_mm=error))
    for end in (0.25, None):
        assert Facts._worst(facts, {"at_s": 0.2, "end_s": end}) == 0.38, "up to 200 ms behind its end"


def test_of_too_many_moments_the_steps_give_way_to_mistakes_and_hazards():
    events = [{"kind": "step_done", "at_s": float(at), "step": "lift"} for at in range(1, 21)]
    facts = SimpleNamespace(duration=60.0, hazards=[{"name": "jump"}], events=events,
                            series=SimpleNamespace(tracking=np.zeros(1, bool)), _worst=lambda hazard: 50.1,
                            answers=lambda hazard: [], mistakes=lambda: [{"at_s": 40.0}],
                            mistake_text=lambda event: "wire touched")
    found = Facts.moments(facts)
    assert [moment["at_s"] for moment in found] == pytest.approx([0.0, *range(1, 9), 40.0, 50.1, 59.9])


def test_each_attempt_has_its_begin_its_length_and_its_mistakes():
    ended = {"number": 1, "first_tick": 1500, "last_tick": 126500, "status": "done", "passed": True,
             "mistakes": {"drop": 2, "collision": 0}}
    waiting = {"number": 2, "first_tick": None, "last_tick": None, "status": "waiting", "passed": None}
    rows = scorecard.attempts_table(SimpleNamespace(attempts=[ended, waiting]))
    assert rows == [["1", "1.5 s", "2 min 05 s", "done", "Dropped: 2", "✓ passed"],
                    ["2", "–", "–", "waiting", "none", "not judged"]]


def test_the_first_screen_says_how_long_the_attempt_itself_was():
    attempt = {"status": "done", "number": 2, "composite": 0.75}
    facts = SimpleNamespace(attempt=attempt, attempts=[attempt] * 3, attempt_span=lambda: (30.0, 155.5))
    assert scorecard._attempt_line(facts) == (
        "Attempt 2 of 3, 2 min 05 s long, 75 % of the judged metrics passed (to pass, all have to)")


@pytest.mark.parametrize("better, zone", [("lower", (90.0, 60.0)), ("higher", (30.0, 60.0))])
def test_a_curve_is_shaded_on_the_side_that_passes(better, zone):
    """The limit is in the middle of the axis, which is 120 high from 30 on."""
    points = [curves.Point("", "done", True, {"time": value}) for value in (1.0, 4.0)]
    drawn = curves._small("time", made.metric(4.0, 2.0, 0.5, 2.5, "s", better), points)
    (y, height), = re.findall(r'<rect x="[\d.]+" y="([\d.]+)" width="[\d.]+" height="([\d.]+)" fill="#d9dee4"', drawn)
    assert (float(y), float(height)) == pytest.approx(zone, abs=0.11)
