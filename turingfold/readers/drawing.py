"""Closed curves of drawings in the SVG format."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ..arrays import Array
from ..checks import whole
from .drawing_numbers import path_data, points_data
from .drawing_shapes import Shape, shapes
from .drawing_style import kind_of


def read_drawing(
    file: Path, name: str, samples: int, *, in_user_units: bool
) -> tuple[list[Array], list[str], float | None]:
    """Return the closed curves (2, n) of a drawing, the name of each, and their unit in m, if it states one.

    name: id or label of the shapes, or of a group around them; "" for all.
    in_user_units: the coordinates of the drawing's viewBox are wanted, whatever width it states.
    Raises ValueError for what is no SVG, for numbers that are wrong, for shapes that a clip-path, a mask or
    the viewport of an inner drawing or symbol cuts, and where nothing is found.
    """
    whole("samples", samples, at_least=1)
    shown, unit = shapes(_root(file), file.name, in_user_units=in_user_units)
    loops: list[Array] = []
    names: list[str] = []
    for shape in shown:
        words = shape.place.words
        if name and name not in words:
            continue
        if shape.place.cut:
            raise ValueError(
                f"{shape.place.cut}, and what it leaves of {shape.kind} is not worked out. Cut the shape "
                "itself (in Inkscape: Path > Intersection), or take that out where nothing is cut off."
            )
        for part in _parts(shape):
            points = _points(part, shape.place.matrix, samples)
            if hidden := next((one for one in shape.place.windows if not one.holds(points)), None):
                raise ValueError(
                    f"{hidden.where} hides what lies beyond its width and height, and {shape.where} reaches "
                    'there. Cut the shape itself, or write overflow="visible" at the former to read it whole.'
                )
            if points.shape[1] >= 3:
                loops.append(points)
                names.append(words[-1] if words else "")
    if not loops:
        known = sorted({word for shape in shown for word in shape.place.words})
        what = f"no outline is called {name!r}, names are {', '.join(known) or 'none'}"
        raise ValueError(f"{file.name}: {what if name else 'it shows no shape with at least 3 points'}.")
    return loops, names, unit


def _root(file: Path) -> ElementTree.Element:
    """Return the drawing's tree, the numbers of its paths and polygons examined and in one form."""
    try:
        root = ElementTree.parse(file).getroot()
    except (ElementTree.ParseError, UnicodeDecodeError) as error:
        raise ValueError(f"{file.name} is not well-formed SVG: {error}.") from error
    if kind_of(root) != "svg":
        raise ValueError(f"{file.name} is no SVG: its outermost element is {root.tag!r}.")
    for element in root.iter():
        kind = kind_of(element)
        where = f"{file.name}: {kind} {element.get('id', '')}".rstrip()
        if kind == "path":
            element.set("d", path_data(element.get("d", ""), where))
        if kind in ("polygon", "polyline"):
            element.set("points", points_data(element.get("points", ""), where))
    return root


def _parts(shape: Shape) -> Any:
    """Return the parts of a shape, each a row of segments, in its own user units."""
    import svgelements as svg

    x, y, cx, cy = (shape.length(name) or 0.0 for name in ("x", "y", "cx", "cy"))
    width, height, r, rx, ry = (shape.length(name) for name in ("width", "height", "r", "rx", "ry"))
    rx, ry = (ry if rx is None else rx), (rx if ry is None else ry)
    try:
        if shape.kind == "path":
            path = svg.Path(shape.given.get("d", ""))
        elif shape.kind in ("polygon", "polyline"):
            made = {"polygon": svg.Polygon, "polyline": svg.Polyline}[shape.kind]
            path = svg.Path(made(shape.given.get("points", "")))
        elif shape.kind == "rect":
            path = svg.Path(svg.Rect(x, y, width, height, rx or 0.0, ry or 0.0)) if width and height else ()
        elif shape.kind == "circle":
            path = svg.Path(svg.Circle(cx, cy, r)) if r else ()
        else:
            path = svg.Path(svg.Ellipse(cx, cy, rx, ry)) if rx and ry else ()
        return list(path.as_subpaths()) if path else []
    except (ValueError, TypeError, AttributeError, IndexError, ZeroDivisionError) as error:
        raise ValueError(f"{shape.where} cannot be read: {error}.") from error


def _points(part: Any, matrix: Any, samples: int) -> Array:
    """Return points of a part of a path, (2, n), without the first again; `samples` on a Bézier curve.

    matrix: to which the y axis turned to point upward is added.
    """
    import svgelements as svg

    points: list[complex] = []
    for segment in part:
        if not points and segment.start is not None and not isinstance(segment, svg.Move):
            points.append(complex(*segment.start))  # after Z, a part may begin without a move
        if isinstance(segment, svg.Move | svg.Line):
            points.append(complex(*segment.end))
        elif isinstance(segment, svg.Close):
            points += _closing(points)
        else:
            quarters = abs(segment.sweep) / (np.pi / 2) if isinstance(segment, svg.Arc) else 1.0
            count = samples * max(1, round(quarters))
            points += [complex(*segment.point(t)) for t in np.arange(1, count + 1) / count]
    found = np.array(points)
    while len(found) > 1 and abs(found[0] - found[-1]) <= 1e-9 * np.abs(found).max():
        found = found[:-1]
    x, y = matrix.point_in_matrix_space((found.real, found.imag))
    return np.stack([x, -y])


def _closing(points: list[complex]) -> list[complex]:
    """Return points along the straight segment that closes a path, as far apart as its points are at most."""
    way = points[0] - points[-1]
    longest = float(np.abs(np.diff(points)).max(initial=0.0))
    count = int(np.ceil(abs(way) / longest)) if longest > 0 else 1
    return [points[-1] + way * k / count for k in range(1, count)]
