"""launch/training.launch: what its arguments make of the programs' command lines. Nothing is started."""

import os

import pytest

roslaunch_config = pytest.importorskip("roslaunch.config")

LAUNCH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "launch", "training.launch")


@pytest.fixture(autouse=True)
def fixture_package(monkeypatch):
    """$(find raven2_trainer) is this source tree, whatever else is installed."""
    monkeypatch.setenv("ROS_PACKAGE_PATH", os.path.dirname(os.path.dirname(LAUNCH)))
    monkeypatch.setenv("HOME", "/nowhere")


def options(*arguments):
    """Of each node: {option: value}."""
    loaded = roslaunch_config.load_config_default([(LAUNCH, list(arguments))], None, verbose=False)
    assert not loaded.config_errors
    words = {node.type: node.args.split() for node in loaded.nodes}
    assert set(words) == {"virtual_raven", "master_console", "simulator"}
    return {name: dict(zip(w[::2], w[1::2])) for name, w in words.items()}


def chosen(of):
    return [of["--" + key] for key in ("exercise", "drill", "hazard")]


def test_without_an_exercise_a_hazard_is_armed():
    for of in options().values():
        assert chosen(of) == ["none", "none", "sudden_jump"]


def test_an_exercise_runs_into_none_by_itself_and_all_programs_have_it():
    seen = options("exercise:=peg_transfer", "motion:=expert")
    for of in seen.values():
        assert chosen(of) == ["peg_transfer", "none", "none"]
    assert seen["master_console"]["--motion"] == seen["simulator"]["--motion-label"] == "expert"


def test_what_is_asked_for_counts():
    for of in options("exercise:=peg_transfer", "drill:=own", "hazard:=joint_drift").values():
        assert chosen(of) == ["peg_transfer", "own", "joint_drift"]
