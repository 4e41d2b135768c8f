"""Size and shape: gyrification index, curvature, shape index, cortical thickness."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..checks import positive
from .curve import Array, as_curve, signed_distance
from .folds import find_folds


def gyrification_index(points: Any, *, initial: Any = None, closed: bool | None = None) -> float:
    """Return the length of the curve over the length of its taut outer path, at least 1.

    The outer path of an outline is its convex hull; of a pial surface, the way from its first point round
    the hull to its last, without the base. With `initial` (2, m), the length over the length of that curve.
    """
    curve = as_curve(points, closed)
    if initial is not None:
        return curve.length / as_curve(initial, curve.closed, "initial").length
    return curve.length / curve.outer.length


def signed_curvature(points: Any, *, closed: bool | None = None) -> Array:
    """Return the curvature (n,), 1/m: turning angle over the length that belongs to a point.

    Positive on gyri, whichever way the curve runs; over an outline the curvature times that length sums to
    2 pi. The ends of an open curve, where nothing turns, have the values of their neighbours.
    """
    curve = as_curve(points, closed)
    ahead = curve.segments
    behind = np.roll(ahead, 1, axis=1)
    turn = np.arctan2(behind[0] * ahead[1] - behind[1] * ahead[0], np.sum(behind * ahead, axis=0))
    length = (curve.lengths + np.roll(curve.lengths, 1)) / 2
    curvature = curve.orientation * turn / length
    if not curve.closed:
        curvature = np.concatenate((curvature[1:2], curvature[1:], curvature[-1:]))
    return np.asarray(curvature)


def shape_index(points: Any, thickness: float, *, closed: bool | None = None) -> Array:
    """Return I = (2/pi) atan(kappa T) (n,), in (-1, 1): +1 sharp gyri, 0 flat, -1 sharp sulci.

    The analogue in the plane of (2/pi) atan(H / sqrt(H^2 - K)) (Choi et al. 2025); thickness T in m.
    """
    curvature = signed_curvature(points, closed=closed)
    return np.asarray(2 / np.pi * np.arctan(curvature * positive("thickness", thickness)))


@dataclass(frozen=True, kw_only=True)
class Thickness:
    """Cortical thickness, m: at all pial points (n,), at the crests of gyri, at the fundi of sulci."""

    all: Array
    gyri: Array
    sulci: Array

    @property
    def ratio(self) -> float:
        """Mean thickness of the gyri over that of the sulci; 1 without sulci."""
        return float(self.gyri.mean() / self.sulci.mean()) if self.sulci.size else 1.0


def cortical_thickness(
    pial: Any,
    interface: Any,
    *,
    prominence: float | None = None,
    reference: Any = None,
    closed: bool | None = None,
) -> Thickness:
    """Return the distance from each pial point (2, n) to the gray-white interface (2, m), both deformed.

    Gyri and sulci are those of `find_folds` with the same options.
    """
    curve = as_curve(pial, closed, "pial")
    depth = np.abs(signed_distance(curve.points, as_curve(interface, curve.closed, "interface")))
    folds = find_folds(curve.points, prominence=prominence, reference=reference, closed=curve.closed)
    return Thickness(all=depth, gyri=depth[folds.gyri], sulci=depth[folds.sulci])
