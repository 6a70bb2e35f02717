"""Shared by the tests of training: clients of the daemon's modes and exercises."""
import rospy
from planning_clients import Newest, until
from raven2_trainer.msg import ExerciseEventStamped, ExerciseProgress, TrainerMode
from raven2_trainer.srv import BeginReplay, RepeatTrial
from std_srvs.srv import SetBool, Trigger

TRIGGERS = ("begin_simulation", "end_simulation", "begin_trial", "end_trial", "discard_trial", "emergency_stop", "clear_stop",
            "start_exercise", "gold/tool_change", "green/tool_change", "engage", "disengage", "end_replay")
SWITCHES = ("set_view", "set_camera_pedal")


class Trainer:
    """Modes and exercise as their clients see them. Services by name: trainer.call("begin_trial")."""

    def __init__(self):
        self.modes = Newest("mode", TrainerMode)
        self.progress = Newest("exercise/state", ExerciseProgress)
        self.events = Newest("exercise/events", ExerciseEventStamped)
        rospy.wait_for_service("repeat_trial", 30)
        self.repeat_trial = rospy.ServiceProxy("repeat_trial", RepeatTrial)
        self.begin_replay = rospy.ServiceProxy("begin_replay", BeginReplay)
        self._calls = {name: rospy.ServiceProxy(name, Trigger) for name in TRIGGERS}
        self._calls.update({name: rospy.ServiceProxy(name, SetBool) for name in SWITCHES})

    def call(self, name, *arguments):
        """@return the answer's text: accepted, or the reason why not."""
        answer = self._calls[name](*arguments)
        assert answer.success == (answer.message == "accepted" or name in ("engage", "disengage")), answer
        return answer.message

    @property
    def mode(self):
        return self.modes.message.mode if self.modes.message else None

    def await_mode(self, mode, seconds=5):
        until(lambda: self.mode == mode, seconds, f"mode {mode}")
