"""What the names of two columns say of their order, and of which way they count."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ..arrays import Array
from ..geometry.units import UNIT

ACROSS = ("x", "col", "cols", "column", "columns", "horizontal")
ALONG = ("y", "row", "rows", "vertical")
EITHER_WAY = ("ml", "lr", "rl", "dv", "si")  # anatomical: written as well where they count the other way
AXES = ("x", "y", "z")
DOWNWARD = ("row", "rows")  # of an image are counted from its top
NAME = rf"({'|'.join(ACROSS + ALONG + EITHER_WAY)})(?:[\W_]*{UNIT}(?![^\W_])|(?![^\W_]))"
NAMES = re.compile(rf"\W*(?:columns?\s*[:=]\s*)?{NAME}[\W_]*\b{NAME}\W*", re.IGNORECASE)


@dataclass(frozen=True)
class Order:
    """swapped: the first column is y.  downward: y is counted downward."""

    swapped: bool = False
    downward: bool = False

    def placed(self, columns: Array) -> Array:
        """Return the columns (2, n) as x and y."""
        x, y = columns[::-1] if self.swapped else columns
        found: Array = columns.copy()
        found[0], found[1] = x, -y if self.downward else y
        return found


def order_of_header(fields: Sequence[str], source: str) -> dict[str, Order]:
    """Return the order that the fields of a header tell, by what they are: "y (mm),x (mm)"; none of others.

    Raises ValueError where both name the same direction, z comes first, or directions count either way.
    """
    if len(fields) != 2:
        return order_of_comment(" ".join(fields), source)
    return _order(source, ",".join(fields), *(_name(field) for field in fields))


def order_of_comment(text: str, source: str) -> dict[str, Order]:
    """Return the order that a comment tells that is made of two names, with units or without: "# row, col".

    Raises as `order_of_header`.
    """
    match = NAMES.fullmatch(text)
    return _order(source, text.strip(), match[1].lower(), match[2].lower()) if match else {}


def _name(field: str) -> str:
    """Return the word of a column's name that says what it is, or "" of one that does not."""
    match = re.fullmatch(NAME + r"\W*", field.strip(), re.IGNORECASE)
    words = [match[1].lower()] if match else re.findall(r"[^\W_]+", field.lower())
    known = [word for word in words if word in AXES] or [
        word for word in words if word in ACROSS + ALONG + EITHER_WAY
    ]
    return known[0] if known else ""


def _order(source: str, said: str, first: str, second: str) -> dict[str, Order]:
    if not (first and second) or (first != "z" and second == "z"):
        return {}  # x, z and y, z are planes, across first
    if {first, second} & {*EITHER_WAY}:
        raise ValueError(
            f"{source}: the columns are named {said!r}, which does not tell whether they count to the right "
            "and upward; name them x and y if they do, else turn the signs round."
        )
    if first == "z" or (first in ACROSS) == (second in ACROSS):
        raise ValueError(
            f"{source}: the columns are named {said!r}, which does not tell which of them runs across the "
            "section; name them x and y."
        )
    return {said: Order(first in ALONG, bool({first, second} & {*DOWNWARD}))}
