"""How a curve that may move and turn lies best on a target.

The distances d_i of its points from the target change by n_i · (a + θ k × (x_i - c)) as it moves by a and
turns by θ. Least squares in a and θ, repeated, find the place; a change of shape then counts without the part
of it that another move or turn takes back.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..arrays import Array
from .distance import Polygon
from .polyline import as_polyline

ROUNDS = 30
STILL = 1e-12  # move or turn, in the size of the curve, that ends them

Distances = Callable[[Array], tuple[Array, Array]]  # points (2, n) -> distances (n,), their gradients (2, n)


def posed(points: Array, weights: Array, distances: Distances) -> tuple[Array, Array, Array]:
    """Return the points of a curve laid on its target, their distances, and which of these are rigid.

    points: (2, n).  weights: of the distances, (n,).
    The distances, (n,), are weighted; rigid, (n, 3), has orthonormal columns: weighted distances that a move
    or a turn could change.
    """
    centre = points.mean(axis=1, keepdims=True)
    size = float(np.abs(points - centre).max())
    start, turn, move = points - centre, 0.0, centre
    for _ in range(ROUNDS):
        rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        arms = rotation @ start
        placed = arms + move
        distance, gradient = distances(placed)
        turning = gradient[1] * arms[0] - gradient[0] * arms[1]
        rigid = weights[:, None] * np.stack([*gradient, turning], axis=1)
        change = np.linalg.lstsq(rigid, -weights * distance, rcond=1e-10)[0]
        if max(np.abs(change[:2]).max() / size, abs(change[2])) < STILL:
            break
        move, turn = move + change[:2, None], turn + float(change[2])
    return placed, weights * distance, np.linalg.qr(rigid)[0]


def without_rigid(rows: Array, rigid: Array) -> Array:
    """Return weighted changes of distances, (n,) or (n, p), without what a move or a turn takes back."""
    return np.asarray(rows - rigid @ (rigid.T @ rows))


def outline_distance(points: Any, target: Any, *, closed: bool | None = None) -> float:
    """Return the mean distance, m, of a curve from another one that it is moved and turned to lie closest to.

    points, target: (2, n) and (2, m); m. The mean over the length of the first, ∫ |d| ds / L.
    Raises ValueError as `as_polyline`.
    """
    curve, other = as_polyline(points, closed), as_polyline(target, closed, "target")
    lengths = curve.lengths if curve.closed else np.append(curve.lengths, 0.0)
    shares = 0.5 * (lengths + np.roll(lengths, 1)) / curve.length
    weights = np.sqrt(shares)
    _, found, _ = posed(curve.points, weights, Polygon(other.points, other.closed).distances)
    return float(np.sum(np.abs(found) * weights))
