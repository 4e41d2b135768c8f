"""Two curves side by side: a table of their morphometry, and a picture of one on the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from .folds import Folds, find_folds, wavelength_spectrum
from .fourier import ORDERS, reconstruction_error
from .polyline import Polyline, as_polyline
from .shape import signed_curvature
from .similarity import aligned, similarity
from .walls import self_intersections

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
    """Morphometry of two curves and their similarity s for p = 1, 2 and infinity."""

    names: tuple[str, str]
    measures: tuple[Measure, ...]
    similarity: dict[str, float]

    def __getitem__(self, name: str) -> Measure:
        """Return the row of that name."""
        for measure in self.measures:
            if measure.name == name:
                return measure
        known = ", ".join(repr(measure.name) for measure in self.measures)
        raise KeyError(f"{name!r} is not measured; known are {known}")

    def text(self) -> str:
        """Return the table as aligned lines of text."""
        head = ("", *self.names, f"{self.names[1]} / {self.names[0]}")
        rows = [head]
        for m in self.measures:
            numbers = _shown(m.a, ".4g"), _shown(m.b, ".4g"), _shown(m.ratio, ".3f")
            rows.append((f"{m.name}, {m.unit}" if m.unit else m.name, *numbers))
        widths = [max(len(row[k]) for row in rows) for k in range(4)]
        template = f"{{:<{widths[0]}}}  " + "  ".join(f"{{:>{width}}}" for width in widths[1:])
        lines = [template.format(*row) for row in rows]
        shares = ", ".join(f"{value:.3f} (p = {p})" for p, value in self.similarity.items())
        return "\n".join([*lines, f"similarity  {shares}"])


def compare(
    points_a: Any,
    points_b: Any,
    *,
    names: tuple[str, str] = ("A", "B"),
    thickness: float | None = None,
    landmarks: Any = None,
    unit: str = "m",
    closed: bool | None = None,
) -> Comparison:
    """Return the morphometry of two curves side by side; both outlines, or both open.

    thickness, m, and landmarks (k, 2): as in `similarity`.  unit: what the coordinates are given in.
    Fourier errors are given at the orders that both have points enough for, two per harmonic.
    """
    a, b = as_polyline(points_a, closed, "points_a"), as_polyline(points_b, closed, "points_b")
    shares = {
        str(p): similarity(a.points, b.points, p, thickness=thickness, landmarks=landmarks, closed=closed)
        for p in (1, 2, float("inf"))
    }
    of_a, of_b = _measures(a, unit), _measures(b, unit)
    rows = (Measure(*row, of_a[row], of_b[row]) for row in of_a if row in of_b)
    return Comparison(names=names, measures=tuple(rows), similarity=shares)


def draw_comparison(
    points_a: Any,
    points_b: Any,
    axes: Axes,
    *,
    names: tuple[str, str] = ("A", "B"),
    scale: bool = False,
    closed: bool | None = None,
) -> None:
    """Draw both curves on `axes`, b moved and turned onto a (and scaled, if `scale`)."""
    curves = aligned(points_a, points_b, scale=scale, closed=closed)
    given = (as_polyline(points_a, closed), as_polyline(points_b, closed))
    for points, curve, name, color in zip(curves, given, names, COLORS, strict=True):
        index, count = curve.length / curve.outer.length, _folds(curve).count
        label = f"{name}: gyrification {index:.2f}, {count} {'fold' if count == 1 else 'folds'}"
        x, y = np.hstack((points, points[:, :1])) if curve.closed else points
        axes.plot(x, y, color=color, label=label, linewidth=1.5)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), frameon=False)


def _shown(value: float, digits: str) -> str:
    """Return a number as text, "-" where it does not exist."""
    return "-" if np.isnan(value) else format(value, digits)


def _folds(curve: Polyline) -> Folds:
    return find_folds(curve.points, closed=curve.closed)


def _measures(curve: Polyline, unit: str) -> dict[tuple[str, str], float]:
    points, closed = curve.points, curve.closed
    folds = _folds(curve)
    waves, parts = wavelength_spectrum(points, closed=closed)
    curvature: Array = np.abs(signed_curvature(points, closed=closed))
    table = {
        ("length", unit): curve.length,
        ("length of the outer path", unit): curve.outer.length,
        ("gyrification index", ""): curve.length / curve.outer.length,
        ("folds", ""): float(folds.count),
        ("mean sulcal depth", unit): folds.depth,
        ("largest sulcal depth", unit): float(folds.depths.max(initial=0.0)),
        ("mean gyral width", unit): folds.width,
        ("main wave length", unit): float(waves[parts.argmax()]) if parts.any() else float("nan"),
        ("mean absolute curvature", f"1/{unit}"): float(np.sum(curve.weights * curvature)) / curve.length,
        ("self-intersections", ""): float(self_intersections(points, closed=closed)),
    }
    for order in ORDERS:
        if order <= curve.size // 2:
            error = reconstruction_error(points, order, closed=closed)
            table[f"Fourier error at order {order}", "radius"] = error
    return table
