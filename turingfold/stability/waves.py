"""Waves of a mode along the pial surface: how many there are, and what share of the surface bears them."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..geometry.body import Body

VISIBLE = 0.02  # lobes below this share of the highest one do not count as half waves
LOCAL = 0.5  # share of the pial surface; a mode that less of it bears is localised


def half_waves(body: Body, shape: Array) -> int:
    """Return the half waves of a displacement (2, n_nodes) on the pial surface, n of cos(nθ) on a half disc.

    Each change of sign of its normal component u, between lobes of at least 2 % of the highest one, ends a
    half wave; an end of the surface that is held ends one too. Half a body counts twice.
    Of a localised one that would count ripples far away, and whether two ends move alike: there it is how
    many half waves of that length the whole surface holds, (L/π) √(∫u'² ds / ∫u² ds).
    """
    normal = _normal(body, shape)
    if extent_of(body, shape) < LOCAL:
        return round(_held(body, normal))
    lobes = np.sign(normal[np.abs(normal) > VISIBLE * np.abs(normal).max()])
    changes = int(np.sum(lobes[1:] != lobes[:-1]))
    if body.pial_curve.closed:
        return changes + int(lobes[0] != lobes[-1])
    fixed = set(body.fixed.tolist())
    held = sum({2 * node, 2 * node + 1} <= fixed for node in (int(body.pial[0]), int(body.pial[-1])))
    return 2 * changes + held if body.mirror else changes + held // 2


def extent_of(body: Body, shape: Array) -> float:
    """Return what share of the pial surface bears a displacement (2, n_nodes).

    That is 3/2 (∫u² ds)² / (L ∫u⁴ ds) of its normal component u, at most 1: 1 for equal waves such as
    cos(nθ), m/n where m of n of them are there.
    """
    values, steps = _along(body, _normal(body, shape))
    square, fourth = (_integral(values**power, steps) for power in (2, 4))
    return min(1.0, 1.5 * square**2 / (float(steps.sum()) * fourth)) if fourth > 0 else 0.0


def _held(body: Body, normal: Array) -> float:
    """Return how many half waves of the length of a localised mode's the whole surface holds."""
    values, steps = _along(body, normal)
    slope = float((np.diff(values) ** 2 / steps).sum())
    length = float(steps.sum()) * (2.0 if body.mirror else 1.0)
    return length / np.pi * float(np.sqrt(slope / _integral(values**2, steps)))


def _normal(body: Body, shape: Array) -> Array:
    """Return the component of a displacement along the normal at the nodes of the pial surface, (n,)."""
    tangent = body.pial_curve.nearest(body.nodes[:, body.pial])[1]
    return np.asarray(tangent[0] * shape[1, body.pial] - tangent[1] * shape[0, body.pial])


def _along(body: Body, normal: Array) -> tuple[Array, Array]:
    """Return values along the pial surface, once around a closed one, and the lengths between them."""
    points = body.nodes[:, body.pial]
    if body.pial_curve.closed:
        normal, points = np.append(normal, normal[0]), np.append(points, points[:, :1], axis=1)
    return normal, np.hypot(*np.diff(points))


def _integral(values: Array, steps: Array) -> float:
    return float(0.5 * (values[1:] + values[:-1]) @ steps)
