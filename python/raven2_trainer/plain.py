"""Values of callers: numpy's in JSON, and whole numbers."""

import numbers

import numpy as np


def as_plain(value):
    """numpy's arrays and numbers as lists and numbers: `default` of json.dumps."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"{value!r}: expected a number, text, list or dict")


def whole_number(name, value, least=1, most=None):
    """The value, if it is one in this range. @raise ValueError."""
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or value < least or (most is not None and value > most):
        raise ValueError(f"{name} is {value!r}, expected a whole number " + (f"of at least {least}" if most is None else f"from {least} to {most}"))
    return int(value)
