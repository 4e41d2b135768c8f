"""How curves lie to each other: what is told, and what cannot be meant and is refused."""

from __future__ import annotations

from functools import reduce

import numpy as np
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from ..arrays import Array
from .region import enclosed, even_odd, pieces, segments

INSIDE = 0.9  # share of the interface's area that lies inside the pial surface
FILLED = 0.99  # share of the tissue that the interface encloses at most
MOSTLY = 0.5 - 1e-6  # share of a hole's area that lies inside the pial surface
SAME = 0.9  # of two holes: common area over that of both, from which on they are one
SLIGHT = 1e-3  # share of the smaller of two curves' areas below which a common part is round-off
CHANGED = 0.01  # share of a hole's area from which on a change is told


def crossing(loops: list[Array]) -> list[str]:
    """Return a note on each curve that crosses itself, and on each two that cross each other.

    Raises ValueError for a curve that is given twice.
    """
    areas, notes = [enclosed(loop) for loop in loops], tangled("curve {} of the pial surface", loops)
    for first, second in _pairs(areas):
        a, b = areas[first], areas[second]
        common, smaller = a.intersection(b).area, min(a.area, b.area)
        if a.symmetric_difference(b).area <= SLIGHT * smaller:
            raise ValueError(f"points[{first}] and points[{second}] are the same curve; give it once.")
        if SLIGHT * smaller < common < (1 - SLIGHT) * smaller:
            notes.append(
                f"curves {first} and {second} of the pial surface cross each other; what both enclose, "
                f"{common:.3g} m², counts as outside"
            )
    return notes


def tangled(name: str, loops: list[Array]) -> list[str]:
    """Return a note on each curve that crosses itself; name: "hole {}", with the number in it."""
    return [
        f"{name.format(k)} crosses or touches itself, and was taken apart there"
        for k, loop in enumerate(loops)
        if not Polygon(loop.T).is_valid
    ]


def inside(loops: list[Array]) -> list[str]:
    """Return a note on curves that lie inside others, and so enclose a sulcus or an island in one."""
    tree = shapely.STRtree(areas := [enclosed(loop) for loop in loops])
    found = {k for k, other in tree.query(areas, predicate="within").T.tolist() if k != other}
    if not found:
        return []
    where, what = ("lies inside another", "it is") if len(found) == 1 else ("lie inside others", "they are")
    return [
        f"{len(found)} of {len(loops)} closed curves {where}; {what} taken as pial surface, of closed-off "
        "sulci, which counts in the gyrification index; ventricles are given as holes="
    ]


def refuse_interface(pial: list[Array], white: list[Array]) -> None:
    """Raise ValueError for a white surface that is not inside the pial one, or leaves no cortex."""
    tissue, inner = even_odd(pial), even_odd(white)
    _refuse_outside("interface", inner, tissue, INSIDE)
    if (common := inner.intersection(tissue).area) > FILLED * tissue.area:
        raise ValueError(
            f"interface encloses {common / tissue.area:.4g} of the area inside the pial surface and leaves "
            f"no cortex; it must be at most {FILLED:g}. Give the gray-white surface, not the pial one."
        )


def refuse_holes(pial: list[Array], holes: list[Array]) -> None:
    """Raise ValueError for a hole that is not mostly inside the pial surface."""
    tissue = even_odd(pial)
    for k, hole in enumerate(holes):
        _refuse_outside(f"holes[{k}]", enclosed(hole), tissue, MOSTLY)


def _refuse_outside(name: str, area: BaseGeometry, tissue: BaseGeometry, least: float) -> None:
    """Raise ValueError for an area of which less than a share lies in the tissue."""
    if (common := area.intersection(tissue).area) < least * area.area:
        raise ValueError(
            f"{name}: {common / area.area:.2g} of its area, {area.area:.3g} m², lies inside the pial "
            f"surface, {tissue.area:.3g} m²; it must be at least {least:g}. Are both in the same unit, and "
            "of the same section?"
        )


def overlapping(holes: list[Array]) -> list[str]:
    """Return a note on holes that are taken as one."""
    joined = [f"{a} and {b}" for a, b in _joined([enclosed(hole) for hole in holes])]
    return [f"holes {', '.join(joined)} overlap or touch, and are one"] if joined else []


def united(holes: list[Array]) -> BaseGeometry:
    """Return what holes enclose: those that are one united; one well inside another is an island in it."""
    areas = [enclosed(hole) for hole in holes]
    first, second = np.reshape(_joined(areas), (-1, 2)).T
    links = coo_matrix((np.ones(len(first)), (first, second)), shape=(len(areas), len(areas)))
    count, number = connected_components(links, directed=False)
    ones = [shapely.union_all([areas[k] for k in np.flatnonzero(number == one)]) for one in range(count)]
    return reduce(shapely.symmetric_difference, ones)


def of_holes(asked: BaseGeometry, tissue: BaseGeometry, made: BaseGeometry, unit: float) -> list[str]:
    """Return notes on holes that are cut off at the pial surface, made smaller or left out.

    unit: of all lengths, m.
    """
    whole, m2 = pieces(asked), unit**2
    out, more = asked.difference(tissue).area, made.difference(asked).area
    left, area = np.array([(one.intersection(made).area, one.area) for one in whole]).T * m2
    gone = left == 0
    less = ~gone & (left < (1 - CHANGED) * area)
    joined = sum(sum(one.intersection(each).area > 0 for each in whole) > 1 for one in pieces(made))
    told = {
        f"{out * m2:.2g} m² of holes outside the pial surface cut off": out > CHANGED * asked.area,
        f"{less.sum()} holes made smaller, from {area[less].sum():.3g} to {left[less].sum():.3g} m², as "
        "elements and the cortex around need": less.any(),
        f"{more * m2:.2g} m² of tissue in or between holes too thin for the elements left out": (
            more > CHANGED * asked.area
        ),
        f"holes nearer to each other than elements need joined to {joined}": joined,
        f"{gone.sum()} holes too small or thin for the elements left out, {area[gone].sum():.2g} m²": (
            gone.any()
        ),
    }
    return [words for words, holds in told.items() if holds]


def crossings(loop: Array, enough: int) -> int:
    """Return how often a closed curve (2, n) crosses itself; not all once there are enough."""
    tree, count = segments([loop]), 0
    for low in range(0, len(tree), 256):
        count += tree.query(tree.geometries[low : low + 256], predicate="crosses").shape[1]
        if count >= 2 * (enough + 1):  # each is found from both segments
            break
    return count // 2


def _pairs(areas: list[BaseGeometry]) -> list[tuple[int, int]]:
    """Return the numbers of areas that have points in common, the smaller number first."""
    found = shapely.STRtree(areas).query(areas, predicate="intersects").T.tolist() if areas else []
    return sorted((a, b) for a, b in found if a < b)


def _joined(areas: list[BaseGeometry]) -> list[tuple[int, int]]:
    """Return the numbers of holes that overlap or touch along a line, neither well inside the other."""
    found = []
    for first, second in _pairs(areas):
        a, b = areas[first], areas[second]
        common, both = a.intersection(b).area, a.union(b)
        well_inside = common >= (1 - SLIGHT) * min(a.area, b.area)
        if common > SAME * both.area or (not well_inside and len(pieces(both)) == 1):
            found.append((first, second))
    return found
