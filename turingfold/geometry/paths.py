"""Lines along the edges of a mesh: boundaries and the gray-white interface, each in one or several parts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from skfem import MeshTri2

from ..arrays import Array, Booleans, Integers
from .curve import Curve


@dataclass(frozen=True, eq=False)
class Path:
    """Nodes along a line, (n,): vertex, middle, vertex, ...; a closed one does not repeat the first."""

    nodes: Integers
    closed: bool


@dataclass(frozen=True, eq=False)
class Curves:
    """Several curves, on which arc length counts on from one to the next."""

    parts: tuple[Curve, ...]

    @cached_property
    def length(self) -> float:
        """Total arc length."""
        return sum(curve.length for curve in self.parts)

    def nearest(self, points: Array) -> tuple[Array, Array, Array]:
        """Return distance, unit tangent (2, m) and arc length at the nearest curve point of each point."""
        best, tangent, arc = self.parts[0].nearest(points)
        before = self.parts[0].length
        for curve in self.parts[1:]:
            distance, along, s = curve.nearest(points)
            nearer = distance < best
            best, arc = np.where(nearer, distance, best), np.where(nearer, before + s, arc)
            tangent = np.where(nearer, along, tangent)
            before += curve.length
        return best, tangent, arc


def paths(mesh: MeshTri2, facets: Integers, left: Booleans, name: str) -> tuple[Path, ...]:
    """Return the lines that edges make, the longest first.

    left: triangles, (e,), that lie on the left of the lines: tissue beside a boundary, white matter beside
    the interface. Raises ValueError, with the name, where lines branch.
    """
    number = {}
    for k, (a, b) in zip(facets.tolist(), mesh.facets[:, facets].T.tolist(), strict=True):
        number[a, b] = number[b, a] = k
    found = []
    for vertices, closed in chains(mesh.facets[:, facets], name):
        onward = np.roll(vertices, -1) if closed else vertices[1:]
        edges = [number[pair] for pair in zip(vertices.tolist(), onward.tolist(), strict=False)]
        nodes = np.empty(len(vertices) + len(edges), dtype=np.int64)
        nodes[0::2], nodes[1::2] = vertices, mesh.nvertices + np.array(edges)
        beside = mesh.f2t[:, edges[0]]
        element = next(e for e in beside.tolist() if e >= 0 and left[e])
        corner = mesh.t[:, element].tolist()
        if corner[(corner.index(vertices[0]) + 1) % 3] != onward[0]:
            nodes = np.roll(nodes[::-1], 1) if closed else nodes[::-1].copy()
        chord = mesh.doflocs[:, nodes]
        found.append((-float(np.hypot(*np.diff(chord, axis=1)).sum()), Path(nodes, closed)))
    return tuple(path for _, path in sorted(found, key=lambda one: one[0]))


def chains(pairs: Integers, name: str) -> list[tuple[Integers, bool]]:
    """Return the vertices of edges (2, n) line by line in order, and whether each line closes.

    Raises ValueError, with the name, where more than two edges meet.
    """
    neighbours: dict[int, list[int]] = {}
    for a, b in pairs.T.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    branches = sum(len(near) > 2 for near in neighbours.values())
    if branches:
        raise ValueError(f"the edges of {name} branch at {branches} vertices; name lines that do not touch.")
    ends = sorted(v for v, near in neighbours.items() if len(near) == 1)
    found, done = [], set[int]()
    for start in [*ends, *sorted(neighbours)]:
        if start in done:
            continue
        path, onward = [start], neighbours[start][0]
        done.add(start)
        while onward not in done:
            path.append(onward)
            done.add(onward)
            onward = next((v for v in neighbours[onward] if v not in done), path[0])
        found.append((np.array(path), len(neighbours[start]) == 2))
    return found
