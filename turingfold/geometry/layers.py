"""Layers of a body: which share of the tissue at a point is gray matter."""

from __future__ import annotations

import numpy as np
from scipy.special import expit

from ..arrays import Array
from .body import Body


def cortex_indicator(body: Body, layers: str = "sigmoid", thickness: Array | float | None = None) -> Array:
    """Return the share of cortex at the integration points, (q, e).

    "sigmoid": θ(y) = 1/(1 + exp(10 (y/T - 1))) (Choi et al. 2025), T the body's thickness or another,
    possibly one per point; "sharp": 1 in gray elements, 0 in white ones.
    """
    if layers == "sharp":
        return np.broadcast_to(body.in_cortex.astype(float), body.quadrature.weights.shape)
    return np.asarray(expit(10.0 * (1.0 - body.depth / (body.thickness if thickness is None else thickness))))
