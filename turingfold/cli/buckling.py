"""The command that says when the scenes of a case buckle, and how."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import SolveError
from ..scene import Scene
from .case import find_case
from .figure import save_figure
from .plan import planned
from .progress import Watch, watching
from .request import Request, Telling
from .status import STOPPED, Answer, complain, progress, say

if TYPE_CHECKING:
    from ..stability.buckling import Buckling

SHOWN = 0.1  # largest displacement of a drawn mode, as a share of the body's length


def report(request: Request, telling: Telling) -> Answer:
    """Print critical growth, mode and time of each scene of a case as a table; draw the modes on request.

    Terms that resist motion are left out: they would only delay what the tangent shows. The exit status is 3
    where a scene has no loss of stability; it is named below the table.
    """
    plan = planned(find_case(request.case), request)
    scenes = {one.name: one.scene for one in plan}
    found: dict[str, Buckling] = {}
    stopped: dict[str, SolveError] = {}
    with watching({name: scene.until for name, scene in scenes.items()}, telling) as watch:
        for name, scene in scenes.items():
            told = f"scene {len(found) + len(stopped) + 1} of {len(scenes)}, {name}"
            _tell(f"{told}: its path is followed until it buckles", telling)
            try:
                found[name] = _buckled(scene, partial(_row, watch, name))
                _tell(f"{told}: buckles at growth {found[name].growth:.4f}", telling)
            except SolveError as error:
                stopped[name] = error
                _tell(f"{told}: {_kind(scene, error)}", telling)
            watch.ended(name)
    say(_table(scenes, found, stopped))
    figures = []
    if request.figure is not None:
        if found:
            _draw(request.figure, scenes, found)
            figures.append(str(request.figure))
        say(f"figure: {request.figure if found else 'not drawn, no scene buckles'}")
    for name, why in stopped.items():
        complain(f"{name}: {why}")
    facts = {name: _facts(found[name]) if name in found else _stop(stopped[name]) for name in scenes}
    return Answer(STOPPED if stopped else 0, {"case": request.case, "scenes": facts, "figures": figures})


def _buckled(scene: Scene, progress: Callable[[dict[str, float]], object]) -> Buckling:
    from ..stability.buckling import buckling
    from ..stability.path_dependence import at_rest

    return buckling(at_rest(scene), progress=progress)


def _row(watch: Watch, name: str, row: dict[str, float]) -> None:
    watch.row(name, row, 0)


def _tell(text: str, telling: Telling) -> None:
    if telling is not Telling.NOTHING:
        progress(text)


def _table(
    scenes: Mapping[str, Scene], found: Mapping[str, Buckling], stopped: Mapping[str, SolveError]
) -> str:
    width = max(len(name) for name in scenes)
    rows = [f"{'scene':{width}}  critical growth  half waves    time"]
    for name, scene in scenes.items():
        if name in stopped:
            kind = _kind(scene, stopped[name])
            rows.append(f"{name:{width}}  {'-':>15}  {'-':>10}  {'-':>6}  ({kind})")
        else:
            one = found[name]
            words = ["limit point"] if one.limit else []
            words += [f"localised on {one.extent:.0%} of the pial surface"] if one.localised else []
            kind = f"  ({', '.join(words)})" if words else ""
            rows.append(f"{name:{width}}  {one.growth:15.4f}  {one.mode:10d}  {one.time:6.3f}{kind}")
    if any(one.localised for one in found.values()):
        rows.append("half waves of a localised mode: as many of its length as the whole surface would hold")
    return "\n".join(rows)


def _kind(scene: Scene, error: SolveError) -> str:
    return "stable until its end" if error.time >= scene.until else "not followed to its end"


def _facts(one: Buckling) -> dict[str, Any]:
    return {
        "growth": one.growth, "time": one.time, "half_waves": one.mode, "extent": one.extent,
        "localised": one.localised, "limit_point": one.limit,
    }  # fmt: skip


def _stop(error: SolveError) -> dict[str, Any]:
    return {"growth": None, "time": error.time, "message": str(error)}


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
            where = f"on {one.extent:.0%} of the surface" if one.localised else f"{one.mode} half waves"
            axes.set_title(f"{name}: growth {one.growth:.3f}, {where}", fontsize=9)
            axes.set_aspect("equal")
            axes.set_axis_off()
        for axes in grid[len(found) :]:
            axes.set_axis_off()
