"""The scene of a session as simple shapes in the world frame W, from the copy of its URDF; and the places of the arms."""

import math
import os
import xml.etree.ElementTree as ElementTree

import numpy as np

MAX_BYTES = 2 * 1024 * 1024
LARGE = 0.5  # [m] the table: larger than what is worth drawing
THIN = 0.4  # least to second side of a box that is drawn as one plane
ARM_BASES = ("base_link_L", "base_link_R")


def rotation(roll, pitch, yaw):
    """URDF's fixed-axis angles."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr], [-sp, cp * sr, cp * cr]])


def from_quaternion(q):
    """Rotation of a unit quaternion x y z w."""
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def numbers(element, name, default):
    values = [float(v) for v in element.get(name, default).split()] if element is not None else \
        [float(v) for v in default.split()]
    if not all(math.isfinite(v) and abs(v) < 1e3 for v in values):
        raise ValueError(f"{name}: not a length")
    return values


def pose(element):
    """(R, p) of an <origin>, of none the identity."""
    return rotation(*numbers(element, "rpy", "0 0 0")), np.array(numbers(element, "xyz", "0 0 0"))


def _parse(path):
    if path is None or os.path.getsize(path) > MAX_BYTES:
        return None
    return ElementTree.parse(path).getroot()


def arm_bases(path):
    """[(R_WB, p_WB)] of gold and green from the robot's URDF; None if they cannot be read."""
    try:
        root = _parse(path)
        joints = root.iter("joint") if root is not None else []
        origins = {j.find("child").get("link"): j.find("origin") for j in joints}
        return [pose(origins[name]) for name in ARM_BASES]
    except (OSError, ElementTree.ParseError, KeyError, ValueError, TypeError, AttributeError):
        return None


def _box_faces(size):
    """Corner lists of a box about its middle: six faces, or its middle plane if it is thin."""
    order = np.argsort(size)
    half = np.array(size) / 2
    if size[order[0]] < THIN * size[order[1]]:
        a, b = order[1], order[2]
        corners = np.zeros((4, 3))
        for i, (u, v) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1))):
            corners[i, a], corners[i, b] = u * half[a], v * half[b]
        return [corners]
    faces = []
    for axis in range(3):
        a, b = [i for i in range(3) if i != axis]
        for side in (-1, 1):
            corners = np.zeros((4, 3))
            for i, (u, v) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1))):
                corners[i, a], corners[i, b], corners[i, axis] = u * half[a], v * half[b], side * half[axis]
            faces.append(corners)
    return faces


class Shape:
    """`kind` plane (corners `points`) or rod (ends `points`, `radius`); `link` and `colour` of it."""

    def __init__(self, kind, points, radius, link, colour):
        self.kind, self.points, self.radius, self.link, self.colour = kind, points, radius, link, colour

    def moved(self, R, p):
        return Shape(self.kind, self.points @ R.T + p, self.radius, self.link, self.colour)


class Scene:
    """`shapes` of what is fixed, in W; `free`: {link: shapes in its own frame} in the order of the log's bodies."""

    def __init__(self):
        self.shapes, self.free = [], {}

    def add_free(self, poses):
        """Shapes of the free links at these poses (records with p, q), in W."""
        found = []
        for (_, shapes), pose in zip(self.free.items(), poses):
            R = from_quaternion(pose["q"])
            found += [shape.moved(R, pose["p"]) for shape in shapes]
        return found


def load_scene(path):
    """The scene of that URDF; an empty one if it cannot be read."""
    scene = Scene()
    try:
        root = _parse(path)
        if root is not None:
            _fill(scene, root)
    except (OSError, ElementTree.ParseError, ValueError, KeyError, TypeError, AttributeError):
        return Scene()
    return scene


def _colour(link, materials):
    visual = link.find("visual/material")
    rgba = materials.get(visual.get("name")) if visual is not None else None
    if rgba is None:
        return "#b9c0c7"
    return "#" + "".join(f"{round(255 * min(max(v, 0.0), 1.0)):02x}" for v in rgba[:3])


def _link_shapes(link, colour):
    shapes = []
    for collision in link.findall("collision"):
        R, p = pose(collision.find("origin"))
        box, rod = collision.find("geometry/box"), collision.find("geometry/cylinder")
        if box is not None:
            size = numbers(box, "size", "0 0 0")
            if max(size) < LARGE:
                shapes += [Shape("plane", corners @ R.T + p, 0.0, link.get("name"), colour)
                           for corners in _box_faces(size)]
        elif rod is not None:
            half = numbers(rod, "length", "0")[0] / 2
            ends = np.array([[0.0, 0.0, -half], [0.0, 0.0, half]]) @ R.T + p
            shapes.append(Shape("rod", ends, numbers(rod, "radius", "0")[0], link.get("name"), colour))
    return shapes


def _fill(scene, root):
    materials = {m.get("name"): numbers(m.find("color"), "rgba", "0 0 0 1") for m in root.findall("material")
                 if m.find("color") is not None}
    joints = {j.find("child").get("link"): j for j in root.findall("joint")}
    for link in root.findall("link"):
        shapes = _link_shapes(link, _colour(link, materials))
        joint = joints.get(link.get("name"))
        if joint is not None and joint.get("type") == "floating":
            scene.free[link.get("name")] = shapes
            continue
        name = link.get("name")
        for _ in range(64):  # up the tree
            if name not in joints:
                break
            R, p = pose(joints[name].find("origin"))
            shapes = [shape.moved(R, p) for shape in shapes]
            name = joints[name].find("parent").get("link")
        scene.shapes += shapes
