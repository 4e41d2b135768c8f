"""Two curves side by side: a table of their morphometry, and a picture of one on the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from .closing import closing_radius
from .folds import find_folds, fold_count, wavelength_spectrum
from .fourier import ORDERS, reconstruction_error
from .landmarks import Landmarks
from .polyline import Polyline, as_polyline
from .shape import gyrification_index, signed_curvature
from .similarity import SimilarityNull, aligned, similarity_null
from .walls import self_intersections

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDE = 16  # letters of the longest name that heads a column
EXPLAINED = (
    "similarity: 1 for curves bent alike everywhere; p: which mean of the differences counts (1: mean, 2: "
    "root mean\nsquare, inf: largest). In brackets what chance gives: curves with folds of their own."
)
COLORS = ("#0072b2", "#d55e00")  # Okabe and Ito: told apart by the colour-blind


@dataclass(frozen=True)
class Measure:
    """One row of a comparison: what, in which unit ("" for none), and its value on both curves."""

    name: str
    unit: str
    a: float
    b: float

    @property
    def ratio(self) -> float:
        """b / a; NaN where a is 0."""
        return self.b / self.a if self.a else float("nan")


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Morphometry of two curves, and their similarity s for p = 1, 2 and infinity with what chance gives.

    landmarks: name, and shares of the arc of both curves, counted from their first points.
    """

    names: tuple[str, str]
    measures: tuple[Measure, ...]
    similarity: dict[str, float]
    nulls: dict[str, SimilarityNull]
    landmarks: tuple[tuple[str, float, float], ...] = ()

    def __getitem__(self, name: str) -> Measure:
        """Return the row of that name."""
        for measure in self.measures:
            if measure.name == name:
                return measure
        known = ", ".join(repr(measure.name) for measure in self.measures)
        raise KeyError(f"{name!r} is not measured; known are {known}")

    def text(self) -> str:
        """Return the table as aligned lines of text; long names are above it, for A and B."""
        short = max(map(len, self.names)) <= WIDE
        a, b = self.names if short else ("A", "B")
        lines = [] if short else [f"{own}: {name}" for own, name in zip((a, b), self.names, strict=True)]
        rows = [("", a, b, f"{b} / {a}")]
        for m in self.measures:
            numbers = _shown(m.a, ".4g"), _shown(m.b, ".4g"), _shown(m.ratio, ".3f")
            rows.append((f"{m.name}, {m.unit}" if m.unit else m.name, *numbers))
        widths = [max(len(row[k]) for row in rows) for k in range(4)]
        template = f"{{:<{widths[0]}}}  " + "  ".join(f"{{:>{width}}}" for width in widths[1:])
        lines += [template.format(*row) for row in rows]
        lines += [f"landmark {name}: at {a:.3f} and {b:.3f} of the arcs" for name, a, b in self.landmarks]
        lines += [f"similarity, p = {p}  {null}" for p, null in self.nulls.items()]
        return "\n".join([*lines, EXPLAINED])


def compare(
    points_a: Any,
    points_b: Any,
    *,
    names: tuple[str, str] = ("A", "B"),
    thickness: float | None = None,
    starts: tuple[Any, Any] = (None, None),
    landmarks: Landmarks | None = None,
    unit: str = "m",
    closed: bool | None = None,
) -> Comparison:
    """Return the morphometry of two curves side by side; both outlines, or both open.

    thickness of the cortex, m: scale of what counts as a fold, of the closing and of `similarity`.  starts:
    the ungrown starts of a and b, where they are known, for `similarity_null`.  landmarks: of
    `read_landmarks`.  unit: what the coordinates are given in.
    Fourier errors are given at the orders that both have points enough for, two per harmonic.
    """
    a, b = as_polyline(points_a, closed, "points_a"), as_polyline(points_b, closed, "points_b")
    indices = None if landmarks is None else landmarks.indices
    nulls = {
        str(p): similarity_null(
            a.points, b.points, p, thickness=thickness, starts=starts, landmarks=indices, closed=closed
        )
        for p in (1, 2, float("inf"))
    }
    of_a, of_b = _measures(a, unit, thickness), _measures(b, unit, thickness)
    rows = (Measure(*row, of_a[row], of_b[row]) for row in of_a if row in of_b)
    places = [] if landmarks is None else zip(landmarks.names, *landmarks.indices.T, strict=True)
    return Comparison(
        names=names,
        measures=tuple(rows),
        similarity={p: null.value for p, null in nulls.items()},
        nulls=nulls,
        landmarks=tuple(
            (name, float(a.arc[i] / a.length), float(b.arc[j] / b.length)) for name, i, j in places
        ),
    )


def draw_comparison(
    points_a: Any,
    points_b: Any,
    axes: Axes,
    *,
    names: tuple[str, str] = ("A", "B"),
    thickness: float | None = None,
    scale: bool = False,
    closed: bool | None = None,
) -> None:
    """Draw both curves on `axes`, b moved and turned onto a (and scaled, if `scale`).

    thickness of the cortex, m: scale of what counts as a fold.
    """
    curves = aligned(points_a, points_b, scale=scale, closed=closed)
    given = (as_polyline(points_a, closed), as_polyline(points_b, closed))
    for points, curve, name, color in zip(curves, given, names, COLORS, strict=True):
        index = curve.length / curve.outer.length
        count = fold_count(curve.points, thickness=thickness, closed=curve.closed)
        label = f"{name}: gyrification {index:.2f}, {count} {'fold' if count == 1 else 'folds'}"
        x, y = np.hstack((points, points[:, :1])) if curve.closed else points
        axes.plot(x, y, color=color, label=label, linewidth=1.5)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), frameon=False)


def _shown(value: float, digits: str) -> str:
    """Return a number as text, "-" where it does not exist."""
    return "-" if np.isnan(value) else format(value, digits)


def _measures(curve: Polyline, unit: str, thickness: float | None) -> dict[tuple[str, str], float]:
    points, closed = curve.points, curve.closed
    folds = find_folds(points, thickness=thickness, closed=closed)
    T = float("nan") if thickness is None else thickness
    radius, closing = float("nan"), float("nan")
    if not curve.inner:  # which has no closing
        radius = closing_radius(points, thickness, closed=closed)
        closing = gyrification_index(points, closing=radius, closed=closed)
    waves, parts = wavelength_spectrum(points, closed=closed)
    curvature: Array = np.abs(signed_curvature(points, closed=closed))
    table = {
        ("length", unit): curve.length,
        ("length of the outer path", unit): curve.outer.length,
        ("gyrification index", ""): curve.length / curve.outer.length,
        ("gyrification index, closing", ""): closing,
        ("radius of the closing", unit): radius,
        ("folds", ""): float(folds.count),
        ("least depth of a fold", unit): folds.prominence,
        ("smoothing of folds", unit): folds.smoothing,
        ("mean sulcal depth", unit): folds.depth,
        ("mean sulcal depth", "thickness"): folds.depth / T,
        ("largest sulcal depth", unit): float(folds.depths.max(initial=0.0)),
        ("mean gyral width", unit): folds.width,
        ("main wave length", unit): float(waves[parts.argmax()]) if parts.any() else float("nan"),
        ("mean absolute curvature", f"1/{unit}"): float(np.sum(curve.weights * curvature)) / curve.length,
        ("self-intersections", ""): float(self_intersections(points, closed=closed)),
    }
    if thickness is None:
        del table["mean sulcal depth", "thickness"]
    for order in ORDERS:
        if order <= curve.size // 2:
            error = reconstruction_error(points, order, closed=closed)
            table[f"Fourier error at order {order}", "radius"] = error
    return table
