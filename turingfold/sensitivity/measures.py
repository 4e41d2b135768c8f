"""What is measured of an equilibrium: on its pial surface, or its energy; and how it changes with points.

The derivatives of lengths are known; those of other measures are differences over h and h/2, extrapolated.
Where these lie apart, or differ to either side, the measure jumps or has a kink: that is the error told.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from numbers import Real

import numpy as np

from ..arrays import Array, Integers
from ..morphometry.folds import sulcal_depth
from ..morphometry.polyline import Polyline, as_polyline
from ..morphometry.shape import gyrification_index
from ..results.result import Result
from ..results.surface import along_pial, pial_closed

Measure = Callable[[Array], float]
ENERGY = "energy"
MEASURES = ("gyrification_index", "perimeter", "sulcal_depth", ENERGY)
STEP = 1e-4  # thicknesses of the cortex by which points move in differences


def measures_of(result: Result, asked: Sequence[str | Measure]) -> dict[str, Measure | None]:
    """Return measures by name, functions of the pial points; None for the energy.

    Raises ValueError for an unknown name, for two of one name, and for what is of one pial surface on a body
    that has several.
    """
    if isinstance(asked, str) or not len(asked):
        raise ValueError(f'of={asked!r}: give a list of one measure or more, such as ["perimeter"].')
    parts = len(result.scene.body.pial_paths)
    if parts > 1 and any(item != ENERGY for item in asked):
        raise ValueError(
            f"the pial surface has {parts} parts, and measures are of one; of=({ENERGY!r},) is of all."
        )
    found = dict(named := [_measure(result, item) for item in asked])
    if len(found) < len(named):
        names = ", ".join(name for name, _ in named)
        raise ValueError(f"of= has two measures of one name ({names}); give functions names of their own.")
    return found


def numbers_at(result: Result, measures: Mapping[str, Measure | None], x: Array, energy: float) -> Array:
    """Return the measures at a displacement (2 n_nodes,) of which the energy is known, (m,)."""
    return np.array([energy if one is None else one(pial_at(result, x)) for one in measures.values()])


def pial_at(result: Result, x: Array) -> Array:
    """Return the points (2, n) of the pial surface at a displacement (2 n_nodes,); m."""
    body = result.scene.body
    return along_pial(body, (body.nodes + x.reshape(-1, 2).T)[:, body.pial])


def perimeter(points: Array, closed: bool) -> float:
    """Return the length of a polygon (2, n); m."""
    return float(np.hypot(*np.diff(points, axis=1, append=points[:, :1] if closed else points[:, -1:])).sum())


def rate_along(result: Result, measure: Measure, x: Array, move: Array) -> tuple[float, float]:
    """Return the derivative of a measure along a motion (2 n_nodes,), and its error."""
    body = result.scene.body
    points = pial_at(result, x)
    way = pial_at(result, move) - along_pial(body, body.nodes[:, body.pial])
    largest = float(np.abs(way).max())
    if not largest > 0:
        return 0.0, 0.0
    if isinstance(measure, Length):
        return float((measure.slopes(points) * way).sum()), 0.0
    return _derivative(partial(_moved, measure, points, way), STEP * body.thickness / largest)


def gradient_of(result: Result, measure: Measure, x: Array, free: Integers) -> tuple[Array, float]:
    """Return the derivatives of a measure with respect to displacements, (2 n_nodes,), and their error.

    free: the numbers of those that are not held; 0 for others and off the surface.  Error: of all, relative.
    """
    body, points, found = result.scene.body, pial_at(result, x), np.zeros(len(x))
    nodes = along_pial(body, body.pial.astype(float)).astype(np.int64)
    still, moved = (along_pial(body, np.full((2, len(body.pial)), one)) for one in (0.0, 1.0))
    ways = np.asarray(moved - still)  # the image of half a body moves the other way
    if isinstance(measure, Length):
        slopes = ways * measure.slopes(points)
        for axis in range(2):
            found += np.bincount(2 * nodes + axis, slopes[axis], minlength=len(x))
        return found * np.isin(np.arange(len(x)), free), 0.0
    errors, h = np.zeros(len(x)), STEP * body.thickness
    for dof in np.intersect1d([2 * body.pial, 2 * body.pial + 1], free).tolist():
        way = np.zeros(points.shape)
        way[dof % 2] = ways[dof % 2] * (nodes == dof // 2)
        found[dof], errors[dof] = _derivative(partial(_moved, measure, points, way), h)
    lost, size = float(np.linalg.norm(errors)), float(np.linalg.norm(found))
    return found, lost / size if size > 0 else (float("inf") if lost > 0 else 0.0)


def _moved(measure: Measure, points: Array, way: Array, s: float) -> float:
    return measure(points + s * way)


def _derivative(function: Callable[[float], float], h: float) -> tuple[float, float]:
    """Return the derivative at 0, of fourth order in h, and its error.

    Half the difference of the slopes to either side, once what is in proportion to h is taken out of it, is
    what a kink leaves open.
    """
    here = function(0.0)
    wide, narrow = ((function(s), function(-s), s) for s in (h, 0.5 * h))
    slopes = [(up - down) / (2 * s) for up, down, s in (wide, narrow)]
    kinks = [(up - 2 * here + down) / s for up, down, s in (wide, narrow)]
    found = (4 * slopes[1] - slopes[0]) / 3
    return found, max(abs(found - slopes[1]), 0.5 * abs(2 * kinks[1] - kinks[0]))


@dataclass(frozen=True, eq=False)
class Own:
    """A function of one's own of the pial points, held to one finite number."""

    name: str
    function: Measure

    def __call__(self, points: Array) -> float:
        """Return it for points (2, n); raises ValueError for what is no finite number."""
        found = self.function(points)
        if np.ndim(found) or not np.isrealobj(found) or not isinstance(found, (Real, np.ndarray)):
            what = f"{type(found).__name__} of shape {np.shape(found)}" if np.ndim(found) else repr(found)
            raise ValueError(f"of={self.name}: it returned {what}; a measure is one real number.")
        if not np.isfinite(found):
            raise ValueError(f"of={self.name}: it returned {found}; a measure is finite.")
        return float(found)


@dataclass(frozen=True, eq=False)
class Length:
    """The length of the pial surface, m, or its gyrification index: what has known derivatives."""

    closed: bool
    index: bool = False

    def __call__(self, points: Array) -> float:
        """Return it for points (2, n)."""
        if self.index:
            return gyrification_index(points, closed=self.closed)
        return perimeter(points, self.closed)

    def slopes(self, points: Array) -> Array:
        """Return its derivatives with the points, (2, n)."""
        curve = as_polyline(points, self.closed)
        if not self.index:
            return _pulls(curve)
        found = _pulls(curve) / curve.outer.length
        found[:, curve.hull] -= _pulls(curve.outer) * curve.length / curve.outer.length**2
        return found


def _pulls(curve: Polyline) -> Array:
    """Return the derivatives of a polygon's length with its points, (2, n)."""
    ahead = np.asarray(curve.segments / curve.lengths)
    if not curve.closed:
        ahead = np.pad(ahead, ((0, 0), (0, 1)))
    return np.asarray(np.roll(ahead, 1, axis=1) - ahead)


def _measure(result: Result, item: str | Measure) -> tuple[str, Measure | None]:
    """Return a measure's name and its function of the pial points."""
    if callable(item):
        name = getattr(item, "__name__", "measure")
        return name, Own(name, item)
    if item not in MEASURES:
        raise ValueError(f"of={item!r} must be one of {', '.join(MEASURES)}, or a function of points (2, n).")
    if item == ENERGY:
        return item, None
    closed, thickness = pial_closed(result.scene.body), result.scene.body.thickness
    if item == "sulcal_depth":
        return item, lambda points: float(sulcal_depth(points, closed=closed, thickness=thickness))
    return item, Length(closed, index=item == "gyrification_index")
