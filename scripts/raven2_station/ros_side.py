"""The station's link to ROS: a process that ends with the ROS master. Started by the server with a socket as its standard input.

It sends the server what the daemon publishes, as messages of wire.py, and does what the server asks: calls services, publishes the
browser's hands, and offers the station's own services, whose answers the server gives.
"""

import os
import queue
import socket
import sys
import threading
import time
import xmlrpc.client

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped, WrenchStamped
from sensor_msgs.msg import CompressedImage, JointState, Joy
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse
from tf2_msgs.msg import TFMessage

from raven2_trainer.msg import ExerciseEventStamped, ExerciseProgress, PlanningProgress, SessionConfiguration, TrainerMode
from raven2_trainer.srv import (BeginReplay, CancelPlan, ExecutePlan, PlanPath, RepeatTrial, StartHazard, StartSession,
                                StartSessionResponse)

from . import frames, priority, wire

STRIP_PERIOD = 0.04    # [s] of tip error and force: 25 Hz
AXES_PERIOD = 1.0      # [s] of the picture's axes while they stay, for a session that starts
MASTER_PERIOD = 0.5    # [s] between questions to the ROS master
MASTER_PATIENCE = 1.0  # [s] for its answer
LONGEST_CALL = 60.0    # [s] the next session: the end of one and the start of another
TAKEN_PERIOD = 0.2     # [s] between looks whether another station has gone
PEDAL_GAP = 0.08       # [s] below silent_after of config/masters/browser.yaml
CAMERA_BUTTON = 4      # of `pedals`: config/network.yaml, joy
FORCES_SILENT = 0.3  # [s] without a force: the strips end
SIDES = {"gold": "L", "green": "R"}
POSES = {"gold": "/browser/left/measured_cp", "green": "/browser/right/measured_cp"}
JAWS = {"gold": "/browser/left/jaw/measured_js", "green": "/browser/right/jaw/measured_js"}
PREFIX = "raven2_trainer: "

SERVICES = {
    **dict.fromkeys(("end_replay", "stop_hazard", "pause", "emergency_stop", "clear_stop", "engage", "disengage", "begin_simulation",
                     "end_simulation", "begin_trial", "end_trial", "discard_trial", "start_exercise", "virtual_raven/press_start"),
                    Trigger),
    "begin_replay": BeginReplay, "inject_hazard": StartHazard, "set_view": SetBool, "plan": PlanPath, "execute_plan": ExecutePlan,
    "cancel_plan": CancelPlan, "repeat_trial": RepeatTrial}


class _Patient(xmlrpc.client.Transport):
    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = MASTER_PATIENCE
        return connection


NAME = rosgraph.names.make_caller_id("station")


def _master():
    return xmlrpc.client.ServerProxy(os.environ.get("ROS_MASTER_URI", "http://localhost:11311"), transport=_Patient())


def master_pid():
    """Process of the ROS master, or None: it does not answer."""
    try:
        code, _, pid = _master().getPid(NAME)
        return pid if code == 1 else None
    except (OSError, xmlrpc.client.Error, xmlrpc.client.ProtocolError):
        return None


def another_station():
    """Whether a living node has our name. ROS would end it, and it would come back and end us."""
    try:
        code, _, uri = _master().lookupNode(NAME, NAME)
        return code == 1 and xmlrpc.client.ServerProxy(uri, transport=_Patient()).getPid(NAME)[0] == 1
    except (OSError, xmlrpc.client.Error, xmlrpc.client.ProtocolError):
        return False


class Link:
    """To the server: send() from any thread; what cannot be sent at once waits, pictures are dropped instead."""

    MOST_WAITING = 64

    def __init__(self, connection):
        self._connection = connection
        self._waiting = queue.Queue()
        threading.Thread(target=self._write, daemon=True).start()

    def send(self, message, data=b"", may_drop=False):
        if may_drop and self._waiting.qsize() > self.MOST_WAITING:
            return
        self._waiting.put(wire.encode(message, data))

    def _write(self):
        while True:
            try:
                self._connection.sendall(self._waiting.get())
            except OSError:
                os._exit(0)  # the server is gone


class Daemon:
    """Hears what the daemon publishes."""

    def __init__(self, link):
        self._link = link
        self._frames = frames.Frames()
        self._lock = threading.Lock()
        self._force = {"gold": 0.0, "green": 0.0}
        self._push = {"gold": [0.0, 0.0, 0.0], "green": [0.0, 0.0, 0.0]}
        self._last_tick = None
        self._axes, self._axes_sent = None, 0.0  # of the picture, as the pages have them
        rospy.Subscriber("mode", TrainerMode, self._mode)
        rospy.Subscriber("exercise/state", ExerciseProgress, self._exercise)
        rospy.Subscriber("exercise/events", ExerciseEventStamped, self._event)
        rospy.Subscriber("plan/progress", PlanningProgress, self._plan)
        rospy.Subscriber("session/configuration", SessionConfiguration, self._session)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._diagnostics)
        rospy.Subscriber("/tf", TFMessage, self._transforms)
        rospy.Subscriber("/tf_static", TFMessage, self._transforms)
        for arm in SIDES:
            rospy.Subscriber(f"haptic/{arm}/force", WrenchStamped, self._wrench, callback_args=arm)
        self._hear_pictures("view/image_raw/compressed", "view")
        self._wants_second, self._second = False, None
        self._second_lock = threading.Lock()

    def _hear_pictures(self, topic, which):
        return rospy.Subscriber(topic, CompressedImage, self._picture, callback_args=which, queue_size=1, buff_size=1 << 22)

    def want_second(self, wanted):
        """In another thread: a slow master must not delay the hands."""
        self._wants_second = wanted
        threading.Thread(target=self._follow_second, daemon=True).start()

    def _follow_second(self):
        with self._second_lock:
            if self._wants_second and self._second is None:
                self._second = self._hear_pictures("camera/second/image_raw/compressed", "second")
            elif not self._wants_second and self._second is not None:
                self._second.unregister()
                self._second = None

    def strips(self):
        with self._lock:
            apart = {arm: self._frames.apart(side) for arm, side in SIDES.items()}
            force, push, last = dict(self._force), dict(self._push), self._last_tick
        if last is not None and time.monotonic() - last < FORCES_SILENT:
            self._link.send({"t": "strips", "apart": apart, "force": force, "push": push}, may_drop=True)

    def _mode(self, m):
        self._link.send({"t": "mode", "mode": m.mode, "pedal": m.pedal, "engaged": m.engaged, "linked": m.linked, "view": m.view,
                         "trial_time": m.trial_time})

    def _exercise(self, m):
        self._link.send({"t": "exercise", "exercise": m.exercise, "title": m.title, "status": m.status, "failure": m.failure,
                         "attempt": m.attempt, "step": m.step, "steps": m.steps, "tracks": list(m.tracks), "done": list(m.done),
                         "current": list(m.current), "mistakes": dict(zip(m.mistakes, m.mistake_counts)),
                         "elapsed": m.elapsed, "time_limit": m.time_limit, "progress": m.progress})

    def _event(self, m):
        self._link.send({"t": "event", "event": m.event, "mistake": m.mistake, "arm": m.arm, "step": m.step, "force": m.force})

    def _plan(self, m):
        self._link.send({"t": "plan", "status": m.status, "arm": m.arm, "progress": m.progress})

    def _session(self, m):
        self._link.send({"t": "session", "directory": m.directory, "exercise": m.exercise, "drill": m.drill, "hazard": m.hazard})

    def _diagnostics(self, m):
        ours = [s for s in m.status if s.name.startswith(PREFIX)]
        if ours:
            self._link.send({"t": "diagnostics", "status": [[s.name[len(PREFIX):], int(s.level), s.message] for s in ours]})

    def _transforms(self, m):
        with self._lock:
            for each in m.transforms:
                t, r = each.transform.translation, each.transform.rotation
                self._frames.put(each.child_frame_id, each.header.frame_id, [t.x, t.y, t.z], [r.x, r.y, r.z, r.w],
                                 each.header.stamp)

    def _wrench(self, m, arm):
        f = m.wrench.force
        with self._lock:
            self._force[arm] = (f.x * f.x + f.y * f.y + f.z * f.z) ** 0.5
            self._push[arm] = [f.x, f.y, f.z]
            self._last_tick = time.monotonic()

    def _picture(self, m, which):
        if which == "view":
            self._show_axes(m.header.frame_id)
        self._link.send({"t": "picture", "which": which, "stamp": m.header.stamp.to_sec()}, m.data, may_drop=True)

    def _show_axes(self, frame):
        """Directions of the picture, along which the mouse moves the tool."""
        with self._lock:
            axes = self._frames.view(frame)
        now = time.monotonic()
        if axes != self._axes or now - self._axes_sent >= AXES_PERIOD:
            self._axes, self._axes_sent = axes, now
            self._link.send({"t": "axes", "axes": axes})


class BrowserHands:
    """Publishes the browser's hands as a hand device (config/masters/browser.yaml) while a page drives."""

    def __init__(self):
        self._poses = {arm: rospy.Publisher(name, PoseStamped, queue_size=4) for arm, name in POSES.items()}
        self._jaws = {arm: rospy.Publisher(name, JointState, queue_size=4) for arm, name in JAWS.items()}
        self._pedal = rospy.Publisher("/browser/pedal", Joy, queue_size=4)
        self._pedals = rospy.Publisher("pedals", Joy, queue_size=4)
        self._camera = False
        self._published = None  # [s] monotonic

    def _holds(self, held):
        """After a gap the console waits for a pedal-up message. A key that is still held then counts as pressed again."""
        now = time.monotonic()
        had_gap = self._published is not None and now - self._published > PEDAL_GAP
        self._published = now
        return held and not had_gap

    def publish(self, message):
        now = rospy.Time.now()
        for arm, hand in message["arms"].items():
            pose = PoseStamped()
            pose.header.stamp = now
            pose.header.frame_id = "browser"
            p, q = pose.pose.position, pose.pose.orientation
            p.x, p.y, p.z = hand["p"]
            q.x, q.y, q.z, q.w = hand["q"]
            self._poses[arm].publish(pose)
            jaw = JointState(name=["jaw"], position=[hand["jaw"]])
            jaw.header.stamp = now
            self._jaws[arm].publish(jaw)
        pedal = Joy(buttons=[int(self._holds(message["pedal"]))])
        pedal.header.stamp = now
        self._pedal.publish(pedal)
        camera = bool(message["camera"]) and self._pedal.get_num_connections() > 0  # other masters have a camera pedal of their own
        if camera or self._camera:  # repeated while held; one release
            joy = Joy(buttons=[0] * CAMERA_BUTTON + [int(camera)])
            joy.header.stamp = now
            self._pedals.publish(joy)
        self._camera = camera


def failure_of(error):
    is_away = isinstance(error, rospy.ROSException) or "service [" in str(error) or "unable to connect" in str(error)
    return "the trainer is not running" if is_away else str(error)


def call(name, arguments):
    """@return (whether it happened, a sentence, the other fields)."""
    kind = SERVICES[name]
    try:
        answer = rospy.ServiceProxy(name, kind)(**arguments)
    except (rospy.ROSException, rospy.ServiceException, TypeError, ValueError) as error:
        return False, failure_of(error), {}
    text = getattr(answer, "message", None) or getattr(answer, "status", "")
    more = {key: getattr(answer, key) for key in ("plan", "arm", "cost", "robot_follows", "was") if hasattr(answer, key)}
    return bool(answer.success), str(text), more


class Side:
    def __init__(self, connection):
        self._connection = connection
        self._link = Link(connection)
        self._answers = {}
        self._lock = threading.Lock()
        self._number = 0
        self._hands = self._daemon = None

    def run(self):
        while another_station():
            self._link.send({"t": "taken"})
            time.sleep(TAKEN_PERIOD)
        rospy.init_node("station", disable_signals=True, log_level=rospy.WARN)
        self._daemon = daemon = Daemon(self._link)
        self._hands = BrowserHands()
        self._status = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=4)
        services = [rospy.Service("station/start_session", StartSession, self._start),
                    rospy.Service("station/end_session", Trigger, lambda _: self._trigger("end")),
                    rospy.Service("station/next_session", Trigger, lambda _: self._trigger("next")),
                    rospy.Service("station/take_hands", SetBool, self._take_hands)]
        threading.Thread(target=self._read, daemon=True).start()
        self._link.send({"t": "up"})
        self._tick(daemon)
        for service in services:
            service.shutdown()

    def _tick(self, daemon):
        """Until the master is gone, or another one, or another node has taken our name."""
        looked, missed, master = time.monotonic(), 0, None
        while True:
            time.sleep(STRIP_PERIOD)
            daemon.strips()
            if time.monotonic() - looked < MASTER_PERIOD:
                continue
            pid = master_pid()
            master = master or pid
            missed = 0 if pid else missed + 1
            looked = time.monotonic()
            if missed >= 2 or pid not in (None, master) or rospy.is_shutdown():
                return
            self._link.send({"t": "alive"})

    def _read(self):
        reader = wire.Reader()
        while True:
            try:
                data = self._connection.recv(1 << 16)
            except OSError:
                data = b""
            if not data:
                os._exit(0)  # the server is gone
            for message, _ in reader.feed(data):
                self._do(message)

    def _do(self, message):
        kind = message["t"]
        if kind == "hands":
            self._hands.publish(message)
        elif kind == "pictures":
            self._daemon.want_second(bool(message["second"]))
        elif kind == "call":
            threading.Thread(target=self._call, args=(message,), daemon=True).start()
        elif kind == "answer":
            with self._lock:
                waiting = self._answers.pop(message["number"], None)
            if waiting is not None:
                waiting.put(message)
        elif kind == "status":
            self._publish_status(message)

    def _call(self, message):
        done, text, more = call(message["service"], message.get("arguments", {}))
        self._link.send({"t": "called", "number": message["number"], "ok": done, "text": text, "more": more})

    def _publish_status(self, message):
        array = DiagnosticArray()
        array.header.stamp = rospy.Time.now()
        array.status = [DiagnosticStatus(name="raven2_station: pages", level=message["level"], message=message["text"],
                                         values=[KeyValue(key=k, value=str(v)) for k, v in message["values"].items()])]
        self._status.publish(array)

    def _ask(self, message):
        """A question to the server. @return (whether it did it, a sentence, the answer)."""
        waiting = queue.Queue()
        with self._lock:
            self._number += 1
            number = self._number
            self._answers[number] = waiting
        self._link.send({**message, "number": number})
        try:
            answer = waiting.get(timeout=LONGEST_CALL)
        except queue.Empty:
            return False, "the station did not answer", {}
        return answer["ok"], answer["text"], answer

    def _start(self, request):
        fields = ("trainee", "curriculum", "exercise", "hazard", "when", "link", "driver", "seed")
        done, text, answer = self._ask({"t": "asked", "do": "start", "with": {f: getattr(request, f) for f in fields}})
        return StartSessionResponse(success=done, message=text, session=answer.get("session", ""))

    def _trigger(self, what):
        done, text, _ = self._ask({"t": "asked", "do": what, "with": {}})
        return TriggerResponse(success=done, message=text)

    def _take_hands(self, request):
        done, text, _ = self._ask({"t": "asked", "do": "take-hands", "with": {"away": request.data}})
        return SetBoolResponse(success=done, message=text)


def main():
    connection = socket.socket(fileno=os.dup(0))
    if master_pid() is None:
        sys.exit(3)  # no ROS master: the server tries again
    priority.come_first(children_too=True)  # if it is refused, the server has said so
    Side(connection).run()
    os._exit(0)


if __name__ == "__main__":
    main()
