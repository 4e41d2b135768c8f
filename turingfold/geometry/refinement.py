"""A body on a finer mesh, with exactly its own geometry."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.sparse import csr_matrix
from skfem import ElementTriP2, MeshTri2

from ..arrays import Array, Integers
from ..checks import instance, whole
from .body import Body
from .triangles import CORNERS_AND_MIDDLES, straight_mesh

# the four triangles between corners and edge middles
CHILDREN = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])
EDGES = ((0, 1), (1, 2), (0, 2))


def refined(body: Body, times: int = 1) -> Body:
    """Return the body with each triangle split into four, `times` times over.

    Curved edges keep their shape, and the nodes of the body keep their numbers: those of the finer one that
    lie where the body has nodes come first. What is measured against it is an error of the discretisation
    alone.
    """
    instance("body", body, Body, "semicircle(radius=0.04, thickness=0.0025, size=0.001)")
    for _ in range(whole("times", times, at_least=0)):
        body = _split(body)
    return body


def _split(body: Body) -> Body:
    nodes, old = body.nodes, body.triangles
    triangles = np.concatenate([old[child] for child in CHILDREN], axis=1)
    mesh = MeshTri2.from_mesh(straight_mesh(nodes, triangles))
    points = np.concatenate([nodes, mesh.doflocs[:, mesh.nvertices :]], axis=1)
    for facets, shapes in _halfway(mesh):
        points[:, mesh.nvertices + facets] = np.tensordot(nodes[:, old], shapes, (1, 0))
    kinds = {**(body.mesh.subdomains or {}), "cortex": np.flatnonzero(body.in_cortex)}
    first = body.mesh.nelements * np.arange(len(CHILDREN))[:, None]
    finer = MeshTri2(
        points,
        mesh.t,
        _boundaries=_boundaries(body, mesh),
        _subdomains={name: (first + elements).ravel() for name, elements in kinds.items()},
        validate=False,
    )
    return replace(body, mesh=finer)


def prolongation(body: Body, finer: Body) -> csr_matrix:
    """Return the matrix (n_finer, n) from nodal values of a body to those of `finer`, its `refined` one."""
    count, vertices, old = finer.nodes.shape[1], finer.mesh.nvertices, body.triangles
    weights, nodes = np.zeros((count, 6)), np.zeros((count, 6), dtype=np.int64)
    weights[:vertices, 0], nodes[:vertices, 0] = 1.0, np.arange(vertices)
    for facets, shapes in _halfway(finer.mesh):
        weights[vertices + facets], nodes[vertices + facets] = shapes, old.T
    rows = np.repeat(np.arange(count), 6)
    return csr_matrix((weights.ravel(), (rows, nodes.ravel())), shape=(count, vertices))


def at_finer_points(body: Body, values: Array) -> Array:
    """Return values (..., q, e) at the integration points at those of `refined(body)`, (..., q, 4 e).

    Inside each triangle they belong to the polynomial through the values at its points.
    """
    rule = body.quadrature
    through = np.linalg.pinv(rule.shapes.T)  # (6, q): nodal values of the polynomial
    own = CORNERS_AND_MIDDLES @ rule.shapes  # the integration points in the reference triangle, (2, q)
    found = []
    for child in CHILDREN:
        corners = CORNERS_AND_MIDDLES[:, child]
        inside = corners[:, :1] + (corners[:, 1:] - corners[:, :1]) @ own
        shapes = np.stack([ElementTriP2().lbasis(inside, i)[0] for i in range(6)])
        found.append(np.einsum("pq,...qe->...pe", shapes.T @ through, values))
    return np.concatenate(found, axis=-1)


def _halfway(finer: MeshTri2) -> Iterator[tuple[Integers, Array]]:
    """Yield facets of a finer mesh, one in each old triangle, and its shape functions in their middles."""
    for child, own in zip(CHILDREN, np.split(finer.t2f, len(CHILDREN), axis=1), strict=True):
        for edge, facets in zip(EDGES, own, strict=True):
            middle = CORNERS_AND_MIDDLES[:, child[list(edge)]].mean(axis=1)
            yield facets, np.array([ElementTriP2().lbasis(middle, i)[0] for i in range(6)])


def _boundaries(body: Body, mesh: MeshTri2) -> dict[str, Integers]:
    """Return the halves of the facets of each named boundary."""
    n = mesh.nvertices
    low, high = np.sort(mesh.facets, axis=0).astype(np.int64)
    order = np.argsort(low * n + high)
    keys = (low * n + high)[order]
    halves = {}
    for name, facets in body.mesh.boundaries.items():
        ends, middle = body.mesh.facets[:, facets].astype(np.int64), body.mesh.nvertices + np.asarray(facets)
        wanted = np.concatenate([np.minimum(end, middle) * n + np.maximum(end, middle) for end in ends])
        halves[name] = order[np.searchsorted(keys, wanted)]
    return halves
