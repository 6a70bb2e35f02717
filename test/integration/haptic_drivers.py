"""Simulated drivers of haptic devices. They publish and subscribe as the real drivers do, with the messages of the real
drivers' packages, made by genpy from those packages' texts."""
import math
import threading

import genpy.dynamic
import rospy
from geometry_msgs.msg import Pose, PoseStamped, Vector3, WrenchStamped
from sensor_msgs.msg import JointState, Joy
from std_msgs.msg import Bool, Header

RULE = "\n" + 80 * "=" + "\n"


def message(name, text, *parts):
    """Class of a message, from its text and the classes of its parts."""
    whole = text + "".join(f"{RULE}MSG: {part._type}\n{part._full_text}" for part in parts)
    return genpy.dynamic.generate_dynamic(name, whole)[name]


# github.com/bharatm11/Geomagic_Touch_ROS_Drivers, omni_msgs/msg
OmniState = message("omni_msgs/OmniState", """std_msgs/Header         header
bool                    locked
bool                    close_gripper
geometry_msgs/Pose      pose        # meters
geometry_msgs/Vector3   current     # Amperes
geometry_msgs/Vector3   velocity    # meters/s
""", Header, Pose, Vector3)
OmniButtonEvent = message("omni_msgs/OmniButtonEvent", "int32 grey_button\nint32 white_button\n")
OmniFeedback = message("omni_msgs/OmniFeedback",
                       "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 position\n", Vector3)
# github.com/WPI-AIM/ros_geomagic, geomagic_control/msg
DeviceButtonEvent = message("geomagic_control/DeviceButtonEvent", "int32 grey_button\nint32 white_button\n")
DeviceFeedback = message("geomagic_control/DeviceFeedback",
                         "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 position\nbool[] lock\n", Vector3)
# github.com/collaborative-robotics/crtk_msgs, msg
OperatingState = message("crtk_msgs/OperatingState",
                         "Header header\nstring state\nbool is_homed\nbool is_busy\n", Header)


class Driver:
    """A device at `position` [m, its own axes], published at about 250 Hz; `trembles` while nobody measures."""

    def __init__(self):
        self.position = [0.0, 0.0, 0.0]
        self.trembles = True
        self.listener, self.others = None, []
        self.is_held = False  # by the device's own controller, until the first force
        self.force = None  # [N] newest that the driver received
        self.forces = 0
        self._ticks = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self):
        self._thread.start()
        return self

    def _run(self):
        while not self._stop.wait(0.004):
            self._ticks += 1
            shake = 0.0005 * math.sin(0.2 * self._ticks) if self.trembles else 0.0
            self.publish([self.position[0] + shake, self.position[1], self.position[2]])

    def move(self, axis, way, seconds=0.3):
        """Moves the device by `way` [m] along one of its axes."""
        start, steps = self.position[axis], int(seconds / 0.01)
        for step in range(1, steps + 1):
            self.position[axis] = start + way * step / steps
            rospy.sleep(0.01)

    def take(self, force):
        self.force = (force.x, force.y, force.z)
        self.forces += 1

    def close(self):
        self._stop.set()
        self._thread.join()
        for subscription in filter(None, [self.listener, *self.others]):  # all tests are one node
            subscription.unregister()


class Omni(Driver):
    """phantom_omni and its like: millimetres, x right, y forward, z up; buttons on change."""

    def __init__(self, name):
        super().__init__()
        self._state = rospy.Publisher(f"/{name}/state", OmniState, queue_size=1)
        self._buttons = rospy.Publisher(f"/{name}/button", OmniButtonEvent, queue_size=100)
        self.held_at = None  # [m] where a device that locks would be held
        self.listener = rospy.Subscriber(f"/{name}/force_feedback", OmniFeedback, self.feel)

    def feel(self, feedback):
        self.held_at = tuple(1e-3 * v for v in (feedback.position.x, feedback.position.y, feedback.position.z))
        self.take(feedback.force)

    def publish(self, p):
        state = OmniState()
        state.header.stamp = rospy.Time.now()
        state.pose.position.x, state.pose.position.y, state.pose.position.z = (1000 * v for v in p)
        state.pose.orientation.w = 1.0
        self._state.publish(state)

    def press(self, grey, white=0):
        self._buttons.publish(OmniButtonEvent(grey, white))


class Geomagic(Driver):
    """WPI's driver: millimetres, x right, y up, z to the user; always reads three locks of a feedback."""

    def __init__(self):
        super().__init__()
        self._pose = rospy.Publisher("/Geomagic/pose", PoseStamped, queue_size=1)
        self._buttons = rospy.Publisher("/Geomagic/button", DeviceButtonEvent, queue_size=100)
        self.listener = rospy.Subscriber("/Geomagic/force_feedback", DeviceFeedback, self.feel)

    def feel(self, feedback):
        assert [feedback.lock[i] for i in range(3)] == [False, False, False]
        self.take(feedback.force)

    def publish(self, p):
        pose = PoseStamped()
        pose.header.frame_id, pose.header.stamp = "world", rospy.Time.now()
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = (1000 * v for v in p)
        pose.pose.orientation.w = 1.0
        self._pose.publish(pose)

    def press(self, grey, white=0):
        self._buttons.publish(DeviceButtonEvent(grey, white))


class Crtk(Driver):
    """sawSensablePhantom or an MTM: metres; `force` and `absolute` are the topics' names."""

    def __init__(self, name, force="servo_cf", absolute=None):
        super().__init__()
        self.is_held = True
        self._name = name
        self._pose = rospy.Publisher(f"/{name}/measured_cp", PoseStamped, queue_size=1)
        self._gripper = rospy.Publisher(f"/{name}/gripper/measured_js", JointState, queue_size=1)
        self._state = rospy.Publisher(f"/{name}/operating_state", OperatingState, queue_size=10, latch=True)
        self._buttons = [rospy.Publisher(f"/{name}/button{n}", Joy, queue_size=10) for n in (1, 2)]
        self.listener = rospy.Subscriber(f"/{name}/{force}", WrenchStamped, self.feel)
        self.is_absolute, self.is_compensated, self.frame, self.angle = None, None, None, 0.8
        self.others = [rospy.Subscriber(f"/{name}/use_gravity_compensation", Bool, self.compensate)]
        if absolute:
            self.await_absolute(absolute)
        self.enable("ENABLED")

    def await_absolute(self, topic):
        self.others.append(rospy.Subscriber(f"/{self._name}/{topic}", Bool, self.turn_absolute))

    def enable(self, state):
        self._state.publish(OperatingState(Header(stamp=rospy.Time.now()), state, True, False))

    def compensate(self, told):
        self.is_compensated = told.data

    def turn_absolute(self, told):
        self.is_absolute = told.data

    def feel(self, wrench):
        self.frame = wrench.header.frame_id
        self.take(wrench.wrench.force)

    def publish(self, p):
        pose = PoseStamped()
        pose.header.frame_id, pose.header.stamp = self._name + "_base", rospy.Time.now()
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = p
        pose.pose.orientation.w = 1.0
        self._pose.publish(pose)
        self._gripper.publish(JointState(name=["gripper"], position=[self.angle]))

    def press(self, first, second=0):
        for publisher, value in zip(self._buttons, (first, second)):
            publisher.publish(Joy(buttons=[value]))


class Gamepad(Driver):
    """joy_node with autorepeat."""

    def __init__(self):
        super().__init__()
        self.axes, self.buttons = [0.0] * 8, [0] * 12
        self.axes[2] = self.axes[5] = 1.0
        self._joy = rospy.Publisher("/joy", Joy, queue_size=1)

    def publish(self, p):
        self._joy.publish(Joy(axes=list(self.axes), buttons=list(self.buttons)))
