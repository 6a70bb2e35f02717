"""scripts/session_report: the page and its text, report.json, learning curves, hostile input, and the view in a browser
(skipped where no browser is installed)."""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import types
import unittest.mock
import warnings

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import forked  # noqa: E402
import report_session as made  # noqa: E402

import raven2_figures  # noqa: E402  (in the same folder as raven2_session; loaded once, for all reports)
from raven2_report import curves, drawing, metric_words, page as _, scorecard, stills, view3d  # noqa: E402,F401

REPORT = made.ROOT / "scripts" / "session_report"
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
if BROWSER is None:
    warnings.warn("no chromium here: nobody looked at the report in a browser", stacklevel=1)
SECTIONS = ("timeline", "paths", "hazards", "pictures", "numbers", "curve", "engineering")


def plainly(script, *arguments):
    return subprocess.run(["/usr/bin/python3", script, *arguments], capture_output=True, text=True, check=False)


def sketchily(script, *arguments):
    """Runs a script with empty figures in the engineering part: those figures take most of the time."""
    def nothing(_, file, metadata=None):
        file.write("<svg></svg>")

    with unittest.mock.patch.object(raven2_figures, "save_svg", nothing):
        return forked.run(script, *arguments)


def report(*directories, fails=False, run=sketchily):
    """(page, record, standard error). Page and record are those of the last directory."""
    done = run(REPORT, *map(str, directories))
    assert fails or done.returncode == 0, done.stderr
    page = pathlib.Path(directories[-1]) / "report.html"
    record = pathlib.Path(directories[-1]) / "report.json"
    return (page.read_text(encoding="utf-8") if page.exists() else "",
            json.loads(record.read_text(encoding="utf-8")) if record.exists() else {}, done.stderr)


def plain(html):
    """Text of a page as a browser shows it."""
    html = re.sub(r"<(script|style)\b.*?</\1>", " ", html, flags=re.S)
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", html))


def headline(page):
    return re.search(r'<p class="headline">(.*?)</p>', page).group(1)


@pytest.fixture(scope="module", name="whole")
def whole_report(tmp_path_factory):
    folder = made.make(tmp_path_factory.mktemp("report") / "first", made.score())
    return (folder, *report(folder, run=forked.run))


# ---- one file ---------------------------------------------------------------------------------------------------


def test_it_is_one_small_file_that_needs_no_network(whole):
    _, page, _, _ = whole
    assert "http" not in re.sub(r'<svg[^>]*xmlns[^>]*>', "", page).replace("http://www.w3.org", "")
    assert not re.search(r'(?:src|href)="(?!data:|#)', page)
    assert not re.search(r"@import|<link|<script[^>]*\bsrc|url\((?!#)|<iframe|<object|<embed", page)
    assert len(page) < 5e6


def test_all_parts_are_there_in_their_order(whole):
    _, page, _, _ = whole
    places = [page.index(f'id="{name}"') for name in SECTIONS]
    assert places == sorted(places)
    assert page.index('class="headline"') < page.index("improve</h2>") < page.index("Score by metric") < places[0]


def test_ids_are_given_once(whole):
    ids = re.findall(r'\bid="([^"]+)"', whole[1])
    drawn = [i for i in ids if not re.search(r"\.(?!figure|axes|legend)", i)]
    assert len(drawn) == len(set(drawn))


# ---- the first screen -------------------------------------------------------------------------------------------


def test_the_failing_metric_is_named_first(whole):
    _, page, record, _ = whole
    assert headline(page) == "Not passed: wires touched twice (limit 0)" == record["verdict"]["headline"]
    assert plain(page).index("Wires touched twice (limit 0)") < plain(page).index("Path length 812.3 mm")
    assert "passed, but near the limit" in page


@pytest.mark.parametrize("changes, expected", [
    ({"passed": True, "improve": []},
     "Passed: three metrics within the expert's band, and the hazard answered rightly"),
    ({"status": "failed", "failure": "time_limit"}, "Not passed: the time limit was reached, and one more reason"),
    ({"status": "running"}, "Not passed: the exercise was not finished (1 of 3 steps done), and one more reason"),
    ({"hazards": [made.hazard("wrong", "push_on", 1500)], "improve": ["hazard_response", "wire_touches"]},
     "Not passed: sudden jump answered wrongly (pushed on), and one more reason"),
    ({"hazards": [made.hazard("none", None)], "improve": ["hazard_response"]},
     "Not passed: sudden jump not answered, and one more reason"),
    ({"hazards": [made.hazard(), made.hazard("late", "pedal_up", 2500)], "improve": ["hazard_response"]},
     "Not passed: sudden jump answered rightly, but late (released the pedal), and one more reason"),
    ({"passed": None, "improve": [], "band": None},
     "Not judged: the exercise was done, but there is no expert band for it"),
    ({"passed": None, "improve": [], "band": None, "status": "failed", "failure": "broke_off"},
     "Not judged: something broke off, and there is no expert band for the exercise"),
])
def test_the_headline_says_why(tmp_path, changes, expected):
    scored = made.score(**changes)
    if scored["attempts"][0]["passed"]:
        del scored["attempts"][0]["metrics"]["wire_touches"]
        del scored["attempts"][0]["metrics"]["drops"]
    page, record, _ = report(made.make(tmp_path / "s", scored))
    assert headline(page).replace("&#x27;", "'") == expected == record["verdict"]["headline"]


def test_what_to_do_about_a_hazard_is_said(tmp_path):
    scored = made.score(hazards=[made.hazard("wrong", "push_on", 1500)], improve=["hazard_response", "wire_touches"])
    page, record, _ = report(made.make(tmp_path / "s", scored))
    assert record["improve"][0]["how"] == "The right answer: release the pedal, within 2.0 s of the cue."
    assert "pushed on 1,500 ms after it began: answered wrongly" in plain(page)
    assert "Release the pedal to disengage" in page, "the library's own advice"


def test_figures_are_those_of_the_score(whole):
    _, page, record, _ = whole
    for name, metric in made.metrics().items():
        entry = next(m for m in record["metrics"] if m["name"] == name)
        assert {key: entry[key] for key in ("value", "mean", "limit", "passed", "unit")} == {
            key: metric[key] for key in ("value", "mean", "limit", "passed", "unit")}
        assert entry["title"] and entry["definition"]
    shown = plain(page[page.index('id="numbers"'):])
    for text in ("812.3 mm 900.0 mm ± 20.0 mm 1,125.0 mm ✓ passed", "2 0 ± 0 0 ✕ not passed",
                 "22 µm – – not judged", "-9.50 -9.00 ± 0.20 -11.25 ✓ passed", "not measured"):
        assert text in shown, text


def test_the_band_says_that_it_is_no_surgeons(whole):
    assert plain(whole[1]).count(made.ORIGIN) >= 2


def test_every_metric_of_a_score_has_words():
    names = re.findall(r'^ +{"(\w+)",', (made.ROOT / "include/raven2_trainer/training/metric_names.h").read_text(), re.M)
    assert len(names) > 30
    for name in names:
        assert name in metric_words.WORDS and metric_words.WORDS[name].meaning, name


def test_a_value_that_rounds_to_its_limit_gets_more_digits():
    metric = made.metric(0.63041, 0.5, 0.01, 0.63029, "-")
    assert metric_words.said("idle", metric) == "at rest 0.6304 (limit 0.6303)"
    assert metric_words.said("idle", {**metric, "value": 0.63029}) == "at rest 0.63 (limit 0.63)"


def test_a_count_s_limit_is_what_is_still_allowed():
    assert metric_words.limit_of({"unit": "count", "better": "lower", "limit": 2.9}) == 2
    assert metric_words.limit_of({"unit": "count", "better": "higher", "limit": 2.1}) == 3
    assert metric_words.limit_of({"unit": "s", "better": "lower", "limit": 2.9}) == 2.9


@pytest.mark.parametrize("metric", [made.metric(3, 0.2, 0.4, 0.6, "count"), made.metric(-12, -9, 1, -10, "-", "higher"),
                                    made.metric(0.0, 0.0, 0.0, 0.0), made.metric(0.9, 0.8, 0.1, 0.7, "-", "higher")])
def test_value_mean_and_limit_lie_on_the_drawn_axis(metric):
    low, high = scorecard.band_range(metric)
    assert low < high and all(low <= metric[key] <= high for key in ("value", "mean", "limit"))


def test_the_record_is_as_its_schema_says(whole):
    """doc/report.md lists every field, and no other."""
    record = whole[2]
    text = (made.ROOT / "doc/report.md").read_text(encoding="utf-8")
    schema = dict(re.findall(r"^\| `(\w+)(?:\[\])?` \| (.*) \|$", text, re.M))
    assert list(schema) == list(record)
    for name, entry in record.items():
        one = entry[0] if isinstance(entry, list) and entry else entry
        if isinstance(one, dict) and name != "band":
            assert set(re.findall(r"`(\w+)(?:\[\])?`", schema[name])) - {"hazard_response"} == set(one), name


def test_of_several_attempts_the_last_that_ended_is_reported(tmp_path):
    scored = made.score()
    first = scored["attempts"][0]
    second = {**made.score(passed=True, improve=[], values={"time": made.metric(1.2, 2.0, 0.1, 2.5)})["attempts"][0],
              "number": 2}
    third = {**first, "number": 3, "status": "waiting", "first_tick": None, "last_tick": None}
    scored["attempts"] = [first, second, third]
    page, record, _ = report(made.make(tmp_path / "s", scored))
    assert record["verdict"]["attempt"] == 2 and record["verdict"]["attempts"] == 3
    assert headline(page).startswith("Passed: one metric")
    assert [p["passed"] for p in record["curve"]] == [False, True], "an attempt that waits does not count"
    assert "Attempts of this session" in page and "Attempt 2 of 3" in page


def test_an_attempt_that_failed_has_ended_too(tmp_path):
    scored = made.score(passed=True)
    failed = made.score(status="failed", failure="time_limit")["attempts"][0]
    scored["attempts"].append({**failed, "number": 2})
    page, record, _ = report(made.make(tmp_path / "s", scored))
    assert record["verdict"]["attempt"] == 2
    assert headline(page).startswith("Not passed: the time limit was reached")


# ---- what happened ----------------------------------------------------------------------------------------------


def test_the_timeline_has_modes_steps_mistakes_and_hazards(whole):
    _, page, record, _ = whole
    drawn = page[page.index('id="timeline"'):page.index('id="paths"')]
    for text in ("Operating: 0.00 s to 2.00 s", "lift: 0.10 s to 0.50 s", "not finished: 0.50 s to 1.90 s",
                 "Wire touched: link1 L and wire left, 0.80 s", "sudden jump: 1.000 s to 1.300 s",
                 "released the pedal, 400 ms after the hazard began"):
        assert text in drawn, text
    assert record["steps"] == [{"name": "lift", "from_s": 0.1, "to_s": 0.5},
                               {"name": "not finished", "from_s": 0.5, "to_s": 1.9}]
    assert [m["kind"] for m in record["mistakes"]] == ["wire_touch"] and record["mistakes"][0]["at_s"] == 0.8
    assert record["phases"] == [{"mode": "teleoperating", "name": "Operating", "from_s": 0.0, "to_s": 2.0}]


def test_a_session_that_only_waits_at_its_end_is_not_drawn_to_its_end(tmp_path):
    folder = made.make(tmp_path / "s", made.score())
    standing = b"".join(made.log.record(1, made.log.tick_payload(t + 10, t, mode=5)) for t in range(2000, 9000))
    (folder / "session.rlog").write_bytes(made.data()[:-len(made.COUNTS)] + standing + made.COUNTS)
    page, record, _ = report(folder)
    assert "Nothing more happened until 9 s." in page
    assert record["phases"][-1] == {"mode": "stopped", "name": "Stopped", "from_s": 2.0, "to_s": 9.0}
    drawn = page[page.index('id="timeline"'):page.index('id="paths"')]
    widths = [float(x) + float(w) for x, w in re.findall(r'<rect x="([\d.]+)" [^>]*?width="([\d.]+)"', drawn)]
    assert max(widths) <= 1000


def test_a_hazard_has_its_figures_and_its_answer(whole):
    _, page, record, _ = whole
    (entry,) = record["hazards"]
    assert entry == {"scenario": "sudden_jump", "at_s": 1.0, "end_s": 1.3, "largest_error_mm": 10.0,
                    "excursion_mm": 10.25,
                    "largest_force_N": 2.0, "cue_after_s": 0.012, "reaction": "pedal_up", "reaction_after_s": 0.4,
                    "verdict": "right"}
    shown = plain(page[page.index('id="hazards"'):page.index('id="pictures"')])
    for text in ("10.25 mm", "released the pedal after 400 ms", "answered rightly", "The model touched: wire (1)",
                 "the cue begins at 3 mm", "first force", "Unintended movement of the robotic arm"):
        assert text in shown, text


def test_paths_are_drawn_in_the_world_over_the_scene(whole):
    page = whole[1]
    data = json.loads(re.search(r'id="turn-data">(.*?)</script>', page).group(1))
    drawn = page[page.index('id="turn"'):page.index('id="turn-hint"')]
    assert len(data["shapes"]) == len(re.findall(r'class="[pr]"', drawn)) > 50
    assert len(data["paths"]) == drawn.count('class="t"') and len(data["marks"]) == drawn.count('class="m"') == 2
    assert page.count('class="scene"') == 4, "one view that rotates, and three projections"


def test_the_script_s_data_are_in_the_order_of_the_drawing(whole):
    """The projection of each shape in the data equals the path in the drawing."""
    page = whole[1]
    data = json.loads(re.search(r'id="turn-data">(.*?)</script>', page).group(1))
    view = page[page.index('id="turn"'):page.index('id="turn-hint"')]
    drawn = re.findall(r'<path class="[prt]"[^>]* d="(M[^"]*)"', view)
    right, up, _ = view3d.directions(*data["view"])
    for numbers, path in zip(data["shapes"] + data["paths"], drawn, strict=True):
        shown = [float(v) for v in re.findall(r"-?[\d.]+", path)]
        for i in range(len(numbers) // 3):
            across, along = (sum(a * b for a, b in zip(numbers[3 * i:3 * i + 3], axis)) for axis in (right, up))
            assert shown[2 * i] == pytest.approx(data["size"][0] / 2 + data["scale"] * across, abs=0.4)
            assert shown[2 * i + 1] == pytest.approx(data["size"][1] / 2 - data["scale"] * along, abs=0.4)


def test_stills_are_linked_to_their_moment_of_the_video(tmp_path):
    folder = made.make(tmp_path / "it's 100 % #1", made.score())
    subprocess.run(["ffmpeg", "-loglevel", "error", "-f", "lavfi", "-i", "testsrc=size=64x64:rate=10:duration=2",
                    str(folder / "video.mp4")], check=True)
    page, record, _ = report(folder)
    links = re.findall(r'<a href="(video\.mp4#t=[\d.]+)"><img src="data:image/jpeg;base64,', page)
    wanted = [f"video.mp4#t={moment['at_s']:.2f}" for moment in record["moments"]]
    assert set(links) <= set(wanted) and len(links) >= 5
    assert "video.mp4#t=0.80" in links, "where the wire was touched"
    video = folder / "video.mp4"
    assert stills.take_frame(video, 0.1) == stills.take_frame(video, 0.1) != stills.take_frame(video, 1.5)


# ---- several sessions -------------------------------------------------------------------------------------------


def series_of_sessions(tmp_path, count=3):
    folders = []
    for i in range(count):
        values = made.metrics()
        values["time"] = made.metric(3.0 - i * 0.5, 2.0, 0.1, 2.5, group="efficiency")
        folders.append(made.make(tmp_path / f"day{i}", made.score(values=values, passed=i == 2),
                                 f"2026-01-0{i + 1}T10:00:00Z"))
    return folders


def test_several_sessions_make_a_learning_curve_in_order_of_time(tmp_path):
    first, second, third = series_of_sessions(tmp_path)
    page, record, said = report(second, first, third)
    assert "day2/report.html" in said, "the report is in the newest session's folder"
    assert [p["session"] for p in record["curve"]] == ["day0", "day1", "day2"]
    assert [p["metrics"]["time"] for p in record["curve"]] == [3.0, 2.5, 2.0]
    shown = page[page.index('id="curve"'):page.index('id="engineering"')]
    assert "3 attempts of 3 sessions" in shown
    for text in ("day0: 3.0 s", "day1: 2.5 s", "day2: 2.0 s", "time over the attempts"):
        assert text in shown, text
    assert not (first / "report.html").exists()


def test_another_exercise_is_left_out_and_named(tmp_path):
    for what, other, why in (("a", made.score(exercise="peg_transfer"), "another exercise, peg transfer"),
                             ("b", {**made.score(), "trainee": "ben"}, "another trainee, ben"),
                             ("c", {**made.score(), "drill": None}, "no drill")):
        first, second, third = series_of_sessions(tmp_path / what)
        (first / "score.json").write_text(json.dumps(other))
        page, record, _ = report(first, second, third)
        assert [p["session"] for p in record["curve"]] == ["day1", "day2"] and record["left_out"] == ["day0"]
        assert f"Left out: day0 ({why})." in page


def curve_of(page):
    shown = page[page.index('id="curve"'):page.index('id="engineering"')]
    return re.findall(r'aria-label="([^"]+) over the attempts"', shown), shown


def test_a_curve_has_all_that_is_judged_time_and_the_answer_to_the_hazard_first(tmp_path):
    values = {f"metric_{i:02d}": made.metric(1.0, 1.0, 0.1, 1.2) for i in range(15)} | {"time": made.metric(2.0, 2.0, 0.1, 2.5)}
    folders = [made.make(tmp_path / f"day{i}", made.score(True, values=values, hazards=[made.hazard(after=200 + 100 * i)]),
                         f"2026-01-0{i + 1}T10:00:00Z") for i in range(2)]
    names, shown = curve_of(report(*folders)[0])
    assert names[:2] == ["time", "hazard response"] and len(names) == 17
    assert "day0: 0.19 s" in shown and "day1: 0.29 s" in shown, "from the cue, 12 ms after the injection"


def test_attempts_that_failed_look_failed_whatever_their_figures(tmp_path):
    values = {"time": made.metric(2.0, 2.0, 0.1, 2.5)}
    broken = made.score(False, status="failed", failure="broke_off", values={"time": made.metric(None, 2.0, 0.1, None)})
    scores = [broken, broken, made.score(False, values=values), made.score(True, values=values)]
    folders = [made.make(tmp_path / f"day{i}", score, f"2026-01-0{i + 1}T10:00:00Z") for i, score in enumerate(scores)]
    _, shown = curve_of(report(*folders)[0])
    figure = shown[shown.index('aria-label="time over the attempts"'):].split("</figure>")[0]
    assert re.findall(r"<title>(day\d: [^<]*)</title>", figure).count("day0: not passed, not measured") == 1
    assert figure.count("not passed, not measured") == 2
    shapes = {day: "circle" if "A" in path else "cross"
              for path, day in re.findall(r'<path d="([^"]*)"[^>]*><title>(day\d): 2.0 s</title>', figure)}
    assert shapes == {"day2": "cross", "day3": "circle"}


def days(tmp_path, *metrics, **last):
    """Sessions in order of time, each with the metrics of its only attempt. `last`: of the newest score."""
    scores = [made.score(values=values, hazards=[], **(last if values is metrics[-1] else {})) for values in metrics]
    return [made.make(tmp_path / f"day{i}", score, f"2026-01-0{i + 1}T10:00:00Z") for i, score in enumerate(scores)]


def unmeasured(metric):
    return {**metric, "value": None, "limit": None, "excess": None, "passed": None}


def test_a_curve_stays_where_the_newest_attempt_has_no_value(tmp_path):
    """A metric without a value has no limit in score.json either: the limit is that of the newest session that has one."""
    sparc = [made.metric(-8.0 - i, -9.0, 0.2, -11.0 - i, "-", "higher", "control") for i in range(2)]
    drops = {**made.metric(1, unit="count"), "scored": True}
    folders = days(tmp_path, *({"time": made.metric(1.0, 2.0, 0.1, 2.5), "sparc": metric, "drops": drops}
                               for metric in (*sparc, unmeasured(sparc[0]))))
    names, shown = curve_of(report(*folders)[0])
    assert names == ["time", "sparc", "drops"]
    (figure,) = (part for part in shown.split("</figure>") if "sparc over the attempts" in part)
    values = re.findall(r"<title>(day\d: [^<]*)</title>", figure)
    assert values == ["day0: -8.00", "day1: -9.00", "day2: not passed, not measured"]
    assert figure.count("#d9dee4") == 1, "the area that passes"


def test_the_limit_of_a_curve_is_that_of_the_newest_session_that_has_one():
    old, new = made.metric(3.0, 2.0, 0.1, 2.5), made.metric(3.0, 2.0, 0.1, 4.0)
    attempts = [{"metrics": {"time": metric, "odd": 1}} for metric in (unmeasured(old), new, old)]
    assert curves._metrics(attempts)["time"] == {**unmeasured(old), "limit": 4.0}
    assert set(curves._metrics(attempts)) == {"time"}


def test_the_newest_of_the_other_sessions_is_the_last_and_of_its_attempts_too(tmp_path):
    def attempts(*limits):
        return [{"metrics": {"time": made.metric(3.0, 2.0, 0.1, limit)}} for limit in limits]

    others = [made.make(tmp_path / f"day{i}", made.score(attempts=attempts(*limits)))
              for i, limits in enumerate(((2.5, 3.5), (4.5, 5.5)))]
    newest = {"metrics": {"time": unmeasured(made.metric(3.0))}}
    facts = types.SimpleNamespace(score=made.score(attempts=[newest]), attempt=newest)
    assert curves._metrics(curves._newest_attempts(facts, others))["time"]["limit"] == 5.5


def test_an_attempt_that_failed_before_it_was_measured_leaves_all_curves(tmp_path):
    measured = {"time": made.metric(1.0, 2.0, 0.1, 2.5), "wire_touches": made.metric(2, 0.0, 0.0, 0.5, "count")}
    folders = days(tmp_path, measured, {name: unmeasured(metric) for name, metric in measured.items()}, status="failed")
    names, shown = curve_of(report(*folders)[0])
    assert names == ["time", "wire touches"] and shown.count("#d9dee4") == 3, "two limits and the legend"


def test_the_newest_session_without_an_attempt_has_the_curves_of_the_others(tmp_path):
    folders = days(tmp_path, *[made.metrics() for _ in range(3)], attempts=[])
    names, shown = curve_of(report(*folders)[0])
    assert names == ["time", "wire touches", "drops", "sparc", "path"], "those out of the band first, then the nearest to it"
    assert "2 attempts of 2 sessions" in shown


def test_sessions_of_the_same_name_are_distinguished(tmp_path):
    parents = [tmp_path / name for name in ("mon", "tue", "wed")]
    folders = [made.make(parent / "session", made.score(), f"2026-01-0{i + 1}T10:00:00Z") for i, parent in enumerate(parents)]
    link = tmp_path / "again"
    link.symlink_to(folders[0])
    page, record, _ = report(link, *folders)
    assert [p["session"] for p in record["curve"]] == ["mon/session", "tue/session", "wed/session"]
    assert "3 attempts of 3 sessions" in page and "tue/session: " in page
    (folders[0] / "score.json").unlink()
    (folders[1] / "score.json").write_text(json.dumps(made.score(exercise="peg_transfer")))
    page, record, _ = report(*folders)
    assert record["left_out"] == ["mon/session", "tue/session"]
    assert "Left out: mon/session (no score); tue/session (another exercise, peg transfer)." in page


@pytest.mark.parametrize("places, names", [
    (["/a/s", "/b/s", "/b/t"], ["a/s", "b/s", "t"]), (["/s", "/b/s"], ["s", "b/s"]), ([], []),
    (["/x/a/s", "/y/a/s", "/y/b/s"], ["x/a/s", "y/a/s", "b/s"]), (["/"], [""])])
def test_a_session_is_named_as_shortly_as_it_can_be(places, names):
    assert list(map(curves.short_names(places).get, places)) == names


def test_the_trainee_s_index_makes_the_curve_without_asking(tmp_path):
    *_, third = series_of_sessions(tmp_path)
    entry = {"start_time_utc": "2025-12-31T10:00:00Z", "exercise": "pick_hand_over_place", "drill": "sudden_jump",
             "attempts": [{"status": "done", "passed": False, "metrics": {"time": 4.5}}]}
    index = {"version": 1, "sessions": [{**entry, "directory": "old", "trainee": "anna"},
                                        {**entry, "directory": "not_hers", "trainee": "ben"},
                                        {**entry, "directory": "day2", "trainee": "anna"}]}
    (tmp_path / "index.json").write_text(json.dumps(index))
    _, record, _ = report(third)
    assert [(p["session"], p["metrics"]["time"]) for p in record["curve"]] == [("old", 4.5), ("day2", 2.0)]


def test_the_newest_session_is_reported_whatever_the_order(tmp_path):
    folders = [str(f) for f in series_of_sessions(tmp_path)]
    for given in (folders, folders[::-1]):
        newest, others = curves.newest_first(given)
        assert newest == folders[2] and others == folders[:2]


# ---- old, broken and hostile ------------------------------------------------------------------------------------


def test_an_old_session_without_an_exercise_has_a_report(tmp_path):
    folder = tmp_path / "old"
    folder.mkdir()
    (folder / "session.rlog").write_bytes(made.log.session_bytes())
    page, record, _ = report(folder)
    assert headline(page).startswith("Free session") and record["verdict"]["passed"] is None
    assert "sudden jump: 1.000 s to 1.300 s" in page and record["metrics"] == []


def test_an_exercise_without_a_score_says_how_to_get_one(tmp_path):
    page, _, _ = report(made.make(tmp_path / "s"))  # score_session, if it is built, rejects this log
    assert "Not judged: this session has no score" in page and "score_session DIR" in page


def put_elsewhere(tmp_path, monkeypatch, says):
    """A build in another place, whose score_session only prints."""
    program = tmp_path / "elsewhere/devel/lib/raven2_trainer/score_session"
    program.parent.mkdir(parents=True)
    program.write_text(f"#!/bin/sh\necho \"{says}\" >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setenv("RAVEN2_TRAINER_BUILD", str(tmp_path / "elsewhere"))


def test_a_build_in_another_place_scores_the_session(tmp_path, monkeypatch):
    put_elsewhere(tmp_path, monkeypatch, "another build: $1")
    folder = made.make(tmp_path / "s")
    assert f"session_report: score_session: another build: {folder}\n" in report(folder)[2]


@pytest.mark.parametrize("content", ["", "[]", '{"version": 2}', '{"version": 1, "attempts": [1]}', "{" * 100000])
def test_a_score_that_is_none_is_said_and_left_out(tmp_path, content):
    folder = made.make(tmp_path / "s")
    (folder / "score.json").write_text(content)
    page, record, _ = report(folder)
    assert "score.json is not what score_session writes" in page and record["metrics"] == []


HOSTILE = '<img src=x onerror=alert(1)>"\'</script><script>alert(2)</script>'


def test_hostile_names_are_shown_and_do_nothing(tmp_path):
    folder = tmp_path / HOSTILE.replace("/", "_")
    scored = made.score(improve=[HOSTILE, "wire_touches"], trainee=HOSTILE, failure=HOSTILE, status="failed",
                        hazards=[{**made.hazard(), "scenario": HOSTILE, "verdict": HOSTILE}])
    scored["attempts"][0]["metrics"][HOSTILE] = made.metric(5.0, 1.0, 0.1, 2.0, HOSTILE)
    scored["attempts"][0]["not_judged"] = [HOSTILE]
    scored["band"]["origin"] = HOSTILE
    header = {"trainee": HOSTILE, "motion": HOSTILE, "hazard": HOSTILE, "drill": HOSTILE, "curriculum": HOSTILE,
              "step_names": [[HOSTILE] * 3], "body_names": [HOSTILE] * 3, "scenarios": [HOSTILE]}
    page, record, _ = report(made.make(folder, scored, **header), run=forked.run)
    assert HOSTILE not in page and "<img src=x" not in page and "alert(2)</script>" not in page
    assert page.count("<script") == 2 and page.count("</script>") == 2, "the view's data and the view's script"
    assert "&lt;img src=x onerror=alert(1)&gt;" in page
    assert record["session"]["trainee"] == HOSTILE, "JSON has the name unchanged"


def test_hostile_figures_of_the_engineering_part_do_nothing(tmp_path):
    folder = made.make(tmp_path / "s", made.score(), arm_names=[HOSTILE, "green"], arm_contacts=[True, False])
    fault = {"name": "sudden_jump", "first_tick": 1000, "last_tick": 1300, "error_to_force_ms": HOSTILE}
    plan = {"success": True, "status": "found", "cost": HOSTILE, "waypoints": HOSTILE}
    (folder / "metrics.json").write_text(json.dumps({"faults": [fault], "plan": plan}))
    page, _, _ = report(folder, run=forked.run)
    assert "<img src=x" not in page and page.count("<script") == 2
    assert "alert(1)&gt;&quot;" in page, "the arm's name"


def test_an_attempt_that_failed_before_its_timer_started_has_no_length(tmp_path):
    scored = made.score(status="failed", failure="broke_off", improve=[])
    scored["attempts"][0].update(first_tick=None, last_tick=None, composite=None, metrics={}, not_judged=["time"])
    page, _, _ = report(made.make(tmp_path / "s", scored))
    assert "Not passed: something broke off" in page and "Attempt 1 of 1, over before its time began" in page


def test_a_hazard_that_nobody_could_notice_is_no_failure(tmp_path):
    unnoticed = {**made.hazard("not_judged", None), "cue_after_ms": None, "cue": None}
    passed = {"time": made.metric(1.8, 2.0, 0.1, 2.5)}
    page, record, _ = report(made.make(tmp_path / "a", made.score(True, improve=[], hazards=[unnoticed], values=passed),
                                       drill="none"))
    assert "answered" not in headline(page) and headline(page).startswith("Passed")
    assert "there was nothing to answer, and nothing is judged" in page
    assert record["improve"] == [] and "Nothing: every figure" in page
    page, record, _ = report(made.make(tmp_path / "b", made.score(None, improve=[], hazards=[unnoticed], values=passed)))
    assert headline(page) == "Not judged: all else passed, but the hazard of the drill gave nothing to feel or to see in time"
    assert record["verdict"]["passed"] is None
    page, _, _ = report(made.make(tmp_path / "c", made.score(None, improve=[], hazards=[], values=passed)))
    assert headline(page) == "Not judged: all else passed, but the hazard of the drill did not come"


@pytest.mark.parametrize("early, why", [("stop", "an emergency stop came before anybody could react"),
                                        ("retreat", "the recording ends, or was paused, before an answer could be seen")])
def test_the_headline_says_why_a_noticed_hazard_is_not_judged(tmp_path, early, why):
    hazard = {**made.hazard("not_judged", None), "coincidences": [{"response": early, "after_ms": 90}]}
    scored = made.score(None, improve=[], hazards=[hazard], values={"time": made.metric(1.8, 2.0, 0.1, 2.5)})
    page, record, _ = report(made.make(tmp_path / "s", scored))
    assert headline(page) == record["verdict"]["headline"] == f"Not judged: all else passed, but in the drill {why}"
    assert f"not judged: {why}" in plain(page) and f"Not judged: {why}." in plain(page)
    assert "nothing to feel" not in page and "every figure is well within its band" in page


def test_a_force_that_was_no_cue_has_warned_nobody(tmp_path):
    unnoticed = {**made.hazard("not_judged", None), "cue_after_ms": None, "cue": None}
    folder = made.make(tmp_path / "s", made.score(None, improve=[], hazards=[unnoticed]))
    fault = {"name": "sudden_jump", "first_tick": 1000, "last_tick": 1300, "max_error_mm": 2.0, "max_force_N": 0.25}
    (folder / "metrics.json").write_text(json.dumps({"faults": [fault]}))
    page, record, _ = report(folder)
    assert "no force warned the surgeon" in record["summary"] and record["summary"].replace("'", "&#x27;") in page
    assert "No force of 0.5 N and no gap of 3 mm lasted 100 ms" in page


def test_a_hazard_that_was_seen_and_not_felt_is_described_so(tmp_path):
    page, _, _ = report(made.make(tmp_path / "s", made.score(hazards=[{**made.hazard(), "cue": "ghost"}])))
    assert "The robot was seen to part from the model after 12 ms" in page


def test_copies_outside_the_session_are_not_read(tmp_path):
    secret = tmp_path / "config" / "exercises" / "pick_hand_over_place.yaml"
    secret.parent.mkdir(parents=True)
    secret.write_text("title: of somebody else\n")
    header = {"configuration": [{"path": "../config/exercises/pick_hand_over_place.yaml", "fnv1a": "0"}]}
    page, _, _ = report(made.make(tmp_path / "s", made.score(), **header))
    assert "of somebody else" not in page


def test_a_wrong_directory_among_several_is_named_and_nothing_written(tmp_path):
    good = made.make(tmp_path / "good", made.score())
    page, _, said = report(tmp_path, good, fails=True)
    assert page == "" and said.count("\n") == 1 and "no session.rlog" in said


def test_the_same_session_gives_the_same_page(tmp_path):
    folder = made.make(tmp_path / "s", made.score())
    assert report(folder, run=plainly)[0] == report(folder, run=forked.run)[0]


def test_ticks_of_an_axis_are_round_and_inside():
    for low, high in ((0.0, 25.0), (-0.6, 3.2), (-24.3, -9.1), (0.0, 0.013), (0.0, 81234.0)):
        ticks = drawing.nice_ticks(low, high, 5)
        assert 2 <= len(ticks) <= 12 and all(low - 1e-9 <= t <= high + 1e-9 for t in ticks)


# ---- in a browser -----------------------------------------------------------------------------------------------

MEASURE = """<script>addEventListener('load', function () {
  var turn = document.getElementById('turn'), path = turn.querySelector('path.t') || turn.querySelector('path.p');
  var before = path.getAttribute('d');
  turn.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowLeft'}));
  setTimeout(function () {
    var wide = [].filter.call(document.querySelectorAll('main *'), function (e) {
      return !e.closest('.wide') && !(e.parentNode.closest('svg')) && e.getBoundingClientRect().right > innerWidth + 1;
    }).map(function (e) { return e.tagName + '.' + e.className; });
    document.body.insertAdjacentHTML('beforeend', '<pre id="measured">' + JSON.stringify({
      page: document.documentElement.scrollWidth, window: innerWidth, beyond: wide,
      turned: path.getAttribute('d') !== before}) + '</pre>');
  }, 100);
});</script></body>"""


def browse(page, width, *options):
    command = [BROWSER, "--headless=new", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
               f"--user-data-dir={page.parent / 'profile'}", "--virtual-time-budget=6000",
               f"--window-size={width},1000",
               *options, page.as_uri()]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=180)


@pytest.mark.skipif(BROWSER is None, reason="NOT CHECKED: no chromium here (Debian's package chromium), so nobody saw "
                                            "the "
                                            "report in a browser")
@pytest.mark.parametrize("width", [1280, 820, 600])
def test_a_browser_shows_it_without_errors_or_overflow(tmp_path, whole, width):
    page = tmp_path / "measured.html"
    page.write_text(whole[1].replace("</body>", MEASURE), encoding="utf-8")
    done = browse(page, width, "--dump-dom")
    assert done.returncode == 0, done.stderr
    measured = json.loads(re.search(r'<pre id="measured">(.*?)</pre>', done.stdout).group(1))
    assert measured["window"] == width and measured["page"] <= width and measured["beyond"] == []
    assert measured["turned"], "the view rotates"
    assert "CONSOLE" not in done.stderr, done.stderr


@pytest.mark.skipif(BROWSER is None, reason="NOT CHECKED: no chromium here (Debian's package chromium)")
def test_it_prints(tmp_path, whole):
    page, paper = tmp_path / "print.html", tmp_path / "print.pdf"
    page.write_text(whole[1], encoding="utf-8")
    browse(page, 1280, f"--print-to-pdf={paper}")
    content = paper.read_bytes()
    assert content.startswith(b"%PDF") and 2 <= len(re.findall(rb"/Type\s*/Page\b", content)) <= 12


def test_a_score_that_is_there_stays(tmp_path, monkeypatch):
    put_elsewhere(tmp_path, monkeypatch, "scored again")
    assert "scored again" not in report(made.make(tmp_path / "s", made.score()))[2]
