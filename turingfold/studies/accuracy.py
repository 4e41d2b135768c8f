"""How much of a result is an error of its mesh and of its steps, and what less of it costs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..checks import instance, whole
from ..figures.style import sulci
from ..geometry.body import Body
from ..geometry.refinement import refined
from ..results.result import Result
from ..scene import Scene, stress_scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

AS_IT_IS = "as it is"
NAMES = {"mesh": "mesh x{}", "steps": "steps x{}"}
MEASURES = {
    "energy_error": "energy, relative",
    "gyrification_error": "gyrification index",
    "distance": "largest distance / T",
}
NOTHING = 1e-12  # of stress times area: less energy than that is none


@dataclass(frozen=True)
class Difference:
    """One run of a series beside the finest one.

    finer: how many times as fine it is as the scene as it is.  seconds: without writing.
    energy: J/m.  gyrification: index.  energy_error: difference to the finest, relative.  gyrification_error:
    of the indices.  distance: the largest between places of the same point of the pial surface, in
    thicknesses of the cortex; all three 0 for the finest.
    """

    finer: int
    elements: float
    dofs: int
    steps: int
    seconds: float
    folds: int
    energy: float
    gyrification: float
    energy_error: float
    gyrification_error: float
    distance: float


def trials(scene: Scene, *, meshes: int = 1, steps: int = 1) -> dict[str, Scene]:
    """Return the scene as it is, with its mesh refined, and with its steps halved, so many times.

    Names are "as it is", "mesh x2", "mesh x4", ..., "steps x2", ... Raises ValueError for neither.
    """
    instance("scene", scene, Scene, "Scene(body=semicircle(...), terms=(Elastic(...),))")
    whole("meshes", meshes, at_least=0)
    if whole("steps", steps, at_least=0) + meshes == 0:
        raise ValueError("meshes=0 and steps=0 leave nothing to compare with; let one of them be at least 1.")
    found, body, now = {AS_IT_IS: scene}, scene.body, scene.stepping
    for k in range(1, meshes + 1):
        body = refined(body)
        found[NAMES["mesh"].format(2**k)] = replace(scene, body=body)
    for n in (2**k for k in range(1, steps + 1)):
        shorter = replace(now, first=now.first / n, largest=now.largest / n, smallest=now.smallest / n)
        found[NAMES["steps"].format(n)] = replace(scene, stepping=shorter)
    return found


def compared(results: Mapping[str, Result]) -> dict[str, list[Difference]]:
    """Return the series "mesh" and "steps", each from the scene as it is to its finest.

    results: by the names that `trials` gives; those of one scene. Raises ValueError without the scene as it
    is, and for one that did not reach its end.
    """
    if AS_IT_IS not in results:
        raise ValueError(f"results has {list(results)}; one of them must be {AS_IT_IS!r}, see trials.")
    for name, result in results.items():
        if not result.converged:
            reached = f"{name!r} stopped at t = {result.last.time:.3g}"
            raise ValueError(f"{reached}; only runs that reach their end can be compared.")
    found = {}
    for kind, name in NAMES.items():
        finer = {1: results[AS_IT_IS]}
        while (again := name.format(2 * max(finer))) in results:
            finer[2 * max(finer)] = results[again]
        if len(finer) > 1:
            finest = list(finer.values())[-1]
            found[kind] = [_difference(n, result, finest) for n, result in finer.items()]
    return found


def _difference(finer: int, result: Result, finest: Result) -> Difference:
    summary, last = result.summary(), finest.summary()
    body = result.scene.body
    # a finer mesh has the nodes of the coarser one under the same numbers
    places = (body.nodes[:, body.pial] + of.last["displacement"][:, body.pial] for of in (result, finest))
    # stress times area, so that no energy at all is no large error of it
    unit = stress_scale(result.scene.terms) * float(body.quadrature.weights.sum())
    return Difference(
        finer=finer,
        elements=body.elements_through_cortex,
        dofs=summary["dofs"],
        steps=summary["steps"],
        seconds=summary["seconds"] - summary["seconds_by_part"].get("writing", 0.0),
        folds=summary["folds"],
        energy=summary["energy"],
        gyrification=summary["gyrification_index"],
        energy_error=abs(summary["energy"] - last["energy"]) / max(abs(last["energy"]), NOTHING * unit),
        gyrification_error=abs(summary["gyrification_index"] - last["gyrification_index"]),
        distance=float(_apart(body, *places).max() / body.thickness),
    )


def _apart(body: Body, one: Array, other: Array) -> Array:
    """Return the distances between two sets of places, (2, n).

    A motion that nothing but the choice of a held node prevents is none: on another mesh it is another node.
    """
    apart, held = one - other, np.setdiff1d(body.fixed, body.supported)
    if len(held) == 1:
        axis = held[0] % 2
        apart[axis] -= apart[axis].mean()
    elif len(held):
        z, w = (np.array([1, 1j]) @ (at - at.mean(axis=1, keepdims=True)) for at in (one, other))
        turn = np.vdot(w, z)
        return np.asarray(np.abs(z - w * turn / abs(turn)))
    return np.asarray(np.hypot(*apart))


def told(series: Mapping[str, Sequence[Difference]]) -> Iterator[str]:
    """Yield the series as tables, with a word of warning where the number of sulci differs."""
    for kind, rows in series.items():
        yield (
            f"{kind:>5}  elements through the cortex  unknowns  steps  seconds  sulci"
            "   energy  gyrification  distance / T"
        )
        for row in rows:
            numbers = [f"{value:.1e}" for value in (row.energy_error, row.gyrification_error, row.distance)]
            shown = numbers if row is not rows[-1] else ["compared", "with", "this"]
            yield (
                f"{f'x{row.finer}':>5}  {row.elements:27.1f}  {row.dofs:8d}  {row.steps:5d}  "
                f"{row.seconds:7.1f}  {row.folds:5d}  {shown[0]:>7}  {shown[1]:>12}  {shown[2]:>12}"
            )
        if len({row.folds for row in rows}) > 1:
            yield (
                "       the number of sulci differs: these runs end in different equilibria, and what tells "
                "them apart is no small error; see Drag, or a smaller growth."
            )
    yield (
        "differences to the finest run, which errs too: of energy (relative), of the gyrification index, and "
        "the largest distance of a point of the pial surface, in cortical thicknesses T"
    )


def draw(figure: Figure, series: Mapping[str, Mapping[str, Sequence[Difference]]]) -> None:
    """Draw differences against run time: a row for each scene, a panel for mesh and steps."""
    rows, columns = len(series), max(len(kinds) for kinds in series.values())
    figure.set_size_inches(5.5 * columns, 4.2 * rows)
    panels = figure.subplots(rows, columns, squeeze=False)
    for line, (name, kinds) in zip(panels, series.items(), strict=True):
        line[0].set_title(name, loc="left", fontsize=10, fontweight="bold", pad=24)
        for axes, (kind, runs) in zip(line, kinds.items(), strict=False):
            _panel(axes, kind, runs)


def _panel(axes: Axes, kind: str, rows: Sequence[Difference]) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter

    *coarser, finest = rows
    times, highest = [row.seconds for row in coarser], np.zeros(len(coarser))
    for (measure, label), marker in zip(MEASURES.items(), "os^", strict=True):
        values = np.array([getattr(row, measure) for row in coarser])
        axes.loglog(times, np.where(values > 0, values, np.nan), marker + "-", label=label)
        highest = np.maximum(highest, values)
    for row, top in zip(coarser, highest, strict=True):
        if top == 0:  # no difference has no place on this axis
            continue
        axes.annotate(
            _size(kind, row), (row.seconds, top), xytext=(0, 6), textcoords="offset points", fontsize=8,
            ha="center",
        )  # fmt: skip
    against = f"{kind}, against {_size(kind, finest)}: {finest.seconds:.3g} s, {sulci(finest.folds)}"
    axes.set_title(against, fontsize=9)
    axes.set_xlabel("run time (s)")
    axes.set_ylabel("difference to the finest")
    axes.set_xlim(0.5 * min(times), 2.0 * max(times))
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.margins(y=0.15)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)


def _size(kind: str, row: Difference) -> str:
    return f"{row.elements:.3g} element(s)" if kind == "mesh" else f"{row.steps} step(s)"
