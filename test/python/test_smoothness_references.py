"""The reference values of test/unit/training/smoothness_test.cpp, derived with numpy from the published definitions.

SPARC as in Balasubramanian et al. 2015 (its siva82kb/SPARC, scripts/smoothness.py), dimensionless jerk likewise.
"""
import math

import numpy
import pytest

RATE = 100.0  # Hz


def spectral_arc_length(speed, padding=4, highest=10.0, threshold=0.05):
    length = 2 ** (math.ceil(math.log2(len(speed))) + padding)
    frequency = numpy.arange(length) * (RATE / length)
    magnitude = numpy.abs(numpy.fft.fft(speed, length))
    magnitude /= magnitude.max()
    frequency, magnitude = frequency[frequency <= highest], magnitude[frequency <= highest]
    above = numpy.nonzero(magnitude >= threshold)[0]
    frequency, magnitude = frequency[above[0]:above[-1] + 1], magnitude[above[0]:above[-1] + 1]
    along = numpy.diff(frequency) / (frequency[-1] - frequency[0])
    return -numpy.sum(numpy.sqrt(along ** 2 + numpy.diff(magnitude) ** 2))


def dimensionless_jerk(speed):
    jerk = numpy.diff(speed, 2) * RATE ** 2
    return -(len(speed) / RATE) ** 3 / numpy.abs(speed).max() ** 2 * numpy.sum(jerk ** 2) / RATE


def stroke(duration):
    s = numpy.arange(round(duration * RATE)) / (duration * RATE)
    return (30 * s ** 2 - 60 * s ** 3 + 30 * s ** 4) / duration


BELL = numpy.exp(-5 * numpy.arange(-1, 1, 0.01) ** 2)
TWO = numpy.concatenate([stroke(1.0), numpy.zeros(50), stroke(1.0)])


@pytest.mark.parametrize("speed, sparc, jerk, logarithm", [
    (BELL, -1.4140313, -335.7468370, -5.816357415),
    (stroke(1.0), -1.4058293, -185.7012255, -5.224139068),
    (stroke(2.0), -1.4058293, -194.9117988, -5.272547142),
    (TWO, -3.1190251, -6021.5976152, -8.703107888)])
def test_smoothness(speed, sparc, jerk, logarithm):
    assert spectral_arc_length(speed) == pytest.approx(sparc, rel=1e-7)
    assert dimensionless_jerk(speed) == pytest.approx(jerk, rel=1e-7)
    assert -math.log(-dimensionless_jerk(speed)) == pytest.approx(logarithm, rel=1e-7)


def test_arc_lengths_of_strokes_without_a_rest_and_of_constant_speed():
    strokes = numpy.abs(numpy.sin(math.pi * numpy.arange(0, 4, 0.01)))
    assert spectral_arc_length(strokes) == pytest.approx(-3.0333230, rel=1e-7)
    assert spectral_arc_length(numpy.ones(200)) == pytest.approx(-2.4011978, rel=1e-7)
