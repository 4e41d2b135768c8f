"""How a curve that may move and turn lies best on a target.

The distances d_i of its points from the target change by n_i · (a + θ k × (x_i - c)) as it moves by a and
turns by θ. Least squares in a and θ, repeated, find the place; a change of shape then counts without the part
of it that another move or turn takes back.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from .distance import Polygon
from .polyline import as_polyline

ROUNDS = 30
STILL = 1e-12  # move or turn, in the size of the curve, that ends them
TURNS = tuple(np.arange(8) * np.pi / 4)
CLEARLY = 0.7  # of the distance without a turn, below which one of these is begun with
RANK = 1e-10  # singular values below this share of the largest are of moves that change nothing


def posed(points: Array, weights: Array, target: Polygon) -> tuple[Array, Array, Array]:
    """Return points laid on a polygon, their distances from it, and which of these are rigid.

    points: (2, n).  weights: of the distances, (n,).
    Begins with both centres at one place, turned by the eighth of a circle that comes nearest.
    The distances, (n,), are weighted; rigid, (n, 3 or 2), has orthonormal columns: weighted distances that a
    move or a turn could change.
    """
    start = points - points.mean(axis=1, keepdims=True)
    move = target.corners.mean(axis=1, keepdims=True)
    size = float(np.abs(start).max())

    def at(turn: float) -> tuple[Array, Array, Array]:
        arms = _rotation(turn) @ start
        return arms, *target.distances(arms + move)

    missed = [float(np.linalg.norm(weights * at(turn)[1])) for turn in TURNS]
    turn = TURNS[int(np.argmin(missed))] if min(missed) < CLEARLY * missed[0] else 0.0
    for _ in range(ROUNDS):
        arms, distance, gradient = at(turn)
        placed = arms + move
        turning = gradient[1] * arms[0] - gradient[0] * arms[1]
        rigid = weights[:, None] * np.stack([gradient[0], gradient[1], turning / size], axis=1)
        change = np.linalg.lstsq(rigid, -weights * distance, rcond=RANK)[0]
        if np.abs(change[:2]).max() / size < STILL and abs(change[2]) / size < STILL:
            break
        move, turn = move + change[:2, None], turn + float(change[2]) / size
    left, singular, _ = np.linalg.svd(rigid, full_matrices=False)
    return placed, weights * distance, left[:, singular > RANK * singular[0]]


def _rotation(turn: float) -> Array:
    return np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])


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
    _, found, _ = posed(curve.points, weights, Polygon(other.points, other.closed))
    return float(np.sum(np.abs(found) * weights))
