"""The program plan from its command line. Needs the built program; skipped where it is not built."""

import csv
import os
import subprocess

import pytest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PLAN = os.path.join(os.environ.get("RAVEN2_TRAINER_BUILD", os.path.join(ROOT, "build")), "devel", "lib",
                    "raven2_trainer", "plan")

pytestmark = pytest.mark.skipif(not os.path.exists(PLAN), reason="plan is not built")


def plan(*arguments):
    return subprocess.run([PLAN, *map(str, arguments)], capture_output=True, text=True, check=False)


def rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_study_is_printed_written_and_drawn(tmp_path):
    folder = tmp_path / "study"
    got = plan("short_move", "--samples", "40,80", "--runs", 2, "--seed", 5, "--output", folder, "--plot")
    assert got.returncode == 0, got.stderr
    assert got.stdout.startswith("short_move: ")
    assert got.stdout.count("planning time [s]") == 2, "one table without the clearance term and one with it"
    runs = rows(folder / "runs.csv")
    assert [(r["samples"], r["run"], r["seed"]) for r in runs] == [(n, i, s) for n in ("40", "80") for i, s in
                                                                  (("1", "5"), ("2", "6"))] * 2
    for run in runs:
        assert (run["success"], run["reason"]) == ("1", "success")
        assert float(run["planning_time_s"]) > 0 and float(run["clearance_m"]) > 0
        track, waypoints = (rows(folder / "paths" / (run["path"] + end + ".csv")) for end in ("", "_waypoints"))
        assert len(waypoints) == int(run["waypoints"])
        # the tracked tip ends at its desired position, and the last row of the file has the tracking time, to a row
        assert float(track[-1]["x_m"]) == pytest.approx(float(track[-1]["x_desired_m"]), abs=1e-3)
        assert float(track[-1]["time_s"]) == pytest.approx(float(run["tracking_time_s"]), abs=0.0021)
    table = rows(folder / "table.csv")
    assert [row["samples"] for row in table] == ["40", "80"] * 2
    for row in table:
        chosen = [r for r in runs if (r["samples"], r["eta_clearance"]) == (row["samples"], row["eta_clearance"])]
        assert float(row["cost_mean"]) == pytest.approx(sum(float(r["cost"]) for r in chosen) / 2)
    for picture in ("figure7.png", "figure8.png"):
        assert (folder / picture).stat().st_size > 20000


def read_ompl_log(path):
    """({planner: [{property: value} of each run]}, names of the statuses). Reads the lines in the order in which
    ompl_benchmark_statistics.py of OMPL 1.5 and later reads them."""
    lines = iter(path.read_text().splitlines())

    def count(words):
        number, rest = next(lines).split(" ", 1)
        assert rest == words
        return int(number)

    def block():
        assert next(lines) == "<<<|"
        while next(lines) != "|>>>":
            pass

    assert next(lines).startswith("OMPL version 1.")
    assert next(lines) == "Experiment short_move"
    assert count("experiment properties") == 0
    assert next(lines).startswith("Running on ") and next(lines).startswith("Starting at 20")
    block()
    block()
    assert count("is the random seed") == 5
    for words in (" seconds per run", " MB per run", " runs per planner", " seconds spent to collect the data"):
        assert (line := next(lines)).endswith(words) and float(line[:-len(words)]) >= 0
    assert count("enum type") == 1
    status = next(lines).split("|")[1:]
    planners = {}
    for _ in range(count("planners")):
        name = next(lines)
        for _ in range(count("common properties")):
            assert " = " in next(lines)
        names = [next(lines).rsplit(" ", 1)[0] for _ in range(count("properties for each run"))]
        runs = [next(lines).split("; ") for _ in range(count("runs"))]
        assert all(run[-1] == "" and len(run) == len(names) + 1 for run in runs)
        planners[name] = [dict(zip(names, run)) for run in runs]
        assert next(lines) == "."
    assert next(lines, None) is None
    return planners, status


def test_a_study_is_written_as_ompls_benchmark_log(tmp_path):
    log = tmp_path / "benchmark.log"
    got = plan("short_move", "--samples", "40", "--runs", 2, "--seed", 5, "--output", tmp_path / "s", "--ompl-log", log)
    assert got.returncode == 0, got.stderr
    planners, status = read_ompl_log(log)
    written = rows(tmp_path / "s" / "runs.csv")
    assert len(planners) == 2 and all(name.startswith("FMTstar_n40_eta") for name in planners)
    runs = [run for of_one in planners.values() for run in of_one]
    for run, row in zip(runs, written, strict=True):
        assert run["seed"] == row["seed"] and run["solved"] == run["correct_solution"] == "1"
        assert status[int(run["status"])] == "success"
        assert float(run["time"]) == pytest.approx(float(row["planning_time_s"]), rel=1e-3)
        assert float(run["solution_cost"]) == pytest.approx(float(row["cost"]), rel=1e-3)
        assert float(run["clearance"]) == pytest.approx(float(row["clearance_m"]), rel=1e-3)
    got = plan("impossible", "--samples", 50, "--runs", 1, "--exact", "--eta", "0.1,0.5,0", "--output", tmp_path / "i",
               "--ompl-log", log)
    assert got.returncode == 0 and "; 0; " in log.read_text(), "a run without a path has no cost"


def test_planners_are_compared_over_time(tmp_path):
    got = plan("short_move", "--planner", "FMTstar,RRTConnect", "--samples", 50, "--times", "1,2", "--runs", 1,
               "--output", tmp_path / "c")
    assert got.returncode == 0, got.stderr
    table = rows(tmp_path / "c" / "comparison.csv")
    assert [(row["planner"], row["time_s"]) for row in table] == [("FMTstar", "1"), ("FMTstar", "2"),
                                                                  ("RRTConnect", "1"), ("RRTConnect", "2")]
    assert all(float(row["success_percent"]) == 100 for row in table)
    assert not (tmp_path / "c" / "table.csv").exists()


def test_what_has_no_path_is_told_and_no_error(tmp_path):
    got = plan("impossible", "--samples", 50, "--runs", 1, "--exact", "--eta", "0.1,0.5,0", "--output", tmp_path / "i")
    assert got.returncode == 0, got.stderr
    assert "without success: no_path 1" in got.stdout
    [run] = rows(tmp_path / "i" / "runs.csv")
    assert (run["success"], run["reason"], run["cost"], run["path"]) == ("0", "no_path", "", "")
    assert not list((tmp_path / "i" / "paths").iterdir())


def test_a_folder_is_used_once(tmp_path):
    (tmp_path / "runs.csv").write_text("mine\n")
    got = plan("short_move", "--runs", 1, "--output", tmp_path)
    assert got.returncode == 1
    assert "exists already" in got.stderr
    assert (tmp_path / "runs.csv").read_text() == "mine\n"


@pytest.mark.parametrize("arguments,says", [
    (["nowhere"], "known: FILE.yaml, impossible, into_dome, paper"),
    (["missing.yaml"], "missing.yaml:1: cannot be opened"),
    (["paper", "--planner", "FMTstar,Dijkstra"], "--planner"),
    (["paper", "--planner", "BITstar", "--threads", "2"], "--threads is 2, expected 1"),
    (["paper", "--samples", "5"], "--samples"),
    (["paper", "--eta", "0.1"], "--eta"),
    (["paper", "--eta", "0.1,0.5,0.1,0.2"], "--eta"),
    (["paper", "--eta", "0.1,nan"], "--eta: value 2 is nan"),
    (["paper", "--times", "0"], "--times"),
    (["paper", "--runs", "0"], "--runs"),
])
def test_what_makes_no_sense_is_refused(tmp_path, arguments, says):
    got = plan(*arguments, "--output", tmp_path / "none")
    assert got.returncode != 0
    assert says in got.stderr
    assert not (tmp_path / "none").exists()


def test_a_problem_of_ones_own_is_read_strictly(tmp_path):
    with open(os.path.join(ROOT, "config", "problems", "short_move.yaml"), encoding="utf-8") as file:
        text = file.read()
    problem = tmp_path / "mine.yaml"
    problem.write_text(text + "speed: 3\n")
    got = plan(problem, "--output", tmp_path / "none")
    assert got.returncode == 1
    assert f"mine.yaml:{text.count(chr(10)) + 1}: unknown key speed" in got.stderr
    problem.write_text(text)
    got = plan(problem, "--runs", 1, "--samples", 40, "--eta", "0.1,0.5,0", "--output", tmp_path / "good")
    assert got.returncode == 0, got.stderr
