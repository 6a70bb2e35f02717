"""Tips of both arms, of the model and of the robot, and the axes of the camera, from the transforms on /tf. Nothing here
knows ROS."""

from raven2_station.hands import product


def rotated(q, v):
    x, y, z, w = q
    a, b, c = v
    tx, ty, tz = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx]


class Frames:
    """The newest transform of each frame into its parent."""

    DEEPEST = 32

    def __init__(self):
        self._links, self._stamps = {}, {}

    def put(self, child, parent, translation, rotation, stamp=None):
        self._links[child] = (parent, translation, rotation)
        self._stamps[child] = stamp

    def _chain(self, frame, root):
        """[(translation, rotation)] from the frame up to `root`; None while a link is missing."""
        chain = []
        for _ in range(self.DEEPEST):
            if frame == root:
                return chain
            if frame not in self._links:
                return None
            frame, *link = self._links[frame]
            chain.append(link)
        return None

    def origin(self, frame, root="world"):
        """[m] of the frame's origin in `root`; None while a link of the chain is missing."""
        chain, point = self._chain(frame, root), [0.0, 0.0, 0.0]
        for translation, rotation in chain or ():
            point = [t + p for t, p in zip(translation, rotated(rotation, point))]
        return None if chain is None else point

    def rotation(self, frame, root="world"):
        """Quaternion x, y, z, w of the frame in `root`; None while a link of the chain is missing."""
        chain, q = self._chain(frame, root), [0.0, 0.0, 0.0, 1.0]
        for _, rotation in chain or ():
            q = product(rotation, q)
        return None if chain is None else q

    def view(self, frame):
        """Axes to the right, up and into the picture of an optical frame, each along the axes of a browser's hand device
        (config/masters/browser.yaml: right, forward, up); None while the frame is unknown."""
        q = self.rotation(frame)
        if q is None:
            return None
        of_world = [rotated(q, axis) for axis in ([1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0])]
        return [[-y, x, z] for x, y, z in of_world]  # the world has x forward, y left

    def apart(self, arm):
        """[m] between the tips of model and robot (the pivot of the jaws); None without both of one moment: the robot may be gone.
        @param arm: L or R."""
        frames = [f"{of}/grasper1_{arm}" for of in ("model", "robot")]
        model, robot = map(self.origin, frames)
        if model is None or robot is None or self._stamps[frames[0]] != self._stamps[frames[1]]:
            return None
        return sum((m - r) ** 2 for m, r in zip(model, robot)) ** 0.5
