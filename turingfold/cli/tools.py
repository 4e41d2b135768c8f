"""Commands beside running: stability of kinetics, comparison of results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .figure import save_figure
from .request import Assignments
from .status import Answer, say

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..arrays import Array
    from ..morphometry.landmarks import Landmarks

ELEMENTS = 4  # through the cortex
CONDITIONS = (
    "activator", "ratio", "critical_ratio", "critical_k2", "fastest_k2", "fastest_rate", "hopf_margin",
)  # fmt: skip


@dataclass(frozen=True)
class Stability:
    """What is asked of a kinetics; parameters as text, lengths in m, `half_waves` on a semi-circle."""

    kinetics: str
    parameters: Assignments = ()
    ratio: float | None = None
    half_waves: int | None = None
    radius: float = 0.0404
    thickness: float = 2.5e-3
    figure: Path | None = None


def stability(asked: Stability) -> Answer:
    """Print the Turing conditions of a kinetics, and with half waves the modes of a semi-circle.

    Raises ValueError for unknown names and for half waves that the body cannot hold.
    """
    from ..geometry.shapes import semicircle
    from ..turing.kinetics.named import kinetics_named
    from ..turing.report import stability_report

    body = None
    if asked.half_waves is not None:
        body = semicircle(radius=asked.radius, thickness=asked.thickness, elements=ELEMENTS)
    values = {}
    for word, text in asked.parameters:
        try:
            values[word] = float(text)
        except ValueError as error:
            raise ValueError(f"--param {word}={text} is not of the form NAME=VALUE with a number.") from error
    kinetics = kinetics_named(asked.kinetics, **values)
    report = stability_report(kinetics, asked.ratio, body, asked.half_waves or 1)
    say(str(report))
    found = report.conditions
    facts = {name: getattr(found, name) for name in (*CONDITIONS, "band")}
    facts |= {
        "kinetics": asked.kinetics, "steady_state": list(found.steady_state),
        "unstable": all(check.holds for check in found.checks),
        "growing_half_waves": [mode.half_waves for mode in report.growing],
    }  # fmt: skip
    return Answer(0, facts | _pictured(asked.figure, report.draw))


def _pictured(file: Path | None, draw: Callable[[Axes], object]) -> dict[str, list[str]]:
    """Draw on one pair of axes where that is asked for, say where, and return the files."""
    if file is None:
        return {"figures": []}
    with save_figure(file) as canvas:
        draw(canvas.add_subplot())
    say(f"figure: {file}")
    return {"figures": [str(file)]}


def compare(
    a: Path, b: Path, figure: Path | None, landmarks: Path | None = None, *,
    curves: tuple[str | None, str | None] = (None, None), known: tuple[Any, ...] = (),
) -> Answer:  # fmt: skip
    """Print the morphometry of two results or outlines as a table; draw one on the other on request.

    curves: which to take where there are several, by number or name.
    Lengths are in mm where both are no longer than brains in m.
    """
    from ..morphometry.compare import compare as compared
    from ..morphometry.compare import draw_comparison
    from ..results.units import BRAIN

    names = (a.name, b.name) if a.name != b.name else (str(a), str(b))
    first, second = (
        _curve(path, f"--curve-{own}", which, known)
        for path, own, which in zip((a, b), "ab", curves, strict=True)
    )
    one, other = first.points, second.points
    given = {first.thickness, second.thickness} - {None}
    thickness = given.pop() if len(given) == 1 else None
    longest = max(np.ptp(curve, axis=1).max() for curve in (one, other))
    scale, unit = (1e3, "mm") if longest < BRAIN else (1.0, "m")

    def scaled(start: Array | None) -> Array | None:
        return None if start is None else scale * start

    found = compared(
        scale * one,
        scale * other,
        names=names,
        thickness=None if thickness is None else scale * thickness,
        starts=(scaled(first.start), scaled(second.start)),
        landmarks=None if landmarks is None else _landmarks(landmarks, first, second),
        unit=unit,
    )
    say(found.text())
    facts = {
        "names": names, "similarity": found.similarity,
        "measures": [
            {"name": row.name, "unit": row.unit, "a": row.a, "b": row.b, "ratio": row.ratio}
            for row in found.measures
        ],
    }  # fmt: skip
    draw = partial(draw_comparison, one, other, names=names, thickness=thickness)
    return Answer(0, facts | _pictured(figure, draw))


@dataclass(frozen=True, eq=False)
class _Curve:
    """A curve, (2, n), of a result with its points at the start and its thickness, or of a file without.

    has_unit: whether its points are in m, as of a file that states a unit.
    """

    path: Path
    points: Array
    start: Array | None = None
    thickness: float | None = None
    has_unit: bool = True


def _landmarks(file: Path, a: _Curve, b: _Curve) -> Landmarks:
    """Return the landmarks on two curves; a ValueError says of a curve that it states no unit."""
    from ..morphometry.landmarks import OffCurveError, read_landmarks

    try:
        return read_landmarks(file, a.points, b.points)
    except OffCurveError as error:
        curve = {"a": a, "b": b}[error.curve]
        if curve.has_unit:
            raise
        raise ValueError(
            f"{error} {curve.path} states no unit, so that its numbers are read as metres; state it there, "
            'as by the header "x (mm),y (mm)" or, in a drawing, a width in mm.'
        ) from error


def _curve(path: Path, option: str, which: str | None, known: tuple[Any, ...]) -> _Curve:
    """Return the pial surface of a result, or the outline in a file.

    which: of several curves, by number or name; the option that takes it is named where it is missing.
    """
    if path.is_file():
        from ..readers.read import read_outline

        read = read_outline(path)
        k = _chosen(path, option, which, read.loops, read.names)
        return _Curve(path, read.loops[k], has_unit=read.unit is not None)
    from ..results.loading import load
    from ..results.surface import facing

    result = load(scene_folder(path), known=known)
    body = result.scene.body
    if len(body.pial_paths) == 1 and which is None:
        return _Curve(path, result.pial(), result.pial(0), body.thickness)
    ends = result.pial_parts()
    k = _chosen(path, option, which, ends, [""] * len(ends))
    return _Curve(path, facing(ends[k]), facing(result.pial_parts(0)[k]), body.thickness)


def _chosen(path: Path, option: str, which: str | None, curves: Sequence[Array], names: Sequence[str]) -> int:
    """Return the number of the curve that is asked for, or of the only one; else ValueError.

    which: its number, or a name that no other has; a number is one though a curve may have it for a name.
    """
    if which is None and len(curves) == 1:
        return 0
    numbers = [k for k in range(len(curves)) if str(k) == which]
    found = numbers or [k for k, name in enumerate(names) if name and name == which]
    if len(found) == 1:
        return found[0]
    from ..morphometry.polyline import perimeter

    each = [
        f"{k} ({f'{names[k]}, ' if names[k] else ''}{perimeter(curves[k], closed=True):.3g} long)"
        for k in found or range(len(curves))
    ]
    shown = ", ".join(each[:8]) + (", ..." if len(each) > 8 else "")
    wrong = "one is wanted of" if which is None else f"{option} {which}: there is none in"
    if found:
        raise ValueError(
            f"{option} {which}: {len(found)} curves of {path} have this name: {shown}; choose one by its "
            f"number, as by {option} {found[0]}."
        )
    raise ValueError(f"{wrong} {path}, of {len(curves)} curves: {shown}; choose one, as by {option} 0.")


def scene_folder(path: Path) -> Path:
    """Return the folder of a scene's result: the one that is named, or the only one in that of a case.

    Raises ValueError where a case's folder holds several, or nothing is there.
    """
    if not path.exists():
        raise ValueError(f"there is no file or folder {path}; name the folder of a result, or an outline.")
    if (path / "scene.json").exists():
        return path
    found = sorted(file.parent for file in path.glob("*/scene.json"))
    if len(found) > 1:
        raise ValueError(f"{path} holds several results; name one of {', '.join(map(str, found))}.")
    return found[0] if found else path
