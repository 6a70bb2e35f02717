"""Smoothness of a row of speeds by the published definitions, with numpy: tests compare the programs' figures with it.

SPARC as in Balasubramanian et al. 2015 (its siva82kb/SPARC, scripts/smoothness.py), dimensionless jerk likewise.
"""
import math

import numpy

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


def dimensionless_jerk(*pieces):
    squares = sum(numpy.sum((numpy.diff(speed, 2) * RATE ** 2) ** 2) for speed in pieces)
    speeds = numpy.concatenate(pieces)
    return -(len(speeds) / RATE) ** 3 / numpy.abs(speeds).max() ** 2 * squares / RATE


def stroke(duration):
    s = numpy.arange(round(duration * RATE)) / (duration * RATE)
    return (30 * s ** 2 - 60 * s ** 3 + 30 * s ** 4) / duration
