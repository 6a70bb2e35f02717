"""A session as a ROS bag: the simulator's topics at its rate, and the faults, from the first pedal down, stamped with the wall
clock: the log's own (monotonic; in lockstep the tick) from when the session began. Topics that the simulator has, too, have its
names and types. Needs
python3-rosbag, Debian's messages and the package's own, imported when a bag is asked for."""

import calendar
import heapq
import math
import os
import sys
import time

import numpy as np

from raven2_exports.frames import Arms

EVERY = 10  # [ticks] 100 Hz, as the simulator publishes
FRAMES_EVERY = 30  # [ticks] 33 Hz, as it tells /tf
LATCHED = ("/mode", "/session/configuration", "/tf_static")  # rosbag play latches them, too
TOLD = ("mode", "pedal", "engaged", "linked", "view")  # a change of one of these is told on /mode
ROLL = (-math.pi / 4, math.pi / 4)  # [rad] gold, green: tool roll of /joint_states (kinematics/joint_conventions.h)
JOINTS = ("shoulder", "elbow", "insertion", "tool_roll", "wrist_joint", "grasper_joint_1", "grasper_joint_2")
NAMES = [f"{joint}_{side}" for side in "LR" for joint in JOINTS]
FRAMES = ("model/base_link_L", "model/base_link_R")
SIGNS = np.array([[1, 1, 1, 1, 1, 1, -1], [1, 1, 1, 1, -1, 1, -1]], dtype=float)


def to_urdf(q, d4):
    """Joint positions (..., 2, 7) in the coordinates of the URDF and the robot's /joint_states."""
    result = np.asarray(q, float) * SIGNS
    result[..., 2] += d4
    result[..., 3] += ROLL
    return result


def joint_state(message, q, dq, tau, d4):
    message.name = list(NAMES)
    message.position = to_urdf(q, d4).ravel().tolist()
    message.velocity = (dq * SIGNS).ravel().tolist()
    message.effort = [] if tau is None else (tau * SIGNS).ravel().tolist()
    return message


class Writer:
    """Messages, each with its own time; `counts` by topic."""

    def __init__(self, bag, offset):
        import rospy

        self.bag, self.counts, self.time, self._offset = bag, {}, rospy.Time, offset

    def put(self, topic, message, nanoseconds, frame=""):
        stamp = self.time(*divmod(nanoseconds + self._offset, 1_000_000_000))
        if hasattr(message, "header"):
            message.header.stamp, message.header.frame_id = stamp, frame
        for transform in getattr(message, "transforms", ()):
            transform.header.stamp, transform.header.frame_id = stamp, "world"
        self.bag.write(topic, message, stamp, connection_header=self._latching(topic, message))
        self.counts[topic] = self.counts.get(topic, 0) + 1

    @staticmethod
    def _latching(topic, message):
        """What the bag says of the connection where it is more than its own words; None else."""
        if topic not in LATCHED:
            return None
        return {"topic": topic, "type": message._type, "md5sum": message._md5sum,
                "message_definition": message._full_text, "latching": "1"}


def _ticks(facts, messages):
    """Joints of model and robot, tips of the model."""
    d4, last_robot = facts.header["d4"], -1
    for record in facts.series.ticks[facts.series.ticks["model"]["tick"] % EVERY == 0]:
        model, robot, now = record["model"], record["robot"], int(record["model"]["time_ns"])
        arms = model["arms"]
        yield ("/model/joint_states", joint_state(messages.JointState(), arms["q"], arms["dq"], arms["tau"], d4), now)
        for arm, name in enumerate(("gold", "green")):
            pose = messages.PoseStamped()
            point, turn = pose.pose.position, pose.pose.orientation
            point.x, point.y, point.z = arms["p_BT"][arm].tolist()
            turn.x, turn.y, turn.z, turn.w = arms["q_BT"][arm].tolist()
            yield (f"/model/{name}/measured_cp", pose, now, FRAMES[arm])
        if robot["frame"] > 0 and robot["connected"] and robot["frame"] != last_robot:
            last_robot = robot["frame"]
            arms = robot["arms"]
            yield ("/robot/joint_states", joint_state(messages.JointState(), arms["q"], arms["dq"], None, d4),
                   int(robot["received_ns"]))


def _forces(facts, messages):
    haptic = facts.log.haptic["haptic"]
    first = facts.series.ticks["model"]["tick"][0]
    for record in haptic[(haptic["tick"] >= first) & (haptic["tick"] % EVERY == 0)]:
        for arm, name in enumerate(("gold", "green")):
            wrench = messages.WrenchStamped()
            force = wrench.wrench.force
            force.x, force.y, force.z = record["force_B"][arm].tolist()
            yield (f"/haptic/{name}/force", wrench, int(record["time_ns"]), FRAMES[arm])


def _transform(messages, child, p, q):
    message = messages.TransformStamped()
    message.child_frame_id = child
    to, turn = message.transform.translation, message.transform.rotation
    to.x, to.y, to.z = p.tolist()
    turn.x, turn.y, turn.z, turn.w = q.tolist()
    return message


def _frames(facts, messages):
    """What moves on /tf, the rest on /tf_static; of the robot while it is linked. Cameras are not told."""
    urdf = facts.configuration.file("urdf", "raven2.urdf")
    if urdf is None:
        print("no readable copy of raven2.urdf in the session: the bag has no /tf", file=sys.stderr)
        return
    d4, arms, ticks = facts.header["d4"], Arms(urdf), facts.series.ticks
    still = arms.poses(NAMES, np.zeros((1, len(NAMES))))
    fixed = [_transform(messages, f"{prefix}/{name}", p[0], q[0]) for prefix in ("model", "robot")
             for name, (p, q) in still.items() if name in arms.fixed]
    yield ("/tf_static", messages.TFMessage(fixed), int(ticks["model"]["time_ns"][0]))
    told = ticks[ticks["model"]["tick"] % FRAMES_EVERY == 0]
    poses = {which: arms.poses(NAMES, to_urdf(told[which]["arms"]["q"], d4).reshape(len(told), -1))
             for which in ("model", "robot")}
    for i, record in enumerate(told):
        is_linked = record["robot"]["frame"] > 0 and record["robot"]["connected"]
        there = ("model", "robot") if is_linked else ("model",)
        moving = [_transform(messages, f"{which}/{name}", p[i], q[i]) for which in there
                  for name, (p, q) in poses[which].items() if name not in arms.fixed]
        yield ("/tf", messages.TFMessage(moving), int(record["model"]["time_ns"]))


def _configuration(facts, messages):
    """What the simulator was configured by, as it told: from meta.json, which has it in the same words."""
    meta, training = facts.meta, facts.training
    message = messages.SessionConfiguration()
    message.directory = os.path.abspath(facts.session.directory)
    message.seed, message.hazard = int(meta.get("seed", 0)), str(meta.get("hazard", facts.header.get("hazard", "none")))
    message.exercise, message.drill = training["exercise"], training["drill"]
    named = meta.get("config_files", []) + [meta[key] for key in ("robot_urdf", "scene_urdf") if key in meta]
    message.files = [messages.ConfigurationHash(path=entry["path"], fnv1a=entry["fnv1a"]) for entry in named]
    yield ("/session/configuration", message, int(facts.series.ticks["model"]["time_ns"][0]))


def _mode(facts, messages):
    model = facts.series.ticks["model"]
    names = facts.log.names("tick", "model.mode")
    has = model.dtype.names  # logs of older versions do not know all of them
    told = np.stack([model[what].astype(int) if what in has else np.zeros(len(model), int) for what in TOLD], -1)
    for i in np.concatenate(([0], np.flatnonzero(np.diff(told, axis=0).any(axis=1)) + 1)):
        message = messages.TrainerMode()
        message.mode = names[told[i][0]]
        message.pedal, message.engaged, message.linked = (bool(x) for x in told[i][1:4])
        message.view = "real" if told[i][4] else "virtual"
        message.trial_time = 0.001 * float(model["trial_ticks"][i]) if "trial_ticks" in has else 0.0
        yield ("/mode", message, int(model["time_ns"][i]))


def _pedal(facts, messages):
    model = facts.series.ticks["model"]
    for i in np.concatenate(([0], np.flatnonzero(np.diff(model["pedal"].astype(int))) + 1)):
        yield ("/console/pedal", messages.Joy(buttons=[int(model["pedal"][i])]), int(model["time_ns"][i]))


def _named(names, number):
    return str(names[number]) if number < len(names) else ""


def _event(facts, event, messages):
    """As src/ros/training_messages.cpp tells it: only what belongs to that kind of event."""
    message = messages.ExerciseEventStamped()
    message.event = facts.log.names("exercise", "event.kind")[event["kind"]]
    if message.event in ("mistake", "dropped", "touch_began", "touch_ended"):
        message.mistake = facts.log.names("exercise", "event.mistake")[event["mistake"]]
    if message.event in ("held", "released", "mistake") and "arm" in event.dtype.names:
        message.arm = _named(("gold", "green", "any", "both"), event["arm"])
    tracks = [str(track.get("name", "")) for track in facts.exercise.get("tracks", [])]
    steps = facts.header.get("step_names", [])
    if event["track"] < len(steps):
        message.track = _named(tracks, event["track"])
        message.step = _named(steps[event["track"]], event["step"])
    bodies = facts.header.get("body_names", [])
    message.a, message.b = _named(bodies, event["a"]), _named(bodies, event["b"])
    for what in ("value", "force"):
        setattr(message, what, float(event[what]) if what in event.dtype.names else 0.0)
    return message


def _events(facts, messages):
    """At the session's tick in which they happened, its first at the earliest; numbered as the simulator does, from the
    log's beginning."""
    model = facts.series.ticks["model"]
    for number, record in enumerate(facts.log.exercise_events if facts.log.exercise_events is not None else (), 1):
        at = facts.session_time(int(record["tick"]))
        if at is None:
            continue
        message = _event(facts, record["event"], messages)
        message.number, message.tick = number, int(record["tick"])
        yield ("/exercise/events", message, int(model["time_ns"][facts.index(at)]))


def _faults(facts, messages):
    """Each row of the scenario as it begins and ends, by faults.json, in order of time; at the tick in which the daemon knew it."""
    model, found = facts.series.ticks["model"], []
    for injection in facts.session.faults.get("injections", []):
        for acts, moment in ((True, injection["inject"]), (False, injection["clear"])):
            if moment.get("tick") is None:
                continue
            message = messages.FaultChange()
            message.scenario, message.acts, message.tick = injection["name"], acts, moment["tick"]
            message.cycle = -1 if moment.get("cycle") is None else moment["cycle"]
            message.channel = -1
            for what in ("row", "host", "site", "variable", "arm", "channel", "kind", "value"):
                if injection.get(what) is not None:
                    setattr(message, what, injection[what])
            i = min(int(np.searchsorted(model["session_tick"], moment["tick"])), len(model) - 1)
            found.append(("/faults", message, int(model["time_ns"][i])))
    return sorted(found, key=lambda change: change[2])


def wall_clock_of(facts):
    """[ns] The wall clock less the log's own, to a second: the session's start is told in seconds."""
    started = facts.meta.get("start_time_utc")
    if not started:
        print("meta.json has no start_time_utc: the bag's stamps are the log's own clock", file=sys.stderr)
        return 0
    begin = calendar.timegm(time.strptime(started, "%Y-%m-%dT%H:%M:%SZ"))
    return begin * 1_000_000_000 - int(facts.log.ticks["model"]["time_ns"][0])


def _find_own_messages():
    """Where the environment is not set up, those of the build folder beside the scripts."""
    try:
        import raven2_trainer.msg  # noqa: F401
    except ImportError:
        root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
        build = os.environ.get("RAVEN2_TRAINER_BUILD", os.path.join(root, "build"))
        sys.path.append(os.path.join(build, "devel/lib/python3/dist-packages"))


class _Messages:
    def __init__(self):
        _find_own_messages()
        from geometry_msgs.msg import PoseStamped, TransformStamped, WrenchStamped
        from raven2_trainer.msg import (ConfigurationHash, ExerciseEventStamped, FaultChange, SessionConfiguration,
                                        TrainerMode)
        from sensor_msgs.msg import JointState, Joy
        from tf2_msgs.msg import TFMessage

        for kind in (PoseStamped, TransformStamped, WrenchStamped, ConfigurationHash, ExerciseEventStamped,
                     FaultChange, SessionConfiguration, TrainerMode, JointState, Joy, TFMessage):
            setattr(self, kind.__name__, kind)


def write(facts, path):
    """Number of messages written, by topic."""
    import rosbag

    messages = _Messages()
    with rosbag.Bag(path, "w") as bag:  # not compressed, as rosbag record: with bz2 reading takes 1.9 times as long
        writer = Writer(bag, wall_clock_of(facts))
        # In order of time: a reader sorts by time, and reads a chunk again each time that it comes back to it.
        parts = (part(facts, messages) for part in (_configuration, _frames, _ticks, _forces, _mode, _pedal, _events,
                                                    _faults))
        for message in heapq.merge(*parts, key=lambda message: message[2]):
            writer.put(*message)
    return writer.counts
