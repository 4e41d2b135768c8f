"""Lengths, transforms and viewports of drawings in the SVG format, as matrices (3, 3)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..arrays import Array

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
INCH = 0.0254
PIXEL = INCH / 96  # of CSS, m
METRES = {"mm": 1e-3, "cm": 1e-2, "q": 0.25e-3, "in": INCH, "pt": INCH / 72, "pc": INCH / 6}
UNITS = {"": 1.0, "px": 1.0, **{unit: metres / PIXEL for unit, metres in METRES.items()}}
ANGLES = {"": np.pi / 180, "deg": np.pi / 180, "rad": 1.0, "grad": np.pi / 200, "turn": 2 * np.pi}
LENGTH = re.compile(rf"({NUMBER})(%|[a-z]*)", re.IGNORECASE)
FUNCTION = re.compile(r"([a-zA-Z]+)\s*\(([^()]*)\)[\s,]*")
ARGUMENT = rf"{NUMBER}(?:%|[a-zA-Z]*)"
COUNTS = {
    "matrix": (6,), "translate": (1, 2), "translatex": (1,), "translatey": (1,),
    "scale": (1, 2), "scalex": (1,), "scaley": (1,), "rotate": (1, 3),
    "skew": (1, 2), "skewx": (1,), "skewy": (1,),
}  # fmt: skip
ASPECT = re.compile(r"(?:defer\s+)?(?:(none)|x(Min|Mid|Max)Y(Min|Mid|Max))(?:\s+(meet|slice))?")
SHARE = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
WORDS = {"left": "0%", "top": "0%", "center": "50%", "right": "100%", "bottom": "100%"}


@dataclass(frozen=True)
class View:
    """Width and height of a viewport, of which percentages are shares; NaN where the file does not say."""

    width: float
    height: float

    def length(self, name: str, text: str, where: str) -> float:
        """Return the length that an attribute states, in the viewport's user units.

        Raises ValueError for units that are not known, and for shares of a viewport that has no size.
        """
        match = LENGTH.fullmatch(text.strip())
        unit = match[2].lower() if match else None
        if match and unit == "%":
            found = float(match[1]) / 100 * self._whole(name)
            if np.isfinite(found):
                return found
            raise ValueError(f"{where}: {name}={text!r} is a share of a window whose size no file states.")
        if match is None or unit not in UNITS:
            raise ValueError(
                f"{where}: {name}={text!r} is no length; known units are {', '.join(UNITS).lstrip(', ')}."
            )
        return float(match[1]) * UNITS[unit]

    def _whole(self, name: str) -> float:
        if name == "r":
            return float(np.hypot(self.width, self.height) / np.sqrt(2))
        return self.width if name in ("x", "cx", "width", "rx") else self.height


def moved(x: float, y: float) -> Array:
    """Return the matrix of a translation."""
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def box_of(text: str | None, where: str) -> tuple[float, float, float, float] | None:
    """Return the numbers of a viewBox, or None without one; ValueError unless they are four with a size."""
    if text is None or text.strip() == "none":
        return None
    numbers = re.split(r"\s*,\s*|\s+", text.strip())
    if len(numbers) != 4 or not all(re.fullmatch(NUMBER, number) for number in numbers):
        raise ValueError(f"{where}: viewBox={text!r} must be four numbers x, y, width, height.")
    x, y, width, height = map(float, numbers)
    if not (width > 0 and height > 0):
        raise ValueError(f"{where}: viewBox={text!r} has no size; its width and height must be positive.")
    return x, y, width, height


def fitted(
    place: tuple[float, float], size: View, box: tuple[float, float, float, float], aspect: str, where: str
) -> Array:
    """Return the matrix that lays a viewBox into a viewport, as preserveAspectRatio says; "": xMidYMid."""
    match = ASPECT.fullmatch(aspect.strip() or "xMidYMid")
    if not match:
        raise ValueError(f"{where}: preserveAspectRatio={aspect!r} is not one that SVG knows.")
    x, y, width, height = box
    scale = np.array([size.width / width, size.height / height])
    shares = np.zeros(2)
    if not match[1]:
        scale[:] = scale.max() if match[4] == "slice" else scale.min()
        shares[:] = SHARE[match[2]], SHARE[match[3]]
    free = np.array([size.width, size.height]) - scale * (width, height)
    shift = np.array(place) - scale * (x, y) + shares * free
    return moved(*shift) @ np.diag([*scale, 1.0])


def outermost(given: Mapping[str, str], where: str, *, in_user_units: bool) -> tuple[Array, View, bool]:
    """Return the matrix of a drawing, its viewport, and whether it says how large it is, in m.

    A width without a height, or the other way round, follows the shape of the viewBox. A drawing that states
    no physical size, or of which the numbers are wanted (in_user_units), keeps those of its viewBox.
    """
    box = box_of(given.get("viewBox"), where)
    texts = [given.get(name, "auto").strip().lower() for name in ("width", "height")]
    matches = [LENGTH.fullmatch(text) for text in texts]
    known = [match[2] if match else "" for match in matches]
    pixels = [float(m[1]) * UNITS[m[2]] if m and m[2] in UNITS else np.nan for m in matches]
    if in_user_units or not set(known) & set(METRES):
        return np.eye(3), View(*(box[2:] if box else pixels)), False
    for name, text, size in zip(("width", "height"), texts, pixels, strict=True):
        if text != "auto" and not size > 0:
            raise ValueError(
                f"{where}: {name}={text!r} gives the drawing no size; leave it out, or write it in mm, "
                "or give the length of the viewBox's unit as unit."
            )
    scale = np.diag([PIXEL, PIXEL, 1.0])
    if box is None:
        return scale, View(*pixels), True
    width, height = pixels
    width = height * box[2] / box[3] if np.isnan(width) else width
    height = width * box[3] / box[2] if np.isnan(height) else height
    within = fitted((0.0, 0.0), View(width, height), box, given.get("preserveAspectRatio", ""), where)
    return scale @ within, View(*box[2:]), True


def transform_of(given: Mapping[str, str], view: View, where: str) -> Array:
    """Return the matrix of an element's transform, about its transform-origin.

    Raises ValueError for transforms that SVG does not know, and about boxes of the shapes themselves.
    """
    text = given.get("transform", "none").strip()
    if text.lower() in ("none", ""):
        return np.eye(3)
    wrong = ValueError(f"{where}: the transform {text!r} is not one that SVG knows.")
    if FUNCTION.sub("", text).strip():
        raise wrong
    found = np.eye(3)
    for name, inner in FUNCTION.findall(text):
        words = re.findall(ARGUMENT, inner)
        kind = name.lower()
        if re.sub(ARGUMENT, "", inner).strip(" ,\t\r\n") or len(words) not in COUNTS.get(kind, ()):
            raise wrong
        try:
            found = found @ _function(kind, words, view, where)
        except KeyError as error:
            raise wrong from error
    if given.get("transform-box", "view-box") != "view-box":
        raise ValueError(
            f"{where}: transform-box={given['transform-box']!r} is not read; write the transform as a matrix."
        )
    x, y = _origin(given.get("transform-origin", "0 0"), view, where)
    return moved(x, y) @ found @ moved(-x, -y)


def _function(kind: str, words: list[str], view: View, where: str) -> Array:
    """Return the matrix of one function of a transform; KeyError for unknown units."""
    if kind.startswith("translate"):
        axes = "y" if kind.endswith("y") else "xy"
        shift = {axis: view.length(axis, word, where) for axis, word in zip(axes, words, strict=False)}
        return moved(shift.get("x", 0.0), shift.get("y", 0.0))
    parts = [(float(m[1]), m[2].lower()) for m in map(LENGTH.fullmatch, words) if m]
    if kind.startswith("s") and "k" not in kind:
        factors = [value * {"": 1.0, "%": 0.01}[unit] for value, unit in parts]
        x, y = {"x": (factors[0], 1.0), "y": (1.0, factors[0])}.get(kind[5:], (factors[0], factors[-1]))
        return np.asarray(np.diag([x, y, 1.0]))
    if kind == "matrix":
        a, b, c, d, e, f = (value * {"": 1.0}[unit] for value, unit in parts)
        return np.array([[a, c, e], [b, d, f], [0.0, 0.0, 1.0]])
    angles = [value * ANGLES[unit] for value, unit in parts]
    if kind == "rotate":
        cos, sin = np.cos(angles[0]), np.sin(angles[0])
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        x, y = (value * {"": 1.0, "px": 1.0}[unit] for value, unit in parts[1:] or [(0.0, "")] * 2)
        return np.asarray(moved(x, y) @ turn @ moved(-x, -y))
    along = np.tan(angles[0]) if kind != "skewy" else 0.0
    down = np.tan(angles[-1]) if kind == "skewy" or len(angles) == 2 else 0.0
    return np.array([[1.0, along, 0.0], [down, 1.0, 0.0], [0.0, 0.0, 1.0]])


def _origin(text: str, view: View, where: str) -> tuple[float, float]:
    words = text.lower().split()
    if not 1 <= len(words) <= 3:
        raise ValueError(f"{where}: transform-origin={text!r} must be one or two lengths.")
    first, second = (*words, "center")[:2]
    if first in ("top", "bottom") or second in ("left", "right"):
        first, second = second, first
    x, y = (view.length(axis, WORDS.get(word, word), where) for axis, word in (("x", first), ("y", second)))
    return x, y
