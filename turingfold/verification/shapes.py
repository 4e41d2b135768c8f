"""Morphometry of curves whose numbers are known."""

from __future__ import annotations

import numpy as np
from scipy.special import ellipe

from ..arrays import Array
from ..morphometry.folds import fold_count, sulcal_depth
from ..morphometry.polyline import perimeter
from ..morphometry.shape import gyrification_index
from .check import Check, Quantity

POINTS, LOBES, INNER = 4000, 9, 0.75


def ellipse() -> list[Quantity]:
    """Perimeter 4 a E(1 - b²/a²) of an ellipse, E the complete elliptic integral; convex: index 1, no folds.

    4000 points on it: chords are short by 1e-6.
    """
    angle = 2 * np.pi * np.arange(POINTS) / POINTS
    curve = np.stack([2 * np.cos(angle), np.sin(angle)])
    return [
        Quantity("perimeter", 8 * float(ellipe(1 - 0.25)), perimeter(curve, closed=True), 1e-6),
        Quantity("gyrification index", 1.0, gyrification_index(curve, closed=True), 1e-12),
        Quantity("folds", 0.0, float(fold_count(curve, closed=True)), 0.0),
    ]


def star() -> list[Quantity]:
    """A star of n points, radii 1 and r: perimeter 2 n √(1 + r² - 2 r cos(π/n)), hull 2 n sin(π/n).

    Its n sulci are cos(π/n) - r deep below the hull, and as deep below the two tips beside them.
    """
    turns = np.pi * np.arange(2 * LOBES) / LOBES
    corners = np.where(np.arange(2 * LOBES) % 2 == 0, 1.0, INNER) * np.exp(1j * turns)
    curve = _cut(corners, 50)
    side = np.sqrt(1 + INNER**2 - 2 * INNER * np.cos(np.pi / LOBES))
    depth = np.cos(np.pi / LOBES) - INNER
    index = side / np.sin(np.pi / LOBES)
    return [
        Quantity("perimeter", 2 * LOBES * side, perimeter(curve, closed=True), 1e-12),
        Quantity("gyrification index", index, gyrification_index(curve, closed=True), 1e-12),
        Quantity("folds", float(LOBES), float(fold_count(curve, closed=True)), 0.0),
        Quantity("sulcal depth", depth, sulcal_depth(curve, closed=True), 1e-6),
    ]


def _cut(corners: Array, parts: int) -> Array:
    """Return points that divide each side of a closed polygon of complex corners evenly, (2, n)."""
    share = np.arange(parts) / parts
    points = (corners[:, None] * (1 - share) + np.roll(corners, -1)[:, None] * share).ravel()
    return np.stack([points.real, points.imag])


CHECKS = (
    Check("Morphometry: ellipse", ellipse, "elliptic integral"),
    Check("Morphometry: star", star, "plane geometry"),
)
