"""How alike two curves are: a map between their arcs, the similarity of shape indices, rigid alignment."""

from __future__ import annotations

from numbers import Real
from typing import Any

import numpy as np

from ..arrays import Array, Integers
from ..checks import between, positive, whole
from .polyline import FEWEST_POINTS, Polyline, as_polyline, fractions, spline_points
from .shape import mean_curvature

THICKNESS = 0.1  # default cortical thickness over the radius of the body (ferret, R/T = 10)
LANDMARK_WEIGHT = 10.0  # Choi et al. 2025
SAMPLES = 1000


def arc_length_map(
    points_a: Any,
    points_b: Any,
    landmarks: Any,
    *,
    weight: float = LANDMARK_WEIGHT,
    samples: int = SAMPLES,
    closed: bool | None = None,
) -> tuple[Array, Array]:
    """Return fractions of arc s (m,) on a and phi (m,) on b that correspond, both counted counter-clockwise.

    They start at the first point of a curve given counter-clockwise, at the last of one given clockwise.
    phi minimises int (phi' - 1)^2 ds + weight sum_i (phi(a_i) - b_i)^2; the ends of open curves are kept.
    landmarks (k, 2): indices of corresponding points on a and on b. phi increases for any weight; on an
    outline it may leave [0, 1], whole numbers being the same point.
    Raises ValueError for landmarks outside the curves, at ends, repeated or not in the same order.
    """
    a, b = _pair(points_a, points_b, closed)
    s = fractions(whole("samples", samples, at_least=FEWEST_POINTS), a.closed)
    return s, _mapped(s, a, b, _landmarks(landmarks, a, b), positive("weight", weight))


def similarity(
    points_a: Any,
    points_b: Any,
    p: float = 1,
    *,
    thickness: float | None = None,
    landmarks: Any = None,
    weight: float = LANDMARK_WEIGHT,
    samples: int = SAMPLES,
    closed: bool | None = None,
) -> float:
    """Return s = 1 - |I_a - I_b|_p / (2 m^(1/p)) in [0, 1] of the shape indices I at m samples.

    The samples of a are at equal steps of its arc, those of b where `arc_length_map` puts them; without
    landmarks they are at equal steps too, and those of an outline start where the indices agree best.
    thickness T, m, of I = (2/pi) atan(kappa T): by default 0.1 of the radius of each body, so that s does
    not depend on scale; curvature is averaged over +-T/2 of arc.  p: 1, 2, inf, or any number above 1.
    Source: Choi et al. 2025, with curvature in the plane for the index on a surface.
    """
    largest = isinstance(p, Real) and p == np.inf
    if not largest:
        between("p", p, 1.0, np.inf, "use 1, 2 or inf")
    a, b = _pair(points_a, points_b, closed)
    s = fractions(whole("samples", samples, at_least=FEWEST_POINTS), a.closed)
    index_a, index_b = (_index(curve, s, thickness) for curve in (a, b))
    if landmarks is not None:
        there = _mapped(s, a, b, _landmarks(landmarks, a, b), positive("weight", weight))
        index_b = np.interp(there, s, index_b, period=1.0 if a.closed else None)
    elif a.closed:
        index_b = _shifted(index_a, index_b)
    difference = np.abs(index_a - index_b)
    if largest:
        return 1 - float(difference.max()) / 2
    return 1 - float(np.mean(difference**p) ** (1 / p)) / 2


def aligned(
    points_a: Any, points_b: Any, *, scale: bool = False, samples: int = SAMPLES, closed: bool | None = None
) -> tuple[Array, Array]:
    """Return both curves at m samples (2, m), b moved and turned onto a (and scaled, if `scale`).

    Least squares over translation, rotation and, for outlines, the first sample; nothing is mirrored.
    """
    a, b = _pair(points_a, points_b, closed)
    s = fractions(whole("samples", samples, at_least=FEWEST_POINTS), a.closed)
    z, w = ((1, 1j) @ spline_points(_counter_clockwise(curve), s) for curve in (a, b))
    zc, wc = z - z.mean(), w - w.mean()
    if a.closed:
        lag = np.fft.ifft(np.fft.fft(zc).conj() * np.fft.fft(wc))
        wc = np.roll(wc, -int(np.argmax(np.abs(lag))))
    turn = np.vdot(wc, zc) / np.vdot(wc, wc).real
    moved = z.mean() + wc * (turn if scale else turn / abs(turn))
    return np.stack((z.real, z.imag)), np.stack((moved.real, moved.imag))


def _pair(points_a: Any, points_b: Any, closed: bool | None) -> tuple[Polyline, Polyline]:
    """Return both curves; they must be both outlines or both open."""
    a, b = as_polyline(points_a, closed, "points_a"), as_polyline(points_b, closed, "points_b")
    if a.closed != b.closed:
        kinds = ["a closed outline" if curve.closed else "an open curve" for curve in (a, b)]
        raise ValueError(f"points_a are {kinds[0]}, points_b {kinds[1]}; both must be of one kind.")
    return a, b


def _counter_clockwise(curve: Polyline) -> Polyline:
    return curve if curve.orientation > 0 else curve.reversed()


def _index(curve: Polyline, s: Array, thickness: float | None) -> Array:
    T = THICKNESS * curve.radius if thickness is None else positive("thickness", thickness)
    return np.asarray(2 / np.pi * np.arctan(mean_curvature(_counter_clockwise(curve), s, T / 2) * T))


def _shifted(a: Array, b: Array) -> Array:
    """Return b begun where it agrees best with a, least squares, between samples by a parabola."""
    match = np.fft.irfft(np.fft.rfft(a).conj() * np.fft.rfft(b), n=a.size)
    k = int(np.argmax(match))
    before, peak, after = match[k - 1], match[k], match[(k + 1) % a.size]
    bend = before - 2 * peak + after
    part = 0.5 * (before - after) / bend if bend < 0 else 0.0
    steps = np.arange(a.size)
    return np.interp(steps + k + part, steps, b, period=a.size)


def _landmarks(landmarks: Any, a: Polyline, b: Polyline) -> tuple[Array, Array]:
    """Return the fractions of arc of the landmarks on a, increasing, and on b, unwrapped."""
    indices: Integers = np.asarray(landmarks)
    if indices.ndim != 2 or indices.shape[1] != 2 or indices.size == 0 or indices.dtype.kind not in "iu":
        raise ValueError(f"landmarks has shape {indices.shape}; it must be (k, 2), pairs of point indices.")
    ends = 0 if a.closed else 1
    for column, curve in enumerate((a, b)):
        wrong = (indices[:, column] < ends) | (indices[:, column] >= curve.size - ends)
        if wrong.any():
            k = int(indices[wrong.argmax(), column])
            raise ValueError(
                f"landmark {k} on points_{'ab'[column]} must be between {ends} and {curve.size - 1 - ends}"
                + ("; the ends correspond anyway." if ends else ".")
            )
    at_a, at_b = (_fraction(curve, indices[:, column]) for column, curve in enumerate((a, b)))
    order = np.argsort(at_a)
    at_a, at_b = at_a[order], at_b[order]
    gaps = np.diff(at_b) % 1.0 if a.closed else np.diff(at_b)
    if (np.diff(at_a) <= 0).any() or (gaps <= 0).any() or gaps.sum() >= 1:
        raise ValueError(
            f"landmarks {indices.tolist()} are repeated or not in the same order on both curves; "
            "going counter-clockwise on a, they must come counter-clockwise on b."
        )
    return at_a, at_b[0] + np.concatenate(([0.0], np.cumsum(gaps)))


def _fraction(curve: Polyline, indices: Integers) -> Array:
    forward = curve.arc[indices] / curve.length
    if curve.orientation > 0:
        return np.asarray(forward)
    # The reversed copy of an outline starts at what was its last point.
    last = curve.arc[-1] / curve.length if curve.closed else 1.0
    return np.asarray(last - forward)


def _mapped(s: Array, a: Polyline, b: Polyline, landmarks: tuple[Array, Array], weight: float) -> Array:
    """Return phi(s) = s + d(s), d linear between landmarks: a chain of springs, tied to the landmarks."""
    at_a, wanted = landmarks[0], landmarks[1] - landmarks[0]
    knots = np.append(at_a, at_a[0] + 1) if a.closed else np.concatenate(([0.0], at_a, [1.0]))
    stiffness = 1 / np.diff(knots)
    count = at_a.size
    matrix = weight * np.eye(count)
    for j, k in enumerate(stiffness):
        left, right = (j, (j + 1) % count) if a.closed else (j - 1, j)
        for here, there in ((left, right), (right, left)):
            if 0 <= here < count:
                matrix[here, here] += k
                if 0 <= there < count:
                    matrix[here, there] -= k
    d = np.linalg.solve(matrix, weight * wanted)
    if a.closed:
        return np.asarray(s + np.interp(s, at_a, d, period=1.0))
    return np.asarray(s + np.interp(s, knots, np.concatenate(([0.0], d, [0.0]))))
