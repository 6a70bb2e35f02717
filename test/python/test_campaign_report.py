"""scripts/campaign_report: what it counts, what it demands an explanation for."""
import csv
import json
import pathlib
import re
import subprocess
import sys

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "campaign_report"
COLUMNS = ("scenario,run,seed,outcome,injection,phase,host,site,variable,kind,arm,channel,value,low,high,first_tick,"
           "duration_ticks,half_period_ticks,repetition,motion_seed,injected_ms,deviation_mm,jump_mm,jump_ms,estop,"
           "estop_ms,seen,reported,force_ms,force_n,motion_mm,golden_motion_mm,program,finite").split(",")
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


def report(folder, *arguments):
    done = subprocess.run([sys.executable, str(SCRIPT), str(folder), *arguments], capture_output=True, text=True,
                          check=False, timeout=120)
    page = folder / "report.html"
    return done.returncode, done.stderr, page.read_text() if page.exists() else ""


def verdicts(page):
    return re.findall(r'<span class="(agrees|explained|UNEXPLAINED)">', page)


def two_scenarios(folder):
    """The second differs from what was published in one of its two runs."""
    rows = [{"scenario": "a", "injection": 1, "outcome": "estop", "estop": "plc", "estop_ms": 200, "reported": 0}] * 3
    rows += [{"scenario": "b", "injection": 2, "outcome": outcome} for outcome in ("masked", "unsafe_jump")]
    write(folder, [scenario("a", 1, 3, ["estop"]), scenario("b", 2, 2, ["masked"])], rows)


def test_a_row_that_differs_needs_an_explanation(tmp_path):
    two_scenarios(tmp_path)
    code, said, page = report(tmp_path)
    assert code == 1 and "[2]" in said
    assert verdicts(page) == ["agrees", "UNEXPLAINED"]
    explained = tmp_path / "why.yaml"
    explained.write_text("2: one motor of ours is weaker\n")
    code, _, page = report(tmp_path, "--explained", str(explained))
    assert code == 0 and verdicts(page) == ["agrees", "explained"]
    assert "one motor of ours is weaker" in page and "1 of 2" in page
    assert "1 of 2 rows agree in every run, 1 differ and are explained, 0 are not" in page


def test_a_note_on_a_row_that_agrees_leaves_it_agreeing(tmp_path):
    two_scenarios(tmp_path)
    explained = tmp_path / "why.yaml"
    explained.write_text("1: shown by its level\n2: weaker\n")
    _, _, page = report(tmp_path, "--explained", str(explained))
    assert verdicts(page) == ["agrees", "explained"] and "shown by its level" in page
    assert "estop 3<br>3 stops of the PLC unreported" in page


def test_what_was_published_is_that_of_the_run_s_own_scenario(tmp_path):
    rows = [{"scenario": "a", "injection": 1, "phase": phase, "outcome": outcome}
            for phase, outcome in (("homing", "no_motion"), ("pedal_down", "estop"))]
    write(tmp_path, [scenario("a", 1, 1, ["estop"]), scenario("a", 1, 1, ["no_motion"])], rows)
    _, _, page = report(tmp_path)
    assert verdicts(page) == ["UNEXPLAINED"] and "0 of 2" in page, "each has what the other should have"


def test_a_grid_of_values_and_durations_is_drawn(tmp_path):
    rows = [{"scenario": "a", "injection": 0, "outcome": "masked", "value": value, "duration_ticks": duration,
             "jump_mm": value * duration / 1000} for value in (1, 2, 3) for duration in (1, 2, 4)]
    write(tmp_path, [scenario("a", 0, 9, [])], rows)
    code, _, page = report(tmp_path)
    assert code == 0, "nothing was published for it"
    assert page.count("<img") == 2 and "Jumps over value and duration" in page
    write(tmp_path, [scenario("a", 0, 3, [])], rows[:3])
    assert report(tmp_path)[2].count("<img") == 1


def test_counts_are_those_of_the_table(tmp_path):
    two_scenarios(tmp_path)
    _, _, page = report(tmp_path)
    assert "<b>5</b><span>runs, each with a recorded outcome" in page
    assert "<b>3</b><span>stopped, after 200 ms (median)" in page
    assert "<b>3</b><span>stops of the PLC that the software never showed" in page
    assert "Toy &amp; co" in page and "seen &lt;so&gt;" in page


def test_a_deviation_that_is_small_by_name_alone_is_counted(tmp_path):
    rows = [{"scenario": "a", "injection": 1, "outcome": "small_deviation", "deviation_mm": deviation}
            for deviation in (0.5, 2.9, 3.1, 200.0)]
    write(tmp_path, [scenario("a", 1, 4, ["small_deviation"])], rows)
    assert "small deviation 4<br>2 deviations beyond 3 mm, though never fast" in report(tmp_path)[2]


def test_what_is_no_campaign_is_refused(tmp_path):
    code, said, _ = report(tmp_path)
    assert code == 1 and "no finished campaign" in said
    two_scenarios(tmp_path)
    wrong = tmp_path / "why.yaml"
    wrong.write_text("7: no such row\n")
    code, said, _ = report(tmp_path, "--explained", str(wrong))
    assert code == 1 and "[7]" in said
    wrong.write_text("- a list\n")
    assert report(tmp_path, "--explained", str(wrong))[0] == 1
