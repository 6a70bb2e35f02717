"""MJCF for MuJoCo from the package's own URDF files and config/model.yaml: the same links, masses, joints, friction and shapes.

Differences that MJCF cannot express: a surface's stiffness in N/m (MuJoCo's is by effective mass: contacts are stiff here),
and towers that break off."""

import xml.etree.ElementTree as ElementTree

import numpy as np

from .urdf import number, numbers

# Who meets whom (doc/model.md): an arm not itself, what is fixed only what moves.
GOLD, GREEN, FIXED, FREE = 1, 2, 4, 8
MEETS = {GOLD: GREEN | FIXED | FREE, GREEN: GOLD | FIXED | FREE, FIXED: 0, FREE: FIXED | FREE}
JOINTS = ('shoulder', 'elbow', 'insertion', 'tool_roll', 'wrist_joint', 'grasper_joint_1', 'grasper_joint_2')
GAINS = ('shoulder', 'elbow', 'insertion', 'tool_rotation', 'wrist', 'grasp1', 'grasp2')  # their names in model.yaml


def values(text):
    return np.array([float(word) for word in text.split()])


def quaternion(rpy):
    """w, x, y, z of Rz(yaw) Ry(pitch) Rx(roll)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(np.asarray(rpy) / 2), np.sin(np.asarray(rpy) / 2)
    return np.array([cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
                     cr * cp * sy - sr * sp * cy])


def place(element):
    """Attributes pos and quat of a URDF element's origin."""
    origin = element.find('origin')
    if origin is None:
        return {}
    return {'pos': numbers(values(origin.get('xyz', '0 0 0'))), 'quat': numbers(quaternion(values(origin.get('rpy', '0 0 0'))))}


def inertial(link):
    source = link.find('inertial')
    tensor = source.find('inertia')
    turned = place(source).get('quat', '1 0 0 0')
    if not np.allclose(values(turned), [1, 0, 0, 0]):
        raise ValueError(f"{link.get('name')}: a turned tensor has no fullinertia in MJCF")
    return {'pos': source.find('origin').get('xyz'), 'mass': source.find('mass').get('value'),
            'fullinertia': ' '.join(tensor.get(name) for name in ('ixx', 'iyy', 'izz', 'ixy', 'ixz', 'iyz'))}


def shape(geometry):
    """A URDF cylinder of a collision is a capsule as long as it, both round ends included."""
    box, capsule, ball = (geometry.find(name) for name in ('box', 'cylinder', 'sphere'))
    if box is not None:
        return {'type': 'box', 'size': numbers(values(box.get('size')) / 2)}
    if ball is not None:
        return {'type': 'sphere', 'size': ball.get('radius')}
    radius, length = float(capsule.get('radius')), float(capsule.get('length'))
    return {'type': 'capsule', 'size': numbers([radius, max(length / 2 - radius, 1e-9)])}


def home(side, arms):
    """Joints of config/arms.yaml in the URDF's coordinates (kinematics/joint_conventions.h)."""
    q, is_left = np.array(arms.home, float), side == '_L'
    q[2] += arms.d4
    q[3] += -np.pi / 4 if is_left else np.pi / 4
    q[4] *= 1 if is_left else -1
    q[6] *= -1
    return q


def side_of(name):
    return {'_L': GOLD, '_R': GREEN}.get(name[-2:])


class Document:
    """One MJCF model out of URDF files that share the link `world`."""

    def __init__(self, name, model, arms, meshes):
        self.model, self.home = model, {side: home(side, arms) for side in ('_L', '_R')}
        self.root = ElementTree.Element('mujoco', model=name)
        self._add(self.root, 'compiler', angle='radian', autolimits='true', inertiafromgeom='false', meshdir=meshes)
        self._add(self.root, 'option', timestep='0.001', gravity=numbers([0, 0, -model['gravity']]), integrator='implicit',
                  cone='elliptic')
        self.assets, self.world = self._add(self.root, 'asset'), self._add(self.root, 'worldbody')
        self.tendons, self.actuators = self._add(self.root, 'tendon'), self._add(self.root, 'actuator')
        self.meshes, self.qpos, self.widest = set(), [], 0.0  # widest: of the first jaw [rad], until the second one comes

    @staticmethod
    def _add(parent, tag, **attributes):
        return ElementTree.SubElement(parent, tag, attributes)

    def add(self, urdf):
        links = {link.get('name'): link for link in urdf.findall('link')}
        colours = {m.get('name'): m.find('color').get('rgba') for m in urdf.findall('material')}
        children = {}
        for joint in urdf.findall('joint'):
            children.setdefault(joint.find('parent').get('link'), []).append(joint)
        self._children(self.world, 'world', links, children, colours, is_free=False)

    def _children(self, parent, name, links, children, colours, is_free):
        for joint in children.get(name, []):
            self._body(parent, joint, links, children, colours, is_free)

    def _body(self, parent, joint, links, children, colours, is_free):
        name, kind = joint.find('child').get('link'), joint.get('type')
        link, is_free = links[name], is_free or kind == 'floating'
        body = self._add(parent, 'body', name=name, **place(joint))
        if kind == 'floating':
            self._add(body, 'freejoint', name=joint.get('name'))
            self.qpos += [*values(body.get('pos')), *values(body.get('quat'))]
        elif kind != 'fixed':
            self._joint(body, joint)
        if link.find('inertial') is not None and (is_free or side_of(name)):
            self._add(body, 'inertial', **inertial(link))
        is_base = name.startswith('base_link_')  # has no shape in the ODE world
        group = side_of(name) or (FREE if is_free else FIXED)
        for collision in [] if is_base else link.findall('collision'):
            mu = self.model['jaw_mu'] if name.startswith('grasper') else self.model['contact_mu']
            self._add(body, 'geom', **place(collision), **shape(collision.find('geometry')), group='3', condim='3',
                      friction=numbers([mu, 0, 0]), contype=str(group), conaffinity=str(MEETS[group]), solref='0.002 1')
        for visual in link.findall('visual'):
            self._visual(body, visual, colours)
        self._children(body, name, links, children, colours, is_free)

    def _joint(self, body, joint):
        name = joint.get('name')
        index = JOINTS.index(name[:-2])
        self.qpos.append(self.home[name[-2:]][index])
        limit, kind = joint.find('limit'), {'revolute': 'hinge', 'prismatic': 'slide'}[joint.get('type')]
        self._add(body, 'joint', name=name, type=kind, axis=joint.find('axis').get('xyz'),
                  range=f"{limit.get('lower')} {limit.get('upper')}", solreflimit='0.002 1',
                  armature=number(self.model['rotor_inertia'][index]), damping=number(self.model['viscous_friction'][index]),
                  frictionloss=number(self.model['coulomb_friction'][index]), solreffriction='0.002 1')
        bound = number(self.model['gains'][GAINS[index]]['limit'])
        self._add(self.actuators, 'motor', name=name, joint=name, ctrlrange=f'-{bound} {bound}')
        if index == len(JOINTS) - 2:
            self.widest = float(limit.get('upper'))
        if index == len(JOINTS) - 1:
            self._jaw_stop(name[-2:], self.widest - float(limit.get('lower')))

    def _jaw_stop(self, side, widest):
        """The jaws meet at an opening J6 + J7 of 0; the URDF's second jaw rotates in the opposite direction."""
        opening = self._add(self.tendons, 'fixed', name=f'opening{side}', range=f'0 {number(widest)}', solreflimit='0.002 1')
        for name, sign in zip(JOINTS[-2:], ('1', '-1')):
            self._add(opening, 'joint', joint=name + side, coef=sign)

    def _visual(self, body, visual, colours):
        name = visual.find('geometry').find('mesh').get('filename').rsplit('/', 1)[1]
        if name not in self.meshes:
            self.meshes.add(name)
            self._add(self.assets, 'mesh', name=name[:-4], file=name)
        self._add(body, 'geom', **place(visual), type='mesh', mesh=name[:-4], group='2', contype='0', conaffinity='0',
                  rgba=colours[visual.find('material').get('name')])

    def text(self):
        self._add(self._add(self.root, 'keyframe'), 'key', name='home', qpos=numbers(self.qpos))
        ElementTree.indent(self.root)
        return ElementTree.tostring(self.root, encoding='unicode') + '\n'


def document(name, urdf_paths, model, arms, meshes):
    """@param meshes folder of the STL files, as the reader of the text finds it."""
    result = Document(name, model, arms, meshes)
    for path in urdf_paths:
        result.add(ElementTree.parse(path).getroot())
    return result.text()
