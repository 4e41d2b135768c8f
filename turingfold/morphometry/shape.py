"""Size and shape: gyrification index, curvature, shape index, cortical thickness."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from ..arrays import Array
from ..checks import between
from .closing import morphological_closing
from .folds import Options, find_folds
from .polyline import Polyline, as_polyline, signed_distance


def gyrification_index(
    points: Any,
    *,
    initial: Any = None,
    closing: float | None = None,
    smoothing: float = 0.0,
    closed: bool | None = None,
) -> float:
    """Return the length of the curve over the length of its outer path.

    The outer path of an outline is its convex hull; of a pial surface, the way from its first point round
    the hull to its last, without the base: the index is at least 1. With `closing`, m, it is that of
    `morphological_closing` by a disc of this radius, which a bent body without folds gives index 1. With
    `initial` (2, m), the length of that curve. smoothing, m: the curve is first averaged along its arc,
    Gaussian with this standard deviation, as an outline with the stairs of voxels needs (two voxels).
    Raises ValueError for `initial` beside `closing`.
    """
    given = as_polyline(points, closed)
    curve = given.smoothed(between("smoothing", smoothing, 0.0, given.radius))
    if initial is not None and closing is not None:
        raise ValueError("initial and closing are two outer lengths to divide by; give one of them.")
    if initial is not None:
        outer = as_polyline(initial, curve.closed, "initial")
    elif closing is not None:
        outer = Polyline(morphological_closing(curve.points, closing, closed=curve.closed), curve.closed)
    else:
        outer = curve.outer
    return curve.length / outer.length


def signed_curvature(points: Any, *, closed: bool | None = None) -> Array:
    """Return the curvature (n,), 1/m: turning angle over the length that belongs to a point.

    Positive on gyri, whichever way the curve runs; over an outline the curvature times that length sums to
    2 pi. The ends of an open curve, where nothing turns, have the values of their neighbours.
    """
    curve = as_polyline(points, closed)
    curvature = turning(curve) / curve.weights
    if not curve.closed:
        curvature = np.concatenate((curvature[1:2], curvature[1:-1], curvature[-2:-1]))
    return np.asarray(curvature)


def turning(curve: Polyline) -> Array:
    """Return the turning angle (n,) at each point, positive where the body is convex; 0 at open ends."""
    ahead = curve.segments
    behind = np.roll(ahead, 1, axis=1)
    turn = np.arctan2(behind[0] * ahead[1] - behind[1] * ahead[0], np.sum(behind * ahead, axis=0))
    turn = curve.orientation * turn
    return turn if curve.closed else np.concatenate(([0.0], turn[1:], [0.0]))


def mean_curvature(curve: Polyline, s: Array, width: float) -> Array:
    """Return the curvature (m,), 1/m, around fractions s (m,) of the arc, weighted 1 - |distance| / width.

    Second difference over +-width, m, of the integral of the tangent angle, which is interpolated between
    the middles of the segments: features and noise much shorter than the width are not seen. Open ends are
    mirrors.
    """
    at, angle = _tangent(curve)
    slope = np.diff(angle) / np.diff(at)
    integral = np.concatenate(([0.0], np.cumsum(np.diff(at) * (angle[1:] + angle[:-1]) / 2)))

    def integrated(x: Array) -> Array:
        k = np.clip(np.searchsorted(at, x) - 1, 0, slope.size - 1)
        return np.asarray(integral[k] + angle[k] * (x - at[k]) + slope[k] * (x - at[k]) ** 2 / 2)

    x = s * curve.length
    return (integrated(x + width) - 2 * integrated(x) + integrated(x - width)) / width**2


def _tangent(curve: Polyline) -> tuple[Array, Array]:
    """Return the tangent angle at arc lengths on the curve and on its continuation at either end."""
    turn = turning(curve)
    at = curve.arc[: curve.lengths.size] + curve.lengths / 2
    angle = np.cumsum(turn)[: at.size]
    if curve.closed:
        shifts = np.array([[-1.0], [0.0], [1.0]])
        return (at + shifts * curve.length).ravel(), (angle + shifts * turn.sum()).ravel()
    first = angle[0] - turn[1] * at[0] / (at[1] - at[0])
    last = angle[-1] + turn[-2] * (curve.length - at[-1]) / (at[-1] - at[-2])
    return (
        np.concatenate((-at[::-1], at, 2 * curve.length - at[::-1])),
        np.concatenate((2 * first - angle[::-1], angle, 2 * last - angle[::-1])),
    )


def shape_index(points: Any, thickness: float, *, closed: bool | None = None) -> Array:
    """Return I = (2/pi) atan(kappa T) (n,), in (-1, 1): +1 sharp gyri, 0 flat, -1 sharp sulci.

    The analogue in the plane of (2/pi) atan(H / sqrt(H^2 - K)) (Choi et al. 2025); thickness T in m.
    """
    curve = as_polyline(points, closed)
    curvature = signed_curvature(curve.points, closed=curve.closed)
    return np.asarray(2 / np.pi * np.arctan(curvature * curve.checked_thickness(thickness)))


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


def cortical_thickness(pial: Any, interface: Any, **options: Unpack[Options]) -> Thickness:
    """Return the distance from each pial point (2, n) to the gray-white interface (2, m), both deformed.

    Gyri and sulci are those of `find_folds` with the same options.
    """
    curve = as_polyline(pial, options.get("closed"), "pial")
    depth = np.abs(signed_distance(curve.points, as_polyline(interface, curve.closed, "interface")))
    folds = find_folds(curve.points, **(options | {"closed": curve.closed}))
    return Thickness(all=depth, gyri=depth[folds.gyri], sulci=depth[folds.sulci])
