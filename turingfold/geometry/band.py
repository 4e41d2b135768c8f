"""Parts of a mesh as meshes of their own, such as the cortical band."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from skfem import MeshTri2

from ..arrays import Integers
from .paths import Path
from .triangles import straight_mesh


@dataclass(frozen=True, eq=False)
class Band:
    """The part of a body's mesh that is cortex: `mesh` and, per node of it, the node of the body."""

    mesh: MeshTri2
    nodes: Integers


def submesh(mesh: MeshTri2, elements: Integers) -> tuple[MeshTri2, Integers]:
    """Return some elements as a mesh with straight sides, and the node of the whole mesh per node of it."""
    vertices, local = np.unique(mesh.t[:, elements], return_inverse=True)
    found = MeshTri2.from_mesh(straight_mesh(mesh.p[:, vertices], local.reshape(3, -1)))
    order = np.argsort(keys := np.sort(mesh.facets, axis=0).T @ np.array([mesh.nvertices, 1]))
    wanted = np.sort(vertices[found.facets], axis=0).T @ np.array([mesh.nvertices, 1])
    facets = order[np.searchsorted(keys[order], wanted)]
    return found, np.concatenate([vertices, mesh.nvertices + facets])


def band(mesh: MeshTri2, elements: Integers, lines: Mapping[str, tuple[Path, ...]]) -> Band:
    """Return some elements with their curved sides; a line that they share names a boundary of the band."""
    straight, nodes = submesh(mesh, elements)
    edge = straight.boundary_facets()
    boundaries = {}
    for name, paths in lines.items():
        side = {n for path in paths for n in path.nodes.tolist()}
        found = edge[[int(nodes[straight.nvertices + f]) in side for f in edge]]
        if len(found):
            boundaries[name] = found
    curved = np.ascontiguousarray(mesh.doflocs[:, nodes])
    return Band(MeshTri2(curved, straight.t, _boundaries=boundaries, validate=False), nodes)
