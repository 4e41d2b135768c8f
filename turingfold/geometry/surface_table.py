"""Values at places along the pial surface: between them, on a body, and read from a table."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array
from ..checks import file_path, finite_array, one_of
from .body import Body
from .curve import Curve
from .paths import Curves
from .units import KNOWN, is_unit, unit_of, unit_of_name

Places = tuple[float, ...] | tuple[tuple[float, float], ...]
BETWEEN = ("linear", "nearest")
SYMMETRIC = 1e-6  # share of the largest value by which mirror images may differ
HEADER = re.compile(r"\s*(.*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")


@dataclass(frozen=True, kw_only=True)
class SurfaceTable:
    """A table with one place of a pial surface to a row.

    names: of the places, "" where the table gives none.  places: shares of the surface's length in [0, 1], or
    points (x, y) in m.  columns, units: of the values, as the header says, None without a unit.
    values: a row of numbers for each place.
    """

    names: tuple[str, ...]
    places: Places
    columns: tuple[str, ...]
    units: tuple[str | None, ...]
    values: tuple[tuple[float, ...], ...]

    @classmethod
    def read(cls, file: str | Path) -> SurfaceTable:
        """Return the table of a CSV file with the columns "s" or "x [mm], y [mm]", then those of values.

        A column "name" may come first. s: share of the surface's length, without a unit.
        Raises ValueError, naming file and line, for other columns or units, and for what is no number.
        """
        path = file_path("file", file, "a CSV file")
        with path.open(newline="", encoding="utf-8-sig", errors="replace") as stream:
            rows = csv.reader(stream, skipinitialspace=True)
            header = next(rows, [])
            named = bool(header) and header[0].strip().lower() == "name"
            found = _header(path.name, header[named:])
            count = 1 if found[0][0] == "s" else 2
            factors = [_metres(path.name, *column) for column in found[:count]] + [1.0] * len(found[count:])
            names, numbers = [], []
            for row in rows:
                if row:
                    names.append(row[0].strip() if named else "")
                    numbers.append(_numbers(f"{path.name}, line {rows.line_num}", row[named:], factors))
        if not numbers:
            raise ValueError(f"{path.name} holds no places; give a line for each.")
        shares = tuple(row[0] for row in numbers)
        places: Places = shares if count == 1 else tuple((row[0], row[1]) for row in numbers)
        columns, units = zip(*found[count:], strict=True)
        return cls(
            names=tuple(names), places=places, columns=columns, units=units,
            values=tuple(row[count:] for row in numbers),
        )  # fmt: skip

    def along(self, column: str, points: Array, *, between: str = "linear") -> Array:
        """Return a column's values at the points (2, n) of a closed outline, (n,).

        Shares begin at the first and count counter-clockwise, as on the body that outline() makes of it.
        Lengths come in m, as outline(thickness=...) takes them, values without a unit ("g", "g [1]") as
        they are. Raises ValueError for another unit, and for points off the places.
        """
        k = self.columns.index(one_of("column", column, self.columns))
        values = _scale(column, self.units[k]) * np.array(self.values)[:, k]
        ring = finite_array("points", points, (2, None))
        ahead = np.roll(ring, -1, axis=1)
        clockwise = float(np.sum(ring[0] * ahead[1] - ring[1] * ahead[0])) < 0
        order = np.r_[0, ring.shape[1] - 1 : 0 : -1] if clockwise else np.arange(ring.shape[1])
        ring = ring[:, order]
        nodes = np.stack([ring, 0.5 * (ring + np.roll(ring, -1, axis=1))], axis=2).reshape(2, -1)
        curves = Curves((Curve(nodes, closed=True),))
        farthest = 0.25 * float(np.ptp(ring, axis=1).max())
        knots = arcs_of(self.places, curves, curves.length, farthest)
        found = np.empty(ring.shape[1])
        found[order] = _interpolated(curves.parts[0].arc[::2], knots, values, curves, between, ring)
        return found


def checked_places(places: Places, count: int, what: str) -> Places:
    """Return places as tuples; raises ValueError unless there are `count`, one to each of the values."""
    by_share = np.ndim(places) == 1
    found = finite_array("places", places, (None,) if by_share else (None, 2))
    if len(found) != count or not count:
        raise ValueError(f"places has {len(found)} and {what} {count} entries; give one per place.")
    if by_share and not (found.min() >= 0 and found.max() <= 1):
        worst = found[np.argmax(np.abs(found - 0.5))]
        raise ValueError(f"places holds {worst:g}; shares of the surface's length are from 0 to 1.")
    return tuple(found.tolist()) if by_share else tuple((x, y) for x, y in found.tolist())


def on_surface(body: Body, places: Places, values: Array, between: str) -> Array:
    """Return values (k,) given at places of the pial surface at the integration points, (q, e).

    Each point has the value of the nearest pial point. Between places it is linear in arc length, or that of
    the nearest one; beyond the first and last of an open surface constant; on a part of the surface without
    any place that of the place nearest in the plane.
    Raises ValueError for points farther from the surface than the cortex is thick, and on half a body for
    values that differ from those of their images beyond the mirror.
    """
    points = body.quadrature.points.reshape(2, -1)
    return _on(body, places, values, between, points, body.arc.ravel()).reshape(body.arc.shape)


def values_at(body: Body, places: Places, values: Array, between: str, points: Array) -> Array:
    """Return values (k,) at places of the pial surface at points (2, n) of the body, as `on_surface` does."""
    return _on(body, places, values, between, points, body.pial_curves.nearest(points)[2])


def evenly(body: Body, count: int, what: str) -> Places:
    """Return evenly spaced shares of the pial surface; of a closed one without its end, which is its start.

    what: the part that has no places.
    Raises ValueError on half a body: values beyond the mirror would change nothing.
    """
    if body.mirror:
        shares = ", ".join(f"{share:.3g}" for share in np.linspace(0.0, 0.5, count))
        raise ValueError(
            f"{what}: its {count} values are without places, and on half a body some lie beyond the mirror "
            f"and change nothing; give places as shares of the whole surface's length, such as "
            f"places=({shares})."
        )
    return tuple(np.linspace(0.0, 1.0, count, endpoint=not body.pial_curve.closed).tolist())


def _on(body: Body, places: Places, values: Array, between: str, points: Array, arc: Array) -> Array:
    """Return values (k,) at points (2, n) of the body with arc lengths (n,)."""
    curves = body.pial_curves
    shares = np.array(places)
    if body.mirror and shares.ndim == 1 and shares.max() > 0.5:
        line = body.nodes[0, body.boundary_path("mirror")[0][0]]
        ends = np.abs(body.nodes[0, body.pial[[0, -1]]] - line) <= 1e-9 * body.length
        _check_symmetric(shares, values, closed=bool(ends.all()))
    length = curves.length * (2.0 if body.mirror else 1.0)
    knots = arcs_of(places, curves, length, body.thickness)
    if shares.ndim == 1:
        knots = _from_starts(body, knots)
    return _interpolated(arc, knots, values, curves, between, points)


def _from_starts(body: Body, knots: Array) -> Array:
    """Return arc lengths, of which those on closed parts count from where the outline's first point is."""
    before, found = 0.0, knots.copy()
    for curve, first in zip(body.pial_curves.parts, body.first_arcs, strict=True):
        on = (knots >= before) & (knots <= before + curve.length)
        if first:
            found[on] = before + (knots[on] - before + first) % curve.length
        before += curve.length
    return found


def _check_symmetric(shares: Array, values: Array, *, closed: bool) -> None:
    """Raise ValueError for values of a whole surface, beyond the mirror too, that half a body cannot have.

    closed: whether the whole surface is.
    """
    order = np.argsort(shares, kind="stable")
    known, lap = (shares[order], values[order]), 1.0 if closed else None
    here, image = (np.interp(at, *known, period=lap) for at in (shares, 1.0 - shares))
    k = int(np.argmax(np.abs(here - image)))
    if abs(here[k] - image[k]) > SYMMETRIC * np.abs(values).max():
        raise ValueError(
            f"values are {here[k]:.6g} at the share {shares[k]:g} and {image[k]:.6g} at {1 - shares[k]:g}, "
            "its image; half a body is one of two alike: run the whole one, or give places up to 0.5."
        )


def arcs_of(places: Places, curves: Curves, length: float, farthest: float) -> Array:
    """Return the arc lengths of places on curves, (k,).

    length: of which places by share are shares.
    Raises ValueError for points farther from the curves than `farthest`.
    """
    given = np.array(places)
    if given.ndim == 1:
        return np.asarray(given * length)
    away, _, arc = curves.nearest(given.T)
    if away.max() > farthest:
        x, y = given[k := int(np.argmax(away))]
        raise ValueError(
            f"place {k}, ({x:.4g}, {y:.4g}) m, is {away[k]:.3g} m from the pial surface, more than "
            f"{farthest:.3g} m; give places on it, in m."
        )
    return np.asarray(arc)


def _interpolated(
    arc: Array, knots: Array, values: Array, curves: Curves, between: str, points: Array
) -> Array:
    """Return values (k,) at knots, (k,), at arc lengths (n,); points: (2, n)."""
    found, low = np.full(arc.shape, np.nan), 0.0
    for curve in curves.parts:
        high = np.inf if curve is curves.parts[-1] else low + curve.length
        here, there = (knots >= low) & (knots <= high), (arc >= low) & (arc <= high)
        if here.any():
            laps = (-1, 0, 1) if curve.closed else (0,)
            s = np.concatenate([knots[here] + lap * curve.length for lap in laps])
            order = np.argsort(s, kind="stable")
            s, each = s[order], np.tile(values[here], len(laps))[order]
            found[there] = (
                np.interp(arc[there], s, each)
                if between == "linear"
                else each[np.searchsorted(0.5 * (s[1:] + s[:-1]), arc[there])]
            )
        low = high
    bare = np.isnan(found)
    if bare.any():
        feet = np.concatenate([curve.points for curve in curves.parts], axis=1)
        starts = np.cumsum([0.0, *(curve.length for curve in curves.parts)])
        arcs = np.concatenate([c.arc + low for c, low in zip(curves.parts, starts, strict=False)])
        near = feet[:, np.argmin(np.abs(arcs - knots[:, None]), axis=1)]
        found[bare] = values[cKDTree(near.T).query(points[:, bare].T)[1]]
    return found


def _header(name: str, header: Sequence[str]) -> list[tuple[str, str | None]]:
    """Return the name and the unit of each column; raises ValueError without places and values."""
    matches = [HEADER.fullmatch(field) for field in header]
    found = [(match[1], match[2]) for match in matches if match]
    names = [column for column, _ in found]
    if not (names[:1] == ["s"] and len(names) > 1) and not (names[:2] == ["x", "y"] and len(names) > 2):
        raise ValueError(
            f"{name}: the first line is {','.join(header)!r}; it must name the columns s or x, y with their "
            'units, and then those of values, such as "x [mm], y [mm], thickness [mm]".'
        )
    return found


def _scale(column: str, unit: str | None) -> float:
    unit = unit_of_name(column) if unit is None else unit
    scale = unit_of(unit) if unit and is_unit(unit) else 1.0
    if scale is None:
        raise ValueError(
            f"column={column!r} has the unit {unit!r}; along gives lengths ({KNOWN}) and values without a "
            "unit. Leave the unit out of the header, and the values come as they are."
        )
    return scale


def _metres(name: str, column: str, unit: str | None) -> float:
    found = (1.0 if unit in (None, "") else None) if column == "s" else unit_of(unit or "")
    if found is None:
        words = "no unit: it is a share" if column == "s" else f"one of {KNOWN}"
        raise ValueError(f"{name}: the column {column} has the unit {unit!r}; it must have {words}.")
    return found


def _numbers(where: str, row: Sequence[str], factors: Sequence[float]) -> tuple[float, ...]:
    try:
        found = tuple(float(word) * factor for word, factor in zip(row, factors, strict=True))
    except ValueError as error:
        raise ValueError(f"{where}: {','.join(row)!r} is not {len(factors)} numbers.") from error
    if not np.isfinite(found).all():
        raise ValueError(f"{where}: {','.join(row)!r} is not finite; leave that line out.")
    return found
