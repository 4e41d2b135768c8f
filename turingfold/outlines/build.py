"""A body from measured curves: its pial surface, and where they are known its white surface and its holes."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree
from skfem import MeshTri2

from ..arrays import Array
from ..checks import between, finite_array, instance, one_of, positive
from ..geometry.body import BASES, Body
from ..geometry.changes import Changes, OutlineWarning
from ..geometry.shapes import element_size
from ..geometry.units import note_large
from ..memory import refuse_too_many
from .domain import Given, Thickness, domain
from .frame import RESOLUTION, Size
from .loops import closed_loops, large_enough, placed_bases
from .mesh import meshed, of_walls
from .region import even_odd, nearest, segments
from .relations import crossing, inside, overlapping, refuse_holes, refuse_interface, tangled, united
from .section import Section

HOLES = ("free", "clamped")
VOXELS = 1.5  # over which their steps are smoothed: so rasterised discs and ellipses have no fold left
STEPS = "steps of voxels smoothed away over {:.3g} m, 1.5 voxels (smooth=0 keeps them)"
MOVED = 0.5  # of the size: so far rounding moves the pial surface of a smooth outline at most
UNLIKE = 0.1  # difference of thickness from the depth of the interface, a share of it, that is told
TOLD = 0.05  # share of the area, or of the cortex, from which on a change is a warning


@dataclass(frozen=True)
class RefinementDisc:
    """A disc in which the cortex has smaller elements: `share` of the asked size.

    centre: (x, y), m.  radius: m; beyond it elements grow by the outline's `grading` to the asked size.
    """

    centre: tuple[float, float]
    radius: float
    share: float

    def __post_init__(self) -> None:
        finite_array("centre", self.centre, (2,))
        positive("radius", self.radius)
        positive(
            "share", self.share, at_most=1.0, remedy="it is the part of the asked element size that is left"
        )

    def away(self, at: Array) -> Array:
        """Return the distances of points (2, n) from the disc, 0 inside it, (n,); m."""
        return np.asarray(np.maximum(0.0, np.hypot(*(at - np.array(self.centre)[:, None])) - self.radius))


def outline(
    points: Any, *, thickness: float | Any = None, size: float | None = None, elements: float | None = None,
    interface: Any = None, holes: Any = (), hole: str = "free", base: str = "free", layers: str = "sharp",
    base_ends: Any = None, inset: float | None = None, smooth: float | None = None, grading: float = 0.35,
    fine: RefinementDisc | tuple[RefinementDisc, ...] = (),
) -> Body:  # fmt: skip
    """Return the tissue inside closed curves, meshed with its gray-white interface on element edges.

    points: the pial surface, a curve (2, n) or (n, 2) in m, in order, or a list of them: what lies inside an
    odd number of turns is tissue. So a section may have several parts, and curves inside others are sulci
    that are closed off. Or a `Section`, whose white surface and holes are taken, too.
    thickness: of the cortex in m; a number, values at the points ((n,), or a list of these), or a function of
    points (2, n) → (n,).  interface: the white surface, curves like `points`; thickness is then not needed.
    It lies inside the pial surface.
    size: element edge in the cortex, m; or elements: so many through the thinnest cortex. Below the cortex
    elements grow by `grading` m per m of depth.
    holes: curves of ventricles, mostly inside the pial surface; united where they overlap, one well inside
    another is an island. Their walls are no pial surface. hole: "free" or "clamped".
    base: "free", "clamped" or "roller"; the last two need base_ends: two points ((x, y), (x, y)) in m, or
    several such pairs; a base runs counter-clockwise along the outline from the point of `points` nearest the
    first to the one nearest the second, each within `size` of the outline. The rest is pial.
    layers: "sharp" or "sigmoid", see `Body`.
    inset: walls of sulci that come nearer to each other than twice this are moved apart, by it; m; size/4.
    smooth: take away details of the curves shorter than this, in m; left out, of a `Section` of an image 1.5
    voxels, else 0: nothing. A wave of four times this length keeps half its height, of eight times 93 %. Each
    curve of an image's `Section` encloses as much as before.
    fine: a disc, or several, of smaller elements in the cortex, as in zones of thinner cortex or more growth.

    What the elements cannot follow is rounded: tissue thinner than size/2 goes, the interface keeps one
    element away from the pial surface, parts below size² are left out. `changes` of the body tells how much;
    more than 5 % of the area is a warning.
    Raises ValueError for curves that are open, leave no white matter, or need more elements than fit.
    """
    one_of("base", base, BASES)
    one_of("hole", hole, HOLES)
    shortest = between("smooth", 0.0 if smooth is None else smooth, 0.0, float("inf"))
    between("grading", grading, 0.0, 1.0)
    if base != "free" and base_ends is None:
        raise ValueError(
            f"base={base!r} needs base_ends=((x, y), (x, y)): where along the outline the base lies."
        )
    voxel, lacking, notes, doubts = 0.0, None, list[str](), list[str]()
    if isinstance(points, Section):
        doubts += points.cut_off(base_ends)
        lacking = None if points.voxel is None else points.lacking
        if smooth is None and points.voxel is not None:
            voxel, shortest = points.voxel, VOXELS * points.voxel
            notes.append(STEPS.format(shortest))
        interface, holes, points = points.white or interface, points.holes or holes, points.pial
        loops = closed_loops("points", points)
    else:
        loops = closed_loops("points", points)
        note_large("points", loops, "multiply them by 1e-3")
    white = None if interface is None else closed_loops("interface", interface)
    if white is not None:
        refuse_interface(loops, white)
    none = holes is None or (hasattr(holes, "__len__") and len(holes) == 0)
    ventricles = [] if none else closed_loops("holes", holes)
    if hole != "free" and none:
        raise ValueError(f"hole={hole!r} holds the walls of holes, and there are none; give holes=....")
    refuse_holes(loops, ventricles)
    depth = _thickness(points, loops, thickness, white)
    step = _size(size, elements, depth, loops)
    walls = step / 4 if inset is None else positive("inset", inset)
    discs = tuple(fine) if isinstance(fine, (tuple, list)) else (fine,)
    finest = _finest(discs, step, grading)
    refuse_too_many(
        _triangles(loops, depth.typical, step, grading, discs), step,
        f"are size, thickness={depth.typical:g} and points in the same unit?",
    )  # fmt: skip
    if white is not None and thickness is not None:
        doubts += _disagreement(loops, white, depth.typical)
    given = _given(loops, base_ends, white, ventricles, (step, voxel), lacking, notes, doubts)
    mesh, changes = _filled(given, depth, (step, walls, shortest), finest, grading)
    starts = tuple((float(x), float(y)) for x, y in (curve[:, 0] for curve in loops))
    changes = replace(changes, expected=max(MOVED * step, shortest, walls), starts=starts)
    if ventricles:
        area = united(ventricles).intersection(even_odd(loops)).area
        changes = replace(changes, holes=1 - of_walls(mesh) / area)
    _warn(changes, given, shortest)
    by = "thickness" if interface is None and depth.at is None else "interface"
    return Body(mesh, depth.typical, base, layers, hole=hole, depth_by=by, changes=changes)


def _warn(changes: Changes, given: Given, shortest: float) -> None:
    """Warn where the body is much unlike its outline, or the outline may not be what was meant.

    shortest: details below this were smoothed away; m.
    """
    shares = [abs(share or 0.0) for share in (changes.cortex, changes.closed, changes.holes)]
    if max(changes.lost + changes.added, *shares) > TOLD:
        less = " and less smoothing" if shortest > 0 else ""
        large = f"outline: {changes}; smaller elements{less} follow it more closely."
        warnings.warn(large, OutlineWarning, stacklevel=3)
    elif loud := [note for note in changes.notes if note not in given.notes]:
        warnings.warn(f"outline: {'; '.join(loud)}.", OutlineWarning, stacklevel=3)


def _given(
    loops: list[Array], base_ends: Any, white: list[Array] | None, holes: list[Array],
    lengths: tuple[float, float], lacking: float | None, notes: list[str], doubts: list[str],
) -> Given:  # fmt: skip
    """Return those of the curves that elements can follow, with bases, and notes on the others.

    lengths: size, and edge of the voxels whose steps are smoothed away, 0 where none are; m.
    """
    least = (*lengths, lacking or 0.0)
    notes.extend(overlapping(holes))
    loops = large_enough("points", loops, least, notes)
    white = None if white is None else large_enough("interface", white, least, notes)
    holes = large_enough("holes", holes, least, notes)
    doubts = [*doubts, *crossing(loops), *inside(loops), *tangled("hole {}", holes)]
    bases = placed_bases(loops, base_ends, least[0])
    return Given(loops, bases, white, holes, tuple(notes), tuple(doubts), least[1] > 0, lacking)


def _triangles(
    loops: list[Array], thickness: float, size: float, grading: float, fine: tuple[RefinementDisc, ...]
) -> float:
    """Return about how many triangles the inside of curves gets, of 0.43 size² each.

    In the cortex they are of one size, or smaller in the discs `fine`, and grow by `grading` below it.
    """
    ahead = [np.roll(loop, -1, axis=1) - loop for loop in loops]
    along = np.concatenate([np.hypot(*step) for step in ahead])
    middles = np.concatenate([loop + 0.5 * step for loop, step in zip(loops, ahead, strict=True)], axis=1)
    gray = along.sum() * thickness
    white = min(along.sum() * size / max(grading, 1e-9), even_odd(loops).area)
    count = (gray + white) / size**2
    for disc in fine:
        inside = min(along[disc.away(middles) == 0].sum() * thickness, np.pi * disc.radius**2)
        count += inside / (disc.share * size) ** 2
    return float(2.3 * count)


def _finest(discs: tuple[Any, ...], step: float, grading: float) -> Size:
    """Return the size of elements in the cortex, m, as a function of points (2, n) → (n,)."""
    for disc in discs:
        instance("fine", disc, RefinementDisc, "RefinementDisc(centre=(0.0, 0.03), radius=0.01, share=0.5)")

    def finest(at: Array) -> Array:
        limits = [disc.share * step + grading * disc.away(at) for disc in discs]
        return np.asarray(np.min([np.full(at.shape[1], step), *limits], axis=0))

    return finest


def _filled(
    given: Given, depth: Thickness, lengths: tuple[float, float, float],
    finest: Size, grading: float,
) -> tuple[MeshTri2, Changes]:  # fmt: skip
    """Return the mesh, and what was changed; lengths: size, inset and smooth of `domain`, m.

    In units of the extent around the origin, so that neither place nor unit decides between triangles.
    """
    everything = np.concatenate(given.pial, axis=1)
    low, high = everything.min(1, keepdims=True), everything.max(1, keepdims=True)
    centre, unit = 0.5 * (low + high), float((high - low).max())

    def near(curves: list[Array]) -> list[Array]:
        return [np.round((curve - centre) / (unit * RESOLUTION)) * RESOLUTION for curve in curves]

    scaled = replace(
        given, pial=near(given.pial), white=None if given.white is None else near(given.white),
        holes=near(given.holes), lacking=None if given.lacking is None else given.lacking / unit**2,
    )  # fmt: skip
    edge, apart, shorter = (float(np.float32(length / unit)) for length in lengths)
    made, changes = domain(scaled, depth.scaled(centre, unit), edge, apart, shorter, unit)
    mesh, smallest = meshed(made, lambda at: finest(centre + unit * at) / unit, grading, centre, unit)
    return mesh, changes.placed(centre, unit, smallest)


def _thickness(points: Any, loops: list[Array], given: Any, white: list[Array] | None) -> Thickness:
    """Return the thickness of the cortex: a number, and where it varies a function of place, too."""
    if white is not None:
        if callable(given) or isinstance(given, (list, tuple)) or np.ndim(given):
            raise ValueError(
                "thickness varies from place to place, and beside interface it must be one number, that of "
                "the layers: how thick the cortex is, the interface says. Leave out one of both."
            )
        if given is None and (given := _median_depth(loops, white)) <= 0:
            raise ValueError(
                "interface: half of its points or more lie on the pial surface, so that it does not tell how "
                "thick the cortex is; give the gray-white surface, and a typical thickness=..., too."
            )
        return Thickness(positive("thickness", given), None)
    if given is None:
        raise ValueError("thickness is missing: give it in m, or the white surface as interface=....")
    if callable(given):
        at = np.concatenate(loops, axis=1)
        return Thickness(float(np.mean(_positive(given(at), at.shape[1]))), lambda x: np.asarray(given(x)))
    if not isinstance(given, (list, tuple)) and np.ndim(given) == 0:
        return Thickness(positive("thickness", given), None)
    where, thick = [], []
    for name, curve, value in _by_curve(points, given):
        curve = np.asarray(curve, dtype=float)
        curve = curve if curve.shape[0] == 2 else curve.T
        value = _positive(value, curve.shape[1], name)
        count = curve.shape[1]
        s = np.arange(0, count + 1 / 32, 1 / 16)  # so dense that the nearest one will do
        *places, along = (np.interp(s, np.arange(count), x, period=count) for x in (*curve, value))
        where.append(places)
        thick.append(along)
    tree, values = cKDTree(np.concatenate(where, axis=1).T), np.concatenate(thick)
    return Thickness(float(values.mean()), lambda x: values[tree.query(x.T)[1]])


def _median_depth(loops: list[Array], white: list[Array]) -> float:
    """Return the median distance of points of the white surface from the pial one; m."""
    at = np.concatenate(white, axis=1)
    return float(np.median(np.hypot(*(at - nearest(at, segments(loops))))))


def _disagreement(loops: list[Array], white: list[Array], thickness: float) -> list[str]:
    """Return a note if a thickness is not that between the surfaces that are given with it."""
    depth = _median_depth(loops, white)
    if depth == 0 or abs(depth - thickness) <= UNLIKE * depth:
        return []
    return [
        f"thickness={thickness:g} m does not move the interface, which is as given, {depth:.3g} m below the "
        "pial surface in the median; leave out one of both"
    ]


def _by_curve(points: Any, given: Any) -> list[tuple[str, Any, Any]]:
    """Return each curve of points with its values of thickness, and what to call these."""
    several = isinstance(points, (list, tuple)) and all(np.ndim(one) == 2 for one in points)
    curves = list(points) if several else [points]
    values = list(given) if any(np.ndim(one) for one in given) else [given]
    if len(values) != len(curves):
        raise ValueError(
            f"thickness has {len(values)} rows of values, and points has {len(curves)} curves; give a list "
            "with an array for each curve, one number for all, or a function of place."
        )
    one = len(curves) == 1
    names = ["thickness"] if one else [f"thickness[{k}]" for k in range(len(curves))]
    return list(zip(names, curves, values, strict=True))


def _positive(values: Any, count: int, name: str = "thickness") -> Array:
    if np.ndim(values) == 1 and len(values) != count:
        raise ValueError(
            f"{name} has {len(values)} values, and its curve {count} points; give one value for each."
        )
    found = finite_array(name, values, (count,))
    if found.min() <= 0:
        k = int(np.argmin(found))
        raise ValueError(f"{name} is {found[k]:g} m at point {k}; it must be positive everywhere.")
    return found


def _size(size: float | None, elements: float | None, depth: Thickness, loops: list[Array]) -> float:
    thinnest = depth.typical if depth.at is None else float(depth.at(np.concatenate(loops, axis=1)).min())
    step = element_size(size, elements, thinnest)
    if step > 2 * depth.typical:
        raise ValueError(
            f"size={step:g} m must be at most twice the thickness {depth.typical:g} m; use smaller elements."
        )
    extent = float(np.ptp(np.concatenate(loops, axis=1), axis=1).max())
    if 2 * depth.typical > extent:
        raise ValueError(
            f"thickness={depth.typical:g} m is more than half of the outline's width, {extent:.3g} m, and "
            "leaves hardly any white matter: are thickness and points in the same unit?"
        )
    return step
