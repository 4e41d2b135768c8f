"""The picture of the atlas: where cells are valid, where they stop, and what they take."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .families import FAMILIES
from .known import reached, told
from .run import FORBIDDEN, OUTCOMES, REFUSED, STOPPED, TOLD, VALID, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {VALID: "#0072b2", TOLD: "#e69f00", STOPPED: "#cc79a7", REFUSED: "#999999"}
DEPTHS = (0.08, 0.1, 0.15, 0.2, 0.3, 0.4)
MARKS = {VALID: "o", TOLD: "s", STOPPED: "^", REFUSED: "x"}


def draw(figure: Figure, rows: Mapping[str, Sequence[Row]]) -> None:
    """Draw mechanics, patterns, runs in time, effort, and the families of scenes."""
    figure.set_size_inches(12, 12)
    panels = figure.subplot_mosaic([["a", "b"], ["c", "d"], ["e", "e"]], height_ratios=[3, 3, 2])
    growth, shape, patterns, effort, families = panels.values()
    solid = rows["mechanics"]
    ratio = [float(row["cortex"]) / float(row["core"]) for row in solid]
    _points(growth, solid, ratio, [float(row["ratio"]) for row in solid])
    growth.set(yscale="log", xlabel="growth of cortex over core", ylabel="modulus of cortex over core")
    depths = [float(row["thickness"]) for row in solid]
    ratios = sorted({float(row["poisson"]) for row in solid})
    shift = np.random.default_rng(0).uniform(-0.3, 0.3, len(solid))  # so that points do not hide each other
    levels = [ratios.index(float(row["poisson"])) + s for row, s in zip(solid, shift, strict=True)]
    _points(shape, solid, depths, levels)
    shape.set(xscale="log", xlabel="thickness of the cortex / radius", ylabel="Poisson's ratio")
    shape.set_xticks(DEPTHS, [f"{depth:g}" for depth in DEPTHS])
    shape.set_xticks([], minor=True)
    shape.set_yticks(range(len(ratios)), [f"{ratio:g}" for ratio in ratios])
    chemical = [*rows["pattern"], *rows["march"]]
    names = sorted({row["kinetics"] for row in chemical})
    side = [0.18] * len(rows["pattern"]) + [-0.18] * len(rows["march"])
    heights = [names.index(row["kinetics"]) + up for row, up in zip(chemical, side, strict=True)]
    _points(patterns, chemical, [float(row["beyond"]) for row in chemical], heights)
    patterns.set(xscale="log", xlabel="diffusivity ratio over the critical one, less 1")
    patterns.set_yticks(range(len(names)), names)
    took = [row for row in solid if row["iterations"]]
    _points(effort, took, [float(row["iterations"]) for row in took], [float(row["seconds"]) for row in took])
    effort.set(xscale="log", yscale="log", xlabel="Newton iterations", ylabel="run time with its check (s)")
    drawn = [(row, number) for number, family in enumerate(FAMILIES) for row in rows[family]]
    whole = [row for row, _ in drawn]
    spread = np.random.default_rng(0).uniform(-0.3, 0.3, len(drawn))
    places = [number + s for (_, number), s in zip(drawn, spread, strict=True)]
    _points(families, whole, [max(float(row["seconds"]), 0.02) for row in whole], places)
    families.set(xscale="log", xlabel="run time with its check (s)")
    names = [f"{family}, {len(rows[family])}\n{_share(family, rows)}" for family in FAMILIES]
    families.set_yticks(range(len(FAMILIES)), names)
    families.invert_yaxis()
    titles = (
        _title("mechanics", solid), told(reached("mechanics", solid)) or "the same cells",
        _title("patterns (steady above)", chemical),
        "effort, mechanics", _title("families of scenes", whole),
    )  # fmt: skip
    for (letter, axes), title in zip(panels.items(), titles, strict=True):
        axes.set_title(f"$\\bf{{{letter}}}$   {title}", loc="left", fontsize=10)
        axes.grid(alpha=0.25)
    handles = dict(zip(*reversed(growth.get_legend_handles_labels()), strict=True))
    for axes in (patterns, families):
        handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=len(handles), frameon=False
    )


def summed(rows: Sequence[Row]) -> str:
    """Return how many cells became what."""
    counts = Counter(row["outcome"] for row in rows)
    words = [f"{counts[outcome]} {outcome}" for outcome in OUTCOMES if counts[outcome]]
    return f"{len(rows)} cells: {', '.join(words)}"


def _title(what: str, rows: Sequence[Row]) -> str:
    forbidden = sum(row["outcome"] in FORBIDDEN for row in rows)
    return f"{what}, {len(rows)} cells, {forbidden} lies, hangs, untyped errors"


def _share(family: str, rows: Mapping[str, Sequence[Row]]) -> str:
    found, known = reached(family, rows[family])
    return f"{found} of {known} known" if known else ""


def _points(axes: Axes, rows: Sequence[Row], x: Sequence[float], y: Sequence[Any]) -> None:
    for outcome in OUTCOMES:
        own = [k for k, row in enumerate(rows) if row["outcome"] == outcome]
        if own:
            color, mark = COLOURS.get(outcome, "#d00000"), MARKS.get(outcome, "*")
            size = 26 if outcome not in FORBIDDEN else 160
            axes.scatter(
                [x[k] for k in own], [y[k] for k in own], s=size, color=color, marker=mark, label=outcome,
                alpha=0.8, linewidths=1.0 if mark == "x" else 0.0, zorder=3,
            )  # fmt: skip
