"""scripts/make_expert_band makes one band from the score.json of several sessions."""
import json
import math
import pathlib
import subprocess
import sys

import pytest

yaml = pytest.importorskip("yaml")

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "make_expert_band"


def metric(value, unit="s", better="lower"):
    return {"value": value, "unit": unit, "better": better}


def session(folder, name, *attempts, exercise="peg_transfer", hazards=()):
    """A session whose attempts are (status, metrics)."""
    directory = folder / name
    directory.mkdir()
    score = {"version": 1, "exercise": exercise, "hazards": list(hazards),
             "attempts": [{"status": status, "metrics": metrics} for status, metrics in attempts]}
    (directory / "score.json").write_text(json.dumps(score))
    return str(directory)


def run(*arguments):
    return subprocess.run([sys.executable, str(SCRIPT), *arguments, "--origin", "three made-up hands"],
                          capture_output=True, text=True, check=False)


def three(folder):
    metrics = [{"time": metric(t), "sparc": metric(s, "-", "higher"), "drops": metric(0, "count"),
                "clutches": metric(c, "count"), "bimanual": metric(None, "-", "higher")}
               for t, s, c in [(50.0, -5.0, 2), (53.0, -6.0, 3), (59.0, -7.0, 4)]]
    failed = ("failed", {"time": metric(500.0)})
    return [session(folder, str(i), failed, ("done", own)) for i, own in enumerate(metrics)]


def test_means_and_sample_deviations_of_the_attempts_that_were_done(tmp_path):
    done = run(*three(tmp_path))
    assert done.returncode == 0, done.stderr
    band = yaml.safe_load(done.stdout)
    assert band["origin"] == "three made-up hands"
    assert band["sessions"] == 3
    assert band["least_spread"] == 0.25
    assert band["metrics"]["time"] == {"mean": 54.0, "deviation": pytest.approx(21 ** 0.5, rel=1e-5), "better": "lower",
                                       "least": 0.5}
    assert band["metrics"]["sparc"] == {"mean": -6.0, "deviation": 1.0, "better": "higher", "least": 0.0}
    assert band["metrics"]["drops"] == {"mean": 0, "deviation": 0, "better": "lower", "least": 0}
    assert band["metrics"]["clutches"]["least"] == 1


def test_a_band_that_cannot_be_written_leaves_the_old_one(tmp_path):
    folders, bands = three(tmp_path), tmp_path / "bands"
    bands.mkdir()
    (bands / "peg_transfer.yaml").write_text("the old one")
    (bands / "peg_transfer.yaml.part").mkdir()  # blocks the new band
    assert run(*folders, "--output", str(bands)).returncode != 0
    assert (bands / "peg_transfer.yaml").read_text() == "the old one"


@pytest.mark.parametrize("name, unit, least", [
    ("path", "mm", 1.0), ("time", "s", 0.5), ("peak_force", "N", 0.5), ("collisions", "count", 1.0),
    ("tremor", "um", 5.0), ("drops", "count", 0.0), ("break_offs", "count", 0.0), ("idle", "-", 0.0),
    ("mean_jerk", "m/s^3", 0.0), ("force_impulse", "Ns", 0.0)])
def test_each_unit_is_granted_its_least_spread(tmp_path, name, unit, least):
    """One count, half a second, half a newton, a millimetre; the tremor of eye surgeons, 49 um, at a scale of 0.1."""
    folders = [session(tmp_path, str(i), ("done", {name: {**metric(value, unit), "scored": True}}))
               for i, value in enumerate([3.0, 5.0])]
    (found,) = yaml.safe_load(run(*folders).stdout)["metrics"].items()
    assert found == (name, {"mean": 4.0, "deviation": pytest.approx(2.0 ** 0.5, rel=1e-5), "better": "lower",
                            "least": least})


def test_a_logarithm_is_granted_a_factor_of_two(tmp_path):
    folders = [session(tmp_path, str(i), ("done", {"ldlj": {**metric(value, "-", "higher"), "scored": True}}))
               for i, value in enumerate([-24.0, -24.2])]
    assert yaml.safe_load(run(*folders).stdout)["metrics"]["ldlj"]["least"] == pytest.approx(math.log(4.0), rel=1e-5)


def test_a_metric_that_is_not_in_every_attempt_is_left_out_and_named(tmp_path):
    done = run(*three(tmp_path))
    assert "bimanual" not in yaml.safe_load(done.stdout)["metrics"]
    assert "bimanual was not measured" in done.stderr


def test_a_chosen_list_and_a_folder(tmp_path):
    folders = three(tmp_path)
    done = run(*folders, "--metrics", "time", "--least-spread", "0.1", "--output", str(tmp_path / "new"))
    assert done.returncode == 0, done.stderr
    band = yaml.safe_load((tmp_path / "new/peg_transfer.yaml").read_text())
    assert list(band["metrics"]) == ["time"]
    assert not list((tmp_path / "new").glob("*.part"))
    assert band["least_spread"] == 0.1


def test_metrics_are_those_that_the_exercise_scores(tmp_path):
    folders = []
    for i, value in enumerate([3.0, 5.0]):
        metrics = {"time": metric(value), "path": {**metric(value, "mm"), "scored": True},
                   "tremor": {**metric(value, "um"), "scored": True}, "idle": {**metric(value, "-"), "scored": False}}
        folders.append(session(tmp_path, str(i), ("done", metrics)))
    assert list(yaml.safe_load(run(*folders).stdout)["metrics"]) == ["path", "tremor"]


@pytest.mark.parametrize("second, reason", [
    ({"exercise": "camera_clutch"}, "one exercise"), ({"hazards": [{"scenario": "sudden_jump"}]}, "hazard")])
def test_sessions_that_do_not_belong_together_are_refused(tmp_path, second, reason):
    good = ("done", {"time": metric(1.0)})
    done = run(session(tmp_path, "a", good), session(tmp_path, "b", good, **second))
    assert done.returncode == 1
    assert reason in done.stderr


def test_one_session_or_none_with_a_score_is_refused(tmp_path):
    assert "needs two" in run(session(tmp_path, "a", ("done", {"time": metric(1.0)}))).stderr
    done = run(str(tmp_path))
    assert done.returncode == 1
    assert "score.json" in done.stderr
