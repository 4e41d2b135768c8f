"""turingfold sensitivity: which parameters of a case's scenes matter for where they end, and how much."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..figures.bars import tornado
from ..results.loading import load
from ..results.result import Result
from ..results.units import is_si, measure_unit, parameter_unit
from ..scene import Scene
from ..sensitivity.forward import Sensitivity, sensitivity
from ..sensitivity.parameters import number_of, numbers_of
from ..sensitivity.tangent import Equilibrium
from ..stability.path_dependence import refuse_motion
from .case import find_case, folder_name
from .figure import save_figure
from .parser import MEASURES
from .plan import base_folder, planned
from .request import Request, Running
from .run import facts_of, finished, outcomes
from .status import Answer, say
from .table import write_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TABLE = "sensitivity.csv"
COLUMNS = (
    "scene", "measure", "measure_unit", "number", "parameter", "parameter_unit", "value", "derivative",
    "per_cent_per_per_cent", "force_error", "good_for", "kink",
)  # fmt: skip


@dataclass(frozen=True)
class Asked:
    """Parameters and measures, () for all."""

    to: tuple[str, ...] = ()
    of: tuple[str, ...] = ()


def sensitivities(request: Request, running: Running, asked: Asked) -> Answer:
    """Run scenes, print and store the sensitivities of their ends, and draw them.

    Raises ValueError, before anything is run, for scenes that no sensitivity is known of, and for unknown
    parameters.
    """
    case = find_case(request.case)
    plan = planned(case, request)
    scenes = {one.name: one.scene for one in plan}
    parameters = {name: _parameters(name, scene, asked) for name, scene in scenes.items()}
    base = base_folder(case, request)
    usual = base / f"{case.name}-sensitivity.png"
    ends = list(outcomes(case, plan, request, running))
    status = finished(ends, case, request)
    facts = {"case": case.name, "folder": str(base), "runs": facts_of(ends, base)}
    if status:  # table and figure of an earlier run would be of other results
        for stale in (base / TABLE, usual):
            stale.unlink(missing_ok=True)
        return Answer(status, {**facts, "scenes": {}, "table": None, "figures": []})
    found = {}
    for name, to in parameters.items():
        result = load(base / folder_name(name), known=case.known)
        try:
            found[name] = _sensitivity(result, to, asked)
        except ValueError as error:
            raise ValueError(f"scene {name!r}: {error}") from error
        say("\n".join(_told(name, found[name])))
    rows = (row for name, one in found.items() for row in _rows(name, one, si=is_si(scenes[name])))
    write_table(base / TABLE, COLUMNS, rows)
    say(f"table: {base / TABLE}")
    picture = request.figure or usual
    with save_figure(picture) as figure:
        draw(figure, found)
    say(f"figure: {picture}")
    own = {name: _facts(one) for name, one in found.items()}
    return Answer(status, {**facts, "scenes": own, "table": str(base / TABLE), "figures": [str(picture)]})


def _sensitivity(result: Result, to: tuple[str, ...], asked: Asked) -> Sensitivity:
    """Return the sensitivities of a result, without parameters that nobody named and that cannot change."""
    of = asked.of or MEASURES
    try:
        return sensitivity(result, to=to, of=of)
    except ValueError as error:
        if asked.to:
            raise
        cause = error
    here, free = Equilibrium.of(result, -1), []
    for name in to:
        try:
            here.change(name)
        except ValueError as error:  # such as half of a symmetric map
            say(f"note: {name} is left out: {error}")
        else:
            free.append(name)
    if len(free) in (0, len(to)):  # it was something else
        raise cause
    return sensitivity(result, to=free, of=of)


def draw(figure: Figure, found: Mapping[str, Sensitivity]) -> None:
    """Draw a row for each scene and a panel for each measure."""
    columns = max(len(one.measures) for one in found.values())
    bars = min(12, max(len(one.parameters) for one in found.values()))
    figure.set_size_inches(4.2 * columns, (1.4 + 0.25 * bars) * len(found))
    rows = figure.subfigures(len(found), 1, squeeze=False)[:, 0]
    for row, (name, one) in zip(rows, found.items(), strict=True):
        row.suptitle(name, fontsize=10, fontweight="bold")
        panels = row.subplots(1, columns, squeeze=False)[0]
        for axes, measure, number, values in zip(
            panels, one.measures, one.numbers, one.relative, strict=True
        ):
            tornado(axes, one.parameters, values)
            axes.set_title(f"{measure.replace('_', ' ')} {number:.4g}", fontsize=9)


def _parameters(name: str, scene: Scene, asked: Asked) -> tuple[str, ...]:
    """Return the parameters of a scene; raises ValueError for unknown ones and where there are none."""
    try:
        refuse_motion(scene)
        for parameter in asked.to:
            number_of(scene, parameter)
    except ValueError as error:
        raise ValueError(f"scene {name!r}: {error}") from error
    found = asked.to or numbers_of(scene)
    if not found:
        raise ValueError(f"scene {name!r} has no parameter that is a number with a decimal point.")
    return tuple(dict.fromkeys(found))


def _told(name: str, one: Sensitivity) -> Iterator[str]:
    yield f"{name}:"
    yield one.text()
    if one.negative_pivots:
        yield f"this state is unstable: its tangent has {one.negative_pivots} negative pivots"


def _facts(one: Sensitivity) -> dict[str, Any]:
    """Return numbers by measure, and by parameter its value and by how many per cent each measure changes."""
    numbers = dict(zip(one.measures, one.numbers.tolist(), strict=True))
    parameters = {
        name: {
            "value": value, "derivatives": dict(zip(one.measures, slopes, strict=True)),
            "per_cent_per_per_cent": dict(zip(one.measures, shares, strict=True)), "good_for": reach,
        }
        for name, value, slopes, shares, reach in zip(
            one.parameters, one.values.tolist(), one.derivatives.T.tolist(), one.relative.T.tolist(),
            one.ranges.tolist(), strict=True,
        )
    }  # fmt: skip
    return {"measures": numbers, "parameters": parameters, "negative_pivots": one.negative_pivots}


def _rows(name: str, one: Sensitivity, *, si: bool) -> Iterator[tuple[Any, ...]]:
    for i, measure in enumerate(one.measures):
        for k, parameter in enumerate(one.parameters):
            units = (measure_unit(measure), parameter_unit(parameter)) if si else ("", "")
            yield (
                name, measure, units[0], one.numbers[i], parameter, units[1], one.values[k],
                one.derivatives[i, k], one.relative[i, k], one.errors[k], one.ranges[k], one.jumps[i, k],
            )  # fmt: skip
