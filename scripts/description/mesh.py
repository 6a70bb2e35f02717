"""Closed triangle meshes from a few parametric shapes, their mass properties, and binary STL."""

import struct

import numpy as np


def rot_x(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rot_y(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rot_z(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def frame_along(direction, hint=(1.0, 0.0, 0.0)):
    """Rotation whose z axis is `direction`, x axis as near to `hint` as can be."""
    z = np.asarray(direction, float) / np.linalg.norm(direction)
    x = np.asarray(hint, float)
    if abs(x @ z) > 0.99 * np.linalg.norm(x):
        x = np.array([0.0, 1.0, 0.0])
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


MARK = b'raven2_trainer'.ljust(80, b' ')  # header of a binary STL


class Mesh:
    """Triangles as an (n, 3, 3) array [m], counter-clockwise seen from outside."""

    def __init__(self, triangles=()):
        self.triangles = np.asarray(triangles, float).reshape(-1, 3, 3)

    def __add__(self, other):
        return Mesh(np.concatenate([self.triangles, other.triangles]))

    def __len__(self):
        return len(self.triangles)

    def moved(self, offset=(0.0, 0.0, 0.0), rotation=np.eye(3)):
        """Rotated, then translated; a rotation of determinant -1 mirrors and keeps the outside outside."""
        t = self.triangles @ np.asarray(rotation).T + np.asarray(offset, float)
        return Mesh(t[:, ::-1] if np.linalg.det(rotation) < 0 else t)

    def flipped(self):
        return Mesh(self.triangles[:, ::-1])

    def volume(self):
        t = self.triangles
        return np.einsum('ij,ij->i', t[:, 0], np.cross(t[:, 1], t[:, 2])).sum() / 6

    def stl(self):
        """Binary STL. -0.0 and rounding noise are removed so that the bytes do not depend on the machine."""
        t = np.round(self.triangles, 7) + 0.0
        n = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
        keep = np.linalg.norm(n, axis=1) > 1e-14
        t, n = t[keep], n[keep]
        n = np.round(n / np.linalg.norm(n, axis=1)[:, None], 4) + 0.0
        facets = np.zeros(len(t), [('numbers', '<f4', 12), ('attribute', '<u2')])
        facets['numbers'] = np.concatenate([n, t.reshape(-1, 9)], axis=1)
        return MARK + struct.pack('<I', len(t)) + facets.tobytes()


def quads(rows, closed_u=False, closed_v=False):
    """Grid rows[i][j] of points; outside is where (d/di x d/dj) points."""
    rows = np.asarray(rows, float)
    n, m = rows.shape[:2]
    out = []
    for i in range(n if closed_u else n - 1):
        for j in range(m if closed_v else m - 1):
            a, b = rows[i, j], rows[(i + 1) % n, j]
            c, d = rows[(i + 1) % n, (j + 1) % m], rows[i, (j + 1) % m]
            out += [[a, b, c], [a, c, d]]
    return Mesh(out)


def polygon(points):
    """Convex flat polygon, counter-clockwise seen from outside."""
    p = np.asarray(points, float)
    return Mesh([[p[0], p[i], p[i + 1]] for i in range(1, len(p) - 1)])


def loft(sections):
    """Closed body through sections of equal point count, counter-clockwise seen from the last section's side."""
    s = np.asarray(sections, float)
    body = quads(s, closed_v=True).flipped() + polygon(s[0][::-1]) + polygon(s[-1])
    if body.volume() <= 0.0:
        raise ValueError('sections run the wrong way round')
    return body


def box(size, bevel=0.0):
    """Box about the origin; `bevel` cuts the four edges parallel to z and the rims of both ends."""
    x, y, z = np.asarray(size, float) / 2
    if bevel <= 0.0:
        ring = [(x, -y), (x, y), (-x, y), (-x, -y)]
        return loft([[(a, b, h) for a, b in ring] for h in (-z, z)])

    def outline(inset):
        a, b, c = x - inset, y - inset, bevel
        return [(a, -b + c), (a, b - c), (a - c, b), (-a + c, b), (-a, b - c), (-a, -b + c), (-a + c, -b), (a - c, -b)]

    levels = [(-z, bevel), (-z + bevel, 0.0), (z - bevel, 0.0), (z, bevel)]
    return loft([[(a, b, h) for a, b in outline(inset)] for h, inset in levels])


def box_between(low, high, bevel=0.0):
    low, high = np.asarray(low, float), np.asarray(high, float)
    return box(np.abs(high - low), bevel).moved((low + high) / 2)


def lathe(profile, segments=24):
    """Solid of revolution about z; profile [(radius, z), ...] from bottom to top, first and last radius may be 0."""
    angles = 2 * np.pi * np.arange(segments) / segments
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    return loft([np.column_stack([max(r, 1e-6) * circle, np.full(segments, h)]) for r, h in profile])


def cylinder(radius, bottom, top, segments=24, chamfer=0.0):
    if chamfer <= 0.0:
        return lathe([(radius, bottom), (radius, top)], segments)
    c = chamfer
    return lathe([(radius - c, bottom), (radius, bottom + c), (radius, top - c), (radius - c, top)], segments)


def tube_ring(inner, outer, bottom, top, segments=48):
    """Pipe about z."""
    angles = 2 * np.pi * np.arange(segments) / segments
    profile = [(outer, bottom), (outer, top), (inner, top), (inner, bottom)]
    rows = [[(r * np.cos(a), r * np.sin(a), h) for r, h in profile] for a in angles]
    return quads(rows, closed_u=True, closed_v=True)


def arc_bar(radius, thickness, width, start, end, steps, corner=0.003):
    """Bar of rectangular section swept over an arc about x: angle 0 is +z, growing towards -y."""
    a, b, c = width / 2, thickness / 2, corner
    section = [(a, -b + c), (a, b - c), (a - c, b), (-a + c, b), (-a, b - c), (-a, -b + c), (-a + c, -b), (a - c, -b)]
    rows = []
    for angle in np.linspace(start, end, steps + 1):
        direction = np.array([0.0, -np.sin(angle), np.cos(angle)])
        rows.append([np.array([x, 0.0, 0.0]) + (radius + r) * direction for x, r in section])
    return loft(rows)


def sweep(points, radius, segments=8, closed=False):
    """Round tube along a path; ends are flat."""
    p = np.asarray(points, float)
    n = len(p)
    rows = []
    normal = None
    for i in range(n):
        after, before = (p[(i + 1) % n], p[i - 1]) if closed else (p[min(i + 1, n - 1)], p[max(i - 1, 0)])
        R = frame_along(after - before, (0.0, 0.0, 1.0) if normal is None else normal)
        normal = R[:, 0]
        angles = 2 * np.pi * np.arange(segments) / segments
        rows.append([p[i] + radius * (np.cos(a) * R[:, 0] + np.sin(a) * R[:, 1]) for a in angles])
    if closed:
        return quads(rows, closed_u=True, closed_v=True).flipped()
    return loft(rows)


def mass_properties(mesh, density):
    """Mass, centre of mass and inertia about it of a closed mesh filled with one material."""
    t = mesh.triangles
    volume = np.einsum('ij,ij->i', t[:, 0], np.cross(t[:, 1], t[:, 2])) / 6
    total = volume.sum()
    com = (volume[:, None] * t.sum(axis=1)).sum(axis=0) / 4 / total
    corners = t - com
    s = corners.sum(axis=1)
    squares = corners.transpose(0, 2, 1) @ corners + s[:, :, None] * s[:, None, :]
    covariance = (np.linalg.det(corners)[:, None, None] / 6 / 20 * squares).sum(axis=0)
    inertia = density * (np.trace(covariance) * np.eye(3) - covariance)
    return density * total, com, inertia
