"""export_session --format jigsaws (scripts/export_dataset) and rosbag: read back with third-party readers and compared
with the log. The transformations here are written independently, from core/frames.h, config/arms.yaml and raven2.md."""
import datetime
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import time
import types

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import report_session as made  # noqa: E402

import raven2_session  # noqa: E402  (in the same folder as raven2_report)
from raven2_exports import jigsaws  # noqa: E402

PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", made.ROOT / "build")) / "devel/lib/raven2_trainer"
built = pytest.mark.skipif(not (PROGRAMS / "simulate").exists() or not (PROGRAMS / "export_session").exists(),
                           reason="simulate or export_session is not built")
# Axes of B in W, as columns: gold x up, y toward the surgeon, z right; green x up, y forward, z left (core/frames.h).
R_WB = (np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]]), np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]))
P_WB = (np.array([-0.03, 0.0643, 0.14]), np.array([-0.03, -0.0643, 0.14]))  # rcm_W of config/arms.yaml


def export(directory, kind, *options):
    done = subprocess.run([PROGRAMS / "export_session", directory, "--format", kind, *map(str, options)],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stderr


@pytest.fixture(scope="module", name="directory")
def simulated(tmp_path_factory):
    """A session of the scripted expert that moves to the ring: both arms move, and the masters rotate."""
    output = tmp_path_factory.mktemp("export") / "a session"
    done = subprocess.run([PROGRAMS / "simulate", "--motion", "expert", "--exercise", "pick_hand_over_place",
                           "--hazard", "sudden_jump", "--seconds", "9", "--homing", "quick", "--output", output], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return output


@pytest.fixture(scope="module", name="log")
def read_log(directory):
    return raven2_session.Session(directory).log


@pytest.fixture(scope="module", name="ticks")
def session_ticks(log):
    ticks = log.ticks["model"]
    return ticks[ticks["session_tick"] >= 0]


@pytest.fixture(scope="module", name="table")
def kinematics(directory):
    export(directory, "jigsaws")
    return np.loadtxt(directory / "jigsaws.txt")


def frames(table, ticks):
    """The tick of each row: frame k is at k / 30 s, to the nearest millisecond."""
    return np.array([np.argmin(np.abs(ticks["session_tick"] - 1000 * k / 30)) for k in range(len(table))])


def turn(q):
    """Rotation matrix of a quaternion x y z w, by rotating the axes."""
    v, w, axes = np.array(q[:3]), q[3], np.eye(3)
    return (axes + 2 * np.cross(v, np.cross(v, axes) + w * axes)).T


# ---- JIGSAWS ----------------------------------------------------------------------------------------------------


@built
def test_there_are_76_columns_at_30_hz(table, ticks):
    assert table.shape == (math.floor(ticks["session_tick"][-1] * 30 / 1000) + 1, 76)


@built
@pytest.mark.parametrize("arm, first", [(0, 38), (1, 57)])
def test_slaves_are_the_tips_in_the_world(table, ticks, arm, first):
    at = ticks["arms"][frames(table, ticks), arm]
    for row, state in zip(table, at, strict=True):
        assert row[first:first + 3] == pytest.approx(R_WB[arm] @ state["p_BT"] + P_WB[arm], abs=1e-6)
        assert row[first + 3:first + 12].reshape(3, 3) == pytest.approx(R_WB[arm] @ turn(state["q_BT"]), abs=1e-6)
        assert row[first + 12:first + 15] == pytest.approx(R_WB[arm] @ state["v_BT"], abs=1e-6)
        assert row[first + 18] == pytest.approx(state["q"][5] + state["q"][6], abs=1e-6)


@built
@pytest.mark.parametrize("arm, first", [(0, 0), (1, 19)])
def test_masters_are_the_hands_and_what_they_asked_of_the_jaws(table, ticks, log, arm, first):
    index = frames(table, ticks)
    at = ticks[index]
    for row, tick in zip(table, at, strict=True):
        assert row[first:first + 3] == pytest.approx(tick["master_I"][arm] / 0.1, abs=1e-6), "motion scale 0.1"
        assert row[first + 18] == pytest.approx(tick["arms"][arm]["q_d"][5:7].sum(), abs=1e-6)
    turned = np.eye(3)
    for command in log.commands[log.commands["tick"] <= at[-1]["tick"]]:
        turned = turn(command["command"]["dq_I"][arm]) @ turned
    assert table[-1][first + 3:first + 12].reshape(3, 3) == pytest.approx(turned, abs=1e-6)
    inner = (index >= 5) & (index < len(ticks) - 5)
    way = (ticks["master_I"][index[inner] + 5, arm] - ticks["master_I"][index[inner] - 5, arm]) / 0.1
    assert table[inner, first + 12:first + 15] == pytest.approx(way / 0.01, abs=1e-6), "over 10 ms"


@built
def test_the_masters_turned_at_all(table):
    assert max(np.abs(table[-1][first:first + 9] - np.eye(3).ravel()).max() for first in (3, 22)) > 0.05


@built
@pytest.mark.parametrize("first", [0, 19, 38, 57])
def test_rotations_are_rotations(table, first):
    for row in table:
        R = row[first + 3:first + 12].reshape(3, 3)
        assert R @ R.T == pytest.approx(np.eye(3), abs=1e-6) and np.linalg.det(R) == pytest.approx(1, abs=1e-6)


@built
@pytest.mark.parametrize("first", [0, 38])  # gold: the green hand rests, its tremor is faster than the frames
def test_velocities_lead_from_frame_to_frame(table, first):
    p, v = table[:, first:first + 3], table[:, first + 12:first + 15]
    way = np.cumsum((v[:-1] + v[1:]) / 2 / 30, axis=0)  # trapezoids of 33 ms
    assert np.abs(way - (p[1:] - p[0])).max() < 0.02 * np.abs(p[1:] - p[0]).max()


def test_an_angular_velocity_is_what_turns_one_attitude_into_the_other():
    generator = np.random.default_rng(7)
    for _ in range(50):
        axis, angle = generator.normal(size=3), generator.uniform(0.0, 3.0)
        axis /= np.linalg.norm(axis)
        spin = turn([*(axis * math.sin(angle / 2)), math.cos(angle / 2)])
        before = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        found = jigsaws.angular_velocity(before[None], (spin @ before)[None], np.array([0.01]))[0]
        assert found == pytest.approx(axis * angle / 0.01, abs=1e-6)
    assert jigsaws.angular_velocity(np.eye(3)[None], np.eye(3)[None], np.array([0.01]))[0].tolist() == [0.0, 0.0, 0.0]


def test_a_hand_does_not_turn_with_the_motion_of_a_crtk_client():
    commands = np.zeros(4, [("tick", int), ("command", [("pedal", np.uint8), ("dq_I", float, (2, 4))])])
    commands["tick"], commands["command"]["pedal"] = np.arange(4), [1, 2, 2, 1]
    commands["command"]["dq_I"] = [math.sin(0.05), 0, 0, math.cos(0.05)]  # 0.1 rad about x
    turns = jigsaws.master_turns(types.SimpleNamespace(commands=commands), np.array([0, 2, 3]))
    for arm in (0, 1):
        for frame, angle in enumerate((0.1, 0.1, 0.2)):
            assert turns[frame, arm] == pytest.approx(turn([math.sin(angle / 2), 0, 0, math.cos(angle / 2)]))


def test_next_to_a_gap_of_the_log_rows_are_ticks_with_their_true_velocity():
    """Records that were lost leave a gap. Its frames are the nearer of its ends, and a velocity is over the true time."""
    ms = np.append(np.arange(38), np.arange(165, 300))
    model = np.zeros(len(ms), [("tick", int), ("master_I", float, (2, 3)), ("arms", [
        ("p_BT", float, 3), ("q_BT", float, 4), ("v_BT", float, 3), ("q", float, 7), ("q_d", float, 7)], 2)])
    model["tick"], model["arms"]["q_BT"] = 7000 + ms, [0, 0, 0, 1]
    model["master_I"][:, :, 0] = model["arms"]["p_BT"][:, :, 0] = 1e-4 * ms[:, None]  # 0.1 m/s
    model["arms"]["q_BT"][:, 0, 2], model["arms"]["q_BT"][:, 0, 3] = np.sin(1e-3 * ms), np.cos(1e-3 * ms)  # 2 rad/s
    log = types.SimpleNamespace(header={"motion_scale": 0.5}, commands=np.zeros(0))
    table = jigsaws.kinematics(log, types.SimpleNamespace(t=ms / 1000, ticks={"model": model}), 2 * [(np.eye(3), np.zeros(3))])
    rows = [0, 33, 37, 37, 165, 167, 200, 233, 267]  # the gap's middle is at 101 ms
    assert table[:, 38] == pytest.approx(1e-4 * np.array(rows)) and table[:, 0] == pytest.approx(2e-4 * np.array(rows))
    for hand in (0, 19):
        assert table[:, hand + 12] == pytest.approx(np.full(9, 0.2))
    assert table[:, 38 + 17] == pytest.approx(np.full(9, 2.0))


def test_labels_are_the_exercise_s_steps_in_frames_from_one(tmp_path):
    folder = made.make(tmp_path / "s")
    from raven2_figures import Series
    from raven2_report.facts import Facts

    session = raven2_session.Session(folder)
    assert jigsaws.labels(Facts(session, Series(session)).steps, 60) == [(4, 15, "lift"), (16, 57, "not_finished")]


def test_no_label_is_of_a_frame_behind_the_last():
    """A session of 350 ms has eleven frames. Its second step begins behind the last one."""
    steps = [{"name": "lift", "from_s": 0.1, "to_s": 0.34}, {"name": "not finished", "from_s": 0.34, "to_s": 0.351}]
    assert jigsaws.labels(steps, 11) == [(4, 11, "lift"), (11, 11, "not_finished")]


# ---- ROS bag ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module", name="bag")
def read_bag(directory, log, tmp_path_factory):
    """{topic: [(message, stamp)]}, with stamps of the log's clock."""
    rosbag = pytest.importorskip("rosbag", reason="NOT CHECKED: python3-rosbag is not installed")
    path = tmp_path_factory.mktemp("bag") / "its.bag"
    export(directory, "rosbag", "--output", path)
    found, offset = {}, began(directory) - int(log.ticks["model"]["time_ns"][0])

    def by_the_log(stamp):
        return type(stamp)(0, stamp.to_nsec() - offset)

    with rosbag.Bag(str(path)) as bag:
        for topic, message, stamp in bag.read_messages():
            assert 0 <= stamp.to_nsec() - began(directory) < 30e9, "the stamps are wall-clock time"
            for stamped in [message, *getattr(message, "transforms", ())]:
                if hasattr(stamped, "header"):
                    stamped.header.stamp = by_the_log(stamped.header.stamp)
            found.setdefault(topic, []).append((message, by_the_log(stamp).to_nsec()))
    return found


@built
@pytest.mark.parametrize("kilobytes", [8, 100, 300])
def test_a_full_disk_leaves_no_bag_and_the_reason(directory, tmp_path, kilobytes):
    """At the beginning, in the messages, in the index. A limit of the file's size gives the same failed write."""
    path = tmp_path / "its.bag"
    done = subprocess.run(["bash", "-c", f"trap '' XFSZ; ulimit -f {kilobytes}; exec \"$@\"", "-", PROGRAMS / "export_session", directory, "--format",
                           "rosbag", "--output", path], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and str(path) in done.stderr, (done.returncode, done.stderr)
    assert not list(tmp_path.iterdir())


@built
def test_messages_are_numbered_and_connections_named_as_in_a_recorded_bag(bag, directory, tmp_path):
    rosbag = pytest.importorskip("rosbag", reason="NOT CHECKED: python3-rosbag is not installed")
    for topic, entries in bag.items():
        numbers = [message.header.seq for message, _ in entries if hasattr(message, "header")]
        assert numbers == list(range(len(numbers))), topic
    export(directory, "rosbag", "--output", tmp_path / "its.bag")
    with rosbag.Bag(str(tmp_path / "its.bag")) as found:
        connections = [{key: bytes(value).decode() for key, value in connection.header.items() if key != "message_definition"}
                       for connection in found._get_connections()]  # pylint: disable=protected-access
    assert {header["callerid"] for header in connections} == {"/raven2_simulator"}
    assert {header["topic"]: header["latching"] for header in connections}["/model/joint_states"] == "0"


def began(directory):
    """Start of the session [ns since 1970]."""
    start = json.loads((directory / "meta.json").read_text())["start_time_utc"]
    return int(datetime.datetime.strptime(start, "%Y-%m-%dT%H:%M:%S%z").timestamp()) * 1_000_000_000


def stamps(entries):
    return [message.header.stamp.to_nsec() for message, _ in entries]


@pytest.fixture(scope="module", name="told")
def ticks_of_the_bag(bag, ticks):
    """Ticks of the session that the bag has: every tenth one, as the simulator publishes."""
    told = ticks[np.isin(ticks["time_ns"], stamps(bag["/model/joint_states"]))]
    assert len(told) == len(bag["/model/joint_states"]) > 100 and set(np.diff(told["tick"])) == {10}
    assert told["session_tick"][0] < 10 and ticks["tick"][-1] - told["tick"][-1] < 10
    return told


@built
def test_a_bag_has_every_tenth_tick_of_the_session_with_its_time(bag, told):
    for topic in ("/model/gold/measured_cp", "/model/green/measured_cp", "/haptic/gold/force", "/haptic/green/force",
                  "/robot/joint_states"):
        assert stamps(bag[topic]) == told["time_ns"].tolist(), topic
    for entries in bag.values():
        assert all(not hasattr(m, "header") or m.header.stamp.to_nsec() == t for m, t in entries)


@built
def test_joints_are_in_the_coordinates_of_the_robot_s_joint_states(bag, told):
    """Insertion from the URDF's zero, tool roll by 45 degrees, wrist and second grasper with their signs."""
    for (message, _), tick in zip(bag["/model/joint_states"], told, strict=True):
        q, dq, tau = (tick["arms"][name] for name in ("q", "dq", "tau"))
        gold = [q[0][0], q[0][1], q[0][2] - 0.47, q[0][3] - math.pi / 4, q[0][4], q[0][5], -q[0][6]]
        green = [q[1][0], q[1][1], q[1][2] - 0.47, q[1][3] + math.pi / 4, -q[1][4], q[1][5], -q[1][6]]
        assert message.position == pytest.approx(gold + green, abs=1e-12)
        assert message.velocity[6] == -dq[0][6] and message.velocity[11] == -dq[1][4]
        assert message.velocity[:6] == tuple(dq[0][:6]) and message.effort[7:11] == tuple(tau[1][:4])
    assert bag["/model/joint_states"][0][0].name[:3] == ["shoulder_L", "elbow_L", "insertion_L"]
    assert bag["/model/joint_states"][0][0].name[-1] == "grasper_joint_2_R"


@built
def test_the_robot_is_as_it_was_known(bag, log, told):
    robots = log.ticks[np.isin(log.ticks["model"]["tick"], told["tick"])]["robot"]
    for (message, _), robot in zip(bag["/robot/joint_states"], robots, strict=True):
        assert message.position[0] == robot["arms"]["q"][0][0] and message.position[7] == robot["arms"]["q"][1][0]
        assert list(message.effort) == []


@built
def test_tips_and_forces_are_the_log_s_to_the_last_bit(bag, told, log):
    haptic = log.haptic["haptic"]
    newest = np.searchsorted(haptic["tick"], told["tick"], side="right") - 1
    for i, (arm, base) in enumerate((("gold", "L"), ("green", "R"))):
        for (message, _), tick in zip(bag[f"/model/{arm}/measured_cp"], told, strict=True):
            point, angle = message.pose.position, message.pose.orientation
            assert (point.x, point.y, point.z) == tuple(tick["arms"][i]["p_BT"])
            assert (angle.x, angle.y, angle.z, angle.w) == tuple(tick["arms"][i]["q_BT"])
            assert message.header.frame_id == f"model/base_link_{base}"
        for (message, _), force_B in zip(bag[f"/haptic/{arm}/force"], haptic["force_B"][newest], strict=True):
            force = message.wrench.force
            assert (force.x, force.y, force.z) == tuple(force_B[i])


@built
def test_markers_show_what_each_hand_feels(bag, log, told):
    haptic = log.haptic["haptic"]
    newest = haptic[np.searchsorted(haptic["tick"], told["tick"], side="right") - 1]
    assert len(bag["/markers"]) > 10
    for message, _ in bag["/markers"]:
        assert {m.ns for m in message.markers} == {"contact_points", "contact_forces", "hand_forces"} and len(message.markers) == 4
    shown = [{m.id: m.action == m.ADD for m in message.markers if m.ns == "hand_forces"} for message, _ in bag["/markers"]]
    felt = (np.linalg.norm(newest["force_B"], axis=2) >= 1e-3).any(axis=0)
    for arm in (0, 1):
        assert any(ids[arm] for ids in shown) == felt[arm], arm


@built
def test_changes_of_pedal_and_mode_and_events_are_told(bag, ticks, told, log, directory):
    names = log.names("tick", "model.mode")
    seen = [(names[t["mode"]], *(bool(t[what]) for what in ("pedal", "engaged", "linked")),
             "real" if t["view"] else "virtual") for t in told]
    changed = [i for i, now in enumerate(seen) if i == 0 or now != seen[i - 1]]
    assert [(m.mode, m.pedal, m.engaged, m.linked, m.view) for m, _ in bag["/mode"]] == [seen[i] for i in changed]
    assert stamps(bag["/mode"]) == told["time_ns"][changed].tolist() and len(changed) > 1
    assert {m.trial_time for m, _ in bag["/mode"]} == {0.0}
    changed = np.concatenate(([0], np.flatnonzero(np.diff(told["pedal"].astype(int))) + 1))
    assert [list(m.buttons) for m, _ in bag["/console/pedal"]] == [[int(told["pedal"][i])] for i in changed]
    assert stamps(bag["/console/pedal"]) == told["time_ns"][changed].tolist()
    kinds = log.names("exercise", "event.kind")
    bodies = raven2_session.Session(directory).log.header["body_names"]
    session_events = [(n, e) for n, e in enumerate(log.exercise_events, 1) if e["tick"] <= told["tick"][-1]]
    events = [m for m, _ in bag["/exercise/events"]]
    assert [(m.number, m.tick, m.event) for m in events] == [(n, e["tick"], kinds[e["event"]["kind"]])
                                                            for n, e in session_events]
    assert events[0].event == "started", "events before the first pedal-down are in the bag, too, with the first stamp"
    for message, (_, record) in zip(events, session_events, strict=True):
        event = record["event"]
        assert message.a == (bodies[event["a"]] if event["a"] < len(bodies) else "")
        assert message.value == event["value"] and message.force == event["force"]


@built
def test_a_bag_has_the_faults_as_they_begin_and_end(bag, ticks, directory):
    (injection,) = json.loads((directory / "faults.json").read_text())["injections"]
    begin, end = (m for m, _ in bag["/faults"])
    for message, when, acts in ((begin, injection["inject"], True), (end, injection["clear"], False)):
        assert (message.scenario, message.row, message.acts, message.host) == ("sudden_jump", 0, acts, "robot")
        assert (message.site, message.variable, message.arm, message.kind, message.value) == (
            "put_usb_packet", "dac", "gold", "stuck_at", 800.0)
        assert (message.channel, message.tick, message.cycle) == (0, when["tick"], when["cycle"])
        (at,) = ticks[ticks["session_tick"] == when["tick"]]
        assert message.header.stamp.to_nsec() == at["time_ns"]
    assert end.tick - begin.tick == 300


@built
def test_faults_of_several_rows_come_in_order_of_time(tmp_path):
    rosbag = pytest.importorskip("rosbag", reason="NOT CHECKED: python3-rosbag is not installed")
    done = subprocess.run([PROGRAMS / "simulate", "--hazard", "master_sluggish", "--seconds", "12", "--homing", "quick", "--output",
                           tmp_path / "session"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    export(tmp_path / "session", "rosbag")
    with rosbag.Bag(str(tmp_path / "session/session.bag")) as found:
        faults = [(m.row, m.acts, m.tick, stamp.to_nsec()) for _, m, stamp in found.read_messages("/faults")]
    injections = json.loads((tmp_path / "session/faults.json").read_text())["injections"]
    wanted = [(i["row"], acts, moment["tick"]) for i in injections
              for acts, moment in ((True, i["inject"]), (False, i["clear"])) if moment["tick"] is not None]
    assert len({row for row, *_ in faults}) == 3
    assert sorted(fault[:3] for fault in faults) == sorted(wanted)
    assert [t for *_, t in faults] == sorted(t for *_, t in faults) and [f[2] for f in faults] == sorted(f[2] for f in faults)


@built
def test_a_fault_that_ended_before_the_first_pedal_down_has_its_end_in_the_bag(tmp_path):
    rosbag = pytest.importorskip("rosbag", reason="NOT CHECKED: python3-rosbag is not installed")
    sys.path.insert(0, str(PROGRAMS.parent / "python3/dist-packages"))
    import raven2_trainer

    with raven2_trainer.Simulation(output=tmp_path / "session") as simulation:
        simulation.step({"pedal": False}, ticks=100)
        simulation.inject("video_loss")
        simulation.step({"pedal": False}, ticks=50)
        simulation.clear_hazards()
        simulation.start()
        simulation.step(ticks=100)
    export(tmp_path / "session", "rosbag")
    with rosbag.Bag(str(tmp_path / "session/session.bag")) as found:
        faults = [(m.scenario, m.acts, m.tick) for _, m, _ in found.read_messages("/faults")]
    assert faults == [("video_loss", True, -1), ("video_loss", False, -1)]


def daemon_types():
    """{topic: type} of the topics that the daemon's code advertises by name. Our own types lack the package there."""
    found = {}
    for path in (made.ROOT / "src/ros").rglob("*.cpp"):
        for kind, topic in re.findall(r'advertise<([\w:]+)>\(\s*"([^"]+)"', path.read_text(encoding="utf-8")):
            found["/" + topic.lstrip("/")] = kind.replace("::", "/") if "::" in kind else f"raven2_trainer/{kind}"
    return found


@built
def test_topics_that_the_daemon_has_too_have_its_names_and_types(bag):
    published = daemon_types()
    assert published["/mode"] == "raven2_trainer/TrainerMode" and published["/tf_static"] == "tf2_msgs/TFMessage"
    own = {"/model/gold/measured_cp", "/model/green/measured_cp", "/console/pedal", "/faults"}
    assert set(bag) - own <= set(published), "a topic that the daemon does not publish"
    for topic in set(bag) - own:
        assert {m._type for m, _ in bag[topic]} == {published[topic]}, topic
    assert {"/mode", "/tf", "/tf_static", "/session/configuration", "/exercise/events"} <= set(bag)


def seconds_to_read(rosbag, paths):
    """Processor time [s] to read each bag, the best of ten. In turns: a machine's speed changes from second to second.

    The first turn does not count: rosbag compiles each message's type when it first meets it.
    """
    turns = np.empty((11, len(paths)))
    for turn, i in np.ndindex(turns.shape):
        begin = time.process_time()
        with rosbag.Bag(str(paths[i])) as bag:
            assert sum(1 for _ in bag.read_messages()) > 1000
        turns[turn, i] = time.process_time() - begin
    return turns[1:].min(axis=0)


@built
def test_a_bag_is_read_as_fast_as_a_recorded_one(directory, tmp_path):
    """The recorded bag has the same messages in the order of their stamps, as rosbag record writes them."""
    rosbag = pytest.importorskip("rosbag", reason="NOT CHECKED: python3-rosbag is not installed")
    export(directory, "rosbag", "--output", tmp_path / "its.bag")
    with rosbag.Bag(str(tmp_path / "its.bag")) as bag, rosbag.Bag(str(tmp_path / "recorded.bag"), "w") as recorded:
        written = [stamp.to_nsec() for _, _, stamp in bag.read_messages()]
        for topic, message, stamp in bag.read_messages():
            recorded.write(topic, message, stamp)
    assert written == sorted(written)
    own, recorded_one = seconds_to_read(rosbag, [tmp_path / "its.bag", tmp_path / "recorded.bag"])
    ratio = own / recorded_one
    print(f"reading it takes {ratio:.2f} times as long as reading a recorded bag")
    assert ratio < 1.3  # 1.9 with bz2, 3.8 with the messages written kind by kind


@built
def test_what_the_daemon_latches_is_latched_by_rosbag_play(directory, tmp_path):
    rosbag = pytest.importorskip("rosbag", reason="NOT CHECKED: python3-rosbag is not installed")
    export(directory, "rosbag", "--output", tmp_path / "its.bag")
    with rosbag.Bag(str(tmp_path / "its.bag")) as found:
        latched = {c.topic for c in found._get_connections() if c.header.get("latching") == b"1"}
    assert {"/mode", "/exercise/state", "/session/configuration", "/tf_static"} <= latched and "/tf" not in latched


@built
def test_frames_are_the_links_of_model_and_robot_in_the_world(bag, told, log):
    """The graspers rotate about the tool's tip, which is in the log. The arms' bases are in config/arms.yaml."""
    fixed = {t.child_frame_id: t.transform for t in bag["/tf_static"][0][0].transforms}
    assert {f"{which}/{link}" for which in ("model", "robot")
            for link in ("world", "base_link_L", "base_link_R")} <= set(fixed)
    assert len(bag["/tf_static"]) == 1
    wanted = told[::3]
    assert [stamp for _, stamp in bag["/tf"]] == wanted["time_ns"].tolist()
    for arm, side in enumerate("LR"):
        base = fixed[f"model/base_link_{side}"]
        assert [base.translation.x, base.translation.y, base.translation.z] == pytest.approx(P_WB[arm], abs=1e-9)
        q = base.rotation
        assert turn([q.x, q.y, q.z, q.w]) == pytest.approx(R_WB[arm], abs=1e-9)
    moving = {f"model/{stem}_{side}" for side in "LR" for stem in
              ("link1", "link2", "link3", "instrument_shaft", "wrist", "grasper1", "grasper2")}
    for (message, stamp), tick in zip(bag["/tf"], wanted, strict=True):
        frames_of = {t.child_frame_id: t.transform for t in message.transforms}
        assert moving <= set(frames_of) and not set(frames_of) & set(fixed)
        assert all(t.header.frame_id == "world" and t.header.stamp.to_nsec() == stamp for t in message.transforms)
        for arm, side in enumerate("LR"):
            to = frames_of[f"model/grasper1_{side}"].translation
            assert [to.x, to.y, to.z] == pytest.approx(R_WB[arm] @ tick["arms"][arm]["p_BT"] + P_WB[arm], abs=1e-6)
    robots = [{t.child_frame_id for t in m.transforms if t.child_frame_id.startswith("robot/")} for m, _ in bag["/tf"]]
    rows = log.ticks[np.isin(log.ticks["model"]["tick"], wanted["tick"])]
    linked = [bool(r["robot"]["frame"] > 0 and r["robot"]["connected"]) for r in rows]
    assert [bool(names) for names in robots] == linked and any(linked)
    assert max(robots, key=len) == {name.replace("model/", "robot/") for name in moving}


@built
def test_the_last_links_are_turned_as_the_chain_turns_them(bag):
    """The positions of the links test all rotations but the last: the jaws' axis is perpendicular to the wrist's."""
    for message, _ in bag["/tf"]:
        found = {t.child_frame_id: t.transform.rotation for t in message.transforms}
        for side in "LR":
            wrist, jaw = (turn([q.x, q.y, q.z, q.w]) for q in
                          (found[f"model/wrist_{side}"], found[f"model/grasper1_{side}"]))
            assert np.linalg.det(wrist) == pytest.approx(1.0, abs=1e-9)
            assert abs(wrist[:, 2] @ jaw[:, 2]) < 1e-9
    assert len(bag["/tf"]) > 100


@built
def test_the_configuration_is_that_of_the_session(bag, directory):
    meta = json.loads((directory / "meta.json").read_text())
    (message, _), = bag["/session/configuration"]
    named = meta["config_files"] + [meta["robot_urdf"], meta["scene_urdf"]]
    assert [(f.path, f.fnv1a) for f in message.files] == [(entry["path"], entry["fnv1a"]) for entry in named]
    assert (message.seed, message.hazard) == (meta["seed"], meta["hazard"])
    assert message.exercise == "pick_hand_over_place" and message.directory == str(directory)


# ---- refusals ---------------------------------------------------------------------------------------------------


@built
def test_other_formats_are_refused_and_folders_that_are_no_session(tmp_path, directory):
    for options, code in ((["--format", "mat"], None), ([], 1)):
        target = directory if options else tmp_path
        done = subprocess.run([PROGRAMS / "export_session", target, *options], capture_output=True, text=True,
                              check=False)
        assert done.returncode not in (0, None) and (code is None or done.returncode == code)
    done = subprocess.run([made.ROOT / "scripts" / "export_dataset", tmp_path], capture_output=True, text=True,
                          check=False)
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and "no session" in done.stderr


@built
def test_the_frames_of_the_robot_are_where_the_robot_is(bag, told, log):
    rows = log.ticks[np.isin(log.ticks["model"]["tick"], told[::3]["tick"])]
    apart = 0.0
    for (message, _), row in zip(bag["/tf"], rows, strict=True):
        frames_of = {t.child_frame_id: t.transform.translation for t in message.transforms}
        for arm, side in enumerate("LR"):
            to, tip = frames_of.get(f"robot/grasper1_{side}"), row["robot"]["arms"][arm]["p_BT"]
            if to is not None:
                assert [to.x, to.y, to.z] == pytest.approx(R_WB[arm] @ tip + P_WB[arm], abs=1e-6)
                apart = max(apart, np.linalg.norm(tip - row["model"]["arms"][arm]["p_BT"]))
    assert apart > 0.005, "the jump parts them"
