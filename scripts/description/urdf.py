"""URDF text: poses as roll-pitch-yaw, capsules as cylinders, links and joints."""

import numpy as np

from .mesh import frame_along


def number(value):
    """Shortest text that reads back as the same double."""
    value = float(value)
    if abs(value) < 1e-15:
        return '0'
    text = repr(value)
    return text[:-2] if text.endswith('.0') else text


def numbers(values):
    return ' '.join(number(v) for v in values)


def frame_numbers(values):
    """Lengths [m] and angles [rad] of a frame. Digits behind the 14th differ between processors: BLAS."""
    return numbers(np.round(values, 14) + 0.0)


def rpy(rotation):
    """Angles of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    R = np.asarray(rotation)
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    if np.hypot(R[0, 0], R[1, 0]) < 1e-9:  # yaw and roll turn about one axis: all of it is called roll
        return np.array([np.arctan2(-R[1, 2], R[1, 1]), pitch, 0.0])
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])


def short_rpy(rotation):
    """For shapes, where a nanoradian is enough."""
    return np.round(rpy(rotation), 9) + 0.0


MARK = '<!-- Written by scripts/generate_description '


class Shape:
    """A collision primitive in its link."""

    def __init__(self, element, centre, rotation=np.eye(3)):
        self.element, self.centre, self.rotation = element, np.asarray(centre, float), rotation


def box_shape(size, centre, rotation=np.eye(3)):
    return Shape(f'<box size="{numbers(np.round(size, 9))}"/>', centre, rotation)


def box_shape_between(low, high):
    low, high = np.asarray(low, float), np.asarray(high, float)
    return box_shape(np.abs(high - low), (low + high) / 2)


def capsule(start, end, radius):
    """Capsule around a segment. In the file: a cylinder as long as the capsule, both round ends included."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    length = np.linalg.norm(end - start)
    element = f'<cylinder radius="{number(radius)}" length="{number(round(length + 2 * radius, 9))}"/>'
    return Shape(element, (start + end) / 2, frame_along(end - start))


def capsule_chain(points, radius):
    return [capsule(a, b, radius) for a, b in zip(points[:-1], points[1:])]


class Visual:
    """A mesh file in its link."""

    def __init__(self, mesh, material, rotation=np.eye(3), offset=(0.0, 0.0, 0.0)):
        self.mesh, self.material, self.rotation, self.offset = mesh, material, rotation, np.asarray(offset, float)


class Document:
    """Collects the text of one robot description."""

    def __init__(self, name, materials):
        self.lines = ['<?xml version="1.0"?>',
                      MARK + 'from meshes/dimensions.yaml and config/arms.yaml. -->',
                      f'<robot name="{name}">']
        for material, colour in materials.items():
            self.lines.append(f'  <material name="{material}"><color rgba="{numbers(colour)}"/></material>')

    def link(self, name, inertial=None, visuals=(), collisions=(), material=''):
        """`material`: of config/model.yaml, how its surface gives way."""
        if not inertial and not visuals and not collisions:
            self.lines.append(f'  <link name="{name}"/>')
            return
        self.lines.append(f'  <link name="{name}">')
        if inertial:
            self._inertial(*inertial)
        for v in visuals:
            self.lines.append(f'    <visual>{origin(v.offset, v.rotation)}<geometry>'
                              f'<mesh filename="package://raven2_trainer/meshes/{v.mesh}.stl"/></geometry>'
                              f'<material name="{v.material}"/></visual>')
        named = f' name="{material}"' if material else ''
        for s in collisions:
            self.lines.append(f'    <collision{named}>{origin(s.centre, s.rotation)}<geometry>{s.element}</geometry>'
                              '</collision>')
        self.lines.append('  </link>')

    def _inertial(self, mass, com, inertia):
        i = np.array([float(f'{x:.6e}') for x in inertia.ravel()]).reshape(3, 3)
        terms = zip(('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'), (i[0, 0], i[0, 1], i[0, 2], i[1, 1], i[1, 2], i[2, 2]))
        text = ' '.join(f'{k}="{number(v)}"' for k, v in terms)
        self.lines.append(f'    <inertial><origin xyz="{numbers(np.round(com, 9) + 0.0)}"/>'
                          f'<mass value="{number(float(f"{mass:.6e}"))}"/><inertia {text}/></inertial>')

    def joint(self, name, kind, parent, child, position=(0, 0, 0), rotation=np.eye(3), axis=None, limit=None):
        """`limit`: lower, upper, effort, velocity."""
        self.lines.append(f'  <joint name="{name}" type="{kind}">')
        self.lines.append(f'    <parent link="{parent}"/><child link="{child}"/>')
        self.lines.append(f'    <origin xyz="{frame_numbers(position)}" rpy="{frame_numbers(rpy(rotation))}"/>')
        if axis is not None:
            lower, upper, effort, velocity = limit
            self.lines.append(f'    <axis xyz="{numbers(axis)}"/>')
            self.lines.append(f'    <limit lower="{number(lower)}" upper="{number(upper)}" effort="{number(effort)}" '
                              f'velocity="{number(velocity)}"/>')
        self.lines.append('  </joint>')

    def text(self):
        return '\n'.join(self.lines + ['</robot>', ''])


def origin(position, rotation):
    position, angles = np.round(position, 9) + 0.0, short_rpy(rotation)
    if not position.any() and not angles.any():
        return ''
    return f'<origin xyz="{frame_numbers(position)}" rpy="{frame_numbers(angles)}"/>'
