"""Poses of the arms' links in the world from the copy of the robot's URDF that a session keeps: quaternions x y z w."""

import math
import os
import xml.etree.ElementTree as ElementTree

import numpy as np

MAX_BYTES = 2 * 1024 * 1024
AXES = np.eye(3)


def turn(axis, angle):
    """Rotations about a unit axis, (..., 4)."""
    half = np.asarray(angle, float)[..., None] / 2
    return np.concatenate((np.sin(half) * axis, np.cos(half)), axis=-1)


def times(a, b):
    """Product of rotations, b first."""
    va, wa, vb, wb = a[..., :3], a[..., 3:], b[..., :3], b[..., 3:]
    return np.concatenate((wa * vb + wb * va + np.cross(va, vb), wa * wb - np.sum(va * vb, -1, keepdims=True)), -1)


def turned(q, p):
    v, w = q[..., :3], q[..., 3:]
    return p + 2 * np.cross(v, np.cross(v, p) + w * p)


def _numbers(element, name, default):
    values = [float(v) for v in (default if element is None else element.get(name, default)).split()]
    if len(values) != 3 or not all(math.isfinite(v) and abs(v) < 1e3 for v in values):
        raise ValueError(f"{name}: not three lengths or angles")
    return np.array(values)


class Link:
    def __init__(self, joint):
        self.name, self.parent = joint.find("child").get("link"), joint.find("parent").get("link")
        origin = joint.find("origin")
        roll, pitch, yaw = _numbers(origin, "rpy", "0 0 0")
        self.p = _numbers(origin, "xyz", "0 0 0")
        self.q = times(turn(AXES[2], yaw), times(turn(AXES[1], pitch), turn(AXES[0], roll)))  # URDF's fixed axes
        self.joint, self.kind = joint.get("name"), joint.get("type")
        self.axis = _numbers(joint.find("axis"), "xyz", "1 0 0")


class Arms:
    """Links parents first; `fixed` are the names of those that nothing moves, the root among them."""

    def __init__(self, path):
        if os.path.getsize(path) > MAX_BYTES:
            raise ValueError(f"{path}: larger than {MAX_BYTES} bytes")
        try:
            root = ElementTree.parse(path).getroot()
            waiting = [Link(joint) for joint in root.findall("joint")]
            self.root = ({link.get("name") for link in root.findall("link")} - {link.name for link in waiting}).pop()
        except (ElementTree.ParseError, AttributeError, KeyError) as error:
            raise ValueError(f"{path}: {error}") from error
        self.links, self.fixed, known = [], {self.root}, {self.root}
        while waiting:
            ready = [link for link in waiting if link.parent in known]
            if not ready:
                raise ValueError(f"{path}: {waiting[0].name} hangs on nothing")
            for link in ready:
                known.add(link.name)
                if link.kind == "fixed" and link.parent in self.fixed:
                    self.fixed.add(link.name)
            self.links += ready
            waiting = [link for link in waiting if link.name not in known]

    def poses(self, names, positions):
        """{link: (p (n, 3), q (n, 4))} in the world for n rows of joint positions in the URDF's coordinates."""
        positions = np.atleast_2d(positions)
        of_joint = {name: positions[:, i] for i, name in enumerate(names)}
        n = len(positions)
        found = {self.root: (np.zeros((n, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (n, 1)))}
        for link in self.links:
            p, q = found[link.parent]
            x = of_joint[link.joint] if link.kind != "fixed" else np.zeros(n)
            slide = x[:, None] * link.axis if link.kind == "prismatic" else np.zeros((n, 3))
            spin = turn(link.axis, x) if link.kind in ("revolute", "continuous") else turn(link.axis, np.zeros(n))
            found[link.name] = (p + turned(q, link.p + turned(link.q, slide)), times(q, times(link.q, spin)))
        return found
