"""Hands without hardware: what the driving page sends becomes the poses, buttons and grippers of a hand device.

The page sends increments of both hands, some 60 times a second. Here they add up to positions of a virtual device
(config/masters/browser.yaml); the console makes ITP packets of it like of any other device. Nothing here knows ROS.
"""

import math

SILENT = 0.08     # [s] without a message of the page: the pedal is up. The console waits up to 20 ms more
SPEED = 1.5       # [m/s] of the device; faster motion comes later
TURN_SPEED = 10.0  # [rad/s]
HALF = 2.0        # [m] from the middle: beyond it the device goes back while the pedal is up
BACK_SPEED = 1.0  # [m/s]
LONGEST = 0.1     # [s] that one message may count for, and by which motion may come later; what is more is lost
FOLLOWING = {"teleoperating", "simulating", "trial"}  # modes in which the hands move something with a held pedal
REFUSED = 0.7     # [s] a held pedal that moves nothing so long was refused. The page says so (REFUSED_MS of page/trainee.js)
LINGER = 0.15     # [s] for which the camera pedal stays down behind its key: the other pedal must be up before it
DITHER = 1e-7     # [m] to and fro: the console takes a device whose pose never changes for one that is not calibrated


def _numbers(values, count):
    if not isinstance(values, list) or len(values) != count:
        raise ValueError(f"expected {count} numbers")
    for value in values:
        # The bounds refuse NaN, too, and whole numbers that no float can hold.
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not -1e300 < value < 1e300:
            raise ValueError("a value is not a number of ordinary size")
    return [float(value) for value in values]


def _limited(vector, most):
    size = math.sqrt(sum(v * v for v in vector))
    return vector if size <= most or size == 0.0 else [v * most / size for v in vector]


def _part(waiting, more, speed, dt):
    """@return (what moves now, what waits)."""
    whole = _limited([w + m for w, m in zip(waiting, more)], speed * LONGEST)
    now = _limited(whole, speed * dt)
    return now, [w - n for w, n in zip(whole, now)]


def product(a, b):
    """Of quaternions x, y, z, w."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz]


def turned(rotation):
    """Quaternion of a rotation vector [rad]."""
    angle = math.sqrt(sum(r * r for r in rotation))
    if angle < 1e-12:
        return [0.0, 0.0, 0.0, 1.0]
    return [r / angle * math.sin(angle / 2) for r in rotation] + [math.cos(angle / 2)]


class Hand:
    """One virtual device: x right, y forward, z up, as config/masters/browser.yaml has it."""

    def __init__(self):
        self.position = [0.0, 0.0, 0.0]              # [m]
        self.orientation = [0.0, 0.0, 0.0, 1.0]
        self.jaw = 0.6                               # [rad] 0 closed
        self.stop()

    def stop(self):
        """Motion that has not come yet is lost."""
        self._motion, self._rotation = [0.0] * 3, [0.0] * 3

    def move(self, motion, rotation, dt):
        """Messages of a busy machine arrive in bunches: nothing of them may be lost, and the speed stays what it was."""
        step, self._motion = _part(self._motion, motion, SPEED, dt)
        turn, self._rotation = _part(self._rotation, rotation, TURN_SPEED, dt)
        self.position = [p + s for p, s in zip(self.position, step)]
        q = product(turned(turn), self.orientation)
        size = math.sqrt(sum(v * v for v in q))
        self.orientation = [v / size for v in q]

    def centre(self, dt):
        """Back toward the middle, slowly: only with the pedal up, where nothing follows."""
        distance = math.sqrt(sum(p * p for p in self.position))
        if distance > HALF / 2:
            self.position = [p - p / distance * min(BACK_SPEED * dt, distance) for p in self.position]


class Away:
    """Whether the instructor has taken the hands away from the pages; True also after a station that was killed.
    @param file: is there while they are; None: only this station knows."""

    def __init__(self, file=None):
        self._file = file
        self.is_on = file is not None and file.exists()

    def set(self, is_on):
        self.is_on = is_on
        if self._file is None:
            return
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            if is_on:
                self._file.touch()
            else:
                self._file.unlink(missing_ok=True)
        except OSError:
            pass  # on a full disk, a station that was killed forgets it


class Hands:
    """The device of the page that drives. Times are monotonic seconds."""

    def __init__(self):
        self.arms = {"gold": Hand(), "green": Hand()}
        self.pedal = self.camera = False
        self._camera_until = None  # the camera pedal stays down until then
        self._camera_moves = False
        self._heard, self._dither = None, DITHER
        self._pressed = None       # time of the press
        self._must_press = False   # a key that is still held does not count
        self._followed = False     # since the press, the hands have moved something
        self._lost = False         # and no longer do
        self._counts = False       # a held pedal, as the trainer has it now

    def apply(self, message, now):
        """@throw ValueError for a message that is not as it should be; then nothing has changed."""
        if not isinstance(message, dict):
            raise ValueError("expected an object")
        pedal, camera = message.get("pedal"), message.get("camera", False)
        if not isinstance(pedal, bool) or not isinstance(camera, bool):
            raise ValueError("pedal and camera are true or false")
        moves, arms = {}, message.get("arms", {})
        if not isinstance(arms, dict):
            raise ValueError("arms are an object")
        for arm, given in arms.items():
            if arm not in self.arms or not isinstance(given, dict):
                raise ValueError("arms are gold and green")
            jaw = given.get("jaw")
            moves[arm] = (_numbers(given.get("move", [0, 0, 0]), 3), _numbers(given.get("turn", [0, 0, 0]), 3),
                          None if jaw is None else _numbers([jaw], 1)[0])
        self._must_press = self._must_press and pedal
        pedal = pedal and not self._must_press
        if not pedal or not self.pedal:
            self._followed = self._lost = False
            self._pressed = now
        dt = min(LONGEST, now - self._heard) if self._heard is not None else 1.0 / 60.0
        dt = max(dt, 1e-3)
        for arm, (motion, rotation, jaw) in moves.items():
            hand = self.arms[arm]
            if pedal or camera:
                hand.move(motion, rotation, dt)
            if jaw is not None:
                hand.jaw = min(1.2, max(0.0, jaw))
        if not pedal and not camera:
            for hand in self.arms.values():
                hand.stop()
                hand.centre(dt)
        self._camera_until = now + LINGER if camera else self._camera_until
        self.pedal, self.camera, self._heard = pedal, camera, now

    @property
    def console_pedal(self):
        """The console sends motion only with its pedal down. With the camera's key alone, once the trainer moves the camera."""
        return self.pedal or (self.camera and self._camera_moves)

    def camera_pedal(self, now):
        """For the trainer. If it came up before the console's pedal, the arms would move for a moment."""
        return self.camera or (self._camera_until is not None and now < self._camera_until)

    def poses(self):
        """For the console: what the virtual device publishes."""
        self._dither = -self._dither
        return {arm: {"p": [hand.position[0] + self._dither, *hand.position[1:]], "q": hand.orientation, "jaw": hand.jaw}
                for arm, hand in self.arms.items()}

    def see(self, mode, counts):
        """A new mode of the trainer, and whether it takes the pedal for down."""
        self._camera_moves = mode == "camera_moving"
        self._counts = counts
        if not self.pedal:
            return
        self._lost = self._followed and mode not in FOLLOWING
        self._followed = self._followed or mode in FOLLOWING

    def watch(self, now):
        """Call often. @return whether the pedal came up because the page was silent.

        A key that is still held when the page goes on counts as pressed again. If the trainer had refused the press, or had already
        ended the motion for another reason, that takes a new press.
        """
        if self._heard is None or now - self._heard <= SILENT:
            return False
        was_down = self.pedal or self.camera
        is_refused = self.pedal and not self._counts and not self._camera_moves and self._heard - self._pressed > REFUSED
        must_press = self._must_press or self._lost or is_refused
        self.release()
        self._must_press = must_press
        return was_down

    def release(self):
        """The page is gone, hidden or was replaced."""
        self.pedal = self.camera = self._must_press = False
        self._heard = None
        for hand in self.arms.values():
            hand.stop()
