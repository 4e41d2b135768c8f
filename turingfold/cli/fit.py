"""turingfold fit: the parameters of a scene with which it comes closest to given outlines."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..arrays import Array
from ..figures.style import mark_unfinished
from ..morphometry.landmarks import LandmarkTable
from ..results.document import stored
from ..results.folder import check_folder
from ..results.loading import load, read_result
from ..results.result import Result
from ..results.surface import pial_closed
from ..results.units import is_si, parameter_unit
from ..scene import Scene
from ..sensitivity.fit import fit
from ..sensitivity.inverse import Fit
from ..sensitivity.parameters import number_of, numbers_of
from .case import Case, find_case, folder_name
from .figure import save_figure
from .fit_folder import check_own
from .outcome import Outcome
from .plan import Planned, base_folder, has_result, planned
from .request import Request, Running, Telling
from .run import facts_of, finished, outcomes
from .status import Answer, progress, say
from .table import write_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TABLE = "fit.csv"
COLUMNS = ("parameter", "unit", "value", "standard_error")
MM = 1e3
STRAYED = 0.02  # thicknesses of the cortex between the fitted outline and that of the run that is told
SHOWN = 5  # maps and other parameters in the figure


@dataclass(frozen=True)
class Asked:
    """Targets and landmarks as time and file, bounds by name ("": of all), and what `fit` takes."""

    targets: tuple[tuple[str, str], ...]
    to: tuple[str, ...]
    unit: str | None = None
    bounds: tuple[tuple[str, tuple[float, float]], ...] = ()
    smoothness: float | Literal["auto"] = 0.0
    noise: float | None = None
    landmarks: tuple[tuple[str, str], ...] = ()


def fitted(request: Request, running: Running, asked: Asked) -> Answer:
    """Fit one scene of a case, run it with what was found, store and draw both.

    Raises ValueError for several scenes, unknown parameters, files that hold no outline, and an earlier fit.
    """
    case = find_case(request.case)
    plan = planned(case, request)
    if len(plan) > 1:
        names = ", ".join(one.name for one in plan)
        raise ValueError(f"{case.shown} has the scenes {names}; choose one with --only.")
    (one,) = plan
    to = expanded(one.scene, asked.to)
    files = _by_time("--target", asked.targets)
    targets = {time: outline(file, asked.unit, case.known) for time, file in files.items()}
    base = base_folder(case, request)
    folder = base / folder_name(one.name)
    check_folder(folder, {}, resume=False, overwrite=True)  # before the fit, for foreign files
    if (folder / "scene.json").exists() and not (running.resume or running.overwrite):
        raise ValueError(
            f"{base} already holds a fit; go on with it (--resume), replace it (--overwrite), or choose "
            "another folder (--out DIR)."
        )
    if running.resume:
        check_own(folder, one.scene, to)
    tables = _by_time("--landmarks", asked.landmarks)
    marks = {time: _landmarks(file, asked.unit) for time, file in tables.items()}
    found = fit(
        one.scene, targets, to, bounds=dict(asked.bounds) or None, smoothness=asked.smoothness,
        noise=asked.noise, out=base, resume=running.resume, progress=_misfits(running.telling),
        landmarks=marks,
    )  # fmt: skip
    write_table(base / TABLE, COLUMNS, _rows(found, si=is_si(one.scene)))
    say(_told(found))
    say(f"table: {base / TABLE}")
    steps = replace(found.scene.stepping, stops=tuple(sorted({*found.scene.stepping.stops, *targets})))
    values = dict(zip(to, found.values.tolist(), strict=True))
    end = _ran(
        case, Planned(one.name, replace(found.scene, stepping=steps), {**one.provenance, "fitted": values}),
        request, running,
    )  # fmt: skip
    status = finished([end], case, request)
    say(f"fitted scene: {folder}")
    told = {name: {"value": value, "standard_error": error} for name, _, value, error in _rows(found)}
    facts = {
        "case": case.name, "folder": str(base), "runs": facts_of([end], base), "table": str(base / TABLE),
        "parameters": told,
        "misfits": {f"{time:g}": size for time, size in found.misfits.items()}, "distinct": found.distinct,
        "message": found.message, "remarks": list(found.remarks),
    }  # fmt: skip
    if not has_result(base, one.name):
        return Answer(status, {**facts, "figures": []})
    result, picture = read_result(folder, known=case.known), request.figure or base / f"{case.name}-fit.png"
    strays = list(_strays(result, found))
    for stray in strays:
        say(f"note: {stray}")
    facts["remarks"] = [*found.remarks, *strays]
    _draw(picture, found, result)
    say(f"figure: {picture}")
    return Answer(status, {**facts, "figures": [str(picture)]})


def _strays(result: Result, found: Fit) -> Iterator[str]:
    """Yield at which times the scene, run from its start, is not where the fit was."""
    thickness, times = result.scene.body.thickness, np.array([state.time for state in result.states])
    for age, fitted_ in found.outlines.items():
        near = int(np.argmin(np.abs(times - age)))
        if abs(times[near] - age) > 1e-9 * max(age, 1.0):  # it stopped before
            continue
        off = float(np.hypot(*(result.pial(near) - fitted_)).max())
        if off > STRAYED * thickness:
            yield (
                f"run from its start, the scene is up to {off / thickness:.2g} of the cortical thickness off "
                f"the fitted outline at {age:g}: it may have folded into another branch there"
            )


def _misfits(telling: Telling) -> Callable[[float], None] | None:
    """Return what tells of each misfit, on standard error as of all progress."""
    if telling is Telling.NOTHING:
        return None
    count, best = 0, math.inf

    def told(misfit: float) -> None:
        nonlocal count, best
        count, before, best = count + 1, best, min(best, misfit)
        if misfit < before or telling is Telling.STEPS:
            progress(f"set {count} of the parameters: misfit {misfit:.3g} m")

    return told


def _ran(case: Case, one: Planned, request: Request, running: Running) -> Outcome:
    """Run the fitted scene; an earlier result of a fit that was not quite as good makes way for it."""
    folder = base_folder(case, request) / folder_name(one.name)
    document, _ = stored(running.limited(one.scene), one.provenance)
    try:
        check_folder(folder, document, resume=running.resume, overwrite=running.overwrite)
    except ValueError:
        if not running.resume:
            raise
        check_own(folder, one.scene, one.provenance["fitted"])
        running = replace(running, resume=False, overwrite=True)
    (end,) = outcomes(case, [one], request, running)
    return end


def _draw(picture: Path, found: Fit, result: Result) -> None:
    """Draw outlines with their targets, and the values of each map."""
    with save_figure(picture) as figure:
        groups = list(_groups(found.parameters).items())[:SHOWN]
        widths = [2.5, *(1.0 + 0.1 * len(among) for _, among in groups)]
        figure.set_size_inches(2.2 * sum(widths), 4.0)
        outlines, *panels = figure.subplots(1, 1 + len(groups), width_ratios=widths)
        _draw_outlines(outlines, result, found.targets)
        for axes, (name, among) in zip(panels, groups, strict=True):
            _draw_values(axes, found, name, among)
        figure.suptitle(
            f"{found.distinct} of {len(found.values)} combinations of the parameters told; bars: two standard"
            " errors; gray: not told", fontsize=9,
        )  # fmt: skip
        mark_unfinished(figure, {"the fitted scene": result})


def expanded(scene: Scene, to: tuple[str, ...]) -> tuple[str, ...]:
    """Return parameters, with all entries of those that are maps: "GrowthMap.cortex" names its places.

    Raises ValueError for what is no number of a part, with the nearest names.
    """
    known, found = numbers_of(scene), []
    for name in to:
        split = [(one, *one.rpartition(".")) for one in known]
        places = [one for one, stem, _, place in split if stem == name and place.isdecimal()]
        if not places:
            number_of(scene, name)  # says what is wrong
        found += places or [name]
    return tuple(dict.fromkeys(found))


def outline(path: Path, unit: str | None, known: tuple[Any, ...]) -> Array:
    """Return the pial surface of a result's end, or the outline in a file, (2, n); m."""
    if path.is_dir():
        return load(path, known=known).pial()
    from ..readers.read import read_outline

    read = read_outline(path, unit=unit)
    return read.single() if read.unit is not None else read_outline(path, unit=1.0).single()


def _landmarks(path: Path, unit: str | None) -> list[tuple[Any, Any]]:
    """Return landmarks as `fit` takes them: places on the undeformed surface and points, m."""
    places = LandmarkTable.read(path, unit).places
    return [(tuple(place), tuple(point)) for place, point in places.tolist()]


def _by_time(option: str, given: tuple[tuple[str, str], ...]) -> dict[float, Path]:
    """Return files by time; raises ValueError for what is no time, and for one that is given twice."""
    found: dict[float, Path] = {}
    for text, file in given:
        try:
            time = float(text)
        except ValueError as error:
            raise ValueError(f"{option} {text}={file}: {text!r} is no time; write 1={file}.") from error
        if time in found:
            raise ValueError(f"{option} has the time {time:g} twice; give one file for each.")
        found[time] = Path(file)
    return found


def _rows(found: Fit, *, si: bool = False) -> list[tuple[str, str, float, float]]:
    units = [parameter_unit(name) if si else "" for name in found.parameters]
    return list(zip(found.parameters, units, found.values.tolist(), found.deviations.tolist(), strict=True))


def _told(found: Fit) -> str:
    lines = found.lines()
    lines += [f"misfit at {time:g}: {size:.3g} m" for time, size in found.misfits.items()]
    told, all_ = found.distinct, len(found.parameters)
    lines.append(f"the outlines tell {told} of {all_} combinations of the parameters apart; {found.message}")
    lines += [f"note: {remark}" for remark in found.remarks]
    return "\n".join(lines)


def _draw_outlines(axes: Axes, result: Result, targets: dict[float, Array]) -> None:
    """Draw the fitted pial surfaces and, dotted, the targets."""
    closed = pial_closed(result.scene.body)
    for k, (time, points) in enumerate(targets.items()):
        color = f"C{k}"
        near = int(np.argmin([abs(state.time - time) for state in result.states]))
        for curve, style, words in ((result.pial(near), "-", f"fitted, {time:g}"), (points, ":", "target")):
            x, y = MM * (np.concatenate([curve, curve[:, :1]], axis=1) if closed else curve)
            axes.plot(x, y, style, color=color if style == "-" else "k", linewidth=1.2, label=words)
    axes.set_aspect("equal")
    axes.set_xlabel("mm")
    axes.legend(fontsize=8)


def _groups(parameters: tuple[str, ...]) -> dict[str, list[int]]:
    """Return the numbers of the parameters of each map, and of each other parameter alone."""
    found: dict[str, list[int]] = {}
    for k, name in enumerate(parameters):
        stem, _, place = name.rpartition(".")
        found.setdefault(stem if place.isdecimal() else name, []).append(k)
    return found


def _draw_values(axes: Axes, found: Fit, name: str, among: list[int]) -> None:
    """Draw the values of one map with two standard errors; gray lines: what the outlines do not tell."""
    values, k = found.values[among], np.arange(len(among))
    errors = np.where(np.isfinite(found.deviations), 2 * found.deviations, 0.0)[among]
    size = max(float(np.ptp(values)), 0.1 * float(np.abs(values).max()))
    for flat in found.flat[:, among]:
        if np.abs(flat).max() > 1e-2:
            axes.plot(k, values + 0.5 * size * flat / np.abs(flat).max(), color="0.7", linewidth=0.8)
    axes.errorbar(k, values, errors, fmt="o", markersize=4, capsize=3)
    axes.set_xticks(k if len(k) < 9 else k[:: len(k) // 8])
    untold = "" if np.isfinite(found.deviations[among]).all() else "\nnot told by the outlines"
    axes.set_title(f"{name}{untold}", fontsize=8)
