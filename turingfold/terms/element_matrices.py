"""Entries of element matrices that couple equal components: constant products and places, shared by terms."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, Places

LOW, HIGH = np.tril_indices(6)[::-1]  # the 21 pairs of nodes of a quadratic triangle


def gradient_products(gradients: Array) -> Array:
    """Return ∂N_a ∂N_b of each pair for the components xx, xy, yy, (21, 3 q), of gradients (6, 2, q)."""
    product = gradients[LOW][:, :, None] * gradients[HIGH][:, None, :]
    parts = [product[:, 0, 0], product[:, 0, 1] + product[:, 1, 0], product[:, 1, 1]]
    return np.stack(parts, axis=1).reshape(len(LOW), -1)


def pairs(triangles: Places) -> tuple[Places, Places]:
    """Return the degrees of freedom of both nodes of each pair, first along x, then along y; each (42, e)."""
    one, other = 2 * triangles[LOW], 2 * triangles[HIGH]
    return np.concatenate([one, one + 1]), np.concatenate([other, other + 1])


def lower(one: Places, other: Places) -> tuple[Places, Places]:
    """Return rows and columns in the lower triangle."""
    return np.maximum(one, other), np.minimum(one, other)
