"""The mesh of tissue: lines laid out, filled with triangles, their curved edges placed, their parts named."""

from __future__ import annotations

from functools import partial

import numpy as np
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skfem import MeshTri1, MeshTri2

from ..arrays import Array, Booleans, Integers
from ..geometry.curve import Curve
from ..geometry.paths import paths
from ..geometry.triangles import folded_over, straight_mesh
from .domain import Domain
from .fill import angles, fill
from .frame import Frame, Side, Size, side
from .region import rings

AWAY = 1e-3  # of the size: lines that end nearer than this to a base end on it, or at its tip
LINES = {"pial": "the pial surface", "base": "a base", "interface": "the interface", "hole": "holes"}
BULGE = 0.1  # largest share of its length by which an edge is curved


def meshed(made: Domain, finest: Size, grading: float, centre: Array, unit: float) -> tuple[MeshTri2, float]:
    """Return the mesh, moved to centre + unit × position, and its smallest angle; degrees.

    finest: edge length asked for in the cortex; in white matter it grows by `grading` × distance.
    Boundaries are named "pial", "base" and "hole", the gray triangles "cortex".
    Raises ValueError if lines cross or touch, so that an edge of them cannot be kept.
    """
    tree = cKDTree(shapely.get_coordinates(shapely.segmentize(made.white.boundary, 0.5 * made.size)))
    shapely.prepare(made.white)

    def white(at: Array) -> Booleans:
        return np.asarray(shapely.contains_xy(made.white, *at))

    def along(at: Array) -> Array:
        return np.asarray(finest(at) + grading * np.where(white(at), tree.query(at.T)[0], 0.0))

    found, points, triangles, gone = fill(_sides(made, along), finest, white, grading)
    if len(gone):
        x, y = (centre[:, 0] + unit * found.points[:, found.edges[:, gone[0]]].mean(1)).tolist()
        kinds = " and ".join(sorted({LINES[kind] for kind in found.kinds[gone]}))
        raise ValueError(
            f"the mesh cannot keep {len(gone)} edges of {kinds}, first near ({x:.4g}, {y:.4g}) m, where "
            "lines cross or touch; move these curves apart by an element, or leave one out."
        )
    smallest = float(angles(points, triangles).min())
    exact = np.concatenate([found.exact, points[:, found.points.shape[1] :]], axis=1)
    inside, middles = white(points[:, triangles].mean(1)), centre + unit * found.middles
    return _quadratic(found, centre + unit * exact, triangles, middles, inside), smallest


def of_walls(mesh: MeshTri2) -> float:
    """Return the area that the walls of holes enclose, islands not counted; m²."""
    walls = (mesh.boundaries or {}).get("hole", np.zeros(0, dtype=np.int64))
    found = paths(mesh, np.asarray(walls), np.ones(mesh.nelements, dtype=bool), "holes")
    return -sum(Curve(mesh.doflocs[:, path.nodes], closed=True).area for path in found)


def _sides(made: Domain, size: Size) -> list[Side]:
    """Return all lines of the frame with their nodes; bases have some where other lines end on them."""
    boundary, near = made.area.boundary, AWAY * made.size
    bases = [b for b in made.bases if shapely.dwithin(boundary, shapely.points(b.T[[0, -1]]), near).all()]
    stops: list[list[float]] = [[] for _ in bases]
    pial, interface = (_ended(rings(area), bases, stops, made.size) for area in (made.area, made.white))
    everything = {"pial": pial, "base": bases, "interface": interface, "hole": rings(made.holes)}
    return [
        side(kind, line, size, partial(made.put, kind), np.array(stops[k]) if kind == "base" else None)
        for kind, lines in everything.items()
        for k, line in enumerate(lines)
    ]


def _ended(whole: list[Array], bases: list[Array], stops: list[list[float]], size: float) -> list[Array]:
    """Return rings without the parts along bases; where the rest ends is added to the stops of the base.

    stops: arc lengths along each base.
    """
    lines = [shapely.LineString(base.T) for base in bases]
    near = shapely.union_all(lines).buffer(0.1 * AWAY * size)
    found = []
    for ring in whole:
        rest = shapely.LineString(ring.T).difference(near) if bases else shapely.LineString(ring.T)
        for part in shapely.get_parts(shapely.line_merge(rest)):
            line = shapely.get_coordinates(part).T.copy()
            for end in () if part.is_ring else (0, -1):
                k = int(np.argmin(shapely.distance(lines, shapely.points(line[:, end]))))
                at, length = lines[k].project(shapely.points(line[:, end])), lines[k].length
                if AWAY * size <= at <= length - AWAY * size:
                    stops[k].append(at)
                else:
                    at = 0.0 if at < AWAY * size else length
                line[:, end] = lines[k].interpolate(at).coords[0]
            found.append(line)
    return found


def _quadratic(found: Frame, points: Array, triangles: Integers, middles: Array, white: Booleans) -> MeshTri2:
    """Return the mesh with the edges of the frame curved, where that folds no triangle.

    white: whether the centre of each triangle is in white matter, (e,).
    """
    straight = straight_mesh(points, triangles)
    mesh = MeshTri2.from_mesh(straight)
    n = points.shape[1]
    order = np.argsort(keys := np.sort(straight.facets, axis=0).T @ np.array([n, 1]))
    facets = order[np.searchsorted(keys[order], np.sort(found.edges, axis=0).T @ np.array([n, 1]))]
    ends = points[:, found.edges]
    chord = ends.mean(1)
    near = np.hypot(*(middles - chord)) < BULGE * np.hypot(*(ends[:, 0] - ends[:, 1]))
    flat = mesh.doflocs
    placed = flat.copy()
    placed[:, n + facets] = np.where(near, middles, chord)
    while len(bad := folded_over(mesh, placed)):
        edges = n + straight.t2f[:, bad].ravel()
        if (placed[:, edges] == flat[:, edges]).all():
            break
        placed[:, edges] = flat[:, edges]
    named = {kind: facets[found.kinds == kind] for kind in ("pial", "base", "hole") if kind in found.kinds}
    cortex = {"cortex": _gray(straight, facets[found.kinds == "interface"], white)}
    return MeshTri2(placed, mesh.t, _boundaries=named, _subdomains=cortex, validate=False)


def _gray(mesh: MeshTri1, interface: Integers, white: Booleans) -> Integers:
    """Return the triangles of all parts between lines of the interface that lie mostly outside white matter.

    Such a part need not have a pial surface: in a section, the bottom of a sulcus that the plane just misses.
    """
    crossed = np.setdiff1d(np.flatnonzero(mesh.f2t[1] >= 0), interface)
    one, other = mesh.f2t[:, crossed]
    links = coo_matrix((np.ones(len(one)), (one, other)), shape=(mesh.nelements, mesh.nelements))
    _, part = connected_components(links, directed=False)
    share = np.bincount(part, white) / np.bincount(part)
    return np.flatnonzero(share[part] < 0.5)
