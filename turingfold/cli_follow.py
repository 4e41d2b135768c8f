"""The command that follows the equilibria of a case's scenes through limit points."""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .arrays import Array
from .cli_case import folder_name, load_case
from .cli_figure import save_figure
from .morphometry.folds import sulcal_depth
from .output.files import write_whole
from .output.history import lines
from .results import along_pial, length_unit, pial_closed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .body import Body
    from .mechanics.arclength import EquilibriumPath
    from .scene import Scene, SolveError

NUMBERS = ("time", "growth", "energy", "negative_pivots", "arc", "rate", "residual")
MEASURED = ("sulcal_depth", "normal_displacement", "fold_amplitude")
COLOR = "#0072b2"


def follow(options: argparse.Namespace) -> str:
    """Return the limit points of each scene of a case as a table; write its path as CSV and draw them.

    <folder>/<scene>.csv: a row per equilibrium; lengths in m.  <folder>/<case>.png: the amplitude of folds
    against growth, unstable states dashed.
    Terms that resist motion are left out: equilibria have none. Where a path stops, what was found is
    written all the same, and the error is raised at the end.
    """
    from .mechanics.arclength import PathStoppedError, equilibria
    from .mechanics.memory import at_rest

    case = load_case(options.case)
    scenes = case.scenes(quick=options.quick, only=options.only or ())
    paths: dict[str, EquilibriumPath] = {}
    stopped: list[SolveError] = []
    for name, scene in scenes.items():
        try:
            paths[name] = equilibria(at_rest(scene))
        except PathStoppedError as error:
            paths[name] = error.path
            stopped.append(error)
        write_path(options.follow / f"{folder_name(name)}.csv", scene.body, paths[name])
    picture = options.follow / f"{case.name}.png"
    _draw(picture, scenes, paths)
    if stopped:
        raise stopped[0]
    return "\n".join([*_table(paths), f"paths: {options.follow}", f"figure: {picture}"])


def measured(body: Body, path: EquilibriumPath) -> dict[str, Array]:
    """Return measures of the pial surface at each point, m.

    Mean sulcal depth; largest displacement along its normal at rest; root mean square of that displacement
    about its mean along the surface, which separates branches that differ in one fold.
    """
    curve = body.pial_curve
    normal = curve.nearest(body.nodes[:, body.pial])[1][::-1] * np.array([[1.0], [-1.0]])
    moves = [point.state["displacement"][:, body.pial] for point in path.points]
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


def write_path(file: Path, body: Body, path: EquilibriumPath) -> None:
    """Write a path as CSV, a row per point."""
    columns = {name: path.of(name) for name in NUMBERS} | measured(body, path)
    columns["negative_pivots"] = path.of("negative_pivots").astype(int)
    rows = [{name: values[k].item() for name, values in columns.items()} for k in range(len(path.points))]
    head = ",".join((*NUMBERS, *MEASURED))
    write_whole(file, f"{head}\n{lines(rows, (*NUMBERS, *MEASURED))}".encode())


def diagram(axes: Axes, body: Body, path: EquilibriumPath) -> None:
    """Draw the amplitude of folds against growth, or time without growth.

    Unstable states are dashed, limit points marked; the path has at least two points.
    """
    size, unit = length_unit(body)
    name = "growth" if np.ptp(path.of("growth")) > 0 else "time"
    load, amplitude = path.of(name), measured(body, path)["fold_amplitude"] / size
    stable = path.stable[1:] & path.stable[:-1]  # of the pieces between points
    ends = [0, *(np.flatnonzero(np.diff(stable)) + 1).tolist(), len(stable)]
    for first, last in pairwise(ends):  # as one line each, or dashes would not show on short pieces
        run, style = slice(first, last + 1), "-" if stable[first] else "--"
        axes.plot(load[run], amplitude[run], style, color=COLOR, linewidth=1.4)
    rate = path.of("rate")
    turns = np.flatnonzero(rate[1:] * rate[:-1] < 0) + 1
    axes.plot(load[turns], amplitude[turns], "o", color="#d55e00", markersize=4)
    axes.set_xlabel(name)
    axes.set_ylabel(f"fold amplitude ({unit})")


def _table(paths: dict[str, EquilibriumPath]) -> list[str]:
    width = max(5, *(len(name) for name in paths))
    rows = [f"{'scene':{width}}  points  reached  limit points at t"]
    for name, path in paths.items():
        turns = ", ".join(f"{time:.4f}" for time in path.limit_points) or "none"
        rows.append(f"{name:{width}}  {len(path.points):6d}  {path.points[-1].time:7.3f}  {turns}")
    return rows


def _draw(file: Path, scenes: dict[str, Scene], paths: dict[str, EquilibriumPath]) -> None:
    with save_figure(file) as figure:
        grid = np.atleast_1d(figure.subplots(-(-len(paths) // 2), min(2, len(paths)))).ravel()
        for axes, (name, path) in zip(grid, paths.items(), strict=False):
            if len(path.points) > 1:
                diagram(axes, scenes[name].body, path)
            axes.set_title(f"{name} (dashed: unstable)", fontsize=9)
        for axes in grid[len(paths) :]:
            axes.set_axis_off()
