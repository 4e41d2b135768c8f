"""Fold-morphogen registration: do the gyri stand on the peaks of a pattern?"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import finite_array, whole
from .null import Null
from .polyline import FEWEST_POINTS, Polyline, as_polyline, signed_distance

UNMOVED = 1e-9  # fold height over the radius of the body below which there are no folds
PHASES = 499  # of the pattern along the surface: a prime, so that no repeat of the pattern meets itself


def registration(
    pattern: Any, points: Any, reference: Any, *, trend: int = 4, closed: bool | None = None
) -> float:
    """Return the correlation in [-1, 1] of a pattern with the fold height: +1 means gyri on its peaks.

    pattern (n,): values at the points, e.g. the activator.  points, reference (2, n): the pial surface
    deformed and undeformed, node by node. Fold height: signed distance to the undeformed curve (on a half
    disc the radial position), weighted with undeformed length. From both, a trend is first removed: over
    the undeformed arc, polynomials up to degree `trend` (open) or harmonics up to trend/2 (closed);
    trend = 0 leaves the plain correlation. 0 where the height has nothing but trend.
    Raises ValueError for shapes that do not match and for a pattern that is nothing but trend.
    """
    undeformed, height, values = _checked(pattern, points, reference, closed)
    return float(_correlations(values, height, undeformed, trend))


def registration_null(
    pattern: Any,
    points: Any,
    reference: Any,
    *,
    phases: int = PHASES,
    trend: int = 4,
    closed: bool | None = None,
) -> Null:
    """Return the registration with that of the same pattern moved along the surface, by every phase.

    The samples are registrations of pattern(s + k L / phases), k = 0 ... phases - 1, over the undeformed arc
    s of an outline of length L; on an open surface the pattern is continued by its mirror images at both
    ends, as zero flux there allows, and L is twice the length. So the null patterns have the wave number of
    the pattern and any phase, and p is the share of phases that register as well or better: for waves of
    one length phi/pi, if phi is the angle by which the peaks miss the gyri.
    Arguments and errors as `registration`, and ValueError for fewer than 8 phases.
    """
    undeformed, height, values = _checked(pattern, points, reference, closed)
    whole("phases", phases, at_least=FEWEST_POINTS)
    arc, length = undeformed.arc, undeformed.length
    if not undeformed.closed:
        arc, values = np.append(arc, 2 * length - arc[-2:0:-1]), np.append(values, values[-2:0:-1])
        length = 2 * length
    shifts = np.arange(phases)[:, None] * (length / phases)
    moved = np.interp(undeformed.arc + shifts, arc, values, period=length)
    found = _correlations(moved, height, undeformed, trend)
    return Null(value=float(found[0]), samples=np.sort(found))


def _checked(pattern: Any, points: Any, reference: Any, closed: bool | None) -> tuple[Polyline, Array, Array]:
    """Return the undeformed curve, the fold heights (n,) on it and the pattern (n,)."""
    undeformed = as_polyline(reference, closed, "reference")
    shape = as_polyline(points, undeformed.closed)
    if shape.size != undeformed.size:
        raise ValueError(
            f"points are {shape.size} and reference {undeformed.size}; they must be the same nodes."
        )
    values = finite_array("pattern", pattern, (None,))
    if values.size == undeformed.size + 1 and undeformed.closed:
        values = values[:-1]  # the outline came with its first point repeated
    if values.size != undeformed.size:
        raise ValueError(f"pattern has {values.size} values; it must have one per point, {undeformed.size}.")
    return undeformed, signed_distance(shape.points, undeformed), values


def _correlations(patterns: Array, height: Array, undeformed: Polyline, trend: int) -> Array:
    """Return the registration (...) of patterns (..., n); 0 where height or moved pattern is only trend."""
    basis, root = _trend(undeformed, trend), np.sqrt(undeformed.weights)

    def waves(values: Array) -> Array:
        weighted = values * root
        return np.asarray(weighted - weighted @ basis @ basis.T)

    wave, fold = waves(patterns), waves(height)
    size = np.max(np.abs(wave / root), axis=-1)
    only_trend = size <= UNMOVED * max(1e-300, float(np.abs(patterns).max()))
    if np.all(only_trend):
        raise ValueError(f"pattern is constant or a trend of degree {trend}; no fold can be on its peaks.")
    if np.abs(fold / root).max() <= UNMOVED * undeformed.radius:
        return np.zeros(patterns.shape[:-1])
    norm = np.linalg.norm(wave, axis=-1) * np.linalg.norm(fold)
    return np.asarray(np.where(only_trend, 0.0, wave @ fold / np.where(only_trend, 1.0, norm)))


def _trend(curve: Polyline, trend: int) -> Array:
    """Return slow functions (n, k) of the arc, orthonormal after weighting with the root of the length."""
    degree = whole("trend", trend, at_least=0)
    s = curve.arc / curve.length
    if curve.closed:
        k = np.arange(1, degree // 2 + 1)[:, None]
        basis = np.concatenate((np.ones((1, s.size)), np.cos(2 * np.pi * k * s), np.sin(2 * np.pi * k * s))).T
    else:
        basis = np.polynomial.legendre.legvander(2 * s - 1, degree)
    return np.linalg.qr(np.sqrt(curve.weights)[:, None] * basis)[0]
