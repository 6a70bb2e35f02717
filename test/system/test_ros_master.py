"""Programs and the ROS master. It may come late, go, and come back; the loops must not notice."""

import json
import os
import signal
import socket
import struct
import sys
import time

import yaml
from ros_master import RosMaster, SlowMaster, resident_mib
from stack import Stack, effort, wait_until
from surgeon import LatestState, Surgeon

PEDAL_UP, PEDAL_DOWN = 2, 3
WITHIN = 1.0  # [s] from the master's first answer to the last topic
NODES = ("/raven2_simulator", "/virtual_raven", "/raven_state_bridge")
ARMS = ("/arm1/", "/arm2/")
CRTK_STATES = {"measured_js", "setpoint_js", "jaw/measured_js", "jaw/setpoint_js", "measured_cp", "setpoint_cp", "goal_cp",
               "local/measured_cp", "local/setpoint_cp", "local/goal_cp", "measured_cv", "local/measured_cv", "measured_cf",
               "body/measured_cf", "spatial/measured_cf", "jacobian", "local/jacobian", "body/jacobian", "spatial/jacobian"}
CRTK_TOPICS = CRTK_STATES | {"operating_state", "info", "warning", "error", "is_valid", "trajectory_j/ratio", "twist_timeout"}
CRTK_HEARS = {"state_command", "hold", "free", "servo_jp", "servo_jr", "servo_jv", "servo_jf", "move_jp", "move_jr",
              "jaw/servo_jp", "jaw/servo_jr", "jaw/servo_jv", "jaw/servo_jf", "jaw/move_jp", "jaw/move_jr", "servo_cp", "servo_cr",
              "servo_cv", "servo_cf", "move_cp", "local/servo_cp", "local/servo_cr", "local/servo_cv", "local/servo_cf",
              "local/move_cp", "body/servo_cf", "spatial/servo_cf", "body/set_cf_orientation_absolute",
              "spatial/set_cf_orientation_absolute", "trajectory_j/set_ratio", "use_gravity_compensation",
              "emulate_tool_present"}
CRTK_SERVICES = {"forward_kinematics", "inverse_kinematics", "local/forward_kinematics", "local/inverse_kinematics"}
DAEMON_TOPICS = {"/model/joint_states", "/robot/joint_states", "/haptic/gold/force", "/haptic/green/force",
                 "/camera/image_raw", "/camera/image_raw/compressed", "/camera/camera_info", "/camera/left/image_raw",
                 "/camera/left/image_raw/compressed", "/camera/left/camera_info", "/camera/right/image_raw",
                 "/camera/right/image_raw/compressed", "/camera/right/camera_info", "/camera/second/image_raw",
                 "/camera/second/image_raw/compressed", "/camera/second/camera_info", "/markers",
                 "/workspace_edge", "/tf", "/tf_static", "/session/configuration", "/diagnostics", "/plan/trajectory",
                 "/plan/tip_path", "/plan/progress", "/plan/execution", "/mode", "/exercise/state", "/exercise/events",
                 "/view/image_raw", "/view/image_raw/compressed", "/move_arm/status", "/move_arm/feedback",
                 "/move_arm/result"} | {arm + topic for arm in ARMS for topic in CRTK_TOPICS} | {
    "/model" + arm + topic for arm in ARMS for topic in CRTK_STATES}
DAEMON_HEARS = {"/move_arm/goal", "/move_arm/cancel", "/pedals", "/real_camera/image_raw"} | {
    arm + topic for arm in ARMS for topic in CRTK_HEARS}
DAEMON_SERVICES = {"/start_hazard", "/inject_hazard", "/stop_hazard", "/pause", "/engage", "/disengage", "/plan", "/planning_mode", "/execute_plan",
                   "/cancel_plan", "/emergency_stop", "/begin_simulation", "/end_simulation", "/begin_trial", "/end_trial",
                   "/discard_trial", "/repeat_trial", "/begin_replay", "/end_replay", "/clear_stop", "/set_view",
                   "/set_camera_pedal", "/start_exercise", "/gold/tool_change", "/green/tool_change",
                   "/gold/set_collisions", "/green/set_collisions", "/raven2_simulator/get_loggers", "/raven2_simulator/set_logger_level"} | {
    arm + service for arm in ARMS for service in CRTK_SERVICES}

# A late subscriber to latched messages. Prints when each message arrived, and its content.
LATECOMER = """
import json, threading, time
import rospy
from raven2_trainer.msg import SessionConfiguration
from tf2_msgs.msg import TFMessage
rospy.init_node("latecomer", anonymous=True, disable_signals=True)
begin, told, complete = time.monotonic(), {}, threading.Event()
def take(name, what):
    told.setdefault(name, [time.monotonic() - begin, what])
    if len(told) == 2:
        complete.set()
rospy.Subscriber("/session/configuration", SessionConfiguration,
                 lambda m: take("configuration", [[f.path, f.fnv1a] for f in m.files]))
rospy.Subscriber("/tf_static", TFMessage, lambda m: take("frames", [t.child_frame_id for t in m.transforms]))
complete.wait(10)
print(json.dumps(told))
"""


# Prints the number of messages of /ravenstate in 8 s, and the milliseconds from the first stamp to the last. The robot
# sends one message a millisecond.
READER = """
import struct
import time
import rospy
stamps = []
def take(message):
    seconds, nanoseconds = struct.unpack("<II", message._buff[4:12])
    stamps.append(seconds * 1000 + nanoseconds // 1000000)
rospy.init_node("reader", anonymous=True, disable_signals=True)
rospy.Subscriber("/ravenstate", rospy.AnyMsg, take)
end = time.monotonic() + 15
while not stamps and time.monotonic() < end:
    time.sleep(0.01)
time.sleep(8)
print(len(stamps), stamps[-1] - stamps[0] if stamps else 0)
"""


class Session:
    """Robot, its bridge and the daemon, with a surgeon that moves. The master need not run yet."""

    def __init__(self, master):
        self.stack, self.beside = Stack(), Stack()
        for each in (self.stack, self.beside):
            each.environment["ROS_MASTER_URI"] = master.uri
            for name in ("ROS_IP", "ROS_HOSTNAME"):
                each.environment.pop(name, None)
        self.surgeon = self.robot = None

    def __enter__(self):
        try:
            self._begin()
        except BaseException:
            self.__exit__()
            raise
        return self

    def _begin(self):
        self.stack.start_robot()
        self.beside.start("raven_state_bridge")
        self.stack.start_daemon("--hazard", "none")
        self.surgeon = Surgeon(self.stack)
        wait_until(self.surgeon.read_forces, 20, "the daemon runs")
        self.robot = LatestState(self.stack.state_port)
        wait_until(lambda: self.robot.runlevel() == PEDAL_UP, 20, "homed")
        self.surgeon.press(lambda: self.robot.runlevel() == PEDAL_DOWN)

    def __exit__(self, *_):
        if self.surgeon:
            self.surgeon.close()
        self.stack.__exit__()
        self.beside.__exit__()


def known(master):
    lists = master.ask("getSystemState")
    return {node: master.known_of(node, lists) for node in NODES}


def is_complete(seen):
    daemon, robot, bridge = (seen[node] for node in NODES)
    return (daemon["published"] == DAEMON_TOPICS and daemon["services"] == DAEMON_SERVICES and
            daemon["subscribed"] == DAEMON_HEARS and
            robot["published"] == {"/ravenstate", "/joint_states"} and robot["subscribed"] == {"/raven_automove"} and
            "/virtual_raven/press_start" in robot["services"] and bridge["subscribed"] == {"/ravenstate"})


def seconds_until_complete(master):
    begin = master.start()
    wait_until(lambda: is_complete(known(master)), 10, "all topics and services of all three nodes")
    return time.monotonic() - begin


def files_of(meta):
    return [[entry["path"], entry["fnv1a"]] for entry in meta["config_files"] + [meta["robot_urdf"], meta["scene_urdf"]]]


def seconds_of_latecomer(master, meta):
    """Seconds until a new subscriber has the messages latched at the start: the configuration, as in meta.json, and the
    frames with the arms' bases."""
    done = master.run(sys.executable, "-c", LATECOMER, seconds=40)
    told = json.loads(done.stdout)
    assert set(told) == {"configuration", "frames"}, (told, done.stderr)
    assert told["configuration"][1] == files_of(meta)
    assert {f"{which}/base_link_{side}" for which in ("model", "robot") for side in "LR"} <= set(told["frames"][1])
    return max(when for when, _ in told.values())


def test_a_master_may_come_late_and_go_and_come_back(tmp_path):
    cycles = effort(2, 10)
    with RosMaster(str(tmp_path)) as master, Session(master) as session:
        came = seconds_until_complete(master)
        latched = [seconds_of_latecomer(master, session.stack.meta())]
        returns = []
        for _ in range(cycles):
            master.kill()
            time.sleep(0.6)  # the programs notice the loss
            returns.append(seconds_until_complete(master))
        latched.append(seconds_of_latecomer(master, session.stack.meta()))
        print("  what is latched, for late subscribers:", " ".join(f"{t:.2f} s" for t in latched))
        assert max(latched) < WITHIN, latched
        print(f"  topics after the master came: {came:.2f} s; after it came back:", " ".join(f"{t:.2f}" for t in returns))
        assert came < WITHIN and max(returns) < WITHIN, (came, returns)
        bridged = LatestState(session.beside.state_port)
        wait_until(lambda: bridged.state, 5, "the bridge has states")
        session.surgeon.pedal = False
        # Services answer, and the bridge receives from a publisher that starts after the master's restart.
        answer = master.run("rosservice", "call", "/virtual_raven/press_start")
        assert "success: True" in answer.stdout, answer
        bridged.close()
        assert session.stack.stop("virtual_raven")[0] == 0
        session.stack.start_robot()
        again = LatestState(session.beside.state_port)
        wait_until(lambda: again.state, 10, "the robot that came back is subscribed to")
        again.close()
        assert session.stack.stop("simulator")[0] == 0
        session.stack.assert_counters_add_up()
        print("  on time:", session.stack.metrics()["on_time_ratio"])
        assert session.stack.metrics()["packets"]["master_to_daemon"]["applied"] > 1000


def test_a_slow_master_costs_no_message_and_is_not_gone(tmp_path):
    """The master takes a second for each call, as over a bad link or on a computer that swaps."""
    with RosMaster(str(tmp_path)) as master, SlowMaster(master, 1.0, always=True) as slow, Stack() as stack:
        master.start()
        stack.environment["ROS_MASTER_URI"] = slow.uri
        for name in ("ROS_IP", "ROS_HOSTNAME"):
            stack.environment.pop(name, None)
        stack.start_robot()
        wait_until(lambda: "registered" in stack.log_text("virtual_raven"), 60, "the robot has registered")
        got, sent = map(int, master.run(sys.executable, "-c", READER, seconds=60).stdout.split())
        print(f"  {got} of {sent} messages of /ravenstate with a master that takes a second for a call")
        assert sent > 4000 and got > 0.97 * sent, "a new subscription would lose a second of messages"
        said = stack.log_text("virtual_raven")
        assert "gone" not in said and "again" not in said, said


def run_daemon(stack, *arguments):
    """Starts a daemon and stops it when its session has begun, unless it refuses. Returns its exit code."""
    process = stack.start_daemon("--hazard", "none", *arguments)
    wait_until(lambda: os.path.exists(os.path.join(stack.output, "meta.json")) or process.poll() is not None, 30,
               "it runs or refuses")
    return stack.stop("simulator")[0]


def overridden(stack):
    return [entry["name"] for entry in stack.meta()["config_files"] if entry.get("overridden")]


def test_parameters_override_the_configuration(tmp_path):
    """One parameter is set by an argument, one on the master, as by a launch file. The session keeps both values."""
    with RosMaster(str(tmp_path)) as master, Stack() as stack:
        master.start()
        stack.environment.update(ROS_MASTER_URI=master.uri, ROS_IP="127.0.0.1")
        master.ask("setParam", "/raven2_simulator/haptics/passivity/enabled", False)
        assert run_daemon(stack, "_haptics/tolerance:=0.005") == 0, stack.log_text("simulator")
        assert overridden(stack) == ["haptics.yaml"]
        copies = [os.path.join(folder, "haptics.yaml") for folder, _, files in os.walk(stack.output)
                  if "haptics.yaml" in files]
        with open(copies[0], encoding="utf-8") as file:
            kept = yaml.safe_load(file)
        assert (len(copies), kept["tolerance"], kept["passivity"]["enabled"]) == (1, 0.005, False)
        assert "ROS parameter /raven2_simulator/haptics/tolerance overrides" in stack.log_text("simulator")


def test_parameters_are_held_to_the_files_ranges_and_keys(tmp_path):
    with RosMaster(str(tmp_path)) as master:
        master.start()
        for key, value, why in (("haptics/tolerance", 0.06, "tolerance is 0.06, expected [0, 0.05]"),
                                ("haptics/tolernace", 0.001, "unknown key tolernace"),
                                ("runtime/enable_remote_control", True, "in the configuration's files alone")):
            with Stack() as stack:
                stack.environment.update(ROS_MASTER_URI=master.uri, ROS_IP="127.0.0.1")
                master.ask("setParam", "/raven2_simulator/" + key, value)
                assert run_daemon(stack) == 1
                said = stack.log_text("simulator").splitlines()[-1]
                assert f"ROS parameter /raven2_simulator/{key}: " in said and why in said, said
                assert not os.path.exists(stack.output), "the session must not begin"
                master.ask("deleteParam", "/raven2_simulator/" + key)


def test_without_a_master_no_parameter_overrides_and_who_asks_is_told():
    with Stack() as stack:  # no master listens at its master's address
        assert run_daemon(stack, "_haptics/tolerance:=0.005") == 0
        assert overridden(stack) == []
        assert stack.log_text("simulator").count("no parameter overrides the configuration") == 1


def stalled_subscribers(master, topics):
    """Starts subscribers that connect, and stops them, so that they read nothing."""
    echoes = [master.popen("rostopic", "echo", topic) for topic in topics]
    wait_until(lambda: all(has_reader(master, topic) for topic in topics), 30, "they subscribe")
    time.sleep(0.5)
    for echo in echoes:
        echo.send_signal(signal.SIGSTOP)
    return echoes


def mute_subscriber(master, node, topic):
    """Connects as a subscriber does (ROS/TCPROS), but never reads."""
    with master.slave(node) as slave:
        code, words, (_, host, port) = slave.requestTopic("/mute", topic, [["TCPROS"]])
    assert code == 1, words
    connection = socket.create_connection((host, port))
    fields = [f"{key}={value}".encode() for key, value in
              (("callerid", "/mute"), ("topic", topic), ("type", "*"), ("md5sum", "*"))]
    head = b"".join(struct.pack("<I", len(field)) + field for field in fields)
    connection.sendall(struct.pack("<I", len(head)) + head)
    assert len(connection.recv(64)) > 4, "the node accepts the subscriber"
    return connection


def has_reader(master, topic):
    return any(name == topic and any("rostopic" in node for node in nodes)
               for name, nodes in master.ask("getSystemState")[1])


def measured(master, topics, seconds):
    """(on-time ratios of the daemon's loops, greatest growth of memory [MiB], cycles of the robot a second)."""
    with Session(master) as session:
        wait_until(lambda: is_complete(dict(known(master), **{NODES[2]: {"subscribed": {"/ravenstate"}}})), 20, "topics")
        echoes = stalled_subscribers(master, topics)
        mute = mute_subscriber(master, "/virtual_raven", "/ravenstate") if topics else None
        try:
            pids = [session.stack.processes[name].pid for name in ("simulator", "virtual_raven")]
            time.sleep(1)  # until the kernel's buffers and the queues are full
            before = [resident_mib(pid) for pid in pids]
            first = session.robot.state
            time.sleep(seconds)
            last = session.robot.state
            growth = max(resident_mib(pid) - old for pid, old in zip(pids, before))
            assert session.stack.stop("simulator")[0] == 0, "a stalled subscriber must not delay the end"
        finally:
            if mute:
                mute.close()
            for echo in echoes:
                echo.kill()
                echo.wait()
        rate = (last["cycle"] - first["cycle"]) / (last["time_ns"] - first["time_ns"]) * 1e9
        return session.stack.metrics()["on_time_ratio"], growth, rate


def test_a_stalled_subscriber_costs_no_memory_and_no_cycle(tmp_path):
    seconds = effort(2, 60)
    with RosMaster(str(tmp_path)) as master:
        master.start()
        stalled = ["/joint_states", "/model/joint_states", "/tf"]  # and /ravenstate by a bare socket
        for topics in effort([stalled], [[], stalled]):
            on_time, growth, rate = measured(master, topics, seconds)
            print(f"  {len(topics)} stalled subscribers: on time {on_time}, {growth:+.1f} MiB in {seconds} s, "
                  f"{rate:.1f} cycles a second")
            # Only the log and the queues of 10 to 100 messages may grow. A second of /ravenstate alone is 1 MB.
            assert growth < 16
            assert rate > 950, "the robot's cycles go on"
