"""Shared by the tests of planning and executing: a console that notes when it sends a release, and daemon clients."""
import threading
import time

import rospy
from raven2_trainer.msg import PlanExecution, PlanningProgress
from raven2_trainer.srv import CancelPlan, ExecutePlan, PlanningMode, PlanPath
from robot_frames import Master
from sensor_msgs.msg import JointState

ARM = ["shoulder_L", "elbow_L", "insertion_L", "tool_roll_L", "wrist_joint_L", "grasper_joint_1_L", "grasper_joint_2_L"]
SUCCESS, PREEMPTED = 1, -7  # moveit_msgs/MoveItErrorCodes


class Console(threading.Thread):
    """Sends a packet about every millisecond. The test sets pedal and step."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.pedal, self.step_um, self.green_um = 0, (0, 0, 0), (0, 0, 0)
        self.released_ns = 0  # CLOCK_MONOTONIC before the first packet with the released pedal
        self._master = Master(port)

    def run(self):
        before = 0
        while True:
            pedal, step, green = self.pedal, self.step_um, self.green_um
            if before and not pedal:
                self.released_ns = time.monotonic_ns()
            before = pedal
            self._master.send(pedal, step, green)
            time.sleep(0.001)

    def play(self, packets):
        """Waits until so many more packets were sent: motion counts packets, and their rate depends on the machine."""
        last = self._master.sequence + packets
        until(lambda: self._master.sequence >= last, 60, f"{packets} packets")

    def release(self):
        """Releases the pedal. Returns when that was sent [ns]."""
        before = self.released_ns
        self.pedal = 0
        until(lambda: self.released_ns != before, 5, "the console sends")
        return self.released_ns


class Newest:
    """The messages of a topic."""

    def __init__(self, topic, kind):
        self.messages = []
        self._subscriber = rospy.Subscriber(topic, kind, self.messages.append)

    @property
    def message(self):
        return self.messages[-1] if self.messages else None


def until(condition, seconds, words):
    """Polls. @return what `condition` gave, once it is true."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        found = condition()
        if found:
            return found
        time.sleep(0.002)
    raise AssertionError(f"not within {seconds} s: {words}")


class Daemon:
    """The daemon as its clients see it."""

    def __init__(self):
        self.progress = Newest("plan/progress", PlanningProgress)
        self.executions = Newest("plan/execution", PlanExecution)
        self.model = Newest("model/joint_states", JointState)
        self.robot = Newest("robot/joint_states", JointState)
        for name in ("plan", "planning_mode", "execute_plan", "cancel_plan"):
            rospy.wait_for_service(name, 30)
        self.plan = rospy.ServiceProxy("plan", PlanPath)
        self.planning_mode = rospy.ServiceProxy("planning_mode", PlanningMode)
        self.execute_plan = rospy.ServiceProxy("execute_plan", ExecutePlan)
        # Persistent: without a look-up at the master and a new connection at each call, only our answer is timed.
        self.cancel_plan = rospy.ServiceProxy("cancel_plan", CancelPlan, persistent=True)

    def status(self):
        return self.progress.message.status if self.progress.message else None

    def await_status(self, status, seconds=5):
        until(lambda: self.status() == status, seconds, f"status {status}")

    def await_execution(self, number, seconds=60):
        """The report of the execution with this number."""
        return until(lambda: next((m for m in self.executions.messages if m.execution == number), None), seconds,
                     f"the report of execution {number}")

    @staticmethod
    def joints(source):
        """The gold arm's seven joints, by name."""
        at = dict(zip(source.message.name, source.message.position))
        return [at[name] for name in ARM]


def plan_to(joints):
    """Fields of a plan's goal for the gold arm, for the action and for the service."""
    return {"arm": "gold", "default_goal": False, "goal": [0.0, 0.0, 0.0], "joints": list(joints)}
