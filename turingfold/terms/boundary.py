"""Quadratic boundary edges as chords fine enough that their walls cannot cross unseen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from ..arrays import Array, Booleans, Integers
from ..geometry.body import Body
from ..geometry.quadratic import distance as piece_distance
from ..geometry.quadratic import weights
from ..morphometry.walls import edge_crossings

LOOPS = 3.0  # vertices farther apart than so many distances along the wall may touch wherever they are


@dataclass(frozen=True, eq=False)
class Chords:
    """Vertices on quadratic edges, and the straight pieces between them; those of moving edges come first.

    share: weight of each node in each vertex, (v, n).  pieces: the vertices that each joins, (p, 2).
    moving: the number of vertices that move.  edge, place: an edge that each vertex is on, and its ξ in
    [0, 1] there, (v,).  edge_of, place_of: the edge of each piece, and ξ of its middle, (p,).
    """

    share: csr_matrix
    pieces: Integers
    moving: int
    edge: Integers
    place: Array
    edge_of: Integers
    place_of: Array


def boundary_edges(body: Body) -> Integers:
    """Return the start, middle and end node of each boundary edge that is not on the mirror, (3, m)."""
    facets = body.mesh.boundary_facets()
    if body.mirror:
        facets = np.setdiff1d(facets, body.mesh.boundaries["mirror"])
    start, end = body.mesh.facets[:, facets]
    return np.stack([start, body.mesh.nvertices + facets, end])


def crossings(body: Body, displacement: Array) -> int:
    """Return how often the deformed boundary, whose edges are curved, crosses itself, or its mirror image."""
    return len(crossed_edges(body, displacement))


def crossed_edges(body: Body, displacement: Array) -> Integers:
    """Return the two boundary edges of each place, (k, 2), where the boundary crosses itself or its image."""
    moved, edges = body.nodes + displacement, boundary_edges(body)
    count = edges.shape[1]
    if body.mirror:
        line, n = body.nodes[0, body.boundary_path("mirror")[0][0]], body.nodes.shape[1]
        own = np.abs(body.nodes[0] - line) <= 1e-9 * body.length  # nodes on the mirror are their own image
        image = np.where(own, np.arange(n), n + np.arange(n))
        edges = np.hstack([edges, image[edges[::-1]]])
        moved = np.hstack([moved, np.stack([2 * line - moved[0], moved[1]])])
    return np.asarray(edge_crossings(moved, edges) % count)


def tissue_left(body: Body, edges: Integers) -> Booleans:
    """Return whether the body lies to the left of the way along each boundary edge, (3, m)."""
    start, middle, end = edges
    triangles = body.mesh.t[:, body.mesh.f2t[0, middle - body.mesh.nvertices]]
    within = body.nodes[:, triangles.sum(axis=0) - start - end] - body.nodes[:, start]
    along = body.nodes[:, end] - body.nodes[:, start]
    return np.asarray(along[0] * within[1] - along[1] * within[0] > 0)


def stays_straight(body: Body, edges: Integers) -> Booleans:
    """Return whether each edge, (3, m), lies on a level or upright line that none of its nodes can leave."""
    held = np.zeros((body.nodes.shape[1], 2), dtype=bool)
    held.reshape(-1)[body.supported] = True
    flat = np.ptp(body.nodes.T[edges], axis=0) <= 1e-9 * body.length
    return np.asarray((held[edges].all(0) & flat).any(1))


def counts(bends: Array, deviation: float) -> Integers:
    """Return how many chords stay within `deviation` of edges.

    bends: |b| = |x₀ - 2 x_m + x₁| of each, (m,); k chords of equal ξ leave it by |b|/(2 k²) at most.
    """
    return np.ceil(np.sqrt(0.5 * bends / deviation)).astype(np.int64)


def chords(edges: Integers, k: Integers, moving: int, total: int) -> Chords:
    """Return k chords of each edge of equal steps in ξ; of `total` nodes the first `moving` move.

    edges: start, middle and end node of each, (3, m); those of nodes that do not move are to be one chord.
    """
    edge = np.repeat(np.arange(len(k)), k + 1)  # edge by edge, both ends included
    number = np.arange(len(edge)) - np.repeat(np.cumsum(k + 1) - k - 1, k + 1)
    inner = (number > 0) & (number < k[edge])
    name = np.where(number == 0, edges[0, edge], edges[2, edge])
    name[name >= moving] += inner.sum()
    name[inner] = moving + np.arange(inner.sum())
    _, first, vertex = np.unique(name, return_index=True, return_inverse=True)
    left = np.flatnonzero(number < k[edge])
    place = number / k[edge]
    rows, shape = np.tile(np.arange(len(first)), 3), (len(first), total)
    share = csr_matrix((weights(place[first]).ravel(), (rows, edges[:, edge[first]].ravel())), shape)
    share.eliminate_zeros()
    return Chords(
        share=share,
        pieces=np.stack([vertex[left], vertex[left + 1]], axis=1),
        moving=int(np.sum(name[first] < moving + inner.sum())),
        edge=edge[first],
        place=place[first],
        edge_of=edge[left],
        place_of=0.5 * (place[left] + place[left + 1]),
    )


def neighbours(points: Array, pieces: Integers, distance: float) -> Integers:
    """Return the pairs of vertices, each i < j, (n, 2), that are near because one wall leads to both.

    points: (v, 2).  pieces: (p, 2).  A vertex and the ends of a piece make such pairs if it is closer than
    `distance` to the piece, and than LOOPS distances along the wall: compression alone brings them together.
    """
    onward = np.concatenate([pieces, pieces[:, ::-1]])
    onward = onward[np.argsort(onward[:, 0], kind="stable")]
    first = np.searchsorted(onward[:, 0], np.arange(len(points) + 1))
    origin, along = onward[:, 0], np.zeros(len(onward))
    here, there = onward.T
    found = []
    while len(origin):
        near = piece_distance(*(points[k].T for k in (origin, here, there))) < (1 - 1e-9) * distance
        found += [np.stack([origin, end], axis=1)[near] for end in (here, there)]
        along = along + np.hypot(*(points[there] - points[here]).T)
        branches = first[there + 1] - first[there]
        source = np.repeat(np.arange(len(there)), branches)
        branch = first[there[source]] + np.arange(len(source)) - (np.cumsum(branches) - branches)[source]
        on = (onward[branch, 1] != here[source]) & (along[source] < LOOPS * distance)
        source, branch = source[on], branch[on]
        origin, along, here, there = origin[source], along[source], there[source], onward[branch, 1]
    first, second = np.sort(np.concatenate(found), axis=1).T
    keys = np.unique((first * len(points) + second)[first < second])  # in a third of the time of unique rows
    return np.stack(np.divmod(keys, len(points)), axis=1)
