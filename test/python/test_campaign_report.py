"""scripts/campaign_report: which runs it counts, and which rows need an explanation."""
import csv
import json
import pathlib
import re
import subprocess
import sys


SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "campaign_report"
sys.path[:0] = [str(SCRIPT.parent), str(pathlib.Path(__file__).resolve().parent)]
import forked  # noqa: E402
import raven2_figures  # noqa: E402,F401  (loaded once, for all reports)

COLUMNS = ("scenario,run,seed,outcome,injection,phase,host,site,variable,kind,arm,channel,value,low,high,first_tick,"
           "duration_ticks,half_period_ticks,repetition,motion_seed,injected_ms,deviation_mm,jump_mm,jump_ms,estop,"
           "estop_ms,seen,reported,force_ms,force_n,motion_mm,golden_motion_mm,started,program,finite").split(",")
PLAIN = dict.fromkeys(COLUMNS, "") | {"phase": "pedal_down", "value": "0", "duration_ticks": "0", "estop": "none",
                                      "injected_ms": "1", "deviation_mm": "0.0", "jump_mm": "0.0", "seen": "0",
                                      "program": "running"}


def scenario(name, injection, runs, published):
    return {"scenario": name, "runs": runs, "injection": injection, "number": 1, "observed": "seen <so>",
            "published": published}


def write(folder, scenarios, rows):
    """A finished campaign."""
    identity = {"name": "toy", "title": "Toy & co", "source": "none", "seed": 1, "digest": "0", "runs": len(rows),
                "shard": 1, "shards": 1, "scenarios": scenarios}
    (folder / "campaign.json").write_text(json.dumps(identity))
    with open(folder / "outcomes.csv", "w", encoding="ascii", newline="") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        for number, row in enumerate(rows, 1):
            table.writerow(PLAIN | {"run": number} | row)


def plainly(script, *arguments):
    return subprocess.run([sys.executable, script, *arguments], capture_output=True, text=True, check=False, timeout=120)


def report(folder, *arguments, run=forked.run):
    done = run(SCRIPT, folder, *arguments)
    page = folder / "report.html"
    return done.returncode, done.stderr, page.read_text() if page.exists() else ""


def verdicts(page):
    return re.findall(r'<span class="(agrees|explained|UNEXPLAINED)">', page)


def two_scenarios(folder):
    """One of the two runs of the second scenario differs from the published outcome."""
    rows = [{"scenario": "a", "injection": 1, "outcome": "estop", "estop": "plc", "estop_ms": 200, "reported": 0}] * 3
    rows += [{"scenario": "b", "injection": 2, "outcome": outcome} for outcome in ("masked", "unsafe_jump")]
    write(folder, [scenario("a", 1, 3, ["estop"]), scenario("b", 2, 2, ["masked"])], rows)


def test_a_row_that_differs_needs_an_explanation(tmp_path):
    two_scenarios(tmp_path)
    code, said, page = report(tmp_path)
    assert code == 1 and "1 runs neither as published nor explained, b/pedal_down: unsafe_jump" in said
    assert verdicts(page) == ["agrees", "UNEXPLAINED"]
    explained = tmp_path / "why.yaml"
    explained.write_text("b/pedal_down: {allowed: [estop], why: one motor of ours is weaker}\n")
    assert report(tmp_path, "--explained", str(explained))[0] == 1, "the note explains an estop, not a jump"
    explained.write_text("b/pedal_down: {allowed: [unsafe_jump], why: one motor of ours is weaker}\n")
    code, _, page = report(tmp_path, "--explained", str(explained))
    assert code == 0 and verdicts(page) == ["agrees", "explained"]
    assert "one motor of ours is weaker" in page and "1 of 2" in page
    assert "1 of 2 rows agree in every run, 1 differ and are explained, 0 are not" in page


def test_a_note_on_a_row_that_agrees_leaves_it_agreeing(tmp_path):
    two_scenarios(tmp_path)
    explained = tmp_path / "why.yaml"
    explained.write_text("a/pedal_down: {allowed: [crash], why: shown by its level}\n"
                         "b/pedal_down: {allowed: [unsafe_jump], why: weaker}\n")
    _, _, page = report(tmp_path, "--explained", str(explained))
    assert verdicts(page) == ["agrees", "explained"] and "shown by its level" in page
    assert "a/pedal_down: crash is allowed and did not come" in page
    assert "estop 3<br>3 stops of the PLC unreported" in page


def test_what_was_published_is_that_of_the_run_s_own_scenario(tmp_path):
    rows = [{"scenario": "a", "injection": 1, "phase": phase, "outcome": outcome}
            for phase, outcome in (("homing", "no_motion"), ("pedal_down", "estop"))]
    write(tmp_path, [scenario("a", 1, 1, ["estop"]), scenario("a", 1, 1, ["no_motion"])], rows)
    _, _, page = report(tmp_path)
    assert verdicts(page) == ["UNEXPLAINED"] and "0 of 2" in page, "each run has the outcome published for the other"


def test_a_grid_of_values_and_durations_is_drawn(tmp_path):
    rows = [{"scenario": "a", "injection": 0, "outcome": "masked", "value": value, "duration_ticks": duration,
             "jump_mm": value * duration / 1000} for value in (1, 2, 3) for duration in (1, 2, 4)]
    write(tmp_path, [scenario("a", 0, 9, [])], rows)
    code, _, page = report(tmp_path)
    assert code == 0, "nothing was published for it"
    assert page.count("<img") == 2 and "Jumps over value and duration" in page and "<h2>Windows" in page
    write(tmp_path, [scenario("a", 0, 3, [])], rows[:3])
    assert report(tmp_path)[2].count("<img") == 1


def test_scenarios_of_one_row_of_the_library_are_one_grid(tmp_path):
    rows = [{"scenario": "low" if value < 3 else "high", "injection": 0, "value": value, "duration_ticks": duration,
             "outcome": "masked" if value * duration < 6 else "unsafe_jump", "jump_mm": value * duration / 4}
            for value in (1, 2, 3, 4) for duration in (1, 2, 4)]
    write(tmp_path, [scenario("low", 0, 6, []), scenario("high", 0, 6, [])], rows)
    code, _, page = report(tmp_path)
    assert code == 0 and page.count("<img") == 2, "each scenario alone has only two values"
    cells = [re.sub("<[^>]*>", " ", line).split() for line in page.split("<h2>Windows")[1].split("<tr>")[2:6]]
    assert [c[2:7] for c in cells] == [["1", "3", "–", "–", "–"], ["2", "3", "4", "4", "–"], ["3", "3", "2", "2", "–"],
                                       ["4", "3", "2", "2", "–"]]


def test_counts_are_those_of_the_table(tmp_path):
    two_scenarios(tmp_path)
    _, _, page = report(tmp_path, run=plainly)
    assert "<b>5</b><span>runs with a recorded outcome" in page
    assert "<b>3</b><span>stopped, after 200 ms (median)" in page
    assert "<b>3</b><span>stops of the PLC that the software never showed" in page
    assert "Toy &amp; co" in page and "seen &lt;so&gt;" in page


def test_figures_are_in_the_units_of_their_columns(tmp_path):
    stopped = {"scenario": "a", "injection": 3, "outcome": "estop"}
    rows = [stopped | {"estop": "software", "estop_ms": 10, "seen": 1, "deviation_mm": "1.25", "jump_mm": "0.125",
                       "force_ms": 40},
            stopped | {"estop": "plc", "estop_ms": 30, "reported": 0, "deviation_mm": "4.5", "jump_mm": "2.5",
                       "force_ms": 70},
            stopped | {"estop": "both", "estop_ms": 50, "seen": 1, "reported": 1, "deviation_mm": "3.0"},
            {"scenario": "a", "injection": 3, "outcome": "masked", "deviation_mm": "0.5", "jump_mm": "0.0625"},
            {"scenario": "b", "injection": 0, "outcome": "masked"}]
    write(tmp_path, [scenario("a", 3, 4, ["estop", "masked"]), scenario("b", 0, 1, [])], rows)
    (tmp_path / "timing.json").write_text(json.dumps({"cpu_s_per_run": 1.2345}))
    page = report(tmp_path)[2]
    cards = dict(reversed(pair) for pair in re.findall(r'<div class="card"><b>(.*?)</b><span>(.*?)</span>', page))
    assert cards == {"runs with a recorded outcome": "5", "runs in which the fault never acted": "0",
                     "stopped, after 30 ms (median)": "3", "stopped by the robot&#x27;s own check": "2",
                     "stops of the PLC that the software never showed": "1", "went more than 3 mm astray": "1",
                     "until the hand feels a force (median of those that do)": "55 ms", "": "1.23 CPU s a run"}
    lines = page.split("<h2>Figures of each scenario")[1].split("<tr>")[1:]
    titles, b, a = ([re.sub("<[^>]*>", "", cell) for cell in re.findall(r"<t[hd].*?>(.*?)</t[hd]>", line)]
                    for line in lines)
    assert titles[5:7] == ["Deviation [mm]", "Jump [mm]"]
    assert a == ["3", "a", "pedal down", "4", "masked 1, estop 3", "4.50", "2.500", "30 ms", "55 ms", "2"]
    assert b == ["–", "b", "pedal down", "1", "masked 1", "0.00", "0.000", "–", "–", "0"]


def test_a_fault_that_never_acted_fails_the_campaign_whatever_was_published(tmp_path):
    rows = [{"scenario": "a", "injection": 0, "outcome": "masked", "injected_ms": at} for at in ("1", "")]
    rows.append({"scenario": "a", "injection": 0, "outcome": "crash", "injected_ms": "", "estop": "",
                 "program": "died"})
    write(tmp_path, [scenario("a", 0, 3, [])], rows)
    code, said, page = report(tmp_path)
    assert code == 1 and "1 runs in which the fault never acted: 2" in said
    assert "1 runs in which the fault never acted: 2" in page, "the page is written although the campaign failed"


def test_a_run_without_an_outcome_fails_the_campaign(tmp_path):
    write(tmp_path, [scenario("a", 0, 1, [])], [{"scenario": "a", "injection": 0, "outcome": "no_outcome",
                                                 "estop": "", "injected_ms": "", "program": "no_end"}])
    code, said, _ = report(tmp_path)
    assert code == 1 and "1 runs without an outcome: 1" in said and "never acted" not in said


def test_a_scenario_that_is_masked_throughout_needs_that_to_be_all_that_is_allowed(tmp_path):
    rows = [{"scenario": "a", "injection": 0, "outcome": "masked"}] * 3
    write(tmp_path, [scenario("a", 0, 3, ["masked", "estop"])], rows)
    code, said, _ = report(tmp_path)
    assert code == 1 and "every run masked, though more is expected: a/pedal_down" in said
    explained = tmp_path / "why.yaml"
    explained.write_text("a/pedal_down: {allowed: [masked, slow_deviation], why: short}\n")
    assert report(tmp_path, "--explained", str(explained))[0] == 1
    explained.write_text("a/pedal_down: {allowed: [masked], why: never looked at}\n")
    assert report(tmp_path, "--explained", str(explained))[0] == 0


def test_a_table_that_lost_or_doubled_rows_is_refused(tmp_path):
    two_scenarios(tmp_path)
    table = tmp_path / "outcomes.csv"
    lines = table.read_text().splitlines(keepends=True)
    for wrong in (lines[:-1], lines[:-1] + lines[1:2], lines + lines[1:2]):
        table.write_text("".join(wrong))
        code, said, _ = report(tmp_path)
        assert code == 1 and "rows, expected 5" in said
    identity = json.loads((tmp_path / "campaign.json").read_text())
    (tmp_path / "campaign.json").write_text(json.dumps(identity | {"shards": 2, "runs": 8}))
    table.write_text("".join(lines))
    assert "expected" not in report(tmp_path)[1], "a shard has only some of the runs"


def test_rows_of_the_library_are_compared_where_the_published_table_has_none(tmp_path):
    rows = [{"scenario": name, "injection": 0, "outcome": "masked"} for name in ("small", "large")]
    entries = [scenario("small", 0, 1, ["masked"]), scenario("large", 0, 1, ["estop"])]
    write(tmp_path, entries, rows)
    code, said, page = report(tmp_path)
    assert code == 1 and "large/pedal_down: masked" in said
    assert verdicts(page) == ["UNEXPLAINED"] and "row 1" in page and "1 of 2" in page


def test_a_slow_deviation_that_goes_far_is_counted(tmp_path):
    rows = [{"scenario": "a", "injection": 1, "outcome": "slow_deviation", "deviation_mm": deviation}
            for deviation in (0.5, 2.9, 3.1, 200.0)]
    write(tmp_path, [scenario("a", 1, 4, ["slow_deviation"])], rows)
    assert "slow deviation 4<br>2 deviations beyond 3 mm, though never fast" in report(tmp_path)[2]


def test_what_is_no_campaign_is_refused(tmp_path):
    code, said, _ = report(tmp_path)
    assert code == 1 and "no finished campaign" in said
    two_scenarios(tmp_path)
    wrong = tmp_path / "why.yaml"
    wrong.write_text("a/homing: {allowed: [], why: no such phase}\n")
    code, said, _ = report(tmp_path, "--explained", str(wrong))
    assert code == 1 and "a/homing" in said
    for text in ("- a list\n", "a/pedal_down: why\n", "a/pedal_down: {allowed: [no_outcome], why: x}\n"):
        wrong.write_text(text)
        code, said, _ = report(tmp_path, "--explained", str(wrong))
        assert code == 1 and "is not a mapping" in said


def test_a_shard_may_hold_those_runs_of_a_scenario_that_are_masked_alone(tmp_path):
    write(tmp_path, [scenario("a", 0, 6, ["masked", "estop"])],
          [{"scenario": "a", "injection": 0, "outcome": "masked"}] * 3)
    identity = json.loads((tmp_path / "campaign.json").read_text())
    (tmp_path / "campaign.json").write_text(json.dumps(identity | {"shards": 2, "runs": 6}))
    code, said, _ = report(tmp_path)
    assert code == 0 and "every run masked" not in said
