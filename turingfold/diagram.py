"""Bifurcation diagrams: how far equilibria are folded, against growth."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from .arrays import Array
from .body import Body
from .morphometry.folds import sulcal_depth
from .results import along_pial, length_unit, pial_closed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .mechanics.arclength import EquilibriumPath

MEASURES = ("sulcal_depth", "normal_displacement", "fold_amplitude")
COLOR, TURN = "#0072b2", "#d55e00"


def pial_measures(body: Body, displacements: Sequence[Array]) -> dict[str, Array]:
    """Return measures of the pial surface for each displacement (2, n_nodes), each (n,); m.

    Mean sulcal depth; largest displacement along its normal at rest; root mean square of that displacement
    about its mean along the surface, which separates branches that differ in one fold.
    """
    curve = body.pial_curve
    normal = curve.nearest(body.nodes[:, body.pial])[1][::-1] * np.array([[1.0], [-1.0]])
    moves = [displacement[:, body.pial] for displacement in displacements]
    shapes = [along_pial(body, body.nodes[:, body.pial] + move) for move in moves]
    outward = np.array([(normal * move).sum(0) for move in moves]).reshape(len(moves), len(body.pial))
    arc = body.pial_arc
    share = np.diff(arc, prepend=arc[0]) + np.diff(arc, append=arc[-1])  # of the surface, of each node
    share /= share.sum()
    about = outward - (outward @ share)[:, None]
    closed = pial_closed(body)
    return {
        "sulcal_depth": np.array([sulcal_depth(shape, closed=closed) for shape in shapes]),
        "normal_displacement": np.abs(outward).max(axis=1),
        "fold_amplitude": np.sqrt(about**2 @ share),
    }


def bifurcation_diagram(axes: Axes, body: Body, path: EquilibriumPath) -> None:
    """Draw the amplitude of folds against growth, or time without growth.

    Unstable states are dashed, limit points marked; the path has at least two points.
    """
    size, unit = length_unit(body)
    name = "growth" if np.ptp(path.of("growth")) > 0 else "time"
    moves = [point.state["displacement"] for point in path.points]
    load, amplitude = path.of(name), pial_measures(body, moves)["fold_amplitude"] / size
    stable = path.stable[1:] & path.stable[:-1]  # of the pieces between points
    ends = [0, *(np.flatnonzero(np.diff(stable)) + 1).tolist(), len(stable)]
    for first, last in pairwise(ends):  # as one line each, or dashes would not show on short pieces
        run, style = slice(first, last + 1), "-" if stable[first] else "--"
        axes.plot(load[run], amplitude[run], style, color=COLOR, linewidth=1.4)
    rate = path.of("rate")
    turns = np.flatnonzero(rate[1:] * rate[:-1] < 0) + 1
    axes.plot(load[turns], amplitude[turns], "o", color=TURN, markersize=4)
    axes.set_xlabel(name)
    axes.set_ylabel(f"fold amplitude ({unit})")
