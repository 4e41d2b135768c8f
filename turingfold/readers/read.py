"""Outlines from files: columns of numbers (CSV) and drawings (SVG)."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

from shapely import Polygon

from ..arrays import Array
from ..checks import file_path
from ..geometry.units import metres, note_large
from .columns import read_columns

SAME = 0.01  # by which two units may differ, as pages are rounded
COLUMNS = (".csv", ".txt", ".dat", ".tsv")


@dataclass(frozen=True, eq=False)
class Contours:
    """The closed curves of a file, in its order.

    loops: each (2, n), the last point not repeated; m, or the numbers of the file where `unit` is None.
    names: of each loop, by which it can be asked for; "" where the file gives none.
    unit: of the file's coordinates, in m; None where neither the file nor the caller states one.
    source: the file's name.
    """

    loops: tuple[Array, ...]
    names: tuple[str, ...]
    unit: float | None
    source: str

    def single(self) -> Array:
        """Return the only loop, (2, n).

        Raises ValueError where there are several, with the area of each.
        """
        if len(self.loops) == 1:
            return self.loops[0]
        each = [f"{name or k} ({Polygon(loop.T).area:.3g})" for k, (name, loop) in enumerate(self._named())]
        shown = ", ".join(each[:8]) + (", ..." if len(each) > 8 else "")
        raise ValueError(
            f"{self.source} holds {len(self.loops)} closed curves where one is wanted: {shown}, with their "
            "areas. Ask for one by its name, take one from read_outline(...).loops, or keep one in the file."
        )

    def _named(self) -> list[tuple[str, Array]]:
        return list(zip(self.names, self.loops, strict=True))


def read_outline(
    path: str | Path, *, name: str = "", unit: str | float | None = None, samples: int = 24
) -> Contours:
    """Return all closed curves of a CSV or SVG file; `.single()` gives the curve of a file that holds one.

    CSV: two columns x, y, separated by comma, semicolon, tab or space, with a decimal point or comma. Blank
    rows, or rows of NaN, begin a new curve. Rows without a number are a header, which may state the unit:
    "x (mm), y (mm)", or a row "mm,mm"; and the order: "y,x", or "row,col", with rows from the top. Lines
    from # or % on are comments, which may: "# units: mm".
    SVG: every path, circle, ellipse, rect, polygon and polyline that is shown, each part of a path a curve of
    its own, with all transforms applied and the y axis turned to point upward; a Bézier curve or a quarter of
    an ellipse has `samples` points. The unit follows from a width or height in mm, cm, in, pt or pc and the
    viewBox, laid into them as preserveAspectRatio says. Shapes cut by a clip-path, a mask or an inner
    viewport are refused.
    name: id or label of the shapes (or of the group or layer that they are in) to read; left out: all.
    unit: of the file's coordinates, "m", "cm", "mm", "um", "nm", "in" or metres; left out: as the file says,
    and if it states none, the numbers are returned as they are. In a drawing it is that of the viewBox.
    Warns of a unit that is not what the file states, of single points of columns that lie far off, and of
    curves of 10 m and more.
    Raises ValueError for other files, and for what cannot be read, with its place.
    """
    found = contours(path, name, unit, samples)
    if unit is None:
        header = "" if Path(path).suffix.lower() == ".svg" else ' or the header "x (mm),y (mm)"'
        note_large(found.source, found.loops, f'give unit="mm"{header}', found.unit)
    return found


def contours(
    path: str | Path, name: str = "", unit: str | float | None = None, samples: int = 24, *, told: bool = True
) -> Contours:
    """Return what `read_outline` returns, without a word on curves that are too large.

    told: whether to warn of a unit that is not what the file states.
    """
    file = file_path("path", path, "a CSV or SVG file")
    given = None if unit is None else metres(unit)
    kind = file.suffix.lower()
    if kind == ".svg":
        from .drawing import read_drawing

        loops, names, stated = read_drawing(file, name, samples, in_user_units=given is not None)
    elif kind in COLUMNS:
        if name:
            raise ValueError(f"name={name!r}: curves of {file.name} have no names; SVG files have.")
        loops, stated = read_columns(file, unit_is_given=given is not None)
        names = [""] * len(loops)
    else:
        known = ", ".join(COLUMNS)
        raise ValueError(f"{file.name} ends in {file.suffix!r}; outlines are read from {known} and .svg.")
    if told and given and stated and abs(given / stated - 1) > SAME:
        warnings.warn(
            f"{file.name} states that its unit is {stated:.4g} m, and unit={unit!r} is taken instead: "
            f"lengths are {given / stated:.3g} times what it says. Leave unit out, or correct the file.",
            stacklevel=3,
        )
    used = stated if given is None else given
    scaled = tuple(loop * (used or 1.0) for loop in loops)
    return Contours(scaled, tuple(names), used, file.name)
