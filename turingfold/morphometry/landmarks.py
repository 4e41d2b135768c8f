"""Landmarks: named points that two curves have in common, read from a table."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array, Integers
from ..checks import file_path
from ..geometry.units import KNOWN, metres, unit_of
from .polyline import Polyline, as_polyline

COLUMNS = ("name", "x_a", "y_a", "x_b", "y_b")
COLUMN = re.compile(r"(name|[xy]_[ab])(?:[\s_/]*[\[(]\s*([^\])]*?)\s*[\])]|[\s_/]+(\S+))?\s*", re.IGNORECASE)
NEAR = 0.05  # farthest that a landmark may lie from its curve, over the radius of the body


class OffCurveError(ValueError):
    """A landmark lies far from its curve, as one in another unit; `curve` is "a" or "b"."""

    def __init__(self, message: str, curve: str) -> None:
        super().__init__(message)
        self.curve = curve


@dataclass(frozen=True, kw_only=True)
class Landmarks:
    """Names (k), and indices (k, 2) of the points of two curves that correspond."""

    names: tuple[str, ...]
    indices: Integers


@dataclass(frozen=True, kw_only=True)
class LandmarkTable:
    """Names (k), and places (k, 2, 2): of each on two curves a and b, x and y.  where: file and line, (k).

    Places are in m where the file or the caller states a unit, else the numbers of the file.
    """

    names: tuple[str, ...]
    places: Array
    where: tuple[str, ...]

    @classmethod
    def read(cls, path: str | Path, unit: str | float | None = None) -> LandmarkTable:
        """Return the landmarks of a CSV file with the columns name, x_a, y_a, x_b, y_b.

        The header may state units of the four, "x_a (mm)" or "x_a_mm".  unit: of all, in place of these.
        Raises ValueError, naming file and line, for other columns or units, repeated names, rows of more
        fields, and what is no number.
        """
        file = file_path("landmarks", path, "a CSV file")
        with file.open(newline="", encoding="utf-8-sig") as stream:
            table = csv.reader(stream, skipinitialspace=True)
            factors = _factors(file, next(table, []), unit)
            rows = [_row(f"{file}, line {table.line_num}", row) for row in table if any(row)]
        names = tuple(row[0].strip() for _, row in rows)
        for (where, _), name in zip(rows, names, strict=True):
            if not name or names.count(name) > 1:
                raise ValueError(f"{where}: the name {name!r} must be there, and only once.")
        if not rows:
            raise ValueError(f"{file} has no landmarks; give a line for each.")
        numbers = [[_place(where, row[1:3], "a"), _place(where, row[3:5], "b")] for where, row in rows]
        places = np.array(numbers) * np.reshape(factors, (2, 2))
        return cls(names=names, places=places, where=tuple(where for where, _ in rows))


def _row(where: str, row: Sequence[str]) -> tuple[str, list[str]]:
    """Return a row of five fields, of a longer one what it has beyond empty fields; raises ValueError."""
    more = [field for field in row[len(COLUMNS) :] if field.strip()]
    if more:
        raise ValueError(
            f"{where}: {len(row)} fields, where the header has {len(COLUMNS)}; if commas are decimal signs, "
            "write points instead."
        )
    return where, [*row, *len(COLUMNS) * [""]][: len(COLUMNS)]


def _factors(file: Path, header: Sequence[str], unit: str | float | None) -> list[float]:
    """Return what the numbers of the four columns are multiplied by; raises ValueError for another header."""
    found = [COLUMN.fullmatch(field.strip()) for field in header]
    if tuple(match[1].lower() for match in found if match) != COLUMNS or len(header) != len(COLUMNS):
        raise ValueError(
            f"{file}: the first line is {','.join(header)!r}; it must be {','.join(COLUMNS)!r}, with units "
            'of the four, such as "x_a (mm)", if they are not in m.'
        )
    if unit is not None:
        return 4 * [metres(unit)]
    words = [match[2] or match[3] for match in found[1:] if match]
    if not any(words):
        return 4 * [1.0]
    lengths = [unit_of(word or "") for word in words]
    if None in lengths:
        k = lengths.index(None)
        stated = f"unit {words[k]!r}" if words[k] else "no unit, others have one"
        raise ValueError(f"{file}: the column {COLUMNS[k + 1]} has {stated}; give all four one of {KNOWN}.")
    return [length for length in lengths if length is not None]


def read_landmarks(
    path: str | Path, points_a: Any, points_b: Any, *, closed: bool | None = None
) -> Landmarks:
    """Return the landmarks of a CSV file with the columns name, x_a, y_a, x_b, y_b, as `LandmarkTable.read`.

    The points are in m if its header states units, else in the unit of its numbers. Each landmark becomes the
    nearest point of its curve.
    Raises ValueError, naming file and line, as `LandmarkTable.read`, and OffCurveError, which is one, for
    places more than 0.05 of the body's radius from the curve, such as those in another unit.
    """
    curves = as_polyline(points_a, closed, "points_a"), as_polyline(points_b, closed, "points_b")
    table = LandmarkTable.read(path)
    indices = [
        [_nearest(where, place, curve, kind) for place, curve, kind in zip(places, curves, "ab", strict=True)]
        for where, places in zip(table.where, table.places, strict=True)
    ]
    return Landmarks(names=table.names, indices=np.array(indices))


def _place(where: str, words: Sequence[str], kind: str) -> tuple[float, float]:
    """Return the place on curve a or b that two fields hold."""
    try:
        return float(words[0]), float(words[1])
    except ValueError as error:
        raise ValueError(f"{where}: x_{kind}, y_{kind} are {tuple(words)}; give two numbers.") from error


def _nearest(where: str, place: Array, curve: Polyline, kind: str) -> int:
    """Return the index of the point of a curve that is nearest to a place."""
    away = np.hypot(*(curve.points - place[:, None]))
    k = int(np.argmin(away))
    if not away[k] <= NEAR * curve.radius:  # also for what is not a number
        raise OffCurveError(
            f"{where}: x_{kind}, y_{kind} are {away[k]:.3g} from the nearest point of curve {kind}, a body "
            f"with a radius of {curve.radius:.3g}; give places on it, in its unit.",
            kind,
        )
    return k
