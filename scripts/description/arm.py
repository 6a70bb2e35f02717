"""The Raven-II: meshes of one arm and the URDF of both.

Bodies lie on the axes of their DH frames, all of which pass through the remote centre (RCM). The arc meshes are made
for the green arm, whose base and elbow lie on +z of frames 1 and 2. In the gold arm they lie on -z. So the meshes of
link 1 rotate by 180 degrees about x, those of link 2 about y. From frame 3 on both arms are alike: the rail is on -x.
"""

import numpy as np

from . import mesh as m
from . import urdf as u

DEGREE = np.pi / 180

MATERIALS = {
    'black_anodised': (0.075, 0.078, 0.085, 1), 'dark_motor': (0.16, 0.165, 0.18, 1),
    'aluminium': (0.72, 0.73, 0.75, 1), 'steel': (0.60, 0.62, 0.65, 1), 'bright_steel': (0.82, 0.83, 0.86, 1),
    'gold_accent': (0.86, 0.62, 0.10, 1), 'green_accent': (0.08, 0.55, 0.25, 1), 'brass': (0.72, 0.58, 0.28, 1),
}


class Side:
    """The differences between the arms: L is gold, R is green."""

    def __init__(self, letter):
        left = letter == 'L'
        self.letter = letter
        self.name = 'gold' if left else 'green'
        self.accent = 'gold_accent' if left else 'green_accent'
        self.sign = -1.0 if left else 1.0  # of the base and elbow directions along z of frames 1 and 2
        self.outward = 1.0 if left else -1.0  # of y in W, away from the other arm
        # Columns: x0, y0, z0 in W (core/frames.h).
        self.R_WB = (np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], float) if left else
                     np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], float))
        self.to_link1 = m.rot_x(np.pi) if left else np.eye(3)
        self.to_link2 = m.rot_y(np.pi) if left else np.eye(3)


LEFT, RIGHT = Side('L'), Side('R')


# ---- meshes ---------------------------------------------------------------------------------------------------------

def base_meshes(d, rcm_height):
    """Left base in axes parallel to W, origin at the RCM; y points outward along the shoulder axis."""
    b, half = d['base'], d['base']['plate_half_width']
    top, bottom = b['plate_height'], b['plate_height'] - b['plate_thickness']
    near, far = b['plate_near'], b['plate_far']
    along_y = m.rot_x(-np.pi / 2)  # z of a turned part becomes +y
    plate = m.box_between((-half, near, bottom), (half, far, top), 0.003)
    shaft = m.cylinder(0.012, d['link1']['radius'] - 0.006, near + 0.03, 20).moved(rotation=along_y)
    ring = m.cylinder(b['bearing_radius'] - 0.006, near - 0.006, near + 0.002, 28, 0.002).moved(rotation=along_y)
    bearing = (m.cylinder(b['bearing_radius'], near, near + 0.045, 28, 0.003).moved(rotation=along_y) +
               m.box_between((-b['bearing_radius'], near + 0.002, top),
                             (b['bearing_radius'], near + 0.043, 0.0), 0.002))
    housing = m.box_between((-half + 0.008, near + 0.01, bottom - b['housing_depth']),
                            (half - 0.008, far - 0.01, bottom))
    cheeks = (m.box_between((-half, near + 0.055, top), (-half + 0.006, far, top + 0.03)) +
              m.box_between((half - 0.006, near + 0.055, top), (half, far, top + 0.03)))
    floor = -rcm_height - d['plate']['thickness']
    w = b['column_half_width']
    middle = (near + far) / 2
    column = m.box_between((-w, middle - w, floor + 0.012), (w, middle + w, bottom - b['housing_depth']), 0.004)
    foot = m.box_between((-half, near + 0.02, floor), (half, far - 0.02, floor + 0.012), 0.003)
    stripes = m.Mesh()
    for sign in (-1, 1):
        x = sign * (half - 0.008)
        stripes += m.box_between((min(x, x + sign * 0.002), near + 0.02, bottom - 0.028),
                                 (max(x, x + sign * 0.002), far - 0.02, bottom - 0.012))
    stripes += m.box_between((-half + 0.02, far - 0.01, bottom - 0.028), (half - 0.02, far - 0.008, bottom - 0.012))
    stripes += m.box_between((-half + 0.02, near + 0.008, bottom - 0.028), (half - 0.02, near + 0.01, bottom - 0.012))
    motors, gears, capstans = motor_pack(d, top)
    return {'base_black': bearing + housing + column, 'base_aluminium': plate + cheeks + foot + ring + gears,
            'base_steel': shaft, 'base_motors': motors, 'base_brass': capstans, 'base_accent': stripes}


def motor_pack(d, top):
    """All seven motors of an arm are on its base: three RE40 with GP42, four RE30 with GP32."""
    b = d['base']
    places = [(x, b['plate_near'] + 0.085, 'motor40', 'gear42') for x in (-0.062, 0.0, 0.062)]
    places += [(x, b['plate_near'] + 0.160, 'motor30', 'gear32') for x in (-0.072, -0.024, 0.024, 0.072)]
    motors, gears, capstans = m.Mesh(), m.Mesh(), m.Mesh()
    for x, y, motor, gear in places:
        r = b[motor + '_radius']
        stand = 0.026
        low, high = top + stand, top + stand + b[gear + '_length']
        end = high + b[motor + '_length']
        for post in (-1, 1):
            gears += m.box_between((x + post * r - 0.003, y - 0.008, top), (x + post * r + 0.003, y + 0.008, low))
        gears += m.cylinder(r + 0.003, low - 0.003, low, 16).moved((x, y, 0))
        gears += m.cylinder(r, low, high, 16).moved((x, y, 0))
        motors += m.cylinder(r - 0.001, high, end, 16, 0.002).moved((x, y, 0))
        motors += m.cylinder(0.6 * r, end, end + 0.012, 10).moved((x, y, 0))
        capstans += m.cylinder(b['capstan40_radius'] + 0.002, top + 0.002, low - 0.004, 8).moved((x, y, 0))
    return motors, gears, capstans


def along(angle):
    """Direction at `angle` from the base (link 1) or elbow (link 2) on the arc, green arm."""
    return np.array([0.0, -np.sin(angle), np.cos(angle)])


def link1_meshes(d):
    k, end = d['link1'], d['chain']['link_angle_12'] * DEGREE
    r, t = k['radius'], k['thickness']
    bar = m.arc_bar(r, t, k['width'], -4 * DEGREE, end + 4 * DEGREE, 18)
    elbow = m.rot_x(end)
    hub = m.cylinder(k['hub_radius'], r - t / 2 - 0.004, r + t / 2 + 0.010, 24, 0.002)
    outside = r + t / 2
    pulley = m.lathe([(k['pulley_radius'] - 0.004, outside), (k['pulley_radius'], outside + 0.002),
                      (k['pulley_radius'] - 0.003, outside + k['pulley_width'] / 2),
                      (k['pulley_radius'], outside + k['pulley_width'] - 0.002),
                      (k['pulley_radius'] - 0.004, outside + k['pulley_width'])], 36)
    cap = m.cylinder(0.014, outside + 0.008, outside + 0.016, 18, 0.002).moved(rotation=elbow)
    ribs = m.Mesh()
    for side in (-1, 1):  # bright flanges along both edges of the bar, as on the machined original
        ribs += m.arc_bar(r, t + 0.004, 0.004, 9 * DEGREE, end - 7 * DEGREE, 12, 0.001).moved(
            (side * (k['width'] / 2 - 0.0005), 0, 0))
    accent = m.arc_bar(outside + 0.0005, 0.002, 0.020, 16 * DEGREE, end - 14 * DEGREE, 12, 0.0005)
    pockets = side_pockets(r, t - 0.004, k['width'] / 2 + 0.0013, 12 * DEGREE, end - 10 * DEGREE, 4)
    return {'link1_black': bar + hub.moved(rotation=elbow) + pockets, 'link1_aluminium': pulley + ribs,
            'link1_steel': cap, 'link1_accent': accent}


def side_pockets(radius, thickness, x, start, end, count):
    """Dark faces of the milled pockets on both sides of a bar."""
    out = m.Mesh()
    pitch = (end - start) / count
    for i in range(count):
        a = start + (i + 0.12) * pitch
        for side in (-1, 1):
            out += m.arc_bar(radius, thickness, 0.001, a, a + 0.76 * pitch, 3, 0.0002).moved((side * x, 0, 0))
    return out


def link2_meshes(d):
    k, end = d['link2'], d['chain']['link_angle_23'] * DEGREE
    r, t = k['radius'], k['thickness']
    insertion = m.rot_x(end)  # z becomes the insertion axis, +y the elbow's side of it
    stop = end - np.arcsin((k['rail_offset'] + k['rail_thickness'] / 2) / r)
    bar = m.arc_bar(r, t, k['width'], -5 * DEGREE, stop, 12)
    pulley = m.lathe([(k['pulley_radius'] - 0.003, r + 0.008), (k['pulley_radius'], r + 0.009),
                      (k['pulley_radius'] - 0.002, r + 0.008 + k['pulley_width'] / 2),
                      (k['pulley_radius'], r + 0.007 + k['pulley_width']),
                      (k['pulley_radius'] - 0.003, r + 0.008 + k['pulley_width'])], 32)
    axle = m.cylinder(0.012, r - 0.014, d['link1']['radius'] + 0.004, 18, 0.001)
    y, h, w = k['rail_offset'], k['rail_thickness'] / 2, k['rail_width'] / 2
    near, far = k['rail_near'], k['rail_far']
    bracket = m.box_between((-w, y + h - 0.002, r - 0.055), (w, y + h + 0.014, r + 0.055), 0.003)
    rail = m.box_between((-w, y - h, near + 0.010), (w, y + h, far - 0.010), 0.001)
    grooves = m.Mesh()
    for side in (-1, 1):  # two guide rods on the carriage's side
        grooves += m.cylinder(0.003, near + 0.010, far - 0.010, 10).moved((side * 0.009, y - h - 0.002, 0))
    caps = (m.box_between((-w - 0.003, y - h - 0.008, near), (w + 0.003, y + h + 0.004, near + 0.012), 0.002) +
            m.box_between((-w - 0.003, y - h - 0.008, far - 0.012), (w + 0.003, y + h + 0.004, far), 0.002))
    sheaves = m.Mesh()
    for z in (near + 0.026, far - 0.026):  # cable sheaves on the back
        for side in (-1, 1):
            sheaves += m.cylinder(0.010, 0.0, 0.006, 14).moved((side * 0.006, y + h + 0.003, z), m.rot_x(-np.pi / 2))
    accent = m.box_between((-0.007, y + h, r + 0.070), (0.007, y + h + 0.0015, far - 0.050))
    flanges = m.Mesh()
    for side in (-1, 1):
        flanges += m.arc_bar(r, t + 0.003, 0.003, 8 * DEGREE, stop - 6 * DEGREE, 8, 0.0008).moved(
            (side * (k['width'] / 2 - 0.0004), 0, 0))
    pockets = side_pockets(r, t - 0.004, k['width'] / 2 + 0.0009, 9 * DEGREE, stop - 7 * DEGREE, 2)
    return {'link2_black': bar + pockets + (bracket + caps).moved(rotation=insertion),
            'link2_aluminium': pulley + flanges + (rail + sheaves).moved(rotation=insertion),
            'link2_steel': axle + grooves.moved(rotation=insertion),
            'link2_accent': accent.moved(rotation=insertion)}


def link3_meshes(d):
    """Carriage on the rail (at -x) and the base of the tool with its four spindles, in frame 3."""
    k, rail = d['link3'], d['link2']
    face = -rail['rail_offset'] + rail['rail_thickness'] / 2 + 0.004
    half, w = k['carriage_length'] / 2, k['carriage_width'] / 2
    carriage = m.box_between((face - 0.003, -w, -half), (face + 0.014, w, half), 0.003)
    adapter = m.box_between((face + 0.014, -w + 0.004, -half + 0.006), (face + 0.020, w - 0.004, half - 0.006), 0.001)
    length, side = k['housing_length'], k['housing_width'] / 2
    housing = m.box_between((face + 0.020, -side, -length / 2), (0.014, side, length / 2), 0.004)
    low = -length / 2
    nose = m.cylinder(0.009, low - 0.022, low, 20, 0.001) + m.cylinder(0.0065, low - 0.036, low - 0.020, 16)
    lid = m.box_between((0.014, -side + 0.003, -length / 2 + 0.003), (0.0165, side - 0.003, length / 2 - 0.003), 0.0008)
    spindles = m.Mesh()
    for y in (-0.009, 0.009):
        for z in (-0.012, 0.012):
            spindles += m.cylinder(0.0065, 0.0165, 0.020, 14).moved((0, y, z), m.rot_y(np.pi / 2))
    return {'link3_black': carriage + housing, 'link3_aluminium': adapter + nose, 'link3_steel': spindles,
            'link3_accent': lid}


def tool_meshes(d, lw, length):
    t = d['tool']
    r = t['shaft_radius']
    shaft = m.lathe([(r - 0.0004, 0.0035), (r, 0.006), (r, length)], 16)
    ring = m.cylinder(r + 0.0004, 0.0045, 0.0085, 16, 0.0003)
    a = t['wrist_radius']
    yoke = m.Mesh()
    for y in (-1, 1):  # clevis arms of the wrist on both sides of its axis z
        yoke += m.box((0.0095, 0.0018, 2 * a - 0.001), 0.0005).moved((lw - 0.0045, y * (a - 0.0011), 0))
    body = m.lathe([(a - 0.0006, -0.0035), (a, -0.0025), (a, lw - 0.0095), (a - 0.0005, lw - 0.008)], 14)
    wrist = body.moved(rotation=m.rot_y(np.pi / 2)) + yoke
    pins = (m.cylinder(0.0013, -a - 0.0004, a + 0.0004, 10) +
            m.cylinder(0.0012, -a - 0.0004, a + 0.0004, 10).moved((lw, 0, 0), m.rot_x(np.pi / 2)))
    return {'shaft': shaft, 'shaft_ring': ring, 'wrist': wrist, 'wrist_pins': pins}


def jaw_mesh(d):
    """Jaw 2: opens towards +y, grips with its face at y = 0; x runs from the pivot to the tip. Jaw 1 is it turned."""
    t = d['tool']
    length, w = t['jaw_length'], t['jaw_width'] / 2
    sections = []
    teeth = 6
    for i in range(2 * teeth + 1):
        s = i / (2 * teeth)
        x = t['jaw_start'] + s * (length - t['jaw_start'])
        height = t['jaw_height'] + s * (t['jaw_tip_height'] - t['jaw_height'])
        half = w * (1.0 - 0.2 * s * s)
        inner = 0.00005 if i % 2 == 0 else 0.00035
        sections.append([(x, inner, -half), (x, height * 0.8, -half), (x, height, -half * 0.75),
                         (x, height, half * 0.75), (x, height * 0.8, half), (x, inner, half)])
    blade = m.loft(sections)
    hub = m.cylinder(0.0021, 0.0001, 0.0013, 14, 0.0002)
    neck = m.box_between((0.0, 0.0001, 0.0001), (0.0030, 0.0018, 0.0013))
    return blade + hub + neck


def meshes(d, arms):
    out = {}
    for name, body in base_meshes(d, arms.rcm['L'][2]).items():
        out[name + '_L'] = body
        out[name + '_R'] = body.moved(rotation=np.diag([1.0, -1.0, 1.0]))
    for part in (link1_meshes(d), link2_meshes(d), link3_meshes(d), tool_meshes(d, arms.lw, -arms.d4)):
        out.update(part)
    out['jaw'] = jaw_mesh(d)
    return out


# ---- inertia --------------------------------------------------------------------------------------------------------

def principal(tensor):
    """Principal moments, ascending."""
    return np.linalg.eigvalsh(np.asarray(tensor, float))


def possible(moments):
    """A body's largest moment is at most the sum of the others; the published link 1 exceeds that by 0.15 %."""
    return np.array([moments[0], moments[1], min(moments[2], 0.999 * (moments[0] + moments[1]))])


def placed(moments, smallest_along, largest_along):
    """Tensor with the smallest and the largest moment about the given directions."""
    a = np.asarray(smallest_along, float) / np.linalg.norm(smallest_along)
    c = np.asarray(largest_along, float)
    c = c - (c @ a) * a
    c /= np.linalg.norm(c)
    R = np.column_stack([a, np.cross(c, a), c])
    return R @ np.diag(moments) @ R.T


def link_inertials(d, side):
    i = d['inertia']
    end = d['chain']['link_angle_12'] * DEGREE
    chord = side.to_link1 @ (along(end) - along(0.0))
    normal = np.array([1.0, 0.0, 0.0])
    com2 = np.array(i[f'link2_com_{side.letter}'])
    about_rcm = principal(i['link2_tensor'])
    about_com = about_rcm - i['link2_mass'] * (com2 @ com2) * np.array([0.0, 1.0, 1.0])
    return {
        'link1': (i['link1_mass'], np.array(i[f'link1_com_{side.letter}']),
                  placed(possible(principal(i['link1_tensor'])), chord, normal)),
        'link2': (i['link2_mass'], com2, placed(possible(about_com), com2, normal)),
        'link3': (i['link3_mass'], np.array(i['link3_com']), np.array(i['link3_tensor'])),
    }


def tool_inertials(d, built, length):
    """From geometry: a steel tube, and solid steel for the wrist and the jaws."""
    t, steel = d['tool'], d['inertia']['steel_density']
    outer = m.cylinder(t['shaft_radius'], 0.0035, length, 64)
    bore = m.cylinder(t['shaft_bore'], 0.0035, length, 64)
    tube = m.Mesh(np.concatenate([outer.triangles, bore.flipped().triangles]))
    return {'shaft': m.mass_properties(tube, steel), 'wrist': m.mass_properties(built['wrist'], steel),
            'jaw2': m.mass_properties(built['jaw'], steel),
            'jaw1': m.mass_properties(built['jaw'].moved(rotation=m.rot_x(np.pi)), steel)}


# ---- URDF -----------------------------------------------------------------------------------------------------------

def arc_points(radius, start, end, count, rotation):
    return [rotation @ (radius * along(a)) for a in np.linspace(start, end, count)]


def collisions(d, side, lw, length):
    b, k1, k2, k3, t = d['base'], d['link1'], d['link2'], d['link3'], d['tool']
    end1, end2 = d['chain']['link_angle_12'] * DEGREE, d['chain']['link_angle_23'] * DEGREE
    half, near, far = b['plate_half_width'], b['plate_near'], b['plate_far']
    low = b['plate_height'] - b['plate_thickness'] - b['housing_depth']
    mirror = np.diag([1.0, side.outward, 1.0])
    R_BW = side.R_WB.T
    base = []
    for lo, hi in (((-half, near, low), (half, far, b['plate_height'])),
                   ((-half, near + 0.06, b['plate_height']), (half, far, 0.09)),
                   ((-0.04, near, b['plate_height']), (0.04, near + 0.045, 0.04))):
        corners = np.array([mirror @ np.array(lo), mirror @ np.array(hi)])
        size = np.abs(corners[1] - corners[0])
        base.append(u.box_shape(size, R_BW @ corners.mean(axis=0), R_BW))
    insertion = side.to_link2 @ m.rot_x(end2)
    rail = u.box_shape((k2['rail_width'] + 0.006, k2['rail_thickness'] + 0.020, k2['rail_far'] - k2['rail_near']),
                       insertion @ np.array([0, k2['rail_offset'], (k2['rail_near'] + k2['rail_far']) / 2]), insertion)
    face = -k2['rail_offset'] + k2['rail_thickness'] / 2
    half3, w3 = k3['carriage_length'] / 2, k3['carriage_width'] / 2
    tip, half_width = t['jaw_length'], t['jaw_box_width'] / 2
    jaw = lambda y: [u.box_shape_between((0, 0, -half_width), (tip, y * t['jaw_box_height'], half_width))]
    return {
        'base': base,
        'link1': u.capsule_chain(arc_points(k1['radius'], 0, end1, 6, side.to_link1), 0.5 * k1['width']),
        'link2': u.capsule_chain(arc_points(k2['radius'], 0, end2 - 0.2, 4, side.to_link2), 0.5 * k2['width']) + [rail],
        'link3': [u.box_shape_between((face, -w3, -half3), (0.020, w3, half3))],
        'shaft': [u.capsule((0, 0, t['shaft_radius']), (0, 0, length), t['shaft_radius'])],
        'wrist': [u.capsule((0, 0, 0), (lw - 0.001, 0, 0), t['wrist_radius'])],
        'jaw1': jaw(-1.0), 'jaw2': jaw(1.0),
    }


def visuals(side):
    def parts(prefix, accent_rotation=np.eye(3), suffix=''):
        names = {'black': 'black_anodised', 'aluminium': 'aluminium', 'steel': 'steel', 'accent': side.accent}
        if prefix == 'base':
            names.update({'motors': 'dark_motor', 'brass': 'brass'})
        return [u.Visual(f'{prefix}_{part}{suffix}', material, accent_rotation) for part, material in names.items()]

    return {
        'base': parts('base', side.R_WB.T, '_' + side.letter),
        'link1': parts('link1', side.to_link1), 'link2': parts('link2', side.to_link2), 'link3': parts('link3'),
        'shaft': [u.Visual('shaft', 'steel'), u.Visual('shaft_ring', side.accent)],
        'wrist': [u.Visual('wrist', 'bright_steel'), u.Visual('wrist_pins', 'dark_motor')],
        'jaw1': [u.Visual('jaw', 'bright_steel', m.rot_x(np.pi))], 'jaw2': [u.Visual('jaw', 'bright_steel')],
    }


def joints(d, arms, side):
    """Name, kind, parent, child, position, rotation, axis, limits, in chain order. Modified DH: an origin is
    RotX(alpha) TransX(a) RotZ(offset) TransZ(d), the axis +-z."""
    c, left = d['chain'], side.letter == 'L'
    s = '_' + side.letter
    twist3 = (180.0 - c['link_angle_23'] if left else c['link_angle_23']) * DEGREE
    roll = (-1 if left else 1) * c['roll_offset'] * DEGREE
    R3 = m.rot_x(twist3) @ m.rot_z((90 if left else -90) * DEGREE)
    wrist_sign = 1.0 if left else -1.0
    low, high = arms.limits
    limit = lambda a, b, i: (a, b, d['joints']['effort'][i], d['joints']['velocity'][i])
    wrist = sorted((wrist_sign * low[4], wrist_sign * high[4]))
    z = (0, 0, 1)
    return [
        ('shoulder' + s, 'revolute', 'base_link', 'link1', (0, 0, 0),
         m.rot_x(0 if left else np.pi) @ m.rot_z(c['shoulder_offset' + s] * DEGREE), z, limit(low[0], high[0], 0)),
        ('elbow' + s, 'revolute', 'link1', 'link2', (0, 0, 0),
         m.rot_x(c['link_angle_12'] * DEGREE) @ m.rot_z(c['elbow_offset' + s] * DEGREE), z, limit(low[1], high[1], 1)),
        ('insertion' + s, 'prismatic', 'link2', 'link3', R3 @ np.array([0, 0, -arms.d4]), R3, z,
         limit(low[2] + arms.d4, high[2] + arms.d4, 2)),
        ('tool_roll' + s, 'revolute', 'link3', 'instrument_shaft', (0, 0, arms.d4), m.rot_z(-roll), z,
         limit(low[3] + roll, high[3] + roll, 3)),
        ('wrist_joint' + s, 'revolute', 'instrument_shaft', 'wrist', (0, 0, 0),
         m.rot_x(np.pi / 2) @ m.rot_z(c['wrist_offset'] * DEGREE), (0, 0, wrist_sign), limit(*wrist, 4)),
        ('grasper_joint_1' + s, 'revolute', 'wrist', 'grasper1', (arms.lw, 0, 0), m.rot_x(np.pi / 2), (0, 0, -1),
         limit(low[5], high[5], 5)),
        ('grasper_joint_2' + s, 'revolute', 'wrist', 'grasper2', (arms.lw, 0, 0), m.rot_x(np.pi / 2), (0, 0, -1),
         limit(-high[6], -low[6], 6)),
    ]


BODY = {'base_link': 'base', 'link1': 'link1', 'link2': 'link2', 'link3': 'link3', 'instrument_shaft': 'shaft',
        'wrist': 'wrist', 'grasper1': 'jaw1', 'grasper2': 'jaw2'}


def document(d, arms, built):
    doc = u.Document('raven2', MATERIALS)
    doc.link('world')
    for side in (LEFT, RIGHT):
        s = '_' + side.letter
        shapes, looks = collisions(d, side, arms.lw, -arms.d4), visuals(side)
        inertials = {**link_inertials(d, side), **tool_inertials(d, built, -arms.d4)}
        for link, body in BODY.items():
            doc.link(link + s, inertials.get(body), looks[body], shapes[body])
        doc.joint('camera' + s, 'fixed', 'world', 'base_link' + s, arms.rcm[side.letter], side.R_WB)
        for name, kind, parent, child, position, rotation, axis, limit in joints(d, arms, side):
            doc.joint(name, kind, parent + s, child + s, position, rotation, axis, limit)
    return doc.text()
