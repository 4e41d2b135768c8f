"""What the header and the comments of a file say of its columns: their unit and their order."""

from __future__ import annotations

import warnings
from contextlib import suppress
from dataclasses import dataclass, field

from ..geometry.units import (
    KNOWN,
    scales_of,
    unit_of,
    units_in_passing,
    units_of_comment,
    units_of_header,
    units_spoken,
)
from .column_names import Order, order_of_comment, order_of_header


@dataclass
class Said:
    """What is said of the columns of a file.

    stated: units, by a header or "units:".  spoken: by other comments.  scales: of units and pixels, which
    may be those of an image behind it.  mentioned: units in passing.  headers, comments: what may name the
    columns.
    """

    name: str
    stated: list[str] = field(default_factory=list)
    spoken: list[str] = field(default_factory=list)
    scales: list[str] = field(default_factory=list)
    mentioned: list[str] = field(default_factory=list)
    headers: list[list[str]] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)

    def comment(self, text: str) -> None:
        """Take in a comment."""
        if found := units_of_comment(text):
            self.stated += found
        else:
            self.spoken += units_spoken(text)
            self.scales += scales_of(text)
        self.mentioned += units_in_passing(text)
        self.comments.append(text)

    def header(self, line: str, fields: list[str]) -> None:
        """Take in a line of words, and its fields."""
        if found := scales_of(line):
            self.scales += found
        else:
            self.stated += units_of_header(fields)
        self.mentioned += units_in_passing(line)
        self.headers.append(fields)

    def unit(self) -> float | None:
        """Return the length in m of the unit that is said, or None without a word.

        Scales count where no unit is stated.
        Raises ValueError for several units, for unknown ones, and for those in passing only: it is not known
        what these are of.
        """
        words = [*self.stated, *self.spoken, *([] if self.stated else self.scales)]
        if self.mentioned and not words:
            raise ValueError(
                f"{self.name}: its header or a comment mentions {self.mentioned[0]!r}, and does not say "
                'whether that is the unit of its coordinates; give unit="mm" or another, or write "# units: '
                'mm", or take it out.'
            )
        units = {word: unit_of(word) for word in words}
        for word, unit in units.items():
            if unit is None:
                raise ValueError(
                    f"{self.name}: its header or a comment states the unit {word!r}; known are {KNOWN}. Give "
                    "the length of its unit in m, such as unit=1e-4, or take that word out."
                )
        if len(set(units.values())) > 1:
            raise ValueError(
                f"{self.name}: it states several units of length, {', '.join(units)}; give both columns in "
                "one."
            )
        return next(iter(units.values()), None)

    def order(self) -> Order:
        """Return the order of the columns that a header tells, or comments without one; else x and y.

        Raises ValueError where they tell several, or none for sure. Warns of comments that differ from
        a header.
        """
        by_header: dict[str, Order] = {}
        for fields in self.headers:
            by_header |= order_of_header(fields, self.name)
        if not by_header:
            by_comment: dict[str, Order] = {}
            for text in self.comments:
                by_comment |= order_of_comment(text, self.name)
            return self._one(by_comment)
        order = self._one(by_header)
        for text in self.comments:
            with suppress(ValueError):  # it tells none for sure
                for said, other in order_of_comment(text, self.name).items():
                    if other != order:
                        warnings.warn(
                            f"{self.name}: a comment names its columns {said!r}, its header "
                            f"{next(iter(by_header))!r}, which counts.",
                            stacklevel=5,
                        )
        return order

    def _one(self, orders: dict[str, Order]) -> Order:
        """Return the only order of several names, x and y without one."""
        if len(set(orders.values())) > 1:
            raise ValueError(
                f"{self.name}: it names its columns in several orders, {' and '.join(map(repr, orders))}; "
                "keep one."
            )
        return next(iter(orders.values()), Order())
