"""The command that says when the scenes of a case buckle, and how."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import NotConvergedError, SolveError
from ..scene import Scene
from .case import find_case
from .figure import save_figure
from .plan import planned
from .request import Request
from .status import progress, say

if TYPE_CHECKING:
    from ..stability.buckling import Buckling

SHOWN = 0.1  # largest displacement of a drawn mode, as a share of the body's length


def report(request: Request, figure: Path | None = None) -> str:
    """Return critical growth, mode and time of each scene of a case as a table; draw the modes on request.

    Terms that resist motion are left out: they would only delay what the tangent shows.
    Raises NotConvergedError, after printing the table, naming the scenes that have no loss of stability.
    """
    from ..stability.buckling import buckling
    from ..stability.path_dependence import at_rest

    plan = planned(find_case(request.case), request)
    scenes = {one.name: one.scene for one in plan}
    found: dict[str, Buckling] = {}
    stopped: dict[str, SolveError] = {}
    for number, (name, scene) in enumerate(scenes.items(), 1):
        progress(f"scene {number} of {len(scenes)}, {name}: its path is followed until it buckles")
        try:
            found[name] = buckling(at_rest(scene))
        except SolveError as error:
            stopped[name] = error
    width = max(len(name) for name in scenes)
    rows = [f"{'scene':{width}}  critical growth  half waves    time"]
    for name, scene in scenes.items():
        if name in stopped:
            kind = "stable until its end" if stopped[name].time >= scene.until else "not followed to its end"
            rows.append(f"{name:{width}}  {'-':>15}  {'-':>10}  {'-':>6}  ({kind})")
        else:
            one = found[name]
            kind = "  (limit point)" if one.limit else ""
            rows.append(f"{name:{width}}  {one.growth:15.4f}  {one.mode:10d}  {one.time:6.3f}{kind}")
    if figure is not None:
        if found:
            _draw(figure, scenes, found)
        rows.append(f"figure: {figure if found else 'not drawn, no scene buckles'}")
    table = "\n".join(rows)
    if stopped:
        say(table)
        raise NotConvergedError("\n".join(f"{name}: {error}" for name, error in stopped.items()))
    return table


def _draw(file: Path, scenes: dict[str, Scene], found: dict[str, Buckling]) -> None:
    from ..figures.sections import outline
    from ..results.result import along_pial

    with save_figure(file) as figure:
        grid = np.atleast_1d(figure.subplots(-(-len(found) // 2), min(2, len(found)))).ravel()
        for axes, (name, one) in zip(grid, found.items(), strict=False):
            body = scenes[name].body
            outline(axes, body)
            moved = body.nodes + one.state["displacement"] + SHOWN * body.length * one.shape
            axes.plot(*(1e3 * along_pial(body, moved[:, body.pial])), color="C3", linewidth=1.2)
            axes.set_title(f"{name}: growth {one.growth:.3f}, {one.mode} half waves", fontsize=9)
            axes.set_aspect("equal")
            axes.set_axis_off()
        for axes in grid[len(found) :]:
            axes.set_axis_off()
