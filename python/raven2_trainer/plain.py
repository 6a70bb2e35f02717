"""numpy's values in JSON."""

import numpy as np


def as_plain(value):
    """numpy's arrays and numbers as lists and numbers: `default` of json.dumps."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"{value!r}: expected a number, text, list or dict")
