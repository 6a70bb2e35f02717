"""Shapes of the parts of training scenes: FRS dome with half its lid cut away, towers, wires, rings. Origin: W."""

import numpy as np

from . import mesh as m
from . import urdf as u

MATERIALS = {
    'table_top': (0.20, 0.29, 0.33, 1), 'plate': (0.80, 0.80, 0.78, 1), 'skin': (0.87, 0.64, 0.53, 1),
    'flesh': (0.74, 0.40, 0.35, 1), 'tower_blue': (0.13, 0.33, 0.75, 1), 'tower_orange': (0.92, 0.45, 0.08, 1),
    'wire': (0.80, 0.80, 0.83, 1), 'ring_red': (0.82, 0.10, 0.12, 1), 'stand': (0.25, 0.27, 0.30, 1),
}


def lid_grid(d, inset, rings, sectors):
    """Points of the lid, `inset` inside its outer face: half an ellipsoid, polar angle from +x, kept for x >= cut_x."""
    o = d['dome']
    radius, height = o['outer_radius'] - inset, o['apex_height'] - o['wall_height'] - inset
    rows = []
    for beta in np.linspace(np.arccos(o['cut_x'] / radius), 0.0, rings + 1):
        r = np.sin(beta)
        psi = np.linspace(0.0, np.pi, sectors + 1)
        rows.append(np.column_stack([np.full(sectors + 1, radius * np.cos(beta)), radius * r * np.cos(psi),
                                     o['wall_height'] + height * r * np.sin(psi)]))
    return np.array(rows)


def lid_meshes(d):
    """Outer skin with the cut's and the rim's faces, and the inner face in another colour."""
    outer, inner = lid_grid(d, 0.0, 12, 28), lid_grid(d, d['dome']['thickness'], 12, 28)
    skin = m.quads(outer).flipped()
    cut = m.quads([outer[0], inner[0]])
    rims = m.quads([outer[:, 0], inner[:, 0]]).flipped() + m.quads([outer[:, -1], inner[:, -1]])
    return {'lid_skin': skin + cut + rims, 'lid_inside': m.quads(inner)}


def s_curve(start, end, amplitude, heights):
    """An S seen from above, at these heights."""
    start, end = np.array(start), np.array(end)
    run = end - start
    across = np.array([-run[1], run[0]]) / np.linalg.norm(run)
    points = []
    for s, height in zip(np.linspace(0.0, 1.0, len(heights)), heights):
        p = start + s * run + amplitude * np.sin(2.0 * np.pi * s) * across
        points.append((p[0], p[1], height))
    return np.array(points)


def wire_path(start, end, amplitude, height, count):
    """Middle line of an S-wire: up from its far foot, an S seen from above, down to its near foot."""
    heights = [height * (1.0 - (2.0 * s - 1.0) ** 8) for s in np.linspace(0.0, 1.0, count)]
    return s_curve(start, end, amplitude, heights)


def rail_path(start, end, amplitude, height, count):
    """The same, but it ends in the air, at its full height."""
    heights = [height * (1.0 - max(0.0, 1.0 - 2.0 * s) ** 8) for s in np.linspace(0.0, 1.0, count)]
    return s_curve(start, end, amplitude, heights)


def by_length(points, count):
    """Resampled at equal distances along the path."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, lengths[-1], count)
    return np.column_stack([np.interp(at, lengths, points[:, i]) for i in range(3)])


def ring_path(ring, count_side, corner):
    """Middle line of the square ring with rounded corners, about its own centre."""
    h = ring['side'] / 2 - corner
    points = []
    for k, (cx, cy) in enumerate(((h, h), (-h, h), (-h, -h), (h, -h))):
        for a in np.linspace(0, np.pi / 2, count_side):
            angle = k * np.pi / 2 + a
            points.append((cx + corner * np.cos(angle), cy + corner * np.sin(angle), 0.0))
    return np.array(points)


def tower_mesh(t, scale=1.0):
    """`scale`: of the steps of its foot."""
    return m.lathe([(t['foot_radius'], 0.0), (t['foot_radius'], 0.002 * scale),
                    (min(t['radius'] + 0.001 * scale, t['foot_radius']), 0.0035 * scale), (t['radius'], 0.006 * scale),
                    (t['radius'], t['height'] - t['radius']), (0.87 * t['radius'], t['height'] - 0.5 * t['radius']),
                    (0.5 * t['radius'], t['height'] - 0.13 * t['radius']), (0.0, t['height'])], 24)


def strand_mesh(path, radius, knob_radius=None):
    """A wire on its feet; or one whose far end is a knob in the air."""
    path = by_length(path, 48)
    ends = m.Mesh()
    for x, y, _ in (path[0],) if knob_radius else (path[0], path[-1]):
        ends += m.cylinder(0.004, 0.0, 0.002, 16, 0.0005).moved((x, y, 0))
    if knob_radius:
        ends += ball(knob_radius).moved(path[-1])
    return m.sweep(path, radius, 8) + ends


def ball(radius, segments=16):
    angles = np.linspace(-np.pi / 2, np.pi / 2, segments // 2 + 1)
    return m.lathe([(radius * np.cos(a), radius * np.sin(a)) for a in angles], segments)


def stand_boxes(r):
    long, w, top = r['side'] / 2 + r['bar_radius'], r['stand_width'] / 2, r['stand_height']
    p = r['peg_width'] / 2
    return [((-long, -w, 0.0), (long, w, top)), ((-w, -long, 0.0), (w, long, top)),
            ((-p, -p, 0.0), (p, p, top + r['peg_height']))]


def stand_mesh(r):
    body = m.cylinder(0.016, 0.0, 0.0015, 32)
    for low, high in stand_boxes(r):
        body += m.box_between(low, high)
    return body


def panel(corners, thickness):
    """Box over a flat-ish patch of four points (in order around it), its outer face on the patch's."""
    a, b, c, e = (np.asarray(p, float) for p in corners)
    x = (b + c - a - e) / 2
    y = (e + c - a - b) / 2
    x = x / np.linalg.norm(x)
    z = np.cross(x, y)
    z /= np.linalg.norm(z)
    R = np.column_stack([x, np.cross(z, x), z])
    local = (np.array([a, b, c, e]) - (a + b + c + e) / 4) @ R
    size = local.max(axis=0) - local.min(axis=0)
    centre = (a + b + c + e) / 4 + R @ ((local.max(axis=0) + local.min(axis=0)) / 2 * [1, 1, 0])
    return u.box_shape((size[0], size[1], thickness), centre - thickness / 2 * R[:, 2], R)


def wall_panels(d, count=20):
    """Boxes whose middle faces lie on the wall's middle line."""
    o = d['dome']
    middle, out = o['outer_radius'] - o['thickness'] / 2, []
    length = 2 * (o['outer_radius']) * np.tan(np.pi / count)
    for k in range(count):
        R = m.rot_z(2 * np.pi * (k + 0.5) / count)
        centre = R @ np.array([middle, 0, o['wall_height'] / 2])
        out.append(u.box_shape((o['thickness'], length, o['wall_height']), centre, R))
    return out


def lid_panels(d, rings=6, sectors=12):
    grid = lid_grid(d, 0.0, rings, sectors)
    out = []
    for i in range(rings):
        for j in range(sectors):
            corners = [grid[i, j], grid[i, j + 1], grid[i + 1, j + 1], grid[i + 1, j]]
            if np.linalg.norm(corners[2] - corners[3]) < 1e-6:  # at the pole: a triangle
                corners[2] = corners[3] = grid[i + 1, j]
            shape = panel(corners, d['dome']['thickness'])
            out.append(shape)
    return out


def ring_shapes(ring):
    """One capsule a side and one across each corner."""
    h, corner, r = ring['side'] / 2, 0.0035, ring['bar_radius']
    e = h - corner
    sides = [((h, -e, 0), (h, e, 0)), ((e, h, 0), (-e, h, 0)), ((-h, e, 0), (-h, -e, 0)), ((-e, -h, 0), (e, -h, 0))]
    corners = [(sides[k][1], sides[(k + 1) % 4][0]) for k in range(4)]
    return [u.capsule(a, b, r) for a, b in sides + corners]


def circle(radius, count):
    angles = 2 * np.pi * np.arange(count) / count
    return np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(count)])


def round_ring_mesh(ring):
    return m.sweep(circle(ring['radius'], 36), ring['bar_radius'], 12, closed=True)


CAPSULES = 12  # of a round ring: their ends lie on its circle, their middles 3.4 % of the radius inside


def round_ring_shapes(ring):
    points = circle(ring['radius'], CAPSULES)
    return [u.capsule(points[k], points[(k + 1) % CAPSULES], ring['bar_radius']) for k in range(CAPSULES)]


def tower_shapes(t):
    r, f = t['radius'], t['foot_radius']
    corners = f * np.array([[0.924, 0.383], [0.707, 0.707], [0.383, 0.924]])  # three boxes in the foot's circle
    foot = [u.box_shape_between((-x, -y, 0), (x, y, 0.003)) for x, y in corners]
    return [u.capsule((0, 0, r), (0, 0, t['height'] - r), r)] + foot
