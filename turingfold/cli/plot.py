"""turingfold plot: the points of a study as a phase diagram, scattered, or as bands of percentiles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..models.declared import nearest
from ..studies.diagram import Values, bands, phase_diagram, values_of
from .figure import save_figure
from .outcome import Outcome
from .status import Answer, say
from .study import gathered, headings

MEASURES = ("folds", "gyrification_index", "sulcal_depth")  # of bands, where none is asked for
FILE = "plot.png"


def plot(base: Path, x: str | None, y: str | None, colour: str | None, figure: Path | None) -> Answer:
    """Draw a study: colour over x and y; with x alone, the percentiles of colour, or of three measures.

    x: None for the only parameter that takes several values, apart from y.
    Raises ValueError for a folder without a study, for unknown columns, where no point has a value, and where
    x is not told and several parameters could be meant.
    """
    study, ends = gathered(base)
    known = headings(study)
    x = x or _only_varied(study, y)
    measures = (colour,) if colour else ("folds",) if y else MEASURES
    for name in (x, *([y] if y else []), *measures):
        if name not in known:
            close, every = nearest(name, known), ", ".join(known)
            raise ValueError(f"the study has no column {name}{close}; it has: {every}.")
    varied = [point["varied"] for point in study["points"]]

    def column(name: str) -> Values:
        return values_of(known[name], [_value(name, *both) for both in zip(varied, ends, strict=True)])

    file = figure or base / FILE
    with save_figure(file) as picture:
        panels = picture.subplots(1, 1 if y else len(measures), squeeze=False)[0]
        picture.set_size_inches(5.6 * len(panels), 4.2)
        if y:
            phase_diagram(panels[0], column(x), column(y), column(measures[0]))
        else:
            for axes, measure in zip(panels, measures, strict=True):
                bands(axes, column(x), column(measure))
            panels[0].legend(fontsize=8)
        picture.suptitle(f"{study['case']}: {_counted(ends)}", fontsize=10)
    say(f"figure: {file}")
    return Answer(0, {"case": study["case"], "figures": [str(file)]})


def _only_varied(study: Mapping[str, Any], y: str | None) -> str:
    points = [point["varied"] for point in study["points"]]
    every: list[str] = list(study["columns"])
    several = [name for name in every if len({point[name] for point in points}) > 1]
    others = [name for name in several or every if name != y]
    if len(others) != 1:
        kinds = f"{', '.join(others)} take" if others else "no other parameter takes"
        raise ValueError(f"{kinds} several values in the study; name what x shows (--x NAME).")
    return others[0]


def _value(name: str, varied: dict[str, Any], end: Outcome) -> Any:
    """Return the value of a point; a measure of one that did not come to a valid end is none."""
    if name in varied:
        return varied[name]
    return end.summary.get(name) if end.status == "converged" else None


def _counted(ends: Sequence[Outcome]) -> str:
    kinds = [end.status for end in ends]
    return f"{len(kinds)} points, " + ", ".join(f"{kinds.count(one)} {one}" for one in dict.fromkeys(kinds))
