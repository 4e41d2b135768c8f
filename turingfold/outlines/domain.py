"""From curves to planar sets that can be meshed: tissue, white matter and holes, and what that changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy.optimize import bisect
from shapely import LineString, MultiPolygon
from shapely.geometry.base import BaseGeometry

from ..arrays import Array
from ..geometry.changes import Changes
from .loops import Trace, traced
from .region import (
    along,
    below,
    buried,
    even_odd,
    fitted,
    hollows,
    large,
    moved,
    pieces,
    smoothed,
    tapered,
    touching,
    unchanged_near,
)
from .relations import of_holes, united

ROUND_OFF = 1e-6  # share of the size below which lengths are no lengths
FINE = 8  # samples of a curve per element
NEAR = 0.02  # of the size: nodes so close to a smooth curve are put on it
OFFSET = 0.011  # of the distance, by which shapely's offsets leave out points
BARE = 0.05  # share of the area in pieces without white matter, from which on it is told
NEAR_BASE = 0.6  # of the size: how far from a base a white surface ends on it
DIGITS = 1e-5  # of a thickness, to which the largest depth is told
DEEPEST = 2 / 3  # largest thickness, as a share of the largest depth below the pial surface


@dataclass(frozen=True, eq=False)
class Given:
    """Closed curves, each (2, n): pial surfaces with bases (loop, first, last), white surfaces, holes.

    notes: on what was left out of them.  doubts: on what they may not be meant to be.  steps: whether they
    have steps of voxels, which are smoothed away.  lacking: area, beside its own, that each curve of an
    image keeps when it is smoothed, m²; None: none.
    """

    pial: list[Array]
    bases: list[tuple[int, int, int]]
    white: list[Array] | None
    holes: list[Array]
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    steps: bool = False
    lacking: float | None = None


@dataclass(frozen=True, eq=False)
class Thickness:
    """Of the cortex: a typical value and, where it varies, a function of points (2, n) → (n,)."""

    typical: float
    at: Callable[[Array], Array] | None

    def scaled(self, centre: Array, unit: float) -> Thickness:
        """Return the thickness in another unit, as a function of places from `centre` (2, 1) in that unit."""
        given = self.at
        if given is None:
            return Thickness(float(np.float32(self.typical / unit)), None)
        return Thickness(self.typical / unit, lambda at: given(centre + unit * at) / unit)


@dataclass(frozen=True, eq=False)
class Domain:
    """What is to be meshed.

    area: without holes.  white: white matter, with the holes in it.  bases: lines along the boundary.
    smooth: the curves of "pial" surface, "interface" and "hole" as they are given.
    depth: of the interface below the pial surface if it is the same everywhere, else 0.
    """

    area: MultiPolygon
    white: MultiPolygon
    holes: MultiPolygon
    bases: list[Array]
    smooth: dict[str, Trace]
    size: float
    depth: float

    def put(self, kind: str, at: Array) -> Array:
        """Return points (2, n) put on the smooth curves of a kind, where they are almost on them.

        On an interface without any, at the depth of one thickness.
        """
        if kind in self.smooth:
            feet = self.smooth[kind].feet(at)
            return np.where(np.hypot(*(feet - at)) < NEAR * self.size, feet, at)
        if kind != "interface" or not self.depth:
            return at
        feet = self.smooth["pial"].feet(at)
        distance = np.hypot(*(at - feet))
        near = np.abs(distance - self.depth) < max(NEAR * self.size, OFFSET * self.depth)
        deep = feet + (self.depth / np.where(near, distance, 1.0)) * (at - feet)
        return np.where(near, deep, at)


def domain(
    given: Given, thickness: Thickness, size: float, inset: float, smooth: float, unit: float
) -> tuple[Domain, Changes]:
    """Return the sets that elements of a size can fill, and what had to be changed.

    inset: half the least distance of walls of sulci.  smooth: details of the curves below this go.  unit: of
    all lengths, m, for messages.
    Raises ValueError if no tissue or no white matter is left.
    """
    step = size / FINE
    surface = traced(given.pial, step, smooth, given.bases, given.lacking)
    measured = even_odd(surface.polygons)
    bases = shapely.union_all([LineString(base.T) for base in surface.bases])
    area = fitted(measured, size, inset, bases)
    if area.is_empty:
        raise ValueError(
            f"no part of the outline is as large as an element: the area is {measured.area:.3g} of its "
            "extent squared; use smaller elements (size=...)."
        )
    pial = area.boundary.difference(bases.buffer(ROUND_OFF * size)) if given.bases else area.boundary
    white = None if given.white is None else [_beyond(one, surface.bases, size) for one in given.white]
    within = None if white is None else traced(white, step, smooth, lacking=given.lacking)
    even = thickness.at is None and within is None
    if even:
        _refuse_thick(area, pial, thickness.typical, unit)
    own = _white(area, pial, thickness, size) if within is None else even_odd(within.polygons)
    least = min(size, 0.9 * thickness.typical)
    allowed = own if even else below(area, pial, least)
    raw = own.intersection(allowed)
    inner = smoothed(raw, size, 0.25 * size).intersection(allowed)
    inner, walls, holes = large(unchanged_near(bases, inner, raw, size), size**2), None, MultiPolygon()
    told: list[str] = []
    if given.holes:
        walls = traced(given.holes, step, smooth, lacking=given.lacking)
        deep = below(area, pial, 2 * size).difference(bases.buffer(size))
        asked = united(walls.polygons)
        holes = large(smoothed(asked.intersection(deep), size, 0.5 * size), size**2)
        told = of_holes(asked if given.steps else united(given.holes), measured, holes, unit)
        inner = large(inner.union(holes.buffer(size)).intersection(below(area, pial, least)), size**2)
    if inner.is_empty:
        raise ValueError(
            "thickness leaves no white matter anywhere inside the outline; use a thinner cortex, and the "
            "same unit for thickness and points."
        )
    curves = {"pial": surface, "interface": within, "hole": walls}
    lines = {kind: one for kind, one in curves.items() if one is not None}
    made = Domain(area, inner, holes, surface.bases, lines, size, thickness.typical if even else 0.0)
    # smoothing away the steps of voxels keeps their area, and is no change
    same = smooth == 0 or given.steps
    rough = measured if same else even_odd(traced(given.pial, step, 0.0, given.bases).polygons)
    changes = _changes(given, rough, made, inset)
    if given.white is not None:
        below_it = own if same else even_odd(traced(given.white, step).polygons)
        if given.holes:  # no cortex, though an inner ring of the white surface may be their wall
            below_it = below_it.union(united(given.holes))
        ribbon = rough.difference(below_it).area
        told += _without_white(area, own)
        changes = replace(
            changes,
            cortex=area.difference(inner).area / ribbon - 1,
            thickened=own.intersection(area).difference(allowed).area / ribbon,
        )
    return made, replace(changes, notes=(*changes.notes, *told))


def _beyond(curve: Array, bases: list[Array], size: float) -> Array:
    """Return a white surface, (2, n), whose points near a base are moved beyond it.

    As drawn they are on it but for round-off, and leave slits of cortex between white matter and the base.
    """
    moved = curve.copy()
    for base in bases:
        line, step = LineString(base.T), np.diff(base, axis=1)
        at = line.project(shapely.points(curve.T))
        near = shapely.distance(line, shapely.points(curve.T)) < NEAR_BASE * size
        k = np.clip(np.searchsorted(along(base), at[near], side="right") - 1, 0, step.shape[1] - 1)
        outward = np.stack([step[1, k], -step[0, k]]) / np.hypot(*step[:, k])  # bases run counter-clockwise
        foot = shapely.get_coordinates(line.interpolate(at[near])).T
        moved[:, near] = foot + size * outward
    return moved


def _white(area: MultiPolygon, pial: BaseGeometry, thickness: Thickness, size: float) -> BaseGeometry:
    """Return what lies deeper than the cortex is thick."""
    if thickness.at is None:
        return below(area, pial, thickness.typical)
    gray = []
    for line in shapely.get_parts(shapely.line_merge(pial)):
        count = max(8, int(np.ceil(2 * line.length / size)))
        at = shapely.get_coordinates(line.interpolate(np.linspace(0.0, line.length, count + 1))).T
        gray.append(tapered(at, thickness.at(at)))
    return area.difference(shapely.union_all(gray))


def _refuse_thick(area: MultiPolygon, pial: BaseGeometry, thickness: float, unit: float) -> None:
    """Raise ValueError for a cortex thicker than 2/3 of the largest depth below the pial surface.

    Less than 1 % of the deepest place is then cortex by θ(y) = 1/(1 + exp(10 (y/T - 1))).
    """
    if not below(area, pial, most := thickness / DEEPEST).is_empty:
        return
    depth = bisect(lambda at: 0.5 - below(area, pial, at).is_empty, 0.0, most, xtol=DIGITS * most)
    raise ValueError(
        f"thickness={thickness * unit:g} m must be at most {DEEPEST * depth * unit:.4g} m, two thirds of the "
        f"largest depth below the pial surface ({depth * unit:.4g} m), or it leaves hardly any white matter; "
        "use a thinner cortex, and the same unit for thickness and points."
    )


def _changes(given: Given, rough: BaseGeometry, made: Domain, inset: float) -> Changes:
    """Return what differs from the tissue before smoothing, `rough`."""
    before, after = rough.area, made.area.area
    lost = rough.difference(made.area).area
    delivered = even_odd(given.pial)
    dropped = [one for one in pieces(delivered) if not one.intersects(made.area)]
    filled = [one for one in hollows(delivered) if made.area.contains(one)]
    gone, walls = shapely.union_all([*dropped, *filled]), touching(delivered, inset, ROUND_OFF * made.size)
    at = np.concatenate(given.pial, axis=1)
    at = at[:, ~shapely.intersects_xy(gone.buffer(ROUND_OFF * made.size), *at)]
    away, beside = moved(at, made.area, walls, 0.5 * made.size)
    surface = np.concatenate(made.smooth["pial"].polygons, axis=1)
    closed = buried(surface, made.area, made.size) & ~shapely.intersects_xy(gone, *surface)
    return Changes(
        moved=away,
        moved_at_walls=beside,
        lost=lost / before,
        added=(after - before + lost) / before,
        cortex=None,
        dropped=tuple((one.centroid.x, one.centroid.y, one.area) for one in dropped),
        filled=len(filled),
        closed=float(closed.mean()),
        smallest_angle=float("nan"),
        notes=(*given.notes, *given.doubts, *_bridged(delivered, len(dropped), len(filled), made.area)),
    )


def _without_white(area: BaseGeometry, white: BaseGeometry) -> list[str]:
    """Return a note on pieces that have no white surface, and are cortex throughout, if they are large."""
    bare = sum(one.area for one in pieces(area) if not one.intersects(white))
    if bare < BARE * area.area:
        return []
    return [f"{bare / area.area:.0%} of the area is in pieces without a white surface, and all of it cortex"]


def _bridged(delivered: BaseGeometry, dropped: int, filled: int, made: BaseGeometry) -> list[str]:
    """Return notes where walls that are near each other became one: pieces fused, sulci closed off."""
    told = []
    given, found = len(pieces(delivered)) - dropped, len(pieces(made))
    if found < given:
        told.append(f"{given} pieces of tissue became {found}, as their walls are too near for the elements")
    given, found = len(hollows(delivered)) - filled, len(hollows(made))
    if found > given:
        told.append(f"{found - given} sulci were closed off, as their walls are too near for the elements")
    return told
