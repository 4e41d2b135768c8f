"""The shapes that a drawing in the SVG format shows, each with its place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from xml.etree.ElementTree import Element

import numpy as np
import svgelements as svg

from ..arrays import Array
from .drawing_style import CUTS, Rule, declared, kind_of, rules_of
from .drawing_view import View, box_of, fitted, outermost, stated_unit, transform_of

LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
LINKS = ("href", "{http://www.w3.org/1999/xlink}href")
SHAPES = ("path", "circle", "ellipse", "rect", "polygon", "polyline")
GROUPS = ("svg", "g", "a", "switch", "use")
SHOWN_BEYOND = ("visible", "auto")  # of overflow; a drawing in the drawing, and a symbol, hide it
ROUND_OFF = 1e-6  # of a window's size
LANGUAGE = "en"  # of which the branch of a switch is shown


@dataclass(frozen=True)
class Window:
    """A viewport beyond which nothing is shown: a rectangle in the user units of what is around it."""

    matrix: svg.Matrix
    corner: tuple[float, float]
    size: tuple[float, float]
    where: str

    def holds(self, points: Array) -> bool:
        """Return whether places of the drawing, (2, n), y upward, lie in it, but for round-off."""
        if not np.isfinite(self.size).all() or not self.matrix.determinant:
            return True
        at = np.stack((~self.matrix).point_in_matrix_space((points[0], -points[1])))
        low, size = np.array(self.corner)[:, None], np.array(self.size)[:, None]
        near = ROUND_OFF * size
        return bool(((at >= low - near) & (at <= low + size + near)).all())


@dataclass(frozen=True)
class Place:
    """Where an element is: matrix, viewport, the names round it, what cuts it, `use` elements, windows."""

    matrix: svg.Matrix
    view: View
    words: tuple[str, ...] = ()
    visible: bool = True
    cut: str = ""
    users: tuple[Element, ...] = ()
    windows: tuple[Window, ...] = ()


@dataclass(frozen=True)
class Shape:
    """A shape that is shown: its kind, what it declares, its place; `where` names it in messages."""

    kind: str
    given: Mapping[str, str]
    place: Place
    where: str

    def length(self, name: str) -> float | None:
        """Return a length that it declares, None without one or for "auto"; ValueError if negative."""
        found = _length(self.given, name, self.place.view, self.where)
        if found is not None and found < 0 and name not in ("x", "y", "cx", "cy"):
            raise ValueError(f"{self.where}: {name}={self.given[name]!r} is negative; sizes are not.")
        return found


def shapes(root: Element, source: str, *, in_user_units: bool) -> tuple[list[Shape], float | None]:
    """Return the shapes of a drawing that are shown, and the unit of their places by what it states; m.

    What only serves others (`defs`, `symbol`, `clipPath`, `mask`, `marker`, `pattern`) is shown where it is
    used; of a `switch` the first branch that English readers without extensions see.
    Raises ValueError for what cannot be placed.
    """
    tree = _Tree(source, rules_of(root, source), {e.get("id", ""): e for e in reversed(list(root.iter()))})
    given, where = declared(root, tree.rules, source), f"{source}: svg"
    matrix, view, physical = outermost(given, where, in_user_units=in_user_units)
    unit = stated_unit(given, where) if in_user_units else 1.0 if physical else None
    if _is_left_out(given):
        return [], unit
    place = replace(_inside(given, Place(matrix, view), where), words=())
    return list(tree.within(root, place)), unit


@dataclass(frozen=True)
class _Tree:
    source: str
    rules: list[Rule]
    elements: Mapping[str, Element]

    def shown(self, element: Element, place: Place, size: Mapping[str, str] | None = None) -> Iterator[Shape]:
        """Yield the shapes of an element; size: the width and height that a `use` gives it."""
        kind = kind_of(element)
        given = declared(element, self.rules, self.source)
        where = f"{self.source}: {kind} {given.get('id', '')}".rstrip()
        used = kind == "symbol" and size is not None
        if not _is_met(given) or (_is_left_out(given) and not used):
            return
        if kind == "foreignObject" and any(kind_of(inner) in SHAPES for inner in element.iter()):
            raise ValueError(
                f"{where} holds shapes, whose place another language gives; take them out of it."
            )
        if kind not in (*SHAPES, *GROUPS) and not used:
            return
        place = _inside(given, place, where)
        if kind == "use":
            yield from self._used(element, given, place, where)
        elif kind in GROUPS or used:
            if kind in ("svg", "symbol"):
                place = _viewport({**given, **(size or {})}, place, where)
            yield from self.within(element, place)
        elif place.visible:
            yield Shape(kind, given, place, where)

    def within(self, element: Element, place: Place) -> Iterator[Shape]:
        """Yield the shapes of what is in an element; of a switch, those of one branch."""
        inner = [each for each in element if kind_of(each)]
        if kind_of(element) == "switch":
            inner = [each for each in inner if _is_met(each.attrib)][:1]
        for each in inner:
            yield from self.shown(each, place)

    def _used(self, element: Element, given: Mapping[str, str], place: Place, where: str) -> Iterator[Shape]:
        link = next((given[name] for name in LINKS if name in given), "")
        target = self.elements.get(link[1:]) if link[:1] == "#" and link[1:] else None
        if target is None:
            raise ValueError(
                f"{where} shows {link!r}, which is not in this file; put it there, or leave it out."
            )
        if element in place.users:
            raise ValueError(f"{where} shows itself; take it out.")
        x, y = (_length(given, name, place.view, where) or 0.0 for name in ("x", "y"))
        matrix = svg.Matrix.translate(x, y) * place.matrix
        inner = replace(place, matrix=matrix, users=(*place.users, element))
        size = {name: given[name] for name in ("width", "height") if given.get(name, "auto") != "auto"}
        yield from self.shown(target, inner, size if kind_of(target) in ("svg", "symbol") else None)


def _inside(given: Mapping[str, str], place: Place, where: str) -> Place:
    """Return the place of what is in an element: after its transform, with its names, visible or not."""
    words = tuple(word for word in (given.get("id"), given.get(LABEL)) if word)
    visibility = given.get("visibility", "inherit").strip().lower()
    cuts = [name for name in CUTS if given.get(name, "none").strip().lower() not in ("none", "")]
    return replace(
        place,
        matrix=transform_of(given, place.view, where) * place.matrix,
        words=place.words + words,
        visible=place.visible if visibility == "inherit" else visibility == "visible",
        cut=f"{where} has {cuts[0]}={given[cuts[0]]!r}" if cuts else place.cut,
    )


def _viewport(given: Mapping[str, str], place: Place, where: str) -> Place:
    """Return the place of what is in a drawing within the drawing, or in a symbol that is used."""
    x, y = (_length(given, name, place.view, where) or 0.0 for name in ("x", "y"))
    sizes = (_length(given, name, place.view, where) for name in ("width", "height"))
    width, height = (
        own if size is None else size
        for size, own in zip(sizes, (place.view.width, place.view.height), strict=True)
    )
    if given.get("overflow", "hidden").strip().lower() not in SHOWN_BEYOND:
        window = Window(place.matrix, (x, y), (width, height), where)
        place = replace(place, windows=(*place.windows, window))
    box = box_of(given.get("viewBox"), where)
    if box is None:
        return replace(place, matrix=svg.Matrix.translate(x, y) * place.matrix, view=View(width, height))
    if not (width > 0 and height > 0):
        raise ValueError(f"{where}: width and height are {width:g} and {height:g}; give them, in numbers.")
    within = fitted((x, y), View(width, height), box, given.get("preserveAspectRatio", ""), where)
    return replace(place, matrix=within * place.matrix, view=View(box[2], box[3]))


def _is_left_out(given: Mapping[str, str]) -> bool:
    return given.get("display", "").strip().lower() == "none"


def _is_met(given: Mapping[str, str]) -> bool:
    """Return whether the conditions of an element hold: no extensions, and English among its languages."""
    languages = given.get("systemLanguage")
    spoken = languages is None or any(
        word.strip().lower().split("-")[0] == LANGUAGE for word in languages.split(",")
    )
    return spoken and "requiredExtensions" not in given


def _length(given: Mapping[str, str], name: str, view: View, where: str) -> float | None:
    text = given.get(name, "auto").strip()
    return None if text == "auto" else view.length(name, text, where)
