"""Scenes from meshes/scenes/*.yaml: the elements that they list, as URDF, meshes and roles (config/scenes/*.yaml)."""

import numpy as np
import yaml

from . import mesh as m
from . import scene as s
from . import urdf as u

MATERIALS = {  # beyond those of every scene
    'ring_green': (0.10, 0.55, 0.25, 1), 'ring_yellow': (0.93, 0.72, 0.06, 1), 'board': (0.16, 0.22, 0.30, 1),
    'peg': (0.86, 0.86, 0.84, 1),
}
MARK = '# Written by scripts/generate_description from meshes/scenes/'
MAX_BODIES = 12  # kMaxSceneBodies of core/scene_roles.h


class Part:
    """An element of the file: its keys, each of which must be read, and the dimensions of its kind."""

    def __init__(self, place, entry, defaults):
        self.place, self.entry, self.read = place, dict(entry), {'kind'}
        self.sizes = dict(defaults)
        for key in set(self.sizes) & set(self.entry):
            self.sizes[key] = self.take(key)

    def take(self, key, default=None):
        self.read.add(key)
        if key not in self.entry and default is None:
            raise SystemExit(f'{self.place}: {key} is missing')
        return self.entry.get(key, default)

    def finish(self):
        if set(self.entry) - self.read:
            raise SystemExit(f'{self.place}: unknown key {", ".join(sorted(set(self.entry) - self.read))}')


class Scene:
    """Collects what the elements add."""

    def __init__(self, name, path, data, dimensions):
        self.name, self.path, self.d = name, path, dimensions
        head = {key: data.pop(key, None) for key in ('title', 'source', 'parking', 'elements', 'points', 'regions')}
        if data or None in head.values():
            raise SystemExit(f'{path}: needs title, source, parking, elements, points and regions, and nothing else')
        self.head, self.meshes, self.materials = head, {}, dict(s.MATERIALS)
        self.links, self.bodies = [], 0
        self.objects, self.pegs, self.wires, self.breakables, self.tissue = {}, {}, {}, [], []
        for i, entry in enumerate(head['elements']):
            self._add(f'{path}: element {i + 1}', entry)

    def _add(self, place, entry):
        if entry.get('kind') not in KINDS:
            raise SystemExit(f'{place}: kind is {entry.get("kind")}, expected one of {", ".join(KINDS)}')
        section, build = KINDS[entry['kind']]
        part = Part(place, entry, self.d.get(section, {}))
        build(self, part)
        part.finish()
        if self.bodies > MAX_BODIES:
            raise SystemExit(f'{place}: more than {MAX_BODIES} bodies that can move')

    def mesh(self, name, body):
        """Adds a mesh; the same name may stand for the same shape again."""
        if name in self.meshes and self.meshes[name].stl() != body.stl():
            raise SystemExit(f'{self.path}: two different meshes are called {name}')
        self.meshes[name] = body

    def colour(self, name):
        if name not in self.materials:
            if name not in MATERIALS:
                raise SystemExit(f'{self.path}: no colour is called {name}')
            self.materials[name] = MATERIALS[name]
        return name

    def fixed(self, name, material, looks, shapes, position=(0, 0, 0), inertial=None):
        self.links.append((name, 'fixed', inertial, looks, shapes, material, position))

    def free(self, name, material, inertial, looks, shapes, position):
        self.links.append((name, 'floating', inertial, looks, shapes, material, position))
        self.bodies += 1

    def urdf(self):
        doc = u.Document(self.name, self.materials)
        doc.link('world')
        for name, kind, inertial, looks, shapes, material, position in self.links:
            doc.link(name, inertial, looks, shapes, material)
            doc.joint(name + '_joint', kind, 'world', name, position)
        return doc.text()


def plate(scene, part):
    p = part.sizes
    size = (p['table_length'], p['table_width'], p['table_thickness'])
    scene.mesh('table', m.box(size, 0.003))
    scene.mesh('plate', m.cylinder(p['radius'], -p['thickness'], 0.0, 64, 0.0015))
    scene.fixed('table', 'plate', [u.Visual('table', 'table_top')], [u.box_shape(size, (0, 0, 0))],
                (0, 0, -p['thickness'] - p['table_thickness'] / 2))
    edge = 2 * p['radius']
    scene.fixed('base_plate', 'plate', [u.Visual('plate', 'plate')], [u.box_shape((edge, edge, 0.020), (0, 0, -0.010))])
    scene.tissue.append('base_plate')


def dome(scene, part):
    o = part.sizes
    d = {**scene.d, 'dome': o}
    scene.mesh('dome_wall', m.tube_ring(o['outer_radius'] - o['thickness'], o['outer_radius'], 0.0, o['wall_height'],
                                        64))
    for name, body in s.lid_meshes(d).items():
        scene.mesh(name, body)
    scene.fixed('dome_wall', 'skin', [u.Visual('dome_wall', 'skin')], s.wall_panels(d))
    scene.fixed('dome_lid', 'skin', [u.Visual('lid_skin', 'skin'), u.Visual('lid_inside', 'flesh')], s.lid_panels(d))
    scene.tissue += ['dome_wall', 'dome_lid']


def tower(scene, part):
    name, at, breaks = part.take('name'), part.take('at'), part.take('breaks', {})
    body = s.tower_mesh(part.sizes)
    look = part.take('mesh', 'tower')
    scene.mesh(look, body)
    inertial = m.mass_properties(body, scene.d['inertia']['plastic_density']) if breaks else None
    scene.fixed(name, 'post', [u.Visual(look, scene.colour(part.take('colour')))], s.tower_shapes(part.sizes),
                (*at, 0.0), inertial)
    scene.pegs[short(name)] = {'link': name, 'base_W': [*at, 0.0], 'height': part.sizes['height'],
                               'radius': part.sizes['radius']}
    if breaks:
        scene.bodies += 1
        scene.breakables.append({'link': name, **breaks})


def strand(scene, part, path, looks_like):
    """A wire or a rail along `path`, one point a millimetre or so."""
    name, radius = part.take('name'), part.sizes['radius']
    line = s.by_length(path, 15)
    scene.mesh(looks_like or name, s.strand_mesh(path, radius, part.sizes.get('knob_radius')))
    scene.fixed(name, 'wire', [u.Visual(looks_like or name, 'wire')], u.capsule_chain(line, radius))
    scene.wires[short(name)] = {'link': name, 'radius': radius, 'line_W': line}


def wire(scene, part):
    strand(scene, part, s.wire_path(part.take('start'), part.take('end'), part.take('amplitude'),
                                    part.sizes['height'], 400), part.take('mesh', ''))


def rail(scene, part):
    strand(scene, part, s.rail_path(part.take('start'), part.take('end'), part.take('amplitude'),
                                    part.sizes['height'], 400), None)


def stand(scene, part):
    scene.mesh('stand', s.stand_mesh(part.sizes))
    scene.fixed(part.take('name'), 'post', [u.Visual('stand', 'stand')],
                [u.box_shape_between(a, b) for a, b in s.stand_boxes(part.sizes)], (*part.take('at'), 0.0))


def ring(scene, part, look, body, shapes, role):
    name = part.take('name')
    scene.mesh(look, body)
    scene.free(name, 'ring', m.mass_properties(body, scene.d['inertia']['plastic_density']),
               [u.Visual(look, scene.colour(part.take('colour')))], shapes, part.take('at'))
    scene.objects[name] = {'link': name, **role, 'bar_radius': part.sizes['bar_radius']}


def square_ring(scene, part):
    r = part.sizes
    ring(scene, part, 'ring', m.sweep(s.ring_path(r, 5, 0.0035), r['bar_radius'], 12, closed=True), s.ring_shapes(r),
         {'shape': 'square', 'inner_radius': round(r['side'] / 2 - r['bar_radius'], 9)})


def round_ring(scene, part):
    r = part.sizes
    ring(scene, part, part.take('mesh', 'round_ring'), s.round_ring_mesh(r), s.round_ring_shapes(r),
         {'shape': 'round', 'inner_radius': round(r['radius'] * np.cos(np.pi / s.CAPSULES) - r['bar_radius'], 6)})


def peg_board(scene, part):
    """A slab with rows of pegs along x: row `left` at y = +half_width, `right` opposite; pegs count away from the
    surgeon."""
    b, xs, y = part.sizes, part.take('columns'), part.take('half_width')
    low, high = np.array([min(xs), -y]) - b['margin'], np.array([max(xs), y]) + b['margin']
    slab = m.box((high[0] - low[0], high[1] - low[1], b['thickness']), 0.0008)
    middle = np.round([*(low + high) / 2, b['thickness'] / 2], 9)
    scene.mesh('peg_board', slab)
    scene.mesh('peg', s.tower_mesh({'height': b['peg_height'], 'radius': b['peg_radius'],
                                    'foot_radius': b['peg_radius'] + 0.0005}, 0.25))
    scene.fixed('board', 'plate', [u.Visual('peg_board', scene.colour('board'))],
                [u.box_shape((high[0] - low[0], high[1] - low[1], b['thickness']), (0, 0, 0))], middle)
    scene.tissue.append('board')
    for side, sign in (('left', 1), ('right', -1)):
        for i, x in enumerate(xs):
            peg(scene, b, f'peg_{side}_{i + 1}', [x, sign * y, b['thickness']])


def peg(scene, b, name, base):
    r = b['peg_radius']
    scene.fixed(name, 'post', [u.Visual('peg', scene.colour('peg'))],
                [u.capsule((0, 0, r), (0, 0, b['peg_height'] - r), r)], base)
    scene.pegs[short(name)] = {'link': name, 'base_W': base, 'height': b['peg_height'], 'radius': r}


def short(name):
    """tower_far_left: far_left."""
    return name.split('_', 1)[1] if '_' in name else name


# Kind: section of meshes/dimensions.yaml that has its dimensions, and what builds it.
KINDS = {'plate': ('plate', plate), 'dome': ('dome', dome), 'tower': ('towers', tower), 'wire': ('wires', wire),
         'rail': ('rails', rail), 'stand': ('ring', stand), 'square_ring': ('ring', square_ring),
         'round_ring': ('round_ring', round_ring), 'peg_board': ('peg_board', peg_board)}


def flow(value):
    """YAML in one line."""
    if isinstance(value, dict):
        return '{' + ', '.join(f'{key}: {flow(v)}' for key, v in value.items()) + '}'
    if isinstance(value, (list, tuple, np.ndarray)):
        return '[' + ', '.join(flow(v) for v in value) + ']'
    return value if isinstance(value, str) else u.number(round(value, 6) + 0.0)


def mapping(key, entries, note):
    """Key with one entry a line, or one point a line."""
    head = f'{key}:' + ('' if entries else ' {}')
    return [f'{head:<31}# {note}'] + [line for name, entry in entries.items() for line in named(name, entry)]


def named(name, entry):
    if 'line_W' not in entry:
        return [f'  {name}: {flow(entry)}']
    rest = [f'    {key}: {flow(value)}' for key, value in entry.items() if key != 'line_W']
    return [f'  {name}:', *rest, '    line_W:', *(f'      - {flow(point)}' for point in entry['line_W'])]


def roles(scene):
    """The text of config/scenes/NAME.yaml."""
    head = scene.head
    lines = [f'{MARK}{scene.name}.yaml.', f'# {head["source"]}', f'title: {head["title"]}',
             f'urdf: ../../urdf/{scene.name}.urdf']
    lines += mapping('objects', scene.objects, '[m] free bodies; opening in the x-y plane of the link')
    lines += mapping('pegs', scene.pegs, '[m] upright from base_W')
    lines += mapping('wires', scene.wires, "[m] centre line, from the object's start")
    lines += [f'{"breakables:" + ("" if scene.breakables else " []"):<31}# [N] and [Nm] about the foot, exceeded for [1 ms]']
    lines += [f'  - {flow(entry)}' for entry in scene.breakables]
    lines += [f'tissue: {flow(scene.tissue)}']
    lines += mapping('points', head['points'], '[m] in W')
    lines += mapping('regions', head['regions'], '[m] in W')
    lines += [f'parking: {"true" if head["parking"] else "false"}', '']
    return '\n'.join(lines)


def read(path, dimensions):
    return Scene(path.stem, path.name, yaml.safe_load(path.read_text()), dimensions)
