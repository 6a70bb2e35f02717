"""A small campaign has the same outcomes for any number of processes, shards and kills."""

import csv
import hashlib
import json
import os
import re
import subprocess

import pytest
from stack import PROGRAMS, wait_until

CAMPAIGN = """
name: small
title: Small
source: none
plant: identified
homing: quick
arm_contacts: false
cpu_limit: 20
horizon_ticks: {homing: 300, pedal_down: 400}
limits: {masked: 0.0001, jump: 0.001, still: 0.0003, moved: 0.001, force: 0.05}
scenarios:
  - scenario: dac
    injection: 0
    number: 0
    observed: none
    published: []
    phase: pedal_down
    repetitions: 1
    faults:
      - {host: robot, site: put_usb_packet, variable: dac, kind: random, arm: [gold, green], channel: [shoulder, all],
         low: [-30000, -3000], high: 3000, start: {trigger: pedal_down, first_tick: 300}, duration_ticks: [2, 200]}
  - scenario: program
    injection: 0
    number: 0
    observed: none
    published: [crash, hang]
    phase: pedal_down
    repetitions: 2
    faults:
      - {host: robot, site: process, variable: program, kind: [crash, hang],
         start: {trigger: pedal_down, first_tick: 200}, duration_ticks: 0}
  - scenario: power_on
    injection: 0
    number: 0
    observed: none
    published: []
    phase: homing
    repetitions: 2
    faults:
      - {host: robot, site: torque_to_dac, variable: current_cmd, kind: random, arm: both, channel: all, low: -3000,
         high: 3000, start: {trigger: power_on, first_tick: 100}, duration_ticks: 100}
"""
RUNS = 16 + 2 * 2 + 2


def command(folder, output, *arguments, text=CAMPAIGN):
    file = folder / "small.yaml"
    file.write_text(text)
    return [os.path.join(PROGRAMS, "run_campaign"), str(file), "--output", str(folder / output), *map(str, arguments)]


def run(folder, output, *arguments, text=CAMPAIGN):
    done = subprocess.run(command(folder, output, *arguments, text=text), capture_output=True, text=True, timeout=300,
                          check=False)
    return done.returncode, done.stderr


def digest(folder, output):
    return hashlib.sha256((folder / output / "outcomes.csv").read_bytes()).hexdigest()


def merge(folder, *shards, output="merged"):
    done = subprocess.run([os.path.join(PROGRAMS, "merge_campaign"), *(str(folder / s) for s in shards), "--output",
                           str(folder / output)], capture_output=True, text=True, timeout=60, check=False)
    return done.returncode, done.stderr


def children_of(pid):
    with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
        return [int(child) for child in file.read().split()]


def lines_in(path):
    return path.read_bytes().count(b"\n") if path.exists() else 0


@pytest.fixture(name="two", scope="module")
def two_jobs(tmp_path_factory):
    """Folder in which "two" is the campaign with seed 3 and two jobs."""
    folder = tmp_path_factory.mktemp("campaign")
    code, said = run(folder, "two", "--seed", 3, "--jobs", 2)
    assert code == 0 and said.rstrip().endswith("/two/outcomes.csv")
    return folder


def rows_of(folder, output):
    with open(folder / output / "outcomes.csv", encoding="ascii", newline="") as file:
        return list(csv.DictReader(file))


def test_jobs_kills_and_shards_change_nothing(two, tmp_path):
    wanted = digest(two, "two")

    # the campaign is killed after a third of the runs, its children end with it; another number of jobs resumes it
    victim = subprocess.Popen(command(tmp_path, "killed", "--seed", 3, "--jobs", 2), stderr=subprocess.DEVNULL)
    part = tmp_path / "killed" / "outcomes.part"
    wait_until(lambda: lines_in(part) >= RUNS // 3, 120, "a third of the runs")
    children = children_of(victim.pid)
    victim.kill()
    victim.wait()
    wait_until(lambda: not any(is_alive(child) for child in children), 10, "the children's end")
    before = lines_in(part)
    assert RUNS // 3 <= before < RUNS
    code, said = run(tmp_path, "killed", "--seed", 3)
    assert code == 1 and "--resume" in said, "only with the option"
    assert run(tmp_path, "killed", "--seed", 3, "--jobs", 1, "--resume")[0] == 0
    assert digest(tmp_path, "killed") == wanted
    made = json.loads((tmp_path / "killed" / "timing.json").read_text())["runs"]
    assert made == RUNS - before, "finished runs are not repeated"

    # in shards
    for shard in (1, 2, 3):
        assert run(tmp_path, f"shard{shard}", "--seed", 3, "--shard", f"{shard}/3")[0] == 0
    code, said = merge(tmp_path, "shard1", "shard3")
    assert code == 1 and "2 shards of 3" in said
    assert merge(tmp_path, "shard2", "shard3", "shard1")[0] == 0
    assert digest(tmp_path, "merged") == wanted

    # all runs are there, and have the expected outcomes
    rows = rows_of(two, "two")
    assert [int(row["run"]) for row in rows] == list(range(1, RUNS + 1))
    assert all(row["injected_ms"] for row in rows), "every fault acted"
    assert {row["outcome"] for row in rows if row["scenario"] == "program" and row["kind"] == "crash"} == {"crash"}
    assert {row["outcome"] for row in rows if row["scenario"] == "program" and row["kind"] == "hang"} == {"hang"}
    assert len({row["seed"] for row in rows}) == RUNS


def test_an_outcome_that_nobody_expects_fails_what_is_written_all_the_same(tmp_path):
    head, scenarios = CAMPAIGN.split("scenarios:\n")
    program = next(s for s in re.split("^  - ", scenarios, flags=re.M) if s.startswith("scenario: program"))
    text = head + "scenarios:\n  - " + program.replace("[crash, hang]\n    phase", "[masked]\n    phase")
    code, said = run(tmp_path, "a", text=text.replace("repetitions: 2", "repetitions: 1"))
    assert code == 1
    assert "1 runs neither as published nor explained, program/pedal_down: crash: 1" in said
    assert "1 runs neither as published nor explained, program/pedal_down: hang: 2" in said
    assert lines_in(tmp_path / "a" / "outcomes.csv") == 3 and (tmp_path / "a" / "timing.json").exists()
    (tmp_path / "small_explained.yaml").write_text("program/pedal_down: {allowed: [crash, hang], why: injected}\n")
    code, said = run(tmp_path, "a", "--resume", text=text.replace("repetitions: 2", "repetitions: 1"))
    assert code == 0 and "explained" not in said, "an explanation does not change the campaign"


def test_another_seed_gives_other_outcomes(two, tmp_path):
    assert run(tmp_path, "seed4", "--seed", 4, "--shard", "1/4", "--jobs", 2)[0] == 0
    there = rows_of(tmp_path, "seed4")
    runs = {row["run"] for row in there}
    here = [row for row in rows_of(two, "two") if row["run"] in runs]
    assert len(here) == len(there) > 4
    tables = [[{k: v for k, v in row.items() if k not in ("seed", "motion_seed")} for row in rows]
              for rows in (here, there)]
    assert tables[0] != tables[1], "another seed changes motions and faults, not only its columns"


def test_what_cannot_be_run_is_refused_with_its_reason(tmp_path):
    assert run(tmp_path, "a", "--shard", "4/3")[0] == 1
    assert "--shard" in run(tmp_path, "a", "--shard", "x")[1]
    done = subprocess.run([os.path.join(PROGRAMS, "run_campaign"), "no_such_campaign", "--output", str(tmp_path / "b")],
                          capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1 and "no_such_campaign.yaml" in done.stderr
    assert not (tmp_path / "b").exists()


def is_alive(pid):
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
