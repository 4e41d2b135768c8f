"""Tables of loads: CSV files with units in their header."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..checks import file_path
from ..outlines.units import METRES

Places = tuple[float, ...] | tuple[tuple[float, float], ...]
NEWTONS = {"N/m": 1.0, "mN/m": 1e-3, "kN/m": 1e3, "µN/m": 1e-6, "uN/m": 1e-6}
HEADER = re.compile(r"\s*(\w+)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")


def read_loads(file: str | Path) -> tuple[Places, tuple[tuple[float, float], ...]]:
    """Return places (shares of the surface, or points in m) and forces in N/m; see BoundaryLoads.read."""
    path = file_path("file", file, "a CSV file")
    with path.open(newline="", encoding="utf-8-sig") as stream:
        table = csv.reader(stream, skipinitialspace=True)
        factors = _columns(path.name, next(table, []))
        rows = [_numbers(f"{path.name}, line {table.line_num}", row, factors) for row in table if row]
    if not rows:
        raise ValueError(f"{path.name} holds no loads; give a line for each.")
    forces = tuple((row[-2], row[-1]) for row in rows)
    if len(factors) == 3:
        return tuple(row[0] for row in rows), forces
    return tuple((row[0], row[1]) for row in rows), forces


def _columns(name: str, header: Sequence[str]) -> list[float]:
    """Return what each column is multiplied by; raises ValueError for other columns or units."""
    matches = [HEADER.fullmatch(field) for field in header]
    found = [(m[1], m[2]) if m else (field, None) for m, field in zip(matches, header, strict=True)]
    names = [column for column, _ in found]
    if names not in (["s", "fx", "fy"], ["x", "y", "fx", "fy"]):
        raise ValueError(
            f"{name}: the first line is {','.join(header)!r}; it must name the columns s, fx, fy or x, y, "
            'fx, fy with their units, such as "x [mm], y [mm], fx [N/m], fy [N/m]".'
        )
    factors = []
    for column, unit in found:
        known = {None: 1.0, "": 1.0} if column == "s" else METRES if column in "xy" else NEWTONS
        if unit not in known:
            words = "no unit: it is a share" if column == "s" else f"one of {', '.join(map(str, known))}"
            raise ValueError(f"{name}: the column {column} has the unit {unit!r}; it must have {words}.")
        factors.append(known[unit])  # type: ignore[index]
    return factors


def _numbers(where: str, row: Sequence[str], factors: Sequence[float]) -> tuple[float, ...]:
    try:
        found = tuple(float(word) * factor for word, factor in zip(row, factors, strict=True))
    except ValueError as error:
        raise ValueError(f"{where}: {','.join(row)!r} is not {len(factors)} numbers.") from error
    if not np.isfinite(found).all():
        raise ValueError(f"{where}: {','.join(row)!r} is not finite; leave that load out.")
    return found
