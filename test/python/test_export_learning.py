"""export_session --format hdf5 and lerobot, and make_dataset: read with h5py and pandas and compared with the logs."""
import concurrent.futures
import contextlib
import importlib.machinery
import json
import os
import pathlib
import subprocess
import sys
import time
import types

import h5py
import numpy as np
import pandas
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import raven2_session  # noqa: E402
import raven2_exports  # noqa: E402
import published  # noqa: E402
from raven2_exports import dataset, episode, hdf5  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"
pytestmark = pytest.mark.skipif(not (PROGRAMS / "export_session").exists(), reason="export_session is not built")
FPS = 30
# Axes of B in W, as columns (core/frames.h), and rcm_W of config/arms.yaml: gold, green.
R_WB = (np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]]), np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]))
P_WB = (np.array([-0.03, 0.0643, 0.14]), np.array([-0.03, -0.0643, 0.14]))


def simulate(output, seconds, hazard, *options):
    subprocess.run([PROGRAMS / "simulate", "--hazard", hazard, "--seconds", str(seconds), "--homing", "quick", "--output", output, *options],
                   check=True, capture_output=True)
    return output


def export(*words, program=PROGRAMS / "export_session"):
    return subprocess.run(list(map(str, (program, *words))), capture_output=True, text=True, check=False,
                          env={key: value for key, value in os.environ.items() if key != "VIRTUAL_ENV"})


@pytest.fixture(scope="module", name="sessions")
def three_sessions(tmp_path_factory):
    """Without a hazard; one that ends in a hazard's aftermath; one that goes on after it."""
    folder = tmp_path_factory.mktemp("sessions")
    return {"nominal": simulate(folder / "c", 3, "none"), "failure": simulate(folder / "a", 8.6, "sudden_jump"),
            "recovery": simulate(folder / "b", 9.5, "sudden_jump")}


@pytest.fixture(scope="module", name="data")
def exported(sessions, tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "set.hdf5"
    done = export(sessions["recovery"], sessions["nominal"], sessions["failure"], "--format", "hdf5", "--cameras", "endoscope",
                  "--size", "64x64", "--output", path)
    assert done.returncode == 0, done.stderr
    assert "3 episodes (1 nominal, 1 failure, 1 recovery)" in done.stderr and not path.with_name("set.hdf5.parts").exists()
    with h5py.File(path) as file:
        yield file["data"], {split: [name.decode() for name in names] for split, names in file["mask"].items()}


def ticks_of(session):
    model = raven2_session.Session(session).log.ticks["model"]
    return model[model["session_tick"] >= 0]


def test_frames_come_at_the_rate_that_is_asked_for(sessions, tmp_path):
    done = export(sessions["nominal"], "--format", "hdf5", "--fps", "10", "--output", tmp_path / "set.hdf5")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "set.hdf5") as file:
        assert file["data"].attrs["fps"] == 10 and file["data/demo_0"].attrs["num_samples"] == 30  # of 3 s


def test_each_split_has_its_session(data):
    demos, masks = data
    assert masks == {"nominal": ["demo_0"], "failure": ["demo_1"], "recovery": ["demo_2"]}
    assert [demos[f"demo_{i}"].attrs["session"] for i in range(3)] == ["c", "a", "b"]
    lengths = [demos[f"demo_{i}"].attrs["num_samples"] for i in range(3)]
    assert lengths == [90, 258, 285] and demos.attrs["total"] == sum(lengths)
    frames = pandas.DataFrame(demos["demo_1/commands"][:], columns=json.loads(demos["demo_1/commands"].attrs["names"]))
    assert len(frames) == 258 and "green_turn_z" in frames and np.isfinite(frames.to_numpy()).all()


def test_the_file_is_as_robomimic_describes_it(data):
    wanted, kinds = published.FORMATS["robomimic"], {"float": "f", "int": "i"}
    assert published.problems(plain(data[0].attrs), wanted["data"]) == []
    assert published.problems(json.loads(data[0].attrs["env_args"]), wanted["env_args"]) == []
    for demo in data[0].values():
        assert published.problems(plain(demo.attrs), wanted["demo"]) == []
        for name, (kind, *axes) in wanted["datasets"].items():
            shape = tuple({"N": demo.attrs["num_samples"], "A": 14}.get(axis, axis) for axis in axes)
            assert (demo[name].dtype.kind, demo[name].shape) == (kinds[kind], shape), name
        assert all(stored.shape[0] == demo.attrs["num_samples"] for stored in demo["obs"].values())
        assert demo["obs/endoscope_image"].dtype == np.uint8 and np.abs(demo["actions"][:]).max() <= 1
        assert set(demo["next_obs"]) == set(demo["obs"])
        for name, stored in demo["obs"].items():
            assert np.array_equal(demo[f"next_obs/{name}"][:], np.concatenate([stored[1:], stored[-1:]])), name


def plain(attributes):
    """As JSON would have them."""
    return {name: value.item() if isinstance(value, np.generic) else value for name, value in attributes.items()}


@pytest.mark.parametrize("value, lines", [
    ({"a": 1, "b": ["x"]}, []), ({"a": True, "b": []}, [".a: True is not int"]), ({"b": []}, [".a is missing"]),
    ({"a": 1, "b": ["x", 2]}, [".b[1]: 2 is not str"]), ({"a": 1, "b": [], "d": 0}, [".d is unknown"]), ([], [": [] is no dictionary"]),
    ({"a": 1, "b": "x"}, [".b: 'x' is no list"]), ({"a": 1, "b": [], "c": "z"}, [".c: 'z' is not = y | null"])])
def test_a_file_that_is_not_as_published_is_noticed(value, lines):
    assert published.problems(value, {"a": "int", "b": ["str"], "c?": "= y | null"}) == lines


def test_actions_are_commands_on_a_scale_that_policies_have(data):
    largest = np.zeros(14)
    for demo in data[0].values():
        actions = demo["actions"]
        np.testing.assert_allclose(actions[:] * actions.attrs["scale"], demo["commands"][:], atol=1e-7)
        largest = np.maximum(largest, np.abs(actions[:]).max(0))
    moved = np.any([demo["commands"][:].any(0) for demo in data[0].values()], axis=0)
    assert moved[[0, 1, 2]].all() and largest == pytest.approx(moved.astype(float))


def test_the_states_are_those_of_the_frames_ticks(data, sessions):
    demo, ticks = data[0]["demo_0"], ticks_of(sessions["nominal"])
    for frame in (0, 1, 40, 89):
        newest = ticks[ticks["session_tick"] <= frame * 1000 / FPS + 1e-6][-1]
        state = demo["obs/model_state"][frame]
        np.testing.assert_allclose(state[:14], newest["arms"]["q"].ravel(), atol=1e-6)
        for arm in (0, 1):
            np.testing.assert_allclose(state[14 + 3 * arm:17 + 3 * arm], newest["arms"]["p_BT"][arm] @ R_WB[arm].T + P_WB[arm], atol=1e-6)


def test_the_forces_are_the_newest_of_the_frames_ticks(data, sessions):
    demo, ticks = data[0]["demo_2"], ticks_of(sessions["recovery"])
    haptic = raven2_session.Session(sessions["recovery"]).log.haptic["haptic"]
    shown = [ticks["tick"][ticks["session_tick"] <= frame * 1000 / FPS + 1e-6][-1] for frame in range(demo.attrs["num_samples"])]
    newest = np.array([haptic["force_B"][haptic["tick"] <= tick][-1] for tick in shown])
    expected = np.concatenate([newest[:, arm] @ R_WB[arm].T for arm in (0, 1)], axis=1)
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(demo["obs/force"][:], expected, atol=1e-6)


def episode_with(faults, attempts=()):
    """An episode of which only this is known."""
    made = object.__new__(episode.Episode)
    made.directory, made._faults = "", faults
    made._session = types.SimpleNamespace(metrics={"exercise": {"attempts": list(attempts)}})
    return made


def test_turns_are_of_the_commands_behind_the_first_tick_up_to_the_last():
    commands = np.zeros(10, [("tick", int), ("command", [("dq_I", float, (2, 4))])])
    commands["tick"], commands["command"]["dq_I"] = np.arange(10), [np.sin(0.005), 0, 0, np.cos(0.005)]
    made = episode_with([])
    made.length, made._session.log = 2, types.SimpleNamespace(commands=commands)
    turns = made._turns(np.array([0, 5]), np.array([5, 9]))
    assert turns[:, 0, 0] == pytest.approx([0.05, 0.04]) and turns[:, 1] == pytest.approx(turns[:, 0])


def test_the_motion_of_a_crtk_client_is_no_action_of_the_surgeon():
    commands = np.zeros(10, [("tick", int), ("command", [("pedal", np.uint8), ("dq_I", float, (2, 4))])])
    commands["tick"], commands["command"]["pedal"] = np.arange(10), 5 * [1] + 5 * [2]
    commands["command"]["dq_I"] = [np.sin(0.005), 0, 0, np.cos(0.005)]
    made = episode_with([])
    made.length, made._session.log = 2, types.SimpleNamespace(commands=commands)
    turns = made._turns(np.array([0, 5]), np.array([5, 9]))
    assert turns[:, 0, 0] == pytest.approx([0.04, 0.0]) and turns[:, 1] == pytest.approx(turns[:, 0])


def test_without_metrics_the_hazards_of_a_session_are_unknown(sessions, tmp_path):
    """A session that was killed lacks them, and its hazards are unknown."""
    for name in os.listdir(sessions["failure"]):
        if name != "metrics.json":
            (tmp_path / name).symlink_to(sessions["failure"] / name)
    with pytest.raises(raven2_session.SessionError, match="recover_session"):
        episode.Episode(tmp_path, FPS)


def test_numbers_that_are_none_make_no_part(monkeypatch, tmp_path):
    made = types.SimpleNamespace(columns={"action": np.array([[0.0], [np.nan]])}, length=2, task="", objects=[], summary={})
    monkeypatch.setattr(dataset.episode, "Episode", lambda *_: made)
    assert dataset.make_part("here", tmp_path / "part", FPS, dataset.Pictures((), (64, 64), "")) == "here: NaN or infinity in action"
    assert not (tmp_path / "part").exists()


def test_without_a_robot_the_state_is_the_models(tmp_path):
    sys.path.insert(0, str(PROGRAMS.parent / "python3/dist-packages"))
    import raven2_trainer

    with raven2_trainer.Simulation(motion="scripted", robot="none", output=tmp_path / "session") as simulation:
        while simulation.state.session_tick < 300:
            simulation.step(ticks=10)
    columns = episode.Episode(tmp_path / "session", FPS).columns
    assert np.array_equal(columns["observation.state"], columns["observation.model_state"]) and columns["truth.error"].max() == 0


def test_work_went_on_only_after_each_of_the_hazards():
    assert episode_with([])._split() == "nominal"
    over, lasting = {"end_tick": 5}, {"end_tick": None}
    assert [episode_with(faults)._split() for faults in ([over, over], [over, lasting], [lasting, over])] == ["recovery", "failure", "failure"]
    assert [episode_with([over], [{"status": status}])._split() for status in ("done", "failed")] == ["recovery", "failure"]


@pytest.mark.parametrize("statuses, split", [(("failed", "done"), "recovery"), (("done", "failed"), "failure"), (("done", "running"), "failure")])
def test_of_several_attempts_the_last_one_counts(statuses, split):
    made = episode_with([{"end_tick": 5}], [{"status": status} for status in statuses])
    assert (made._is_done(), made._split()) == (split == "recovery", split)


def test_a_kept_part_is_of_the_same_options_and_the_same_score(tmp_path):
    options = [(30, (), (64, 64)), (15, (), (64, 64)), (30, ("top",), (64, 64)), (30, (), (64, 128))]
    key = lambda fps, cameras, size: dataset._key(tmp_path, fps, dataset.Pictures(cameras, size, ""))  # noqa: E731
    keys = [key(*each) for each in options]
    assert [key(*each) for each in options] == keys
    (tmp_path / "score.json").write_text("{}")
    assert len({*keys, key(*options[0])}) == 5


def test_each_of_two_hazards_of_a_kind_has_its_own_response(monkeypatch):
    judged = [{"scenario": "sudden_jump", "injection_tick": tick, "reaction": {"after_ms": after, "response": "stop"}}
              for tick, after in ((1000, 200), (1600, 100), (9000, 300))]
    monkeypatch.setattr(episode.facts, "load_score", lambda _: ({"hazards": judged}, None))
    for first, reaction in ((1001, 1200), (1601, 1700), (9001, 9300)):
        fault = {"name": "sudden_jump", "first_tick": first, "last_tick": first + 50}
        assert episode_with([fault])._response(fault, first + 500) == (reaction, "stop")


def test_a_clutch_that_the_score_does_not_take_for_an_answer_is_none(monkeypatch):
    fault = {"name": "sudden_jump", "first_tick": 100, "last_tick": 200}
    made = episode_of_ticks(np.arange(1000), pedal=np.where(np.arange(1000) < 300, 1, 0))
    for judged, response in (([], (300, "pedal_up")), ([{"scenario": "sudden_jump", "injection_tick": 100, "reaction": None}], None)):
        monkeypatch.setattr(episode.facts, "load_score", lambda _, hazards=judged: ({"hazards": hazards}, None))
        assert made._response(fault, 900) == response


def episode_of_ticks(times, faults=(), pedal=1, linked=1, fresh=1):
    """An episode of these session ticks [ms]. The tips of model and robot are 3 mm (gold) and 4 mm (green) apart."""
    arms = [("arms", [("p_BT", float, 3)], 2)]
    ticks = np.zeros(len(times), [("model", [("session_tick", int), ("pedal", int), ("linked", int), ("robot_fresh", int), *arms]),
                                  ("robot", arms)])
    model = ticks["model"]
    model["session_tick"], model["pedal"], model["linked"], model["robot_fresh"] = times, pedal, linked, fresh
    ticks["robot"]["arms"]["p_BT"][:, :, 1] = [0.003, 0.004]
    made = episode_with(list(faults))
    made.fps, made._ticks, made._times = 100, ticks, model["session_tick"]
    made._frames = made._frame_ticks()
    made.length = len(made._frames)
    made._force = np.zeros((made.length, 2, 3))
    return made


@pytest.mark.parametrize("linked, fresh", [(1, 0), (0, 1), (0, 0)])
def test_without_a_common_pose_there_is_no_error(linked, fresh):
    """A robot that is not heard any more keeps its last pose in the log."""
    times = np.arange(100)
    apart = (times >= 35) & (times < 65)
    error = episode_of_ticks(times, linked=np.where(apart, linked, 1), fresh=np.where(apart, fresh, 1))._truth()["truth.error"]
    assert (error[[0, 1, 2, 3, 7, 8, 9]] == [0.003, 0.004]).all() and (error[[4, 5, 6]] == 0).all()


FAULT = {"name": "sudden_jump", "first_tick": 205, "last_tick": 255, "end_tick": 505}


def responses(fault, pedal, monkeypatch, score):
    monkeypatch.setattr(episode.facts, "load_score", lambda _: (score, None))
    return episode_of_ticks(np.arange(1000), [fault], pedal)._truth()["truth.response"]


def test_a_response_of_the_score_is_there_from_its_time_behind_the_injection(monkeypatch):
    """doc/scores.md: `after_ms` is from the injection, not from the cue or the first tick that the daemon knew of."""
    judged = {"scenario": "sudden_jump", "injection_tick": 200, "force_after_ms": 40, "cue_after_ms": 70,
              "reaction": {"response": "hold_still", "after_ms": 250}}
    found = responses(FAULT, 1, monkeypatch, {"hazards": [judged]})
    assert found == 45 * ["none"] + 6 * ["hold_still"] + 49 * ["none"]


@pytest.mark.parametrize("ups, first", [([(100, 200), (300, 400)], 30), ([(150, 700)], 21), ([(100, 200), (600, 700)], None)])
def test_without_a_score_the_response_is_the_first_pedal_up_between_the_hazards_begin_and_end(ups, first, monkeypatch):
    times = np.arange(1000)
    pedal = 1 - sum(((times >= a) & (times < b)).astype(int) for a, b in ups)
    found = responses(FAULT, pedal, monkeypatch, {})
    assert [i for i, response in enumerate(found) if response == "pedal_up"] == ([] if first is None else list(range(first, 51)))
    assert set(found) <= {"none", "pedal_up"}


def test_frames_in_a_gap_of_the_log_are_the_newest_tick_before_it():
    """Records that were lost leave a gap. Its frames keep their times, and nothing is made up between its ends."""
    times = np.append(np.arange(35), np.arange(78, 100))
    made = episode_of_ticks(times)
    assert times[made._frames].tolist() == [0, 10, 20, 30, 34, 34, 34, 34, 80, 90]


def test_frames_before_the_first_tick_of_the_log_are_that_tick():
    """The pedal-down itself may be in a gap."""
    times = np.arange(35, 100)
    made = episode_of_ticks(times)
    assert times[made._frames].tolist() == [35, 35, 35, 35, 40, 50, 60, 70, 80, 90]


def test_a_turn_is_the_same_by_the_quaternion_of_the_other_sign():
    q = np.array([[0.0, 0.6, 0.0, 0.8], [0.1, 0.0, 0.0, np.sqrt(0.99)]])
    turn = episode._rotation_vector(q)
    assert np.linalg.norm(turn) < np.pi and episode._rotation_vector(q[:1]) == pytest.approx([0, 2 * np.arctan2(0.6, 0.8), 0])
    assert episode._rotation_vector(q * [[-1], [1]]) == pytest.approx(turn)


def test_the_labels_are_the_truth_of_the_log(data, sessions):
    for number, split in ((1, "failure"), (2, "recovery")):
        demo, fault = data[0][f"demo_{number}"], raven2_session.Session(sessions[split]).metrics["faults"][0]
        at = np.floor(np.arange(demo.attrs["num_samples"]) * 1000 / FPS + 1e-6)
        acts = (at >= fault["first_tick"]) & (at <= fault["last_tick"])
        end = fault["end_tick"] if fault["end_tick"] is not None else at[-1]
        phase, hazard = demo["truth/phase"].asstr()[:], demo["truth/hazard"].asstr()[:]
        assert acts.sum() > 5 and set(phase[acts]) == {"failure"} and set(hazard[acts]) == {"sudden_jump"}
        assert set(phase[(at > fault["last_tick"]) & (at <= end)]) == {"recovery"}
        assert set(phase[at < fault["first_tick"]]) == {"nominal"} and set(hazard[~acts]) == {"none"}
        assert demo["truth/error"][:].max() == pytest.approx(fault["max_error_mm"] / 1000, rel=0.05)
        assert demo["truth/error"][:][at < fault["first_tick"]].max() < 0.001
        assert 0.8 * fault["max_force_N"] < demo["truth/cue"][:].max() <= fault["max_force_N"] + 1e-6
    assert all(data[0][f"demo_{i}/rewards"][:].sum() == 0 for i in range(3))  # without an exercise nothing is done
    assert set(data[0]["demo_0/truth/phase"].asstr()[:]) == {"nominal"} and data[0]["demo_0/truth/cue"][:].max() == 0


def test_the_actions_move_a_simulation_along_the_same_path(data):
    sys.path.insert(0, str(PROGRAMS.parent / "python3/dist-packages"))
    import raven2_trainer

    demo = data[0]["demo_0"]
    starts = np.floor(np.arange(91) * 1000 / FPS + 1e-6).astype(int)
    with raven2_trainer.Simulation(robot="none") as simulation:
        simulation.start()
        simulation.step(ticks=1)
        begin = simulation.state.tips.copy()
        for frame in range(89):
            action = demo["commands"][frame].reshape(2, 7).astype(float)
            simulation.step(action, ticks=int(starts[frame + 1] - starts[frame]))
        end = np.concatenate([R_WB[arm] @ (simulation.state.tips - begin)[arm] for arm in (0, 1)])
    wanted = demo["obs/model_state"][89, 14:] - demo["obs/model_state"][0, 14:]
    assert np.abs(wanted).max() > 0.01
    np.testing.assert_allclose(end, wanted, atol=1e-4)


def assert_the_tool_turns_as_recorded(demo, frames):
    """Plays the actions of the expert, who rotates the gold tool on the way to the ring."""
    sys.path.insert(0, str(PROGRAMS.parent / "python3/dist-packages"))
    import raven2_trainer

    starts = np.floor(np.arange(frames + 1) * 1000 / FPS + 1e-6).astype(int)
    joints = demo["obs/model_state"][:, :14]
    with raven2_trainer.Simulation("pick_hand_over_place", robot="none") as simulation:
        simulation.start()
        simulation.step(ticks=1)
        for frame in range(frames):
            simulation.step(demo["commands"][frame].reshape(2, 7).astype(float), ticks=int(starts[frame + 1] - starts[frame]))
        reached = simulation.state.joints.reshape(14).copy()
    moved = np.abs(joints[frames] - joints[0])
    assert moved[3:7].max() > 0.2, "roll, wrist and jaws of the gold arm move"
    np.testing.assert_allclose(reached, joints[frames], atol=0.05)


def test_the_pictures_are_those_of_the_frames(data):
    pictures = data[0]["demo_0/obs/endoscope_image"]
    assert pictures.shape == (90, 64, 64, 3) and pictures.dtype == np.uint8
    assert pictures[0].std() > 10 and np.abs(pictures[89].astype(int) - pictures[0]).max() > 30


def test_pictures_compressed_by_several_cores_are_in_order(tmp_path):
    drawn = np.random.default_rng(3).integers(0, 256, (40, 4, 6, 3), np.uint8)
    part = types.SimpleNamespace(length=len(drawn), frames=lambda _camera, _size: iter(drawn))
    with h5py.File(tmp_path / "set.hdf5", "w") as file, concurrent.futures.ThreadPoolExecutor(3) as pool:
        hdf5._write_pictures(file, part, dataset.Pictures(("top",), (6, 4), ""), pool, 3)
        assert np.array_equal(file["obs/top_image"][:], drawn)


@pytest.mark.parametrize("count", [39, 41])
def test_a_video_of_another_length_is_no_data_set(tmp_path, count):
    part = types.SimpleNamespace(length=40, facts={"session": "s1"}, frames=lambda _camera, _size: iter(np.zeros((count, 4, 6, 3), np.uint8)))
    with h5py.File(tmp_path / "set.hdf5", "w") as file, concurrent.futures.ThreadPoolExecutor(2) as pool:
        with pytest.raises((OSError, ValueError)):
            hdf5._write_pictures(file, part, dataset.Pictures(("top",), (6, 4), ""), pool, 2)


class NoParquet(types.ModuleType):
    """In place of pyarrow, which Debian lacks: a file is the table's columns as JSON."""

    @staticmethod
    def array(values, _kind=None):
        return np.asarray(values)

    @staticmethod
    def string():
        return None

    @staticmethod
    def table(columns):
        return types.SimpleNamespace(columns=columns, schema=list(columns), nbytes=8)

    class ParquetWriter(contextlib.AbstractContextManager):
        def __init__(self, path, schema, compression=""):
            assert compression == "snappy"
            self.path, self.columns = path, {name: [] for name in schema}

        def write_table(self, table):
            for name, values in table.columns.items():
                self.columns[name] += np.asarray(values).tolist()

        def __exit__(self, *_):
            self.path.write_text(json.dumps(self.columns))


@pytest.fixture(name="lerobot")
def lerobot_without_pyarrow(monkeypatch):
    fake = NoParquet("pyarrow")
    fake.parquet = NoParquet("pyarrow.parquet")
    fake.FixedSizeListArray = types.SimpleNamespace(from_arrays=lambda values, size: np.reshape(values, (-1, size)))
    monkeypatch.setitem(sys.modules, "pyarrow", fake)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", fake.parquet)
    def forget():
        sys.modules.pop("raven2_exports.lerobot", None)
        vars(raven2_exports).pop("lerobot", None)

    forget()
    from raven2_exports import lerobot

    yield lerobot
    forget()


def kept_part(folder, name, split, length, success, seed, camera=None):
    """An episode's part as make_part() leaves it, with pictures of at most one camera, 64 by 48."""
    random = np.random.default_rng(seed)
    columns = {column: random.normal(size=(length, len(names))).astype(np.float32) if names else np.full(length, "none")
               for column, (names, _, _) in episode.COLUMNS.items()}
    folder.mkdir()
    np.savez(folder / "table.npz", **columns)
    (folder / "part.json").write_text(json.dumps({"length": length, "task": "peg" if seed % 2 else "ring", "session": name, "split": split,
                                                  "success": success, "seed": seed, "exercise": "none", "hazards": [], "objects": []}))
    if camera:
        subprocess.run(["ffmpeg", "-loglevel", "error", "-f", "lavfi", "-i", f"testsrc=size=64x48:rate={FPS}", "-frames:v", str(length),
                        "-pix_fmt", "yuv420p", folder / f"{camera}.mp4"], check=True)
    return dataset.Part(folder)


def test_a_data_set_of_format_3_says_where_each_episode_lies(lerobot, tmp_path, monkeypatch):
    """Two episodes fill a file."""
    fake, lengths, out = lerobot.pyarrow, (7, 3, 5, 4, 6), tmp_path / "set"
    monkeypatch.setattr(lerobot, "FILE_BYTES", 16)
    monkeypatch.setattr(lerobot, "_tasks", lambda tasks: fake.table({"task": tasks}))
    fake.Table = types.SimpleNamespace(from_pylist=lambda rows: types.SimpleNamespace(
        columns={name: np.array([row[name] for row in rows], object) for name in rows[0]}, schema=list(rows[0])))
    parts = [kept_part(tmp_path / f"p{i}", f"s{i}", "nominal", length, True, i, "top") for i, length in enumerate(lengths)]
    lerobot.write(parts, out, FPS, dataset.Pictures(("top",), (64, 48), ""), 2, "3.0")
    info = json.loads((out / "meta/info.json").read_text())
    found = json.loads((out / "meta/episodes/chunk-000/file-000.parquet").read_text())
    assert found["length"] == list(lengths) and found["data/file_index"] == [0, 0, 1, 1, 2]
    assert found["dataset_from_index"] == [0, 7, 10, 15, 19] and found["dataset_to_index"] == [7, 10, 15, 19, 25]
    for number, (first, last) in enumerate(((0, 10), (10, 19), (19, 25))):
        rows = json.loads((out / info["data_path"].format(chunk_index=0, file_index=number)).read_text())
        assert rows["index"] == list(range(first, last))
    action = np.concatenate([part.columns()["action"] for part in parts]).astype(float)
    assert json.loads((out / "meta/stats.json").read_text())["action"]["mean"] == pytest.approx(action.mean(0))
    wanted = published.FORMATS["lerobot 3.0"]
    assert published.problems(info, wanted["info"]) == []
    for row in ({name: values[i] for name, values in found.items()} for i in range(len(lengths))):
        stats = {name: {key: row.pop(f"stats/{name}/{key}") for key in wanted["stats"]} for name in lerobot_numbers(info)}
        video = {key: row.pop(f"videos/{CAMERA}/{key}") for key in wanted["episode_video"]}
        assert (out / info["video_path"].format(video_key=CAMERA, chunk_index=0, file_index=row["episode_index"])).exists()
        assert published.problems(row, wanted["episode"]) == []
        assert published.problems(stats, {"*": wanted["stats"]}) + published.problems(video, wanted["episode_video"]) == []
    stats = json.loads((out / "meta/stats.json").read_text())
    assert set(stats) == set(lerobot_numbers(info)) and published.problems(stats, {"*": wanted["stats"]}) == []


CAMERA = "observation.images.top"


def lerobot_numbers(info):
    """Names of the columns with statistics. The indices and a camera are described as lerobot does it."""
    features, wanted = info["features"], published.FORMATS["lerobot features"]
    assert published.problems({name: features[name] for name in wanted["indices"]}, wanted["indices"]) == []
    if info["video_path"]:
        assert published.problems(features[CAMERA], wanted["video"]) == [] and features[CAMERA]["shape"] == [48, 64, 3]
    return [name for name, feature in features.items() if feature["dtype"] != "string"]


def test_a_lerobot_data_set_describes_its_episodes(lerobot, tmp_path):
    """Format 2.1, as the reader of lerobot 0.3.3 wants it: five episodes by three workers."""
    shape = [("nominal", 7, True), ("nominal", 3, False), ("failure", 5, False), ("failure", 4, False), ("recovery", 6, True)]
    parts = [kept_part(tmp_path / f"p{i}", f"s{i}", split, length, success, i) for i, (split, length, success) in enumerate(shape)]
    out = tmp_path / "set"
    lerobot.write(parts, out, FPS, dataset.Pictures((), (64, 64), ""), 3, "2.1")
    info = json.loads((out / "meta/info.json").read_text())
    assert (info["codebase_version"], info["total_episodes"], info["total_frames"], info["total_tasks"]) == ("v2.1", 5, 25, 2)
    assert info["splits"] == {"train": "0:5", "nominal": "0:2", "failure": "2:4", "recovery": "4:5"} and info["video_path"] is None
    assert info["features"]["action"]["shape"] == [14] and info["features"]["next.done"]["dtype"] == "bool"
    episodes, stats, tasks = ([json.loads(line) for line in (out / f"meta/{name}.jsonl").read_text().splitlines()]
                              for name in ("episodes", "episodes_stats", "tasks"))
    assert [(e["episode_index"], e["length"], e["tasks"]) for e in episodes] == [(i, shape[i][1], ["peg" if i % 2 else "ring"]) for i in range(5)]
    assert {task["task"]: task["task_index"] for task in tasks} == {"peg": 0, "ring": 1}
    first = 0
    for number, (_, length, success) in enumerate(shape):
        columns = json.loads((out / info["data_path"].format(episode_chunk=0, episode_index=number)).read_text())
        assert columns["index"] == list(range(first, first + length)) and columns["episode_index"] == [number] * length
        assert columns["next.done"] == [False] * (length - 1) + [True] and columns["next.reward"][-1] == float(success)
        assert columns["next.success"] == [False] * (length - 1) + [success]
        assert columns["task_index"] == [0 if number % 2 else 1] * length
        assert columns["timestamp"] == pytest.approx(np.arange(length) / FPS, abs=1e-6)
        action, found = parts[number].columns()["action"], stats[number]["stats"]["action"]
        for name, of in (("min", np.min), ("max", np.max), ("mean", np.mean), ("std", np.std)):
            assert found[name] == pytest.approx(of(action.astype(float), axis=0)), name
        assert found["count"] == [length] and "truth.hazard" not in stats[number]["stats"]
        first += length
    wanted = published.FORMATS["lerobot 2.1"]
    assert published.problems(info, wanted["info"]) == [] and {name for each in stats for name in each["stats"]} == set(lerobot_numbers(info))
    for name, rows in (("episode", episodes), ("task", tasks), ("episode_stats", stats)):
        assert published.problems(rows, [wanted[name]]) == []


def test_the_statistics_of_pictures_are_those_of_their_values(lerobot):
    pixels = np.random.default_rng(5).integers(0, 256, (6, 5, 4, 3), np.uint8) // np.array([1, 2, 3], np.uint8)
    part = types.SimpleNamespace(length=6, facts={"session": "s1"}, frames=lambda _camera, _size: iter(pixels))
    table = types.SimpleNamespace(length=6, part=part, values={})
    found = lerobot.statistics(table, dataset.Pictures(("top",), (4, 5), ""))["observation.images.top"]
    flat = pixels.reshape(-1, 3) / 255.0
    for name, wanted in (("min", flat.min(0)), ("max", flat.max(0)), ("mean", flat.mean(0)), ("std", flat.std(0)),
                         *((f"q{round(100 * q):02d}", np.quantile(flat, q, 0)) for q in lerobot.QUANTILES)):
        assert np.shape(found[name]) == (3, 1, 1) and np.ravel(found[name]) == pytest.approx(wanted, abs=1e-12), name
    assert found["count"] == [6]
    part.frames = lambda _camera, _size: iter(pixels[:5])
    with pytest.raises(OSError, match="has 5 pictures, the session 6"):
        lerobot.statistics(table, dataset.Pictures(("top",), (4, 5), ""))


def test_pooled_statistics_are_those_of_all_frames(lerobot):
    rows = [np.random.default_rng(i).normal(i, 1 + i, (length, 3)) for i, length in enumerate((4, 9, 2))]
    pooled, together = lerobot._pooled([lerobot._of(each, 0) for each in rows]), np.concatenate(rows)
    for name, of in (("min", np.min), ("max", np.max), ("mean", np.mean), ("std", np.std)):
        assert pooled[name] == pytest.approx(of(together, axis=0)), name
    assert pooled["count"] == [15]


def test_work_ahead_is_in_order_and_takes_few_items_at_a_time():
    taken, found = [], []
    items = (taken.append(i) or i for i in range(50))
    with concurrent.futures.ThreadPoolExecutor(3) as pool:
        for square in dataset.ahead(pool, lambda i: i * i, items, 5):
            assert len(taken) <= len(found) + 5
            found.append(square)
    assert found == [i * i for i in range(50)]


def test_a_video_that_cannot_be_read_is_an_error(tmp_path):
    (tmp_path / "part.json").write_text('{"length": 3}')
    (tmp_path / "top.mp4").write_bytes(b"no video")
    with pytest.raises(OSError, match="top.mp4"):
        list(dataset.Part(tmp_path).frames("top", (64, 64)))


def test_what_cannot_be_exported_is_said_and_the_rest_is_kept(sessions, tmp_path):
    empty = tmp_path / "empty"
    empty.mkdir()
    for name in os.listdir(sessions["nominal"]):
        if name != "configuration":
            (empty / name).symlink_to(sessions["nominal"] / name)
    output = tmp_path / "set.hdf5"
    done = export(sessions["nominal"], empty, "--format", "hdf5", "--output", output)
    assert done.returncode == 1 and f"{empty}: no readable copy of raven2.urdf" in done.stderr and not output.exists()
    kept = list((tmp_path / "set.hdf5.parts").glob("*/part.json"))
    assert len(kept) == 1
    written = kept[0].stat().st_mtime_ns
    kept[0].write_text(kept[0].read_text().replace('"seed": 1', '"seed": 7'))  # a kept part is used again, not made again
    done = export(sessions["nominal"], "--format", "hdf5", "--output", output)
    assert done.returncode == 0, done.stderr
    with h5py.File(output) as file:
        assert file["data/demo_0"].attrs["seed"] == 7 and written > 0
    done = export(sessions["nominal"], "--format", "hdf5", "--output", output)
    assert done.returncode == 1 and "exists; delete it or choose another --output" in done.stderr


def test_a_session_whose_length_is_half_a_frame_is_exported(tmp_path):
    session = simulate(tmp_path / "short", 0.150, "none")  # 4.5 frames
    done = export(session, "--format", "hdf5", "--cameras", "endoscope", "--size", "64x64", "--output", tmp_path / "set.hdf5")
    assert done.returncode == 0 and "5 frames" in done.stderr, done.stderr


def test_a_killed_export_leaves_no_workers(sessions, tmp_path):
    command = [PROGRAMS / "export_session", *sessions.values(), "--format", "hdf5", "--cameras", "endoscope,top,overview", "--size", "640x480",
               "--jobs", "2", "--output", tmp_path / "set.hdf5"]
    mark = str(tmp_path / "set.hdf5")
    with subprocess.Popen(list(map(str, command)), stderr=subprocess.DEVNULL) as running:
        until = time.monotonic() + 60
        while time.monotonic() < until and not list((tmp_path / "set.hdf5.parts").glob("*/*.mp4")):
            time.sleep(0.02)
        found = subprocess.run(["pgrep", "-f", f"export_dataset.*{mark}"], capture_output=True, text=True, check=False).stdout.split()
        running.kill()
    for pid in found[:1]:
        subprocess.run(["kill", "-9", pid], check=False)
    until = time.monotonic() + 30
    while subprocess.run(["pgrep", "-f", mark], capture_output=True, check=False).returncode == 0 and time.monotonic() < until:
        time.sleep(0.05)
    assert len(found) >= 3 and subprocess.run(["pgrep", "-f", mark], capture_output=True, check=False).returncode != 0


@pytest.mark.parametrize("words, reason", [
    (("--format", "hdf5", "--cameras", "nowhere"), "nowhere"), (("--format", "hdf5", "--size", "63x64"), "63x64"),
    (("--format", "hdf5", "--fps", "0"), "fps"), (("--format", "hdf5", "--lerobot", "9"), "lerobot")])
def test_bad_options_are_refused(words, reason, sessions, tmp_path):
    done = export(sessions["nominal"], *words, "--output", tmp_path / "set")
    assert done.returncode != 0 and reason in done.stderr and not (tmp_path / "set").exists()


def test_two_sessions_are_no_csv(sessions):
    done = export(sessions["nominal"], sessions["failure"])
    assert done.returncode == 1 and "2 sessions for the format csv, which takes one" in done.stderr


def test_without_pyarrow_the_export_says_how_to_get_it(sessions, tmp_path):
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        done = export(sessions["nominal"], "--format", "lerobot", "--output", tmp_path / "set")
        assert done.returncode == 1 and "needs the Python module pyarrow" in done.stderr and "ENV/bin/pip install pyarrow" in done.stderr
    else:
        pytest.skip("pyarrow is installed")


def test_a_session_with_another_reaction_is_another_session(tmp_path):
    loader = importlib.machinery.SourceFileLoader("make_dataset", str(ROOT / "scripts/make_dataset"))
    module = types.ModuleType(loader.name)
    module.__file__ = loader.path
    loader.exec_module(module)
    names = {module.Run("peg_transfer", reaction, "own", "expert", 1, tmp_path).name for reaction in ("none", "250", "400")}
    assert len(names) == 3
    words = module.Run("peg_transfer", "400", "own", "clumsy:dropper", 7, tmp_path).words
    assert dict(zip(words[::2], words[1::2])) == {"--exercise": "peg_transfer", "--drill": "own", "--motion": "clumsy:dropper", "--reaction": "400",
                                                  "--seed": 7, "--homing": "quick"}


def test_shares_of_a_data_set_come_together(tmp_path):
    words = ("--exercise", "pick_hand_over_place", "--seeds", "1..2", "--output", f"{tmp_path}/set.hdf5/")
    script = ROOT / "scripts/make_dataset"
    done = export(*words, "--part", "2/2", program=script)
    assert done.returncode == 0 and [p.name for p in (tmp_path / "set.hdf5.sessions").iterdir()] == ["pick_hand_over_place-none-expert-2"]
    first = (tmp_path / "set.hdf5.sessions/pick_hand_over_place-none-expert-2/session.rlog").stat().st_mtime_ns
    done = export(*words, "--keep-sessions", program=script)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "set.hdf5.sessions/pick_hand_over_place-none-expert-2/session.rlog").stat().st_mtime_ns == first
    with h5py.File(tmp_path / "set.hdf5") as file:
        assert [file[f"data/demo_{i}"].attrs["seed"] for i in (0, 1)] == [1, 2]
        assert file["data/demo_0"].attrs["task"].startswith("The ring from its stand") and file["data/demo_0/rewards"][-1] == 1
        assert_the_tool_turns_as_recorded(file["data/demo_0"], frames=120)
    done = export(*words, "--hazards", "own,own", program=script)
    assert done.returncode == 2 and "own,own: a name is given twice" in done.stderr
    done = export("--exercise", "nothing", "--seeds", "1", "--output", tmp_path / "other", program=script)
    assert done.returncode == 2 and "nothing" in done.stderr


def test_no_hazard_at_all_is_a_wrong_argument(tmp_path):
    done = export("--exercise", "pick_hand_over_place", "--seeds", "1", "--hazards", ",", "--output", tmp_path / "set/", program=ROOT / "scripts/make_dataset")
    assert done.returncode == 2 and "at least one name" in done.stderr and not list(tmp_path.iterdir()), done.stderr


def test_a_wrong_hazard_is_found_before_the_first_session(tmp_path):
    done = export("--exercise", "pick_hand_over_place", "--seeds", "1", "--hazards", "own,sudden_jumb", "--output", tmp_path / "set.hdf5",
                  program=ROOT / "scripts/make_dataset")
    assert done.returncode == 2 and "sudden_jumb" in done.stderr and not list(tmp_path.iterdir()), done.stderr
    done = export("--exercise", "pick_hand_over_place", "--seeds", "1", "--cameras", "endoscpe", "--output", tmp_path / "set.hdf5",
                  program=ROOT / "scripts/make_dataset")
    assert done.returncode == 2 and "endoscpe" in done.stderr and not list(tmp_path.iterdir()), done.stderr


def test_a_terminated_run_ends_its_simulations_and_leaves_no_half_session(tmp_path):
    command = [ROOT / "scripts/make_dataset", "--exercise", "ring_tower_transfer", "--seeds", "1-50", "--hazards", "none", "--jobs", "2",
               "--output", tmp_path / "set.hdf5"]
    sessions = tmp_path / "set.hdf5.sessions"
    with subprocess.Popen(list(map(str, command)), stderr=subprocess.PIPE, text=True, env=dict(os.environ)) as running:
        until = time.monotonic() + 60
        while time.monotonic() < until and not list(sessions.glob("*.unfinished/session.rlog")):
            time.sleep(0.02)
        simulating = subprocess.run(["pgrep", "-f", f"simulate.*{sessions}"], capture_output=True, text=True, check=False).stdout.split()
        running.terminate()
        assert running.wait(timeout=60) == 143
    left = subprocess.run(["pgrep", "-f", f"simulate.*{sessions}"], capture_output=True, text=True, check=False).stdout.split()
    assert simulating and not left and not list(sessions.glob("*.unfinished"))


def test_a_killed_run_with_hazards_and_pictures_goes_on_where_it_was(tmp_path):
    words = ("--exercise", "pick_hand_over_place", "--seeds", "1", "--hazards", "none,own", "--cameras", "endoscope", "--size", "64x64",
             "--jobs", "1", "--output", tmp_path / "set.hdf5")
    script = ROOT / "scripts/make_dataset"
    sessions = tmp_path / "set.hdf5.sessions"
    first, second = (sessions / f"pick_hand_over_place-{hazard}-expert-1" for hazard in ("none", "own"))
    with subprocess.Popen(list(map(str, (script, *words))), stderr=subprocess.DEVNULL, env=dict(os.environ)) as running:
        wait_for(lambda: first.exists() and second.with_name(second.name + ".unfinished").exists())
        running.kill()
    wait_for(lambda: not subprocess.run(["pgrep", "-f", f"simulate.*{sessions}"], stdout=subprocess.DEVNULL, check=False).returncode == 0)
    assert not second.exists(), "it was killed in the middle"
    recorded = (first / "session.rlog").stat().st_mtime_ns
    done = export(*words, "--keep-sessions", program=script)
    assert done.returncode == 0, done.stderr
    assert (first / "session.rlog").stat().st_mtime_ns == recorded
    with h5py.File(tmp_path / "set.hdf5") as file:
        assert {split: list(names[:]) for split, names in file["mask"].items()} == {"nominal": [b"demo_0"], "recovery": [b"demo_1"]}
        for demo, hazards in (("demo_0", {b"none"}), ("demo_1", {b"none", b"sudden_jump"})):
            pictures = file[f"data/{demo}/obs/endoscope_image"]
            assert pictures.shape == (file[f"data/{demo}/actions"].shape[0], 64, 64, 3) and len(np.unique(pictures[-1])) > 10
            assert set(file[f"data/{demo}/truth/hazard"][:]) == hazards


def wait_for(condition, seconds=60):
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until, condition
        time.sleep(0.02)


def test_robot_objects_and_pedal_are_those_of_the_frames_ticks(data, sessions):
    demo, ticks = data[0]["demo_1"], raven2_session.Session(sessions["failure"]).log.ticks
    ticks = ticks[ticks["model"]["session_tick"] >= 0]
    wanted = np.floor(np.arange(demo.attrs["num_samples"]) * 1000 / FPS + 1e-6)
    shown = ticks[np.searchsorted(ticks["model"]["session_tick"], wanted, side="right") - 1]
    arms, bodies, state = shown["robot"]["arms"], shown["model"]["bodies"], demo["obs/state"][:]
    np.testing.assert_allclose(state[:, :14], arms["q"].reshape(-1, 14), atol=1e-6)
    for arm in (0, 1):
        np.testing.assert_allclose(state[:, 14 + 3 * arm:17 + 3 * arm], arms["p_BT"][:, arm] @ R_WB[arm].T + P_WB[arm], atol=1e-6)
    assert np.abs(state - demo["obs/model_state"][:]).max() > 0.005, "the hazard moves the robot alone"
    poses = np.concatenate([bodies["p"], bodies["q"]], axis=2).reshape(len(shown), -1)
    np.testing.assert_allclose(demo["obs/objects"][:], poses, atol=1e-6)
    assert demo["obs/pedal"][:, 0].tolist() == (shown["model"]["pedal"] != 0).astype(float).tolist()
