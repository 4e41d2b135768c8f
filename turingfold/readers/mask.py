"""Sections of brains from images of labels or of probabilities."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from shapely import Polygon

from ..arrays import Array, Booleans
from ..checks import finite, one_of, whole
from ..geometry.changes import OutlineWarning
from ..outlines.section import Cut, Section
from .image import FEWEST, PLANES, Image
from .tissues import Labels, Tissue, tissues_of

INWARD = 3  # voxels from the edge of an image to where the width of what it cuts is compared
TAPER = 0.75  # of that width, below which tissue only touches the edge


def sections(
    image: Any,
    *,
    plane: str = "coronal",
    at_mm: float | Sequence[float] | None = None,
    index: int | Sequence[int] | None = None,
    gray: Labels = None,
    white: Labels = None,
    hole: Labels = None,
    level: float | None = None,
    pixel_mm: float | None = None,
) -> tuple[Section, ...]:
    """Return the sections of an image in given planes; in none, the section with the most tissue.

    image: a NIfTI or MGH file, a nibabel image, a pair (array, affine in mm), or a picture (PNG, TIFF) or
    array with two axes, rows from top to bottom; or a mapping of "gray", "white", "hole" to such images, each
    the probability of that tissue, or its mask, the higher of two values. A NIfTI image that states no
    unit of length is in mm.
    at_mm: along right, anterior or superior; the nearest plane of voxels is taken. An oblique image has
    sections as oblique, named by the closest axes.
    index: of the plane of voxels, counted from left, back or bottom; of the picture in a file of several.
    gray, white, hole: labels of the tissues, one or several, such as gray=(3, 42); numbers of the maps where
    the image has a fourth axis of tissues. All left out: the image is the probability of tissue, or a mask,
    of whose two values the higher is tissue; with a warning the lower, where the higher fills most of the
    image's edges, as does the white round a black brain. gray=0 or gray=255 says which.
    level: the probability at the surface, 0.5 if left out; without labels any value of the image.
    pixel_mm: the edge of a pixel, for pictures and arrays with two axes.

    The curves are those of marching squares, linear between the centres of voxels. A label counts as 1 inside
    and 0 outside, so that its curve runs midway and cuts the corners: it encloses its voxels less half a one
    (`lacking`), and has their steps; `outline` smooths these away from a `Section`, and makes up for that.
    Where the image's edge cuts the tissue, the curve runs along it: see `cuts` of `Section`.
    Raises ValueError for what cannot be read, and for planes and labels that the image does not have.
    """
    one_of("plane", plane, tuple(PLANES))
    wanted = {"gray": gray, "white": white, "hole": hole}
    found = tissues_of(image, plane, pixel_mm, wanted, None if level is None else finite("level", level))
    return tuple(_section(found, plane, k) for k in _planes(found, plane, at_mm, index))


def mask_outline(
    path: str | os.PathLike[str],
    *,
    section: str = "coronal",
    index: int | None = None,
    level: float | None = None,
) -> Array:
    """Return the closed curve (2, n) that encloses the most in a section of a mask; m.

    The arguments are those of `sections`, of an image without labels. The curve has the steps of the voxels:
    give `outline` the length of one as smooth=, or the `Section`. Warns of parts outside the curve, and
    where the image's edge cuts it off.
    """
    one_of("section", section, tuple(PLANES))
    (found,) = sections(path, plane=section, index=index, level=level)
    for remark in found.cut_off(None):
        warnings.warn(f"{found.source}: {remark}.", OutlineWarning, stacklevel=2)
    largest, *others = found.pial
    around = Polygon(largest.T)
    apart = [one.area for loop in others if not around.contains(one := Polygon(loop.T))]
    if apart:
        warnings.warn(
            f"{found.source}: parts of {', '.join(f'{1e6 * a:.3g}' for a in apart[:5])} mm² lie outside the "
            f"outline, which encloses {1e6 * around.area:.4g} mm²; sections(...) returns them all.",
            stacklevel=2,
        )
    return largest


def _planes(tissues: dict[str, Tissue], plane: str, at_mm: Any, index: Any) -> list[int]:
    """Return the numbers of the planes of voxels that are asked for."""
    image = tissues["gray"].image
    count = image.values.shape[PLANES[plane]]
    known = f"{image.source} has {plane} planes 0 to {count - 1}"
    if at_mm is not None and index is not None:
        raise ValueError("at_mm and index both choose planes; give one of them.")
    if index is not None:
        given = list(index) if np.iterable(index) else [index]
        numbers = [whole("index", k, at_least=0, remedy=known) for k in given]
        if max(numbers) >= count:
            raise ValueError(f"index={max(numbers)}: {known}.")
        return numbers
    if at_mm is None:
        return [int(np.argmax([_tissue(tissues, plane, k).sum() for k in range(count)]))]
    if not image.placed:
        raise ValueError(f"at_mm={at_mm!r}: pictures have no position; choose one by index, {known}.")
    start, step = image.position(plane, 0), image.position(plane, 1) - image.position(plane, 0)
    numbers = []
    for at in at_mm if np.iterable(at_mm) else [at_mm]:
        number = int(np.floor((1e-3 * finite("at_mm", at) - start) / step + 0.5))
        if not 0 <= number < count:
            end = start + step * (count - 1)
            raise ValueError(f"at_mm={at:g}: {known}, at {1e3 * start:g} to {1e3 * end:g} mm.")
        numbers.append(number)
    return numbers


def _tissue(tissues: dict[str, Tissue], plane: str, index: int) -> Array:
    """Return the share of all tissues, and holes in them, in a plane of voxels."""
    return np.asarray(sum(tissue.at(plane, index) for tissue in tissues.values()))


def _section(tissues: dict[str, Tissue], plane: str, index: int) -> Section:
    """Return the curves in a plane of voxels; ValueError where it has no tissue."""
    image = tissues["gray"].image
    level = tissues["gray"].level
    pial = _curves(image, plane, _tissue(tissues, plane, index), level, index)
    if not pial:
        raise ValueError(
            f"{plane} plane {index} of {image.source} has no tissue above {level:g}; choose another."
        )
    below = {name: tissue for name, tissue in tissues.items() if name != "gray"}
    white = _curves(image, plane, _tissue(below, plane, index), level, index) if "white" in below else ()
    holes = _curves(image, plane, below["hole"].at(plane, index), level, index) if "hole" in below else ()
    position = image.position(plane, index) if image.placed else None
    source = f"{image.source}, {plane} plane {index}"
    edge = float(np.linalg.norm(image.frame(plane, index)[1], axis=0).max())
    cuts = _cuts(image, plane, index, _tissue(tissues, plane, index) > level)
    labels = np.isin(_tissue(tissues, plane, index), (0.0, 1.0)).all()
    # of corners that turn outward there are four more than of those that turn inward, each of 1/8
    lacking = 0.5 * abs(np.linalg.det(image.frame(plane, index)[1])) if labels else 0.0
    return Section(pial, white, holes, plane, position, source, voxel=edge, cuts=cuts, lacking=lacking)


def _cuts(image: Image, plane: str, index: int, inside: Booleans) -> tuple[Cut, ...]:
    """Return the ends, counter-clockwise round the tissue, of what the edges of an image cut off; m.

    A shape that is closely cropped touches an edge, too, and its width grows fast from there: that of a disc,
    N voxels wide, from at most 2 √N in the first row of voxels to twice that in the fourth. So the edge cuts
    where it holds a longer row of tissue, and one that is not a quarter shorter than three voxels inward.
    Less than 8 voxels across tell neither.
    """
    start, edges = image.frame(plane, index)
    found = []
    for across, far in ((1, False), (0, True), (1, True), (0, False)):  # bottom, right, top, left
        rows = np.moveaxis(inside, across, 0)[:: -1 if far else 1]
        touching = 2 * np.sqrt(rows.any(axis=0).sum())
        inward = _runs(rows[min(INWARD, len(rows) - 1)])
        for first, last in _runs(rows[0]) if len(rows) >= FEWEST else []:
            middle, count = (first + last) // 2, last - first + 1
            wide = max((b - a + 1 for a, b in inward if a <= middle <= b), default=0)
            if count > touching and count > TAPER * wide:
                beyond = len(rows) - 0.5 if far else -0.5
                order = (first, last) if (across == 1) != far else (last, first)
                ends = [(k, beyond) if across == 1 else (beyond, k) for k in order]
                (x0, y0), (x1, y1) = ((start + edges @ np.array(end)).tolist() for end in ends)
                found.append(((x0, y0), (x1, y1)))
    return tuple(found)


def _runs(row: Booleans) -> list[tuple[int, int]]:
    """Return the first and the last number of each run of true values."""
    steps = np.diff(np.concatenate([[0], row.astype(int), [0]]))
    first, beyond = np.flatnonzero(steps > 0), np.flatnonzero(steps < 0)
    return list(zip(first.tolist(), (beyond - 1).tolist(), strict=True))


def _curves(image: Image, plane: str, share: Array, level: float, index: int) -> tuple[Array, ...]:
    """Return the closed curves (2, n) at a level of the share in a plane, by falling area; m."""
    from contourpy import contour_generator

    start, edges = image.frame(plane, index)
    # the voxels outside the image are empty, so that every curve closes
    closing = np.pad(share, 1, constant_values=0.0 if level > 0 else level - 1.0)
    lines: Any = contour_generator(z=closing.T).lines(level)
    curves = [start[:, None] + edges @ (line[:-1].T - 1.0) for line in lines]
    return tuple(sorted((c for c in curves if c.shape[1] >= 3), key=lambda c: -Polygon(c.T).area))
