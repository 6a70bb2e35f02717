"""Two simulated trainees in the same drill. One releases the pedal 400 ms after the force, the other continues."""
import csv
import json
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "test/python")]
import raven2_lockstep  # noqa: E402
import raven2_session  # noqa: E402
from own_exercise import exercise  # noqa: E402

PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"

pytestmark = pytest.mark.skipif(not (PROGRAMS / "simulate").exists(), reason="simulate is not built")

# The second step ends after the drill, so that the drill occurs during the attempt.
STEPS = [("come", "gold", 0.5), ("stay", "green", 6.0)]
EXERCISE = exercise("stroke", STEPS, "{time: {}}", "{scenario: sudden_jump, at: {step: 2, delay: 0.3, jitter: 0.5}, "
                    "right: [pedal_up], wrong: [push_on], within: 2.0}")
BARE = exercise("bare", STEPS, "{time: {}}")
AGREEMENT = 5  # [ms] of a measured time with the truth
# (exercise, motion, [s] after which the drill has been answered or ignored)
CASES = [("stroke", "scripted", 6.5)]


def simulate(school, name, *options, seed=3):
    output = school / "sessions" / name
    return output, subprocess.run(
        [PROGRAMS / "simulate", "--config", school / "config/trainer.yaml", "--homing", "quick", "--seed", str(seed),
         "--output", output, *map(str, options)], capture_output=True, text=True, check=False)


@pytest.fixture(scope="module", name="school")
def make_school(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drills")
    raven2_lockstep.copy_of_configuration(folder)
    (folder / "config/exercises/stroke.yaml").write_text(EXERCISE)
    (folder / "config/exercises/bare.yaml").write_text(BARE)
    return folder


class Trainee:
    """A recorded drill: its only hazard in score.json, and the first time of each event of the surgeon."""

    def __init__(self, school, case, reaction):
        exercise, motion, seconds = case
        truth = school / f"{exercise}_{reaction}.csv"
        self.directory, done = simulate(school, f"{exercise}_{reaction}", "--exercise", exercise, "--drill", "own",
                                        "--motion", motion, "--reaction", reaction, "--truth", truth,
                                        "--seconds", seconds)
        assert done.returncode == 0, done.stderr
        with truth.open(encoding="ascii") as file:
            self.events = {row["what"]: int(row["sequence"]) for row in reversed(list(csv.DictReader(file)))}
        self.score = json.loads((self.directory / "score.json").read_text())
        (self.hazard,) = self.score["hazards"]
        self.log = raven2_session.Session(self.directory).log


@pytest.fixture(scope="module", name="both", params=CASES, ids=[case[1] for case in CASES])
def make_both(school, request):
    return Trainee(school, request.param, 400), Trainee(school, request.param, "none")


def session_tick(log, sequence):
    """Session tick that consumed the packet with this sequence number."""
    (command,) = log.commands[log.commands["command"]["sequence"] == sequence]
    model = log.ticks["model"]
    return int(model["session_tick"][np.searchsorted(model["tick"], command["tick"])])


def test_who_lets_go_is_right_and_who_goes_on_is_not(both):
    reacting, ignoring = (trainee.hazard for trainee in both)
    assert reacting["verdict"] == "right"
    assert ignoring["verdict"] != "right"
    assert reacting["injection_tick"] == ignoring["injection_tick"], "the same seed, the same drill"


def test_the_reaction_time_is_the_truth(both):
    reacting, _ = both
    hazard = reacting.hazard
    injection = hazard["injection_tick"]
    assert hazard["reaction"]["response"] == "pedal_up"
    let_go = session_tick(reacting.log, reacting.events["pedal_up"])
    assert abs(injection + hazard["reaction"]["after_ms"] - let_go) <= AGREEMENT
    felt = session_tick(reacting.log, reacting.events["felt"])
    assert abs(injection + hazard["cue_after_ms"] - felt) <= AGREEMENT
    assert abs(hazard["reaction"]["after_ms"] - hazard["cue_after_ms"] - 400) <= AGREEMENT


def test_the_drill_is_in_score_log_and_ground_truth(both):
    for trainee in both:
        score, injection_tick = trainee.score, trainee.hazard["injection_tick"]
        assert score["drill"] == trainee.log.training["drill"] == "sudden_jump", "`own` is replaced by the scenario"
        assert score["response_rule"] == {"right": ["pedal_up"], "wrong": ["push_on"], "within_s": 2.0}
        (attempt,) = score["attempts"]
        assert [hazard["injection_tick"] for hazard in attempt["hazards"]] == [injection_tick]
        (injection,) = json.loads((trainee.directory / "faults.json").read_text())["injections"]
        assert injection["name"] == "sudden_jump"
        assert 0 <= injection["inject"]["tick"] - injection_tick <= 3, "the daemon learns of it a little later"


@pytest.mark.parametrize("exercise_, seed", [("pick_hand_over_place", 2), ("retrieve_and_reach", 4)])
def test_who_answers_rightly_passes(school, exercise_, seed):
    """The expert has no time to spare. The time of an answer, 3 s, or 12 s while the robot receives no packets,
    must not count."""
    directory, done = simulate(school, f"fair_{exercise_}", "--exercise", exercise_, "--drill", "own", "--motion", "expert",
                               "--reaction", "400", seed=seed)
    assert done.returncode == 0, done.stderr
    (attempt,) = json.loads((directory / "score.json").read_text())["attempts"]
    (hazard,) = attempt["hazards"]
    assert hazard["verdict"] == "right" and hazard["answer_time_ms"] > 3000
    ticks = attempt["last_tick"] - attempt["first_tick"] + 1
    assert attempt["metrics"]["time"]["value"] == pytest.approx((ticks - hazard["answer_time_ms"]) / 1000, abs=1e-6)
    assert attempt["passed"], {name: metric for name, metric in attempt["metrics"].items() if metric["passed"] is False}


@pytest.mark.parametrize("options, words", [
    (("--exercise", "bare", "--drill", "own"), "bare.yaml has no key drill"),
    (("--exercise", "bare", "--drill", "sudden_jump"), "bare.yaml has no key drill"),
    (("--exercise", "stroke", "--drill", "no_such"), 'no hazard is called "no_such"'),
    (("--drill", "own"), "there is no exercise that could run into it"),
])
def test_a_drill_that_cannot_be_is_refused(school, options, words):
    output, done = simulate(school, "refused", *options)
    assert done.returncode != 0 and words in done.stderr, done.stderr
    assert not output.exists()


@pytest.fixture(scope="module", name="measured")
def make_measured(tmp_path_factory):
    """Five seeds of the expert in a drill, without a reaction, and with a release of the pedal after 400 ms."""
    table = tmp_path_factory.mktemp("measured") / "drills.csv"
    command = [ROOT / "scripts/measure_drills", "camera_clutch", "--seeds", "1-5", "--reactions", "none,400", "--seconds", "9",
               "--jobs", "1", "--output", table]
    return table, command, subprocess.run(command, capture_output=True, text=True, check=False)


def test_drills_are_judged_as_promised(measured):
    table, _, done = measured
    assert done.returncode == 0, done.stdout + done.stderr
    with table.open(encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 10 and sum(row["cue"] == "force" for row in rows) >= 6
    assert "cue: force: right within" in done.stdout and "answer: right within" in done.stdout and "NOT KEPT" not in done.stdout


def test_a_measurement_that_was_interrupted_goes_on_where_it_was(measured):
    table, command, done = measured
    whole = table.read_text(encoding="ascii")
    lines = whole.splitlines(keepends=True)
    table.write_text("".join(lines[:-1]) + lines[-1][:20], encoding="ascii")  # killed while it wrote the last row
    again = subprocess.run(command, capture_output=True, text=True, check=False)
    assert again.stdout == done.stdout and again.stderr.count("camera_clutch") == 1
    assert table.read_text(encoding="ascii") == whole


def test_a_promise_that_is_not_kept_fails(measured, tmp_path):
    table, command, _ = measured
    broken = tmp_path / "drills.csv"
    text = table.read_text(encoding="ascii")
    broken.write_text(text.replace("wrong,force", "right,force").replace("none,force", "right,force"), encoding="ascii")
    done = subprocess.run([*command[:-1], broken], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "reaction none" in done.stdout and "NOT KEPT" in done.stdout
