"""The mesh of tissue: lines laid out, filled with triangles, their curved edges placed, their parts named."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skfem import MeshTri1, MeshTri2

from ..arrays import Array, Booleans, Integers
from ..geometry.triangles import folded_over, straight_mesh
from .domain import Domain
from .fill import angles, fill
from .frame import Frame, Side, Size, side
from .region import rings

BULGE = 0.1  # largest share of its length by which an edge is curved


def meshed(made: Domain, finest: Size, grading: float, centre: Array, unit: float) -> tuple[MeshTri2, float]:
    """Return the mesh, moved to centre + unit × position, and its smallest angle; degrees.

    finest: edge length asked for in the cortex; in white matter it grows by `grading` × distance.
    Boundaries are named "pial", "base" and "hole", the gray triangles "cortex".
    """
    tree = cKDTree(shapely.get_coordinates(shapely.segmentize(made.white.boundary, 0.5 * made.size)))
    shapely.prepare(made.white)

    def white(at: Array) -> Booleans:
        return np.asarray(shapely.contains_xy(made.white, *at))

    def along(at: Array) -> Array:
        return np.asarray(finest(at) + grading * np.where(white(at), tree.query(at.T)[0], 0.0))

    found, points, triangles = fill(_sides(made, along), finest, white, grading)
    smallest = float(angles(points, triangles).min())
    exact = np.concatenate([found.exact, points[:, found.points.shape[1] :]], axis=1)
    inside, middles = white(points[:, triangles].mean(1)), centre + unit * found.middles
    return _quadratic(found, centre + unit * exact, triangles, middles, inside), smallest


def _sides(made: Domain, size: Size) -> list[Side]:
    """Return all lines of the frame with their nodes."""
    sides: list[Side] = []
    inner, stops = _interface(made)
    for ring in rings(made.area):
        sides += _boundary(made, ring, size, stops)
    for line in inner:
        sides.append(side("interface", line, size, made.on_interface))
    sides += [side("hole", ring, size, made.on_wall) for ring in rings(made.holes)]
    return sides


def _boundary(made: Domain, ring: Array, size: Size, stops: list[list[float]]) -> list[Side]:
    """Return a ring of the boundary as pial lines and bases."""
    whole, put = Side("pial", ring, np.zeros(0), _same), made.on_surface
    curve = shapely.LinearRing(ring.T)
    cuts = []
    for k, base in enumerate(made.bases):
        first, last = shapely.points(base[:, 0]), shapely.points(base[:, -1])
        if curve.distance(first) + curve.distance(last) < 1e-3 * made.size:
            cuts.append((curve.project(first), curve.project(last), k))
    if not cuts:
        return [side("pial", ring, size, put)]
    cuts.sort()
    sides, total = [], float(whole.arc[-1])
    for n, (_, end, k) in enumerate(cuts):
        base = made.bases[k]
        begin, _, onward = cuts[(n + 1) % len(cuts)]
        between = (
            whole.arc[(whole.arc > end) & (whole.arc < begin)]
            if end < begin
            else np.concatenate([whole.arc[whole.arc > end], whole.arc[1:][whole.arc[1:] < begin] + total])
        )
        middle = whole.at(between % total if end >= begin else between)
        apart = 1e-3 * made.size
        for tip in (base[:, -1], made.bases[onward][:, 0]):
            middle = middle[:, np.hypot(*(middle - tip[:, None])) > apart]
        pial = np.concatenate([base[:, -1:], middle, made.bases[onward][:, :1]], axis=1)
        sides += [side("base", base, size, _same, np.array(stops[k])), side("pial", pial, size, put)]
    return sides


def _same(at: Array) -> Array:
    return at


def _interface(made: Domain) -> tuple[list[Array], list[list[float]]]:
    """Return the lines between gray and white matter, and per base the arc lengths at which they end."""
    stops: list[list[float]] = [[] for _ in made.bases]
    whole = rings(made.white)
    if not made.bases:
        return whole, stops
    bottoms = [Side("base", base, np.zeros(0), _same) for base in made.bases]
    lines = [shapely.LineString(base.T) for base in made.bases]
    near = shapely.union_all(lines).buffer(1e-4 * made.size)
    found = []
    for ring in whole:
        if not shapely.LineString(ring.T).intersects(near):
            found.append(ring)
            continue
        off = shapely.line_merge(shapely.LineString(ring.T).difference(near))
        for part in shapely.get_parts(off):
            line = shapely.get_coordinates(part).T.copy()
            for end in (0, -1):
                tip = shapely.points(line[:, end])
                k = int(np.argmin([one.distance(tip) for one in lines]))
                at = lines[k].project(tip)
                stops[k].append(at)
                line[:, end] = bottoms[k].at(np.array([at]))[:, 0]
            found.append(line)
    return found, stops


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
    kinds = np.array(found.kinds)[found.side]
    named = {name: facets[kinds == name] for name in ("pial", "base", "hole")}
    cortex = _gray(straight, facets[kinds == "interface"], white)
    return MeshTri2(
        placed,
        mesh.t,
        _boundaries={name: part for name, part in named.items() if len(part)},
        _subdomains={"cortex": cortex},
        validate=False,
    )


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
