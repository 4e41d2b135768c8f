"""Layers of a body: which share of the tissue at a point is gray matter."""

from __future__ import annotations

import numpy as np
from scipy.special import expit

from ..arrays import Array
from .body import SIGMOID, Body


def cortex_indicator(body: Body, thickness: Array | float | None = None) -> Array:
    """Return the share of cortex at the integration points, (q, e), by the kind of the body's layers.

    "sigmoid": θ(y) = 1/(1 + exp(10 (y/T - 1))) (Choi et al. 2025); "sharp": 1 in gray elements, 0 in white.
    thickness: T where it is not the body's, possibly one per point; m.
    Raises ValueError for another thickness of sharp layers, which are those of the mesh.
    """
    if body.layers == SIGMOID:
        relative = body.relative_depth if thickness is None else body.depth / thickness
        return np.asarray(expit(10.0 * (1.0 - relative)))
    if thickness is not None:
        raise ValueError(
            'a cortical thickness that changes in time or place needs a body with layers="sigmoid"; the '
            'mesh of this one has layers="sharp" of one thickness.'
        )
    return np.broadcast_to(body.in_cortex.astype(float), body.quadrature.weights.shape)
