"""How alike two curves are: a map between their arcs, the similarity of shape indices, rigid alignment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from ..arrays import Array, Integers
from ..checks import between, positive, whole
from .null import Null
from .polyline import FEWEST_POINTS, Polyline, as_polyline
from .resampling import fractions, spline_points
from .shape import mean_curvature

THICKNESS = 0.1  # default cortical thickness over the radius of the body (ferret, R/T = 10)
LANDMARK_WEIGHT = 10.0  # Choi et al. 2025
SAMPLES = 1000
TURNS = 6  # in which random foldings get the values and the spectrum of a curve: more change nothing


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
    A smooth curve is 0.9 similar to most: see `similarity_null`.
    Source: Choi et al. 2025, with curvature in the plane for the index on a surface.
    """
    options = {"thickness": thickness, "landmarks": landmarks, "weight": weight, "samples": samples}
    a, b, matched = _indices(points_a, points_b, closed=closed, **options)
    return _alike(a, matched(b), _order(p))


@dataclass(frozen=True, kw_only=True)
class SimilarityNull:
    """The similarity of two curves a and b, beside that of a with curves that know nothing of its folds.

    circle: the circle (or straight line) most similar to a.  start: the ungrown start of one of them with
    the other, None if it is not given.  foldings: random foldings of b's wave lengths.
    """

    value: float
    circle: float
    start: float | None
    foldings: Null

    def __str__(self) -> str:
        """Return all in a line, and what follows from them."""
        start = "" if self.start is None else f", ungrown start {self.start:.3f}"
        low, high = self.foldings.quantile(0.05), self.foldings.quantile(0.95)
        says = [] if self.value > self.circle else ["less than a circle"]
        says += ["less than before it grew"] if self.start is not None and self.value <= self.start else []
        says += ["no more than by chance"] if self.foldings.p > 0.05 else []
        share = f"{100 * self.foldings.p:.0f} % of them as similar"
        chance = f"random foldings {low:.3f} to {high:.3f}, {share}"
        verdict = f": {' and '.join(says)}" if says else ""
        return f"{self.value:.3f} (best circle {self.circle:.3f}{start}, {chance}){verdict}"


def similarity_null(
    points_a: Any,
    points_b: Any,
    p: float = 1,
    *,
    starts: tuple[Any, Any] = (None, None),
    count: int = 99,
    seed: int = 0,
    thickness: float | None = None,
    landmarks: Any = None,
    weight: float = LANDMARK_WEIGHT,
    samples: int = SAMPLES,
    closed: bool | None = None,
) -> SimilarityNull:
    """Return the similarity of two curves with what it would be without a likeness of their folds.

    starts: the ungrown starts of a and of b, (2, n) or None; of two, the better one counts.
    The `count` random foldings have the values of b's shape index, and the amplitudes of its spectrum with
    random phases, and are matched with a as b is. Arguments and errors else as `similarity`.
    Source of the random foldings: Schreiber & Schmitz 1996, Phys. Rev. Lett. 77, 635 (surrogate data).
    """
    options = {"thickness": thickness, "landmarks": landmarks, "weight": weight, "samples": samples}
    a, b, matched = _indices(points_a, points_b, closed=closed, **options)
    order = _order(p)
    outline = _pair(points_a, points_b, closed)[0].closed
    foldings = _random_foldings(b, whole("count", count, at_least=19), seed, outline)
    value, by_chance = _alike(a, matched(b), order), [_alike(a, matched(c), order) for c in foldings]
    circle = minimize_scalar(lambda index: -_alike(a, index, order), bounds=(0.0, 1.0), method="bounded")
    before = [
        similarity(other, start, p, thickness=thickness, samples=samples, closed=closed)
        for other, start in zip((points_b, points_a), starts, strict=True)
        if start is not None
    ]
    return SimilarityNull(
        value=value,
        circle=-float(circle.fun),
        start=max(before, default=None),
        foldings=Null(value=value, samples=np.sort(by_chance)),
    )


def _order(p: Any) -> float:
    if isinstance(p, Real) and p == np.inf:
        return np.inf
    return between("p", p, 1.0, np.inf, "use 1, 2 or inf")


def _indices(
    points_a: Any, points_b: Any, *, thickness: Any, landmarks: Any, weight: Any, samples: Any, closed: Any
) -> tuple[Array, Array, Callable[[Array], Array]]:
    """Return the shape indices (m,) of both curves at equal steps, and what puts one of b where a's are."""
    a, b = _pair(points_a, points_b, closed)
    s = fractions(whole("samples", samples, at_least=FEWEST_POINTS), a.closed)
    index_a, index_b = (_index(curve, s, thickness) for curve in (a, b))
    if landmarks is not None:
        there = _mapped(s, a, b, _landmarks(landmarks, a, b), positive("weight", weight))
        return index_a, index_b, lambda index: np.interp(there, s, index, period=1.0 if a.closed else None)
    return index_a, index_b, lambda index: _shifted(index_a, index) if a.closed else index


def _alike(a: Array, b: Array | float, p: float) -> float:
    difference = np.abs(a - b)
    size = difference.max() if p == np.inf else np.mean(difference**p) ** (1 / p)
    return 1 - float(size) / 2


def _random_foldings(index: Array, count: int, seed: int, closed: bool) -> Array:
    """Return shape indices (count, m) with the values of `index` (m,) and its spectrum at random phases.

    The index of an open curve is continued by its mirror image. Values and spectrum are imposed in turn.
    """
    loop = index if closed else np.concatenate((index, index[::-1]))
    values, amplitude = np.sort(loop), np.abs(np.fft.rfft(loop))
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, (count, amplitude.size))
    spectrum = np.exp(1j * phase)
    for _ in range(TURNS):
        folding = np.fft.irfft(amplitude * spectrum, n=loop.size)
        np.put_along_axis(folding, np.argsort(folding, axis=1), values[None, :], axis=1)
        spectrum = np.fft.rfft(folding)
        spectrum /= np.maximum(np.abs(spectrum), 1e-300)
    return np.asarray(folding[:, : index.size])


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
    T = THICKNESS * curve.radius if thickness is None else curve.checked_thickness(thickness)
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
