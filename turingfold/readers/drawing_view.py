"""Lengths, transforms and viewports of drawings in the SVG format.

Matrices are those of svgelements, which apply one after the other: `first * second`. Its lengths and its
viewports are not taken: an inch is 25.39999 mm there, what is no length is 0, numbers have twelve decimals.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import svgelements as svg

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
INCH = 0.0254
PIXEL = INCH / 96  # of CSS, m
METRES = {"mm": 1e-3, "cm": 1e-2, "q": 0.25e-3, "in": INCH, "pt": INCH / 72, "pc": INCH / 6}
UNITS = {"": 1.0, "px": 1.0, **{unit: metres / PIXEL for unit, metres in METRES.items()}}
LENGTH = re.compile(rf"({NUMBER})(%|[a-z]*)", re.IGNORECASE)
FUNCTION = re.compile(r"([a-z]+)\s*\(([^()]*)\)[\s,]*")
ARGUMENT = rf"{NUMBER}(?:%|[a-z]*)"
ANGLE, FACTOR = rf"{NUMBER}(?:deg|grad|rad|turn)?", rf"{NUMBER}%?"
FORMS = {
    "matrix": rf"{NUMBER}(?: {NUMBER}){{5}}", "rotate": rf"{ANGLE}(?:(?: {NUMBER}(?:px)?){{2}})?",
    "translate": rf"{ARGUMENT}(?: {ARGUMENT})?", "translatex": ARGUMENT, "translatey": ARGUMENT,
    "scale": rf"{FACTOR}(?: {FACTOR})?", "scalex": FACTOR, "scaley": FACTOR,
    "skew": rf"{ANGLE}(?: {ANGLE})?", "skewx": ANGLE, "skewy": ANGLE,
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
) -> svg.Matrix:
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
    return svg.Matrix(scale[0], 0.0, 0.0, scale[1], *shift)


def outermost(given: Mapping[str, str], where: str, *, in_user_units: bool) -> tuple[svg.Matrix, View, bool]:
    """Return the matrix of a drawing, its viewport, and whether it says how large it is, in m.

    A width without a height, or the other way round, follows the shape of the viewBox. A drawing that states
    no physical size, or of which the numbers are wanted (in_user_units), keeps those of its viewBox.
    """
    box = box_of(given.get("viewBox"), where)
    texts = [given.get(name, "auto").strip().lower() for name in ("width", "height")]
    matches = [LENGTH.fullmatch(text) for text in texts]
    width, height = (float(m[1]) * UNITS[m[2]] if m and m[2] in UNITS else np.nan for m in matches)
    if in_user_units or not any(m and m[2] in METRES for m in matches):
        return svg.Matrix(), View(*(box[2:] if box else (width, height))), False
    for name, text, size in zip(("width", "height"), texts, (width, height), strict=True):
        if text != "auto" and not size > 0:
            raise ValueError(
                f"{where}: {name}={text!r} gives the drawing no size; leave it out, or write it in mm, "
                "or give the length of the viewBox's unit as unit."
            )
    if box is None:
        return svg.Matrix.scale(PIXEL), View(width, height), True
    width = height * box[2] / box[3] if np.isnan(width) else width
    height = width * box[3] / box[2] if np.isnan(height) else height
    within = fitted((0.0, 0.0), View(width, height), box, given.get("preserveAspectRatio", ""), where)
    return within * svg.Matrix.scale(PIXEL), View(*box[2:]), True


def stated_unit(given: Mapping[str, str], where: str) -> float | None:
    """Return the length in m of the viewBox's unit by the size that a drawing states, None without one."""
    with suppress(ValueError):
        matrix, _, physical = outermost(given, where, in_user_units=False)
        return float(np.sqrt(matrix.a * matrix.d)) if physical else None
    return None


def transform_of(given: Mapping[str, str], view: View, where: str) -> svg.Matrix:
    """Return the matrix of an element's transform, about its transform-origin.

    Raises ValueError for transforms that SVG does not know, and about boxes of the shapes themselves.
    """
    text = given.get("transform", "none").strip().lower()
    if text in ("none", ""):
        return svg.Matrix()
    functions = [_function(name, inner, view, where) for name, inner in FUNCTION.findall(text)]
    if FUNCTION.sub("", text).strip() or None in functions:
        raise ValueError(f"{where}: the transform {given['transform']!r} is not one that SVG knows.")
    if given.get("transform-box", "view-box") != "view-box":
        raise ValueError(
            f"{where}: transform-box={given['transform-box']!r} is not read; write the transform as a matrix."
        )
    x, y = _origin(given.get("transform-origin", "0 0"), view, where)
    return svg.Matrix(f"translate({x!r} {y!r}) {' '.join(map(str, functions))} translate({-x!r} {-y!r})")


def _function(name: str, inner: str, view: View, where: str) -> str | None:
    """Return a function of a transform as the library reads it, lengths in user units; None of others."""
    words = re.findall(ARGUMENT, inner)
    left = re.sub(ARGUMENT, "", inner).strip(" ,\t\r\n")
    if left or not re.fullmatch(FORMS.get(name, "(?!)"), " ".join(words)):
        return None
    words = [re.sub(r"\.(?!\d)", "", word) for word in words]  # it takes "1.e3" for two numbers
    if name.startswith("translate"):
        axes = "y" if name == "translatey" else "xy"
        words = [repr(view.length(axis, word, where)) for axis, word in zip(axes, words, strict=False)]
    elif name.startswith("scale"):
        words = [repr(float(word.rstrip("%")) * (0.01 if "%" in word else 1.0)) for word in words]
    elif name == "skew":
        words = [*words, "0"][:2]
    return f"{name}({' '.join(words)})"


def _origin(text: str, view: View, where: str) -> tuple[float, float]:
    words = text.lower().split()
    if not 1 <= len(words) <= 3:
        raise ValueError(f"{where}: transform-origin={text!r} must be one or two lengths.")
    first, second = (*words, "center")[:2]
    if first in ("top", "bottom") or second in ("left", "right"):
        first, second = second, first
    x, y = (view.length(axis, WORDS.get(word, word), where) for axis, word in (("x", first), ("y", second)))
    return x, y
