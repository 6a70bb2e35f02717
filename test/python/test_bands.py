"""The packaged bands. The band of each exercise has every metric that the exercise scores. The expert passes with seeds
from which no band was made. A clumsy surgeon fails where its exercise expects it."""
import concurrent.futures
import json
import os
import pathlib
import subprocess

import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIMULATE = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer/simulate"
EXERCISES = {path.stem: yaml.safe_load(path.read_text()) for path in sorted((ROOT / "config/exercises").glob("*.yaml"))}
IS_FULL = os.environ.get("RAVEN2_TRAINER_FULL") == "1"
SEEDS = range(1, 21) if IS_FULL else [1]  # bands are made from seeds 1001 to 1020
RATE = 0.95
SHORT = ["camera_clutch", "retrieve_and_reach"]  # a quarter of a minute each
TRIED = list(EXERCISES) if IS_FULL else SHORT

is_built = pytest.mark.skipif(not SIMULATE.exists(), reason="simulate is not built")


def attempt(folder, exercise, motion, seed):
    """Returns the scored first attempt of a session."""
    output = folder / f"{exercise}_{motion.replace(':', '_')}_{seed}"
    done = subprocess.run([SIMULATE, "--exercise", exercise, "--drill", "none", "--motion", motion, "--seed", str(seed),
                           "--homing", "quick", "--output", output], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    score = json.loads((output / "score.json").read_text())
    (output / "session.rlog").unlink()  # 0.7 MB a second
    return score["attempts"][0]


def failed(scored):
    """Metrics that did not pass."""
    return {name for name, metric in scored["metrics"].items() if metric["passed"] is False}


@pytest.mark.parametrize("exercise", EXERCISES)
def test_every_scored_metric_has_its_place_in_the_band(exercise):
    band = yaml.safe_load((ROOT / f"config/bands/{exercise}.yaml").read_text())
    assert "not surgeons" in band["origin"], "a reader of a score must know who the expert was"
    assert band["sessions"] >= 19, "of 20 seeds"
    assert set(EXERCISES[exercise]["metrics"]) <= set(band["metrics"])


@is_built
@pytest.mark.parametrize("exercise", TRIED)
def test_the_expert_passes(exercise, tmp_path):
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        tried = list(pool.map(lambda seed: attempt(tmp_path, exercise, "expert", seed), SEEDS))
    passed = [one["passed"] for one in tried].count(True)
    print(f"{exercise}: {passed} of {len(tried)} passed; failed: {[sorted(failed(one)) for one in tried if failed(one)]}")
    assert passed >= RATE * len(tried)


# Metric of the score for each mistake that an exercise expects of a clumsy surgeon.
METRIC_OF = {"drop": "drops", "wire_touch": "wire_touches", "collision": "collisions", "out_of_order": "out_of_order",
             "wrong_arm": "wrong_arm", "break_off": "break_offs"}


@is_built
@pytest.mark.parametrize("exercise", TRIED)
def test_clumsy_hands_fail_for_the_right_reason(exercise, tmp_path):
    for name, hand in EXERCISES[exercise]["clumsy"].items():
        (kind, what), = hand["expect"].items()
        scored = attempt(tmp_path, exercise, f"clumsy:{name}", 1)
        assert scored["passed"] is False, name
        if kind == "fail":
            assert (scored["status"], scored["failure"]) == ("failed", what), name
        elif scored["failure"] == "time_limit" and what == "time":
            continue  # the attempt ended at the time limit: no longer time is possible
        else:
            assert (METRIC_OF[what] if kind == "mistake" else what) in failed(scored), name
