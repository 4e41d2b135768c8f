"""turingfold accuracy: what a case's mesh and steps leave as error, against run time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields

from ..results.loading import load
from ..results.result import Result
from ..results.units import is_si, measure_unit, with_unit
from ..studies.accuracy import Difference, compared, draw, told, trials
from .case import check_apart, find_case, folder_name
from .figure import save_figure
from .plan import Planned, base_folder, planned
from .request import Request, Running, Telling
from .run import facts_of, finished, outcomes
from .status import Answer, progress, say
from .table import write_table

TABLE = "accuracy.csv"


def accuracy(request: Request, running: Running, *, meshes: int, steps: int) -> Answer:
    """Run scenes also on finer meshes and with shorter steps; say how much they differ, and draw it."""
    case = find_case(request.case)
    plan = [
        Planned(f"{one.name}, {own}", trial, one.provenance)
        for one in planned(case, request)
        for own, trial in trials(one.scene, meshes=meshes, steps=steps).items()
    ]
    check_apart([one.name for one in plan], case.path)
    base = base_folder(case, request)
    ends = []
    for end in outcomes(case, plan, request, running):
        ends.append(end)
        if running.telling is not Telling.NOTHING:
            progress(f"run {len(ends)} of {len(plan)}, {end.name}: {end.status}")
    status = finished(ends, case, request)
    usual = base / f"{case.name}-accuracy.png"
    facts = {"case": case.name, "folder": str(base), "runs": facts_of(ends, base)}
    if status:  # table and figure of an earlier run would be of other results
        for stale in (base / TABLE, usual):
            stale.unlink(missing_ok=True)
        return Answer(status, {**facts, "series": {}, "table": None, "figures": []})
    scenes = of_scenes({one.name: load(base / folder_name(one.name), known=case.known) for one in plan})
    rows = []
    for scene, series in scenes.items():
        say(f"{scene}:")
        for line in told(series):
            say(line)
        rows += [(scene, kind, *asdict(row).values()) for kind, runs in series.items() for row in runs]
    si = all(is_si(one.scene) for one in plan)
    names = (with_unit(field.name, _unit(field.name, si=si)) for field in fields(Difference))
    write_table(base / TABLE, ("scene", "series", *names), rows)
    say(f"table: {base / TABLE}")
    picture = request.figure or usual
    with save_figure(picture) as figure:
        draw(figure, scenes)
    say(f"figure: {picture}")
    numbers = {
        scene: {kind: list(map(asdict, differences)) for kind, differences in own.items()}
        for scene, own in scenes.items()
    }
    return Answer(status, {**facts, "series": numbers, "table": str(base / TABLE), "figures": [str(picture)]})


def _unit(name: str, *, si: bool) -> str:
    """Return the unit of a column; si: whether energies are in J/m, and not in units of the scene's own."""
    return "T" if name == "distance" else measure_unit(name) if si else ""


def of_scenes(results: Mapping[str, Result]) -> dict[str, dict[str, list[Difference]]]:
    """Return the differences by scene, from results by the names "scene, trial"."""
    found: dict[str, dict[str, Result]] = {}
    for name, result in results.items():
        scene, _, own = name.rpartition(", ")
        found.setdefault(scene, {})[own] = result
    return {scene: compared(own) for scene, own in found.items()}
