"""What is measured of an equilibrium: on its pial surface, or its energy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from ..arrays import Array
from ..morphometry.folds import sulcal_depth
from ..morphometry.shape import gyrification_index
from ..results.result import Result
from ..results.surface import along_pial, pial_closed

Measure = Callable[[Array], float]
ENERGY = "energy"
MEASURES = ("gyrification_index", "perimeter", "sulcal_depth", ENERGY)
STEP = 1e-4  # thicknesses of the cortex by which points move in differences


def measures_of(result: Result, asked: Sequence[str | Measure]) -> dict[str, Measure | None]:
    """Return measures by name, functions of the pial points; None for the energy.

    Raises ValueError for an unknown name, and for two of one name.
    """
    found = dict(named := [_measure(result, item) for item in asked])
    if len(found) < len(named):
        names = ", ".join(name for name, _ in named)
        raise ValueError(f"of= has two measures of one name ({names}); give functions names of their own.")
    return found


def pial_at(result: Result, x: Array) -> Array:
    """Return the points (2, n) of the pial surface at a displacement (2 n_nodes,); m."""
    body = result.scene.body
    return along_pial(body, (body.nodes + x.reshape(-1, 2).T)[:, body.pial])


def perimeter(points: Array, closed: bool) -> float:
    """Return the length of a polygon (2, n); m."""
    return float(np.hypot(*np.diff(points, axis=1, append=points[:, :1] if closed else points[:, -1:])).sum())


def rate_along(result: Result, measure: Measure, x: Array, move: Array) -> float:
    """Return the derivative of a measure along a motion (2 n_nodes,), by extrapolated differences."""
    body = result.scene.body
    points = pial_at(result, x)
    way = pial_at(result, move) - along_pial(body, body.nodes[:, body.pial])
    largest = float(np.abs(way).max())
    if not largest > 0:
        return 0.0
    return _derivative(lambda s: measure(points + s * way), STEP * body.thickness / largest)


def gradient_of(result: Result, measure: Measure, x: Array) -> Array:
    """Return the derivatives of a measure with respect to displacements, (2 n_nodes,); 0 off the surface."""
    body, found = result.scene.body, np.zeros(len(x))

    def moved(dof: int, length: float) -> float:
        away = x.copy()
        away[dof] += length
        return measure(pial_at(result, away))

    for dof in np.unique([2 * body.pial, 2 * body.pial + 1]).tolist():
        found[dof] = _derivative(partial(moved, dof), STEP * body.thickness)
    return found


def _derivative(function: Callable[[float], float], h: float) -> float:
    """Return the derivative at 0, of fourth order in h."""
    wide, narrow = ((function(s) - function(-s)) / (2 * s) for s in (h, 0.5 * h))
    return (4 * narrow - wide) / 3


def _measure(result: Result, item: str | Measure) -> tuple[str, Measure | None]:
    """Return a measure's name and its function of the pial points."""
    closed, thickness = pial_closed(result.scene.body), result.scene.body.thickness
    known: dict[str, Measure | None] = {
        "gyrification_index": lambda points: gyrification_index(points, closed=closed),
        "perimeter": lambda points: perimeter(points, closed),
        "sulcal_depth": lambda points: float(sulcal_depth(points, closed=closed, thickness=thickness)),
        ENERGY: None,
    }
    if callable(item):
        return getattr(item, "__name__", "measure"), item
    if item not in known:
        raise ValueError(f"of={item!r} must be one of {', '.join(known)}, or a function of points (2, n).")
    return item, known[item]
