"""Array types, and the sum of values that share a place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Places = NDArray[np.int64] | NDArray[np.int32]
Booleans = NDArray[np.bool_]
Complexes = NDArray[np.complex128]


def add_up(places: Places, values: Array, count: int) -> Array:
    """Return the sums of the values at each of `count` places; both of one shape."""
    sums = np.bincount(places.ravel(), values.ravel(), minlength=count)
    return sums.astype(np.float64, copy=False)
