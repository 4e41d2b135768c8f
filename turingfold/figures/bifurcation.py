"""Bifurcation diagrams: how far equilibria are folded, against growth."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..geometry.body import Body
from ..morphometry.folds import sulcal_depth
from ..results.result import along_pial, pial_closed
from ..results.units import length_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..stability.arc_length import EquilibriumPath

MEASURES = ("sulcal_depth", "normal_displacement", "fold_amplitude")
SHALLOWEST = 0.05  # least depth, over the cortical thickness, that a path shows: long before a sulcus counts
COLOR, TURN = "#0072b2", "#d55e00"


def pial_measures(body: Body, displacements: Sequence[Array]) -> dict[str, Array]:
    """Return measures of the pial surface for each displacement (2, n_nodes), each (n,); m.

    Mean sulcal depth; largest displacement along its normal at rest; `fold_amplitude`.
    """
    moves = [displacement[:, body.pial] for displacement in displacements]
    shapes = [along_pial(body, body.nodes[:, body.pial] + move) for move in moves]
    closed, least = pial_closed(body), SHALLOWEST * body.thickness
    return {
        "sulcal_depth": np.array([sulcal_depth(shape, prominence=least, closed=closed) for shape in shapes]),
        "normal_displacement": np.abs(_outward(body, displacements)).max(axis=1),
        "fold_amplitude": fold_amplitude(body, displacements),
    }


def fold_amplitude(body: Body, displacements: Sequence[Array]) -> Array:
    """Return how far the pial surface is folded by each displacement (2, n_nodes), (n,); m.

    The root mean square of its displacement along the normal at rest, about the mean along the surface: it
    separates branches that differ in one fold.
    """
    outward, arc = _outward(body, displacements), body.pial_arc
    share = np.diff(arc, prepend=arc[0]) + np.diff(arc, append=arc[-1])  # of the surface, of each node
    share /= share.sum()
    about = outward - (outward @ share)[:, None]
    return np.asarray(np.sqrt(about**2 @ share))


def _outward(body: Body, displacements: Sequence[Array]) -> Array:
    """Return the displacements of the pial nodes along the normal at rest, (n, n_pial)."""
    normal = body.pial_curve.nearest(body.nodes[:, body.pial])[1][::-1] * np.array([[1.0], [-1.0]])
    outward = [(normal * displacement[:, body.pial]).sum(0) for displacement in displacements]
    return np.array(outward).reshape(len(displacements), len(body.pial))


def bifurcation_diagram(axes: Axes, body: Body, path: EquilibriumPath) -> None:
    """Draw the amplitude of folds against growth, or time without growth.

    Unstable states are dashed, limit points marked where they are between the points; the path has at least
    two points.
    """
    size, unit = length_unit(body)
    name = "growth" if np.ptp(path.of("growth")) > 0 else "time"
    moves = [point.state["displacement"] for point in path.points]
    load, amplitude = path.of(name), fold_amplitude(body, moves) / size
    stable = path.stable[1:] & path.stable[:-1]  # of the pieces between points
    ends = [0, *(np.flatnonzero(np.diff(stable)) + 1).tolist(), len(stable)]
    for first, last in pairwise(ends):  # as one line each, or dashes would not show on short pieces
        run, style = slice(first, last + 1), "-" if stable[first] else "--"
        axes.plot(load[run], amplitude[run], style, color=COLOR, linewidth=1.4)
    turns = [path.at_limit_points(values) for values in (load, amplitude)]
    axes.plot(*turns, "o", color=TURN, markersize=4)
    axes.set_xlabel(name)
    axes.set_ylabel(f"fold amplitude ({unit})")
