"""Plane sections of closed triangle surfaces, such as FreeSurfer's pial and white surfaces."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.parsers.expat import ExpatError

import numpy as np
from shapely import Polygon

from ..arrays import Array, Integers
from ..checks import file_path, finite, finite_array, one_of
from ..geometry.paths import chains
from ..geometry.units import metres
from ..outlines.section import Section
from .image import DAMAGE, PLANES, nibabel_for

Surface = str | os.PathLike[str] | tuple[Any, Any]


def surface_section(
    pial: Surface | Sequence[Surface],
    white: Surface | Sequence[Surface] = (),
    *,
    plane: str = "coronal",
    at: float,
    unit: str | float = "mm",
) -> Section:
    """Return the section of a pial and a white surface by a plane.

    pial, white: each a GIFTI (.gii, .gii.gz) or FreeSurfer file, or a pair (vertices (n, 3), triangles
    (m, 3)); or a list of them, such as of both hemispheres. Axes are right, anterior, superior.
    at: of the plane along the axis across it; m.
    unit: of the vertices, as in `read_outline`; files are in mm.

    A curve runs from edge to edge of the triangles that the plane cuts, with two points in between. Vertices
    on the plane count as above it, so that every curve of a closed surface closes. Where a surface is open,
    its curve is closed by a straight line, with a warning that tells how long.
    Raises ValueError for what is no surface, for edges of more than two triangles, and for planes that miss.
    """
    across = PLANES[one_of("plane", plane, tuple(PLANES))]
    finite("at", at)
    scale = metres(unit)
    surfaces = {"pial": _surfaces("pial", pial), "white": _surfaces("white", white)}
    curves: dict[str, list[Array]] = {}
    for name, each in surfaces.items():
        found = [loop for item in each for loop in _cut(*item, across, at / scale, scale, name)]
        curves[name] = sorted(found, key=lambda loop: -Polygon(loop.T).area)
    if not curves["pial"]:
        low = scale * min(points[:, across].min() for points, _, _ in surfaces["pial"])
        high = scale * max(points[:, across].max() for points, _, _ in surfaces["pial"])
        raise ValueError(
            f"at={at:g} m: the {plane} planes that meet the pial surface lie from {low:g} to {high:g} m. "
            f"{at:g} mm would be at={1e-3 * at:g}."
        )
    return Section(
        curves["pial"], curves["white"], (), plane, float(at), ", ".join(item[2] for item in surfaces["pial"])
    )


def _surfaces(name: str, given: Any) -> list[tuple[Array, Integers, str]]:
    """Return vertices (n, 3), triangles (m, 3) and source of each surface."""
    single = isinstance(given, str | os.PathLike) or (
        isinstance(given, tuple) and len(given) == 2 and not isinstance(given[0], str | os.PathLike | tuple)
    )
    items = [given] if single else list(given)
    found = []
    for item in items:
        pair, source = (item, name) if isinstance(item, tuple) else _read(name, item)
        points = finite_array(f"vertices of {source}", pair[0], (None, 3))
        triangles = np.asarray(pair[1])
        if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
            raise ValueError(
                f"triangles of {source} have shape {triangles.shape}; give vertex numbers (m, 3)."
            )
        if triangles.size and not 0 <= triangles.min() <= triangles.max() < len(points):
            raise ValueError(f"triangles of {source} name vertices beyond its {len(points)}.")
        found.append((points, triangles.astype(np.int64), source))
    return found


def _read(name: str, path: Any) -> tuple[tuple[Any, Any], str]:
    """Return the vertices and triangles in a file."""
    file: Path = file_path(name, path, "a surface in GIFTI or FreeSurfer's format")
    nibabel = nibabel_for(file)
    try:
        if file.name.lower().endswith((".gii", ".gii.gz")):
            image = nibabel.load(file)
            pair = image.agg_data("pointset"), image.agg_data("triangle")
        else:
            pair = nibabel.freesurfer.read_geometry(file)
    except (
        nibabel.filebasedimages.ImageFileError,
        ExpatError,
        LookupError,
        AttributeError,
        *DAMAGE,
    ) as error:
        raise ValueError(f"{file.name} is no surface in GIFTI or FreeSurfer's format: {error}.") from error
    if not all(isinstance(part, np.ndarray) for part in pair):
        raise ValueError(f"{file.name} holds no single set of vertices with triangles; give a surface.")
    return pair, file.name


def _cut(
    points: Array, triangles: Integers, source: str, across: int, at: float, scale: float, name: str
) -> list[Array]:
    """Return the closed curves (2, n) in which a plane cuts a surface; m."""
    height = points[:, across] - at
    above = height >= 0
    cut = triangles[above[triangles].sum(axis=1) % 3 > 0]
    edges = np.sort(np.stack([cut, np.roll(cut, -1, axis=1)], axis=2), axis=2)  # (m, 3, 2)
    crossing = above[edges[..., 0]] != above[edges[..., 1]]  # two of each triangle
    ends, number = np.unique(edges[crossing], axis=0, return_inverse=True)
    if not len(ends):
        return []
    links = number.reshape(-1, 2)
    share = height[ends[:, 0]] / (height[ends[:, 0]] - height[ends[:, 1]])
    places = points[ends[:, 0]] + share[:, None] * (points[ends[:, 1]] - points[ends[:, 0]])
    places = scale * np.delete(places, across, axis=1).T
    if (counts := np.bincount(number.ravel())).max() > 2:
        x, y = places[:, counts.argmax()]
        raise ValueError(
            f"{source}: an edge near ({x:g}, {y:g}) m belongs to {counts.max()} triangles, not to two "
            "at most; repair the surface."
        )
    loops = []
    for chain, closed in chains(links.T, source):
        loop = places[:, chain]
        apart = np.hypot(*(loop - np.roll(loop, 1, axis=1))) > 1e-12 * np.abs(places).max()
        loop = loop[:, apart]
        if not closed:
            gap = float(np.hypot(*(loop[:, 0] - loop[:, -1])))
            words = f"{source}: the {name} surface is open; its curve is closed by a line of {gap:g} m."
            warnings.warn(words, stacklevel=3)
        if loop.shape[1] >= 3:
            loops.append(_in_thirds(loop))
    return loops


def _in_thirds(loop: Array) -> Array:
    """Return a closed curve (2, n) with points at the thirds of its segments, (2, 3 n).

    Triangles are flat: a smooth curve through their corners alone would leave them.
    """
    step = (np.roll(loop, -1, axis=1) - loop) / 3
    return np.stack([loop, loop + step, loop + 2 * step], axis=2).reshape(2, -1)
