"""The command that follows the equilibria of a case's scenes through limit points."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..figures.bifurcation import MEASURES, bifurcation_diagram, pial_measures
from ..results.files import write_whole
from ..results.history import lines
from ..results.units import stored_unit, with_unit
from .case import find_case, folder_name
from .figure import save_figure
from .plan import planned
from .progress import Watch, watching
from .request import Request, Telling
from .status import STOPPED, Answer, complain, say

if TYPE_CHECKING:
    from ..scene import Scene
    from ..stability.arc_length import EquilibriumPath, PathPoint

NUMBERS = ("time", "growth", "energy", "negative_pivots", "arc", "rate", "residual")


def follow(request: Request, telling: Telling, folder: Path) -> Answer:
    """Print the limit points of each scene of a case as a table; write its path as CSV and draw them.

    <folder>/<scene>.csv: a row per equilibrium.  <folder>/<case>.png: the amplitude of folds against growth,
    unstable states dashed.
    Terms that resist motion are left out: equilibria have none. Where paths stop, what was found is written,
    drawn and printed all the same, the scenes are named below, and the exit status is 3.
    """
    from ..stability.arc_length import PathStoppedError, equilibria
    from ..stability.path_dependence import at_rest

    case = find_case(request.case)
    scenes = {one.name: one.scene for one in planned(case, request)}
    paths: dict[str, EquilibriumPath] = {}
    stopped: dict[str, PathStoppedError] = {}
    with watching({name: scene.until for name, scene in scenes.items()}, telling) as watch:
        for name, scene in scenes.items():
            try:
                paths[name] = equilibria(at_rest(scene), progress=partial(_row, watch, name))
            except PathStoppedError as error:
                paths[name] = error.path
                stopped[name] = error
            watch.ended(name)
            write_path(folder / f"{folder_name(name)}.csv", scene, paths[name])
    picture = folder / f"{case.name}.png"
    _draw(picture, scenes, paths)
    say("\n".join([*_table(paths, stopped), f"paths: {folder}", f"figure: {picture}"]))
    for name, why in stopped.items():
        complain(f"{name}: {why}")
    facts = {
        name: {
            "points": len(path.points), "limit_points": path.limit_points.tolist(),
            "reached": path.points[-1].time if path.points else None, "message": str(stopped.get(name, "")),
            "table": str(folder / f"{folder_name(name)}.csv"),
        }
        for name, path in paths.items()
    }  # fmt: skip
    return Answer(STOPPED if stopped else 0, {"case": case.name, "scenes": facts, "figures": [str(picture)]})


def _row(watch: Watch, name: str, point: PathPoint) -> None:
    watch.row(name, {"time": point.time, "step": 0.0, "growth": point.growth, "residual": point.residual}, 0)


def write_path(file: Path, scene: Scene, path: EquilibriumPath) -> None:
    """Write a path as CSV, a row per point."""
    moves = [point.state["displacement"] for point in path.points]
    columns = {name: path.of(name) for name in NUMBERS} | pial_measures(scene.body, moves)
    columns["negative_pivots"] = path.of("negative_pivots").astype(int)
    rows = [{name: values[k].item() for name, values in columns.items()} for k in range(len(path.points))]
    head = ",".join(with_unit(name, stored_unit(scene, name)) for name in (*NUMBERS, *MEASURES))
    write_whole(file, f"{head}\n{lines(rows, (*NUMBERS, *MEASURES))}".encode())


def _table(paths: Mapping[str, EquilibriumPath], stopped: Collection[str]) -> list[str]:
    width = max(5, *(len(name) for name in paths))
    rows = [f"{'scene':{width}}  points  reached  limit points at t"]
    for name, path in paths.items():
        turns = ", ".join(f"{time:.4f}" for time in path.limit_points) or "none"
        reached = f"{path.points[-1].time:.3f}" if path.points else "-"
        end = "  STOPPED EARLY" if name in stopped else ""
        rows.append(f"{name:{width}}  {len(path.points):6d}  {reached:>7}  {turns}{end}")
    return rows


def _draw(file: Path, scenes: dict[str, Scene], paths: dict[str, EquilibriumPath]) -> None:
    with save_figure(file) as figure:
        grid = np.atleast_1d(figure.subplots(-(-len(paths) // 2), min(2, len(paths)))).ravel()
        for axes, (name, path) in zip(grid, paths.items(), strict=False):
            if len(path.points) > 1:
                bifurcation_diagram(axes, scenes[name].body, path)
            axes.set_title(f"{name} (dashed: unstable)", fontsize=9)
        for axes in grid[len(paths) :]:
            axes.set_axis_off()
