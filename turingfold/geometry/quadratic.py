"""Quadratic edges x(ξ), ξ from 0 to 1, through start, middle and end, shape (3, 2, n), and straight ones."""

from __future__ import annotations

import numpy as np

from ..arrays import Array


def weights(xi: Array) -> Array:
    """Return the shares of start, middle and end in x(ξ), (3, n)."""
    return np.stack([(1 - xi) * (1 - 2 * xi), 4 * xi * (1 - xi), xi * (2 * xi - 1)])


def point(edges: Array, xi: Array) -> Array:
    """Return x(ξ) of each edge, (2, n)."""
    return np.asarray(np.sum(weights(xi)[:, None] * edges, axis=0))


def bend(edges: Array) -> Array:
    """Return b = x₀ - 2 x_m + x₁, (2, n); a part of length h in ξ leaves its chord by |b| h²/2 at most."""
    return np.asarray(edges[0] - 2 * edges[1] + edges[2])


def nearest(edges: Array, points: Array, xi: Array) -> Array:
    """Return the place on each edge nearest to a point (2, n), by Gauss-Newton steps from ξ."""
    turn, slope = 4 * bend(edges), 4 * edges[1] - 3 * edges[0] - edges[2]
    for _ in range(4):
        along = slope + turn * xi
        way = np.sum((points - point(edges, xi)) * along, axis=0)
        xi = np.clip(xi + way / np.maximum(np.sum(along**2, axis=0), 1e-300), 0.0, 1.0)
    return xi


def gap(one: Array, other: Array, xi: Array, eta: Array) -> Array:
    """Return the smallest distance between edges, pair by pair, (n,), near the places ξ and η.

    From ξ the nearest place on the other edge is found, from there the nearest on the first, and so on.
    """
    for _ in range(6):
        eta = nearest(other, point(one, xi), eta)
        xi = nearest(one, point(other, eta), xi)
    return np.asarray(np.hypot(*(point(one, xi) - point(other, eta))))


def distance(points: Array, start: Array, end: Array) -> Array:
    """Return the distance of points to straight pieces, all (2, n)."""
    along = end - start
    share = np.sum((points - start) * along, axis=0) / np.maximum(np.sum(along**2, axis=0), 1e-300)
    return np.asarray(np.hypot(*(points - start - np.clip(share, 0.0, 1.0) * along)))
