"""The formulas by which a session's log keeps some numbers of its ticks (doc/session.md, Formulas).

Every reader must get the same bits, so the order of the operations is fixed. Nothing here may be reordered. Functions of numpy
whose last bit depends on the library (sin, cos, dot, sum) may not be used.
"""

import struct

import numpy as np

PERIOD = 0.001      # s
MOST_CYCLES = 8
KINDS = {1: ((1, 7, 7), (7, 7, 7, 7), 182), 2: ((7,), (7,), 14), 3: ((7, 7, 7), (7,), 28), 4: ((7, 7), (3, 3), 3),
         5: ((7,), (4,), 3)}  # columns that it needs, columns that it gives, constants
QUARTERS_PER_RADIAN = 6.36619772367581382433e-01
QUARTER = (1.57079632673412561417e+00, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
SINE = (-1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04, 2.75573137070700676789e-06,
        -2.50507602534068634195e-08, 1.58969099521155010221e-10)
COSINE = (4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05, -2.75573143513906633035e-07,
          2.08757232129817482790e-09, -1.13596475577881948265e-11)
LINK_12 = (0.25881904510252076235, 0.96592582628906828675)
LINK_23 = (0.61566147532565827967, 0.78801075360672195669)
CHAINS = (((1.0, 0.0), (-LINK_23[0], LINK_23[1]), (0.0, 1.0), 3.5779249665883754, np.pi),
          ((-1.0, 0.0), LINK_23, (0.0, -1.0), 0.43633231299858238, 0.0))


def _cos_sin(radians):
    """(cosine, sine)"""
    angle = np.where(np.abs(radians) <= 1e5, radians, 0.0)
    k = np.rint(angle * QUARTERS_PER_RADIAN)
    r = ((angle - k * QUARTER[0]) - k * QUARTER[1]) - k * QUARTER[2]
    z = r * r
    sine, cosine = SINE[5], COSINE[5]
    for i in range(4, -1, -1):
        sine = sine * z + SINE[i]
        cosine = cosine * z + COSINE[i]
    s = r + (z * r) * sine
    c = 1.0 - (0.5 * z - (z * z) * cosine)
    quarter = k.astype(np.int64) & 3
    is_odd = (quarter & 1) == 1
    first, second = np.where(is_odd, s, c), np.where(is_odd, c, s)
    return (np.where((quarter == 1) | (quarter == 2), -first, first), np.where(quarter >= 2, -second, second))


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


class _Axes:
    """A frame that goes along the arm: its axes, each three arrays."""

    def __init__(self):
        self.x, self.y, self.z = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]

    def link(self, twist, angle):
        for i in range(3):
            twisted = twist[0] * self.y[i] + twist[1] * self.z[i]
            self.z[i] = twist[0] * self.z[i] - twist[1] * self.y[i]
            self.y[i] = angle[0] * twisted - angle[1] * self.x[i]
            self.x[i] = angle[0] * self.x[i] + angle[1] * twisted


def _walk(arm, q):
    """(axes at the wrist, axes of shoulder, elbow and shaft)"""
    twist0, twist2, theta3, offset1, offset2 = CHAINS[0 if arm == 0.0 else 1]
    axes = _Axes()
    axes.link(twist0, _cos_sin(q[0] + offset1))
    shoulder = list(axes.z)
    axes.link(LINK_12, _cos_sin(q[1] + offset2))
    elbow = list(axes.z)
    axes.link(twist2, theta3)
    shaft = list(axes.z)
    axes.link((1.0, 0.0), _cos_sin(q[3]))
    axes.link((0.0, 1.0), _cos_sin(q[4] - np.pi / 2.0))
    return axes, shoulder, elbow, shaft


def _tip(numbers, q, dq):
    """Place and velocity."""
    arm, d4, lw = numbers
    wrist, shoulder, elbow, shaft = _walk(arm, q)
    depth = q[2] + d4
    lever = [lw * wrist.x[i] for i in range(3)]
    p = [depth * shaft[i] + lever[i] for i in range(3)]
    columns = [_cross(shoulder, p), _cross(elbow, p), shaft, _cross(shaft, p), _cross(wrist.z, lever)]
    v = []
    for i in range(3):
        v.append(columns[0][i] * dq[0])
        for j in range(1, 5):
            v[i] = v[i] + columns[j][i] * dq[j]
    return [*p, *v]


def _quaternion(axes):
    m = [[axes.x[i], axes.y[i], axes.z[i]] for i in range(3)]
    trace = (m[0][0] + m[1][1]) + m[2][2]
    t = np.sqrt(trace + 1.0)
    f = 0.5 / t
    result = [(m[2][1] - m[1][2]) * f, (m[0][2] - m[2][0]) * f, (m[1][0] - m[0][1]) * f, 0.5 * t]
    largest = np.where(m[1][1] > m[0][0], 1, 0)
    largest = np.where(m[2][2] > np.where(largest == 1, m[1][1], m[0][0]), 2, largest)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        here = ~(trace > 0.0) & (largest == i)
        t = np.sqrt(((m[i][i] - m[j][j]) - m[k][k]) + 1.0)
        f = 0.5 / t
        other = {i: 0.5 * t, 3: (m[k][j] - m[j][k]) * f, j: (m[j][i] + m[i][j]) * f, k: (m[k][i] + m[i][k]) * f}
        result = [np.where(here, other[n], result[n]) for n in range(4)]
    return result


def _times(matrix, values):
    """Of columns: matrix times values, from the left term to the right."""
    rows = []
    for row in matrix:
        total = row[0] * values[0]
        for k in range(1, 7):
            total = total + row[k] * values[k]
        rows.append(total)
    return rows


def _filtered(steps, x, y):
    """The robot's low pass: first its last result before these steps, then one for each step.

    steps: rows of rates. x, y: the last three rates and results before them, newest first."""
    before = np.concatenate([x[::-1], steps])
    inputs = ((0.02864 * steps + 0.08591 * before[2:-1]) + 0.08591 * before[1:-2]) + 0.02864 * before[:-3]
    out = np.concatenate([y[::-1], np.empty_like(steps)])
    rows, term = list(out), np.empty(out.shape[1])
    add, subtract, multiply = np.add, np.subtract, np.multiply
    for i, given in enumerate(inputs):
        row = rows[i + 3]
        multiply(rows[i + 2], 1.5189, term)
        add(given, term, row)
        multiply(rows[i + 1], 0.9600, term)
        subtract(row, term, row)
        multiply(rows[i], 0.2120, term)
        add(row, term, row)
    return out[2:]


def _robot(numbers, cycle, gold, green):
    matrices = numbers[:98].reshape(2, 7, 7)
    x, y = (numbers[begin : begin + 42].reshape(2, 3, 7).transpose(1, 0, 2).reshape(3, 14) for begin in (98, 140))
    motor = np.concatenate([gold, green]).T
    cycles = np.clip((cycle[1:].view(np.uint64) - cycle[:-1].view(np.uint64)).view(np.int64), 0, MOST_CYCLES)
    rates = ((motor[1:] - motor[:-1]) / cycles[:, None].astype(float)) / PERIOD
    filtered = _filtered(np.repeat(rates, cycles, axis=0), x, y)
    filtered = filtered[np.concatenate([[0], np.cumsum(cycles)])].T
    return [*_times(matrices[0], gold), *_times(matrices[1], green), *_times(matrices[0], filtered[:7]),
            *_times(matrices[1], filtered[7:])]


def _positions(numbers, rate):
    base, bend = numbers.reshape(2, 7, 1)
    before, now = rate[:, :-1], rate[:, 1:]
    steps = ((before + now) / 2.0) * PERIOD + bend * (now - before)
    return np.cumsum(np.concatenate([base, steps], axis=1), axis=1)


def _control(numbers, q_d, q, dq):
    kp, kd, ki, base = numbers.reshape(4, 7, 1)
    error = q_d - np.concatenate([q[:, :1], q[:, :-1]], axis=1)
    term = (ki * PERIOD) * error
    term[:, 0] = 0.0
    return ((kp * error - kd * np.concatenate([dq[:, :1], dq[:, :-1]], axis=1)) + np.cumsum(term, axis=1)) + base


def _orientation(numbers, q):
    tool = _walk(numbers[0], q)[0]
    tool.link((0.0, 1.0), _cos_sin((q[6] - q[5]) / 2.0))
    return _quaternion(tool)


EVALUATE = {1: _robot, 2: _positions, 3: _control, 4: _tip, 5: _orientation}


class Formula:
    """One formula of a group: `needs` and `gives`, (first column, columns)."""

    def __init__(self, contents, position):
        """Of the bytes from `position` on. @throw ValueError for what no writer makes."""
        kind = int(contents[position]) if position < len(contents) else 0
        if kind not in KINDS:
            raise ValueError("no formula")
        needs, gives, constants = KINDS[kind]
        layout = struct.Struct(f"<{len(needs) + len(gives)}H{constants}d")
        self.size = 1 + layout.size
        try:
            values = layout.unpack_from(contents, position + 1)
        except struct.error as error:
            raise ValueError(str(error)) from None
        blocks = list(zip(values, needs + gives))
        self.needs, self.gives = blocks[: len(needs)], blocks[len(needs) :]
        self.is_robot = kind == 1
        self._numbers = np.array(values[len(blocks) :])
        self._evaluate = EVALUATE[kind]

    def fits(self, forms):
        """Whether its columns are numbers of the record: f64, but for the robot's cycle."""
        return all(first + width <= len(forms) and (forms[first : first + width] == (8 if width == 1 else 0x88)).all()
                   for first, width in self.needs + self.gives)

    def results(self, needed):
        """An array (column, record). needed: the columns that it needs, each an array (column, record)."""
        with np.errstate(all="ignore"):
            results = np.array([np.broadcast_to(column, needed[-1].shape[1]) for column in self._evaluate(self._numbers, *needed)])
        return np.where(np.isfinite(results), results, 0.0)
