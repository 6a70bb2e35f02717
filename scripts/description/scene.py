"""The training scene: the FRS dome with half its lid cut away, towers, S-wires and a ring to pick up. Origin: W."""

import numpy as np

from . import mesh as m
from . import urdf as u

MATERIALS = {
    'table_top': (0.20, 0.29, 0.33, 1), 'plate': (0.80, 0.80, 0.78, 1), 'skin': (0.87, 0.64, 0.53, 1),
    'flesh': (0.74, 0.40, 0.35, 1), 'tower_blue': (0.13, 0.33, 0.75, 1), 'tower_orange': (0.92, 0.45, 0.08, 1),
    'wire': (0.80, 0.80, 0.83, 1), 'ring_red': (0.82, 0.10, 0.12, 1), 'stand': (0.25, 0.27, 0.30, 1),
}

# A ring goes from a far tower to the near one of the same colour, crosswise.
TOWERS = {'far_left': 'tower_blue', 'far_right': 'tower_orange', 'near_left': 'tower_orange',
          'near_right': 'tower_blue'}


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


def wire_path(d, mirror, count):
    """Middle line of an S-wire: up from its far foot, an S seen from above, down to its near foot."""
    w = d['wires']
    start, end = np.array(w['start']), np.array(w['end'])
    run = end - start
    across = np.array([-run[1], run[0]]) / np.linalg.norm(run)
    points = []
    for s in np.linspace(0.0, 1.0, count):
        height = w['height'] * (1.0 - (2.0 * s - 1.0) ** 8)
        p = start + s * run + w['amplitude'] * np.sin(2.0 * np.pi * s) * across
        points.append((p[0], mirror * p[1], height))
    return np.array(points)


def by_length(points, count):
    """Resampled at equal distances along the path."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, lengths[-1], count)
    return np.column_stack([np.interp(at, lengths, points[:, i]) for i in range(3)])


def ring_path(d, count_side, corner):
    """Middle line of the square ring with rounded corners, about its own centre."""
    h = d['ring']['side'] / 2 - corner
    points = []
    for k, (cx, cy) in enumerate(((h, h), (-h, h), (-h, -h), (h, -h))):
        for a in np.linspace(0, np.pi / 2, count_side):
            angle = k * np.pi / 2 + a
            points.append((cx + corner * np.cos(angle), cy + corner * np.sin(angle), 0.0))
    return np.array(points)


def meshes(d):
    o, plate, t, ring = d['dome'], d['plate'], d['towers'], d['ring']
    out = {
        'table': m.box((plate['table_length'], plate['table_width'], plate['table_thickness']), 0.003),
        'plate': m.cylinder(plate['radius'], -plate['thickness'], 0.0, 64, 0.0015),
        'dome_wall': m.tube_ring(o['outer_radius'] - o['thickness'], o['outer_radius'], 0.0, o['wall_height'], 64),
        'tower': m.lathe([(t['foot_radius'], 0.0), (t['foot_radius'], 0.002), (t['radius'] + 0.001, 0.0035),
                          (t['radius'], 0.006), (t['radius'], t['height'] - t['radius']),
                          (0.87 * t['radius'], t['height'] - 0.5 * t['radius']),
                          (0.5 * t['radius'], t['height'] - 0.13 * t['radius']), (0.0, t['height'])], 24),
        'ring': m.sweep(ring_path(d, 5, 0.0035), ring['bar_radius'], 12, closed=True),
        'stand': stand_mesh(d),
    }
    for side, mirror in (('left', 1.0), ('right', -1.0)):
        path = by_length(wire_path(d, mirror, 400), 48)
        feet = m.Mesh()
        for x, y, _ in (path[0], path[-1]):
            feet += m.cylinder(0.004, 0.0, 0.002, 16, 0.0005).moved((x, y, 0))
        out['wire_' + side] = m.sweep(path, d['wires']['radius'], 8) + feet
    out.update(lid_meshes(d))
    return out


def stand_boxes(d):
    r = d['ring']
    long, w, top = r['side'] / 2 + r['bar_radius'], r['stand_width'] / 2, r['stand_height']
    p = r['peg_width'] / 2
    return [((-long, -w, 0.0), (long, w, top)), ((-w, -long, 0.0), (w, long, top)),
            ((-p, -p, 0.0), (p, p, top + r['peg_height']))]


def stand_mesh(d):
    body = m.cylinder(0.016, 0.0, 0.0015, 32)
    for low, high in stand_boxes(d):
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


def ring_shapes(d):
    """One capsule a side and one across each corner."""
    h, corner, r = d['ring']['side'] / 2, 0.0035, d['ring']['bar_radius']
    e = h - corner
    sides = [((h, -e, 0), (h, e, 0)), ((e, h, 0), (-e, h, 0)), ((-h, e, 0), (-h, -e, 0)), ((-e, -h, 0), (e, -h, 0))]
    corners = [(sides[k][1], sides[(k + 1) % 4][0]) for k in range(4)]
    return [u.capsule(a, b, r) for a, b in sides + corners]


def tower_shapes(d):
    t = d['towers']
    r, f = t['radius'], t['foot_radius']
    corners = f * np.array([[0.924, 0.383], [0.707, 0.707], [0.383, 0.924]])  # three boxes in the foot's circle
    foot = [u.box_shape_between((-x, -y, 0), (x, y, 0.003)) for x, y in corners]
    return [u.capsule((0, 0, r), (0, 0, t['height'] - r), r)] + foot


def document(d, built):
    plate, ring = d['plate'], d['ring']
    doc = u.Document('frs_trainer', MATERIALS)
    doc.link('world')

    def fixed(name, looks, shapes, position=(0, 0, 0)):
        doc.link(name, None, looks, shapes)
        doc.joint(name + '_joint', 'fixed', 'world', name, position)

    size = (plate['table_length'], plate['table_width'], plate['table_thickness'])
    fixed('table', [u.Visual('table', 'table_top')], [u.box_shape(size, (0, 0, 0))],
          (0, 0, -plate['thickness'] - plate['table_thickness'] / 2))
    edge = 2 * plate['radius']
    fixed('base_plate', [u.Visual('plate', 'plate')], [u.box_shape((edge, edge, 0.020), (0, 0, -0.010))])
    fixed('dome_wall', [u.Visual('dome_wall', 'skin')], wall_panels(d))
    fixed('dome_lid', [u.Visual('lid_skin', 'skin'), u.Visual('lid_inside', 'flesh')], lid_panels(d))
    for name, material in TOWERS.items():
        fixed('tower_' + name, [u.Visual('tower', material)], tower_shapes(d), (*d['towers'][name], 0.0))
    for side, mirror in (('left', 1.0), ('right', -1.0)):
        path = by_length(wire_path(d, mirror, 400), 15)
        fixed('wire_' + side, [u.Visual('wire_' + side, 'wire')], u.capsule_chain(path, d['wires']['radius']))
    fixed('ring_stand', [u.Visual('stand', 'stand')], [u.box_shape_between(a, b) for a, b in stand_boxes(d)],
          (*ring['position'], 0.0))
    doc.link('ring', m.mass_properties(built['ring'], d['inertia']['plastic_density']), [u.Visual('ring', 'ring_red')],
             ring_shapes(d))
    doc.joint('ring_joint', 'floating', 'world', 'ring', (*ring['position'], ring['stand_height'] + ring['bar_radius']))
    return doc.text()
