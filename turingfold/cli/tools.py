"""Commands beside running: stability of kinetics, comparison of results."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from .figure import save_figure

if TYPE_CHECKING:
    from ..arrays import Array
    from ..turing.kinetics.base import Kinetics

ELEMENTS = 4  # through the cortex


def stability(options: argparse.Namespace) -> str:
    """Return the Turing conditions of a kinetics as text, and with half waves the modes of a semi-circle.

    Raises ValueError for unknown names and for half waves that the body cannot hold.
    """
    from ..checks import positive
    from ..geometry.shapes import semicircle
    from ..turing.report import stability_report

    body = None
    if options.half_waves is not None:
        T = positive("thickness", options.thickness)
        body = semicircle(radius=options.radius, thickness=T, size=T / ELEMENTS)
    kinetics = _kinetics(options.kinetics, options.param)
    report = stability_report(kinetics, options.ratio, body, options.half_waves or 1)
    if options.figure is None:
        return str(report)
    with save_figure(options.figure) as canvas:
        report.draw(canvas.add_subplot())
    return f"{report}\nfigure: {options.figure}"


def _kinetics(name: str, parameters: Iterable[str]) -> Kinetics:
    from ..turing.kinetics import concentrations, deviations
    from ..turing.kinetics.base import Kinetics

    known = {
        word: item
        for module in (concentrations, deviations)
        for word, item in vars(module).items()
        if isinstance(item, type) and issubclass(item, Kinetics) and item is not Kinetics
    }
    if name not in known:
        raise ValueError(f"there are no kinetics {name!r}; known are {', '.join(sorted(known))}.")
    own = known[name]().parameters
    values = {}
    for text in parameters:
        word, _, value = text.partition("=")
        if word not in own:
            raise ValueError(f"{name} has no parameter {word!r}; it has {', '.join(own)}.")
        try:
            values[word] = float(value)
        except ValueError as error:
            raise ValueError(f"--param {text} is not of the form NAME=VALUE with a number.") from error
    return known[name](**values)


def compare(a: Path, b: Path, figure: Path | None) -> str:
    """Return the morphometry of two results or outlines as a table; draw one on the other on request."""
    from ..morphometry.compare import compare as compared
    from ..morphometry.compare import draw_comparison

    names = (a.name, b.name) if a.name != b.name else (str(a), str(b))
    one, other = _points(a), _points(b)
    table = compared(one, other, names=names).text()
    if figure is None:
        return table
    with save_figure(figure) as canvas:
        draw_comparison(one, other, canvas.add_subplot(), names=names)
    return f"{table}\nfigure: {figure}"


def _points(path: Path) -> Array:
    """Return the pial surface of a result's folder, or the outline in a CSV or SVG file."""
    if path.is_file():
        from ..outlines.read import read_outline

        return read_outline(path).single()
    from ..results.result import load

    return load(path).pial()
