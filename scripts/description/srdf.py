"""SRDF text: what MoveIt and its kind need beyond the URDF. Groups by arm and jaws, home, which links may overlap."""

from . import arm
from . import urdf as u


class Side:
    """Names of one arm: the groups by its colour, as everywhere in the package; the links by its letter."""

    def __init__(self, side):
        suffix = '_' + side.letter
        self.arm, self.jaws, self.both = side.name + '_arm', side.name + '_jaws', side.name
        self.base, self.wrist = 'base_link' + suffix, 'wrist' + suffix
        self.tips = ['grasper1' + suffix, 'grasper2' + suffix]


def home(d, arms, side):
    """Joint and value of each joint at config/arms.yaml's home, in the URDF's coordinates: those of the robot's own
    /joint_states (raven2.md 5.4), as `kinematics::toUrdf` has them."""
    left = side.letter == 'L'
    q = list(arms.home)
    q[2] += arms.d4
    q[3] += (-1 if left else 1) * d['chain']['roll_offset'] * arm.DEGREE
    q[4] *= 1 if left else -1
    q[6] *= -1
    return list(zip((joint[0] for joint in arm.joints(d, arms, side)), q))


def groups(names):
    """The arm ends at the wrist: the jaws are a group of their own, or the end effector would overlap its arm."""
    return [f'  <group name="{names.arm}"><chain base_link="{names.base}" tip_link="{names.wrist}"/></group>',
            f'  <group name="{names.jaws}">' + ''.join(f'<link name="{tip}"/>' for tip in names.tips) +
            ''.join(f'<joint name="{joint}"/>' for joint in jaw_joints(names)) + '</group>',
            f'  <end_effector name="{names.both}_tool" parent_link="{names.wrist}" parent_group="{names.arm}" '
            f'group="{names.jaws}"/>']


def jaw_joints(names):
    return [f'grasper_joint_{i}' + names.wrist[-2:] for i in (1, 2)]


def state(group, values):
    joints = ''.join(f'<joint name="{name}" value="{u.number(value)}"/>' for name, value in values)
    return f'  <group_state name="home" group="{group}">{joints}</group_state>'


def overlaps(d, arms, side):
    """Links on one joint, and both jaws, which close on each other."""
    suffix = '_' + side.letter
    pairs = [(parent + suffix, child + suffix, 'Adjacent') for _, _, parent, child, *_ in arm.joints(d, arms, side)]
    pairs.append(('grasper1' + suffix, 'grasper2' + suffix, 'Default'))
    return [f'  <disable_collisions link1="{a}" link2="{b}" reason="{why}"/>' for a, b, why in pairs]


def document(d, arms):
    lines = ['<?xml version="1.0"?>', u.MARK + 'from meshes/dimensions.yaml and config/arms.yaml. -->',
             '<robot name="raven2">']
    sides = [(side, Side(side)) for side in (arm.LEFT, arm.RIGHT)]
    for _, names in sides:
        lines += groups(names)
    lines.append('  <group name="both_arms">' + ''.join(f'<group name="{names.arm}"/>' for _, names in sides) +
                 '</group>')
    for side, names in sides:
        values = home(d, arms, side)
        lines += [state(names.arm, values[:5]), state(names.jaws, values[5:])]
    lines.append(state('both_arms', [v for side, _ in sides for v in home(d, arms, side)[:5]]))
    for side, _ in sides:
        lines += overlaps(d, arms, side)
    return '\n'.join(lines + ['</robot>', ''])
