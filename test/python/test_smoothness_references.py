"""The reference values in test/unit/training/smoothness_test.cpp follow from the published definitions."""
import math
import pathlib
import re

import numpy
import pytest
from smoothness_oracle import dimensionless_jerk, spectral_arc_length, stroke

SOURCE = pathlib.Path(__file__).resolve().parents[1] / "unit" / "training" / "smoothness_test.cpp"
BELL = numpy.exp(-5 * numpy.arange(-1, 1, 0.01) ** 2)
TWO = numpy.concatenate([stroke(1.0), numpy.zeros(50), stroke(1.0)])


def references():
    """(sparc, dlj, ldlj) of the tests in that file: the bell, strokes of 1 and 2 s, two strokes with a rest."""
    number = r"(-[0-9.]+)"
    found = re.findall(rf"\{{{number}, {number}, {number}\}}", SOURCE.read_text())
    return [tuple(map(float, reference)) for reference in found]


def arc_lengths():
    """The separate arc lengths in that file: four strokes without a rest, and a constant speed."""
    return [float(value) for value in re.findall(r"spectralArcLength\(\w+, kRate\)\.value\(\), (-[0-9.]+)",
                                                 SOURCE.read_text())]


def test_smoothness():
    speeds = [BELL, stroke(1.0), stroke(2.0), TWO]
    assert len(references()) == len(speeds)
    for speed, (sparc, jerk, logarithm) in zip(speeds, references()):
        assert spectral_arc_length(speed) == pytest.approx(sparc, rel=1e-7)
        assert dimensionless_jerk(speed) == pytest.approx(jerk, rel=1e-7)
        assert -math.log(-dimensionless_jerk(speed)) == pytest.approx(logarithm, rel=1e-7)


def test_arc_lengths_of_strokes_without_a_rest_and_of_constant_speed():
    strokes = numpy.abs(numpy.sin(math.pi * numpy.arange(0, 4, 0.01)))
    expected = [spectral_arc_length(strokes), spectral_arc_length(numpy.ones(200))]
    assert arc_lengths() == pytest.approx(expected, rel=1e-7)
