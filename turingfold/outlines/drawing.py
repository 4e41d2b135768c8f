"""Closed curves of drawings in the SVG format."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ..arrays import Array
from ..checks import whole

LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
INCH = 0.0254
METRES = {"mm": 1e-3, "cm": 1e-2, "Q": 0.25e-3, "in": INCH, "pt": INCH / 72, "pc": INCH / 6}
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
WIDTH = re.compile(rf"\s*({NUMBER})\s*({'|'.join(METRES)})\s*")
FLAG = "[01]"
COMMAND = re.compile(r"([a-zA-Z])([^a-df-zA-DF-Z]*)")
ARGUMENTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
TRANSFORM = re.compile(r"(?:(?:matrix|translate|scale|rotate|skewX|skewY)\s*\([^()]*\)[\s,]*)*|none", re.I)


def read_drawing(
    file: Path, name: str, samples: int, *, in_user_units: bool
) -> tuple[list[Array], list[str], float | None]:
    """Return the closed curves (2, n) of a drawing, the name of each, and their unit in m, if it states one.

    name: id or label of the shapes, or of a group around them; "" for all.
    in_user_units: the coordinates of the drawing's viewBox are wanted, whatever width it states.
    Raises ValueError for what is no SVG, for numbers that are wrong, and where nothing is found.
    """
    import svgelements as svg

    whole("samples", samples, at_least=1)
    root = _root(file)
    width = None if in_user_units else WIDTH.fullmatch(root.get("width", ""))
    if width is None:
        for word in ("width", "height", "viewBox"):
            root.attrib.pop(word, None)
    try:
        drawing: Any = svg.SVG.parse(io.BytesIO(ElementTree.tostring(root)), reify=False)
    except (ValueError, TypeError, AttributeError, IndexError, ZeroDivisionError) as error:
        raise ValueError(f"{file.name} cannot be read as SVG: {error}.") from error
    if not isinstance(drawing, svg.SVG) or (width is not None and not drawing.width):
        raise ValueError(
            f"{file.name} cannot be read as SVG: its outermost element has no name space or size."
        )
    scale = 1.0 if width is None else float(width[1]) * METRES[width[2]] / drawing.width
    loops: list[Array] = []
    names: list[str] = []
    known: set[str] = set()
    for shape, words in _shapes(drawing, ()):
        known |= set(words)
        if name and name not in words:
            continue
        path = svg.Path(shape)
        for part in path.as_subpaths():
            points = _points(part, path.transform, samples)
            if points.shape[1] >= 3:
                loops.append(points * scale)
                names.append(words[-1] if words else "")
    if not loops:
        what = f"no outline is called {name!r}, names are {', '.join(sorted(known)) or 'none'}"
        raise ValueError(f"{file.name}: {what if name else 'it shows no shape with at least 3 points'}.")
    return loops, names, None if width is None else 1.0


def _root(file: Path) -> ElementTree.Element:
    """Return the drawing's tree, its numbers examined: the SVG reader passes over what it cannot read."""
    try:
        root = ElementTree.parse(file).getroot()
    except (ElementTree.ParseError, UnicodeDecodeError) as error:
        raise ValueError(f"{file.name} is not well-formed SVG: {error}.") from error
    if root.tag.rpartition("}")[2] != "svg":
        raise ValueError(f"{file.name} is no SVG: its outermost element is {root.tag!r}.")
    for element in root.iter():
        kind = str(element.tag).rpartition("}")[2]
        where = f"{file.name}: {kind} {element.get('id', '')}".rstrip()
        if kind == "path":
            _examine_path(element.get("d", ""), where)
        if kind in ("polygon", "polyline"):
            numbers = re.findall(NUMBER, element.get("points", ""))
            left = re.sub(NUMBER, "", element.get("points", "")).strip(" ,\t\r\n")
            if len(numbers) % 2 or re.sub(r"[\s,]", "", left):
                raise ValueError(f"{where}: the attribute points must be pairs of numbers x, y.")
        style = re.search(r"(?:^|;)\s*transform\s*:([^;]*)", element.get("style", ""))
        for text in (element.get("transform", ""), style[1] if style else ""):
            if not TRANSFORM.fullmatch(text.strip()):
                raise ValueError(f"{where}: the transform {text.strip()!r} is not one that SVG knows.")
    return root


def _examine_path(text: str, where: str) -> None:
    """Refuse path data with unknown commands or wrong counts of numbers, or that begin without M."""
    commands = COMMAND.findall(text)
    if re.sub(r"\s", "", text) != re.sub(r"\s", "", "".join(a + b for a, b in commands)):
        raise ValueError(f"{where}: the path begins with {text.strip()[:10]!r}; it must begin with M or m.")
    for k, (command, values) in enumerate(commands):
        kind = command.upper()
        if k == 0 and kind != "M":
            raise ValueError(f"{where}: the path begins with {command!r}; it must begin with M or m.")
        if kind not in ARGUMENTS:
            raise ValueError(f"{where}: there is no path command {command!r}.")
        one = [NUMBER] * ARGUMENTS[kind]
        if kind == "A":
            one[3] = one[4] = FLAG  # "a1 1 0 011 1": flags need no space after them
        row = r"[\s,]*".join(one)
        if not re.fullmatch(rf"\s*(?:{row}[\s,]*)+" if one else r"\s*", values):
            raise ValueError(
                f"{where}: path command {command!r} has {values.strip()[:40]!r}, which are not sets of "
                f"{ARGUMENTS[kind]} numbers."
            )


def _shapes(group: Any, outer: tuple[str, ...]) -> list[tuple[Any, tuple[str, ...]]]:
    """Return the shapes shown in a group, each with its id and label, after those of the groups round it."""
    import svgelements as svg

    found = []
    for element in group:
        attributes = element.values.get("attributes", element.values)
        own = [element.id, attributes.get(LABEL)]
        words = outer + tuple(word for word in own if word)
        if isinstance(element, svg.Group | svg.Use):
            found += _shapes(element, words)
        elif isinstance(element, svg.Shape):
            found.append((element, words))
    return found


def _points(part: Any, transform: Any, samples: int) -> Array:
    """Return points of a part of a path, (2, n), without the first again; `samples` on a Bézier curve.

    They are transformed as points: the reader's own transformed arcs are wrong under shear.
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
    x, y = found.real, found.imag
    m = transform
    return np.stack([m.a * x + m.c * y + m.e, -(m.b * x + m.d * y + m.f)])


def _closing(points: list[complex]) -> list[complex]:
    """Return points along the straight segment that closes a path, as far apart as its points are at most."""
    way = points[0] - points[-1]
    longest = float(np.abs(np.diff(points)).max(initial=0.0))
    count = int(np.ceil(abs(way) / longest)) if longest > 0 else 1
    return [points[-1] + way * k / count for k in range(1, count)]
