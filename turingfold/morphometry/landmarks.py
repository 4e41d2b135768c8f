"""Landmarks: named points that two curves have in common, read from a table."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array, Integers
from ..checks import file_path
from .polyline import Polyline, as_polyline

COLUMNS = ("name", "x_a", "y_a", "x_b", "y_b")
NEAR = 0.05  # farthest that a landmark may lie from its curve, over the radius of the body


@dataclass(frozen=True, kw_only=True)
class Landmarks:
    """Names (k), and indices (k, 2) of the points of two curves that correspond."""

    names: tuple[str, ...]
    indices: Integers


@dataclass(frozen=True, kw_only=True)
class LandmarkTable:
    """Names (k), and places (k, 2, 2): of each on two curves a and b, x and y.  where: file and line, (k)."""

    names: tuple[str, ...]
    places: Array
    where: tuple[str, ...]

    @classmethod
    def read(cls, path: str | Path) -> LandmarkTable:
        """Return the landmarks of a CSV file with the columns name, x_a, y_a, x_b, y_b.

        Raises ValueError, naming file and line, for other columns, repeated names, and what is no number.
        """
        file = file_path("landmarks", path, "a CSV file")
        with file.open(newline="", encoding="utf-8-sig") as stream:
            table = csv.DictReader(stream, skipinitialspace=True)
            if tuple(table.fieldnames or ()) != COLUMNS:
                found = ",".join(table.fieldnames or ())
                raise ValueError(f"{file}: the first line is {found!r}; it must be {','.join(COLUMNS)!r}.")
            rows = [(f"{file}, line {table.line_num}", row) for row in table]
        names = tuple(str(row["name"]).strip() for _, row in rows)
        for (where, _), name in zip(rows, names, strict=True):
            if not name or names.count(name) > 1:
                raise ValueError(f"{where}: the name {name!r} must be there, and only once.")
        if not rows:
            raise ValueError(f"{file} has no landmarks; give a line for each.")
        places = [[_place(where, row, kind) for kind in "ab"] for where, row in rows]
        return cls(names=names, places=np.array(places), where=tuple(where for where, _ in rows))


def read_landmarks(
    path: str | Path, points_a: Any, points_b: Any, *, closed: bool | None = None
) -> Landmarks:
    """Return the landmarks of a CSV file with the columns name, x_a, y_a, x_b, y_b, in the points' unit.

    Each becomes the nearest point of its curve.
    Raises ValueError, naming file and line, as `LandmarkTable.read`, and for places more than 0.05 of the
    body's radius from the curve, such as those in another unit.
    """
    curves = as_polyline(points_a, closed, "points_a"), as_polyline(points_b, closed, "points_b")
    table = LandmarkTable.read(path)
    indices = [
        [_nearest(where, place, curve, kind) for place, curve, kind in zip(places, curves, "ab", strict=True)]
        for where, places in zip(table.where, table.places, strict=True)
    ]
    return Landmarks(names=table.names, indices=np.array(indices))


def _place(where: str, row: dict[str, Any], kind: str) -> tuple[float, float]:
    """Return a row's place on curve a or b."""
    words = row[f"x_{kind}"], row[f"y_{kind}"]
    try:
        return float(words[0]), float(words[1])
    except (TypeError, ValueError) as error:
        raise ValueError(f"{where}: x_{kind}, y_{kind} are {words}; they must be two numbers.") from error


def _nearest(where: str, place: Array, curve: Polyline, kind: str) -> int:
    """Return the index of the point of a curve that is nearest to a place."""
    away = np.hypot(*(curve.points - place[:, None]))
    k = int(np.argmin(away))
    if not away[k] <= NEAR * curve.radius:  # also for what is not a number
        raise ValueError(
            f"{where}: x_{kind}, y_{kind} are {away[k]:.3g} from the nearest point of curve {kind}, a body "
            f"with a radius of {curve.radius:.3g}; give places on it, in its unit."
        )
    return k
