"""A session as a ROS bag: the simulator's topics at its rate, from the first pedal down, stamped with the log's own
clock (monotonic; in lockstep the tick). Needs python3-rosbag and messages, imported when a bag is asked for."""

import json
import math

import numpy as np

EVERY = 10  # [ticks] 100 Hz, as the simulator publishes
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
    """Messages kind by kind, each with its own time, by which readers of a bag sort them; `counts` by topic."""

    def __init__(self, bag):
        import rospy

        self.bag, self.counts, self.time = bag, {}, rospy.Time

    def put(self, topic, message, nanoseconds, frame=""):
        stamp = self.time(nanoseconds // 1_000_000_000, nanoseconds % 1_000_000_000)
        if hasattr(message, "header"):
            message.header.stamp, message.header.frame_id = stamp, frame
        self.bag.write(topic, message, stamp)
        self.counts[topic] = self.counts.get(topic, 0) + 1


def _ticks(facts, put, messages):
    """Joints of model and robot, tips of the model."""
    d4, last_robot = facts.header["d4"], -1
    for record in facts.series.ticks[facts.series.ticks["model"]["tick"] % EVERY == 0]:
        model, robot, now = record["model"], record["robot"], int(record["model"]["time_ns"])
        arms = model["arms"]
        put("/model/joint_states", joint_state(messages.JointState(), arms["q"], arms["dq"], arms["tau"], d4), now)
        for arm, name in enumerate(("gold", "green")):
            pose = messages.PoseStamped()
            point, turn = pose.pose.position, pose.pose.orientation
            point.x, point.y, point.z = arms["p_BT"][arm].tolist()
            turn.x, turn.y, turn.z, turn.w = arms["q_BT"][arm].tolist()
            put(f"/model/{name}/measured_cp", pose, now, FRAMES[arm])
        if robot["frame"] > 0 and robot["connected"] and robot["frame"] != last_robot:
            last_robot = robot["frame"]
            arms = robot["arms"]
            put("/robot/joint_states", joint_state(messages.JointState(), arms["q"], arms["dq"], None, d4),
                int(robot["received_ns"]))


def _forces(facts, put, messages):
    haptic = facts.log.haptic["haptic"]
    first = facts.series.ticks["model"]["tick"][0]
    for record in haptic[(haptic["tick"] >= first) & (haptic["tick"] % EVERY == 0)]:
        for arm, name in enumerate(("gold", "green")):
            wrench = messages.WrenchStamped()
            force = wrench.wrench.force
            force.x, force.y, force.z = record["force_B"][arm].tolist()
            put(f"/haptic/{name}/force", wrench, int(record["time_ns"]), FRAMES[arm])


def _changes(facts, put, messages):
    """Pedal and mode when they change, and what the exercise's judge told."""
    model = facts.series.ticks["model"]
    names = facts.log.names("tick", "model.mode")
    for what in ("pedal", "mode"):
        for i in np.concatenate(([0], np.flatnonzero(np.diff(model[what].astype(int))) + 1)):
            message = messages.Joy() if what == "pedal" else messages.String()
            if what == "pedal":
                message.buttons = [int(model["pedal"][i])]
            else:
                message.data = names[model["mode"][i]]
            put(f"/{'console/pedal' if what == 'pedal' else 'mode'}", message, int(model["time_ns"][i]))
    for event in facts.events:
        said = {key: value for key, value in event.items() if key != "at_s" and value}
        put("/exercise/event", messages.String(json.dumps(said, sort_keys=True)),
            int(model["time_ns"][facts.index(event["at_s"])]))


class _Messages:
    def __init__(self):
        from geometry_msgs.msg import PoseStamped, WrenchStamped
        from sensor_msgs.msg import JointState, Joy
        from std_msgs.msg import String

        self.PoseStamped, self.WrenchStamped, self.JointState, self.Joy, self.String = (
            PoseStamped, WrenchStamped, JointState, Joy, String)


def write(facts, path):
    """Number of messages written, by topic."""
    import rosbag

    messages = _Messages()
    with rosbag.Bag(path, "w", compression="bz2") as bag:
        writer = Writer(bag)
        for part in (_ticks, _forces, _changes):
            part(facts, writer.put, messages)
    return writer.counts
