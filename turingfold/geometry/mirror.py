"""Mirror-symmetric bodies and their halves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree
from skfem import MeshTri2

from ..arrays import Integers
from ..checks import instance
from .band import submesh
from .body import Body

SYMMETRIC = 1e-9  # share of the body's length by which mirror images may differ
FLIP = np.array([[-1.0], [1.0]])  # to the mirror image in x = 0


def half(body: Body) -> Body:
    """Return the half x >= 0 of a mirror-symmetric body; its boundary on x = 0 is named "mirror".

    Raises ValueError if the mesh is not its own mirror image to 1e-9 of the body's length, if triangles lie
    across x = 0, or if the body is half of one already.
    """
    instance("body", body, Body, "semicircle(radius=0.04, thickness=0.0025, size=0.001)")
    if body.mirror:
        raise ValueError("body has a mirror: it is half of a body already; only a whole one can be halved.")
    if mirror_images(body) is None:
        raise ValueError(
            "the mesh is not its own image in the line x = 0; only a mirror-symmetric mesh can be halved: "
            "shift its line of symmetry to x = 0, or make it symmetric (geometric_imperfection(..., "
            "symmetric=True))."
        )
    mesh = body.mesh
    keep = np.flatnonzero(mesh.p[0][mesh.t].mean(0) > 0)
    tolerance = SYMMETRIC * body.length
    if 2 * len(keep) != mesh.nelements or np.any(mesh.p[0][mesh.t[:, keep]] < -tolerance):
        raise ValueError("the mesh has triangles across x = 0; only one with edges along it can be halved.")
    part, nodes = submesh(body.mesh, keep)
    points = mesh.doflocs[:, nodes].copy()
    points[0, np.abs(points[0]) < tolerance] = 0.0
    outer = part.boundary_facets()
    facets = nodes[part.nvertices + outer] - mesh.nvertices
    named = {name: outer[np.isin(facets, known)] for name, known in mesh.boundaries.items()}
    named["mirror"] = outer[points[0, part.nvertices + outer] == 0.0]
    gray = np.flatnonzero(body.in_cortex[keep])
    halved = MeshTri2(
        points,
        part.t,
        _boundaries={k: v for k, v in named.items() if len(v)},
        _subdomains={"cortex": gray},
        validate=False,
    )
    return replace(body, mesh=halved)


def mirror_images(body: Body) -> Integers | None:
    """Return for each node the one at its image in x = 0, (n_nodes,), or None for a body without symmetry.

    Nodes agree to 1e-9 of the body's length; triangles, cortex and named boundaries must agree as well.
    """
    distance, nearest = cKDTree(body.nodes.T).query((body.nodes * FLIP).T)
    image = np.asarray(nearest, dtype=np.int64)
    if np.max(distance) > SYMMETRIC * body.length or len(np.unique(image)) < len(image):
        return None
    gray, mesh = body.in_cortex, body.mesh
    parts = [body.triangles[3:, gray], body.triangles[3:, ~gray]]
    parts += [mesh.nvertices + np.asarray(facets)[None] for facets in (mesh.boundaries or {}).values()]
    alike = (np.array_equal(_sorted(image[part]), _sorted(part)) for part in parts)
    return image if all(alike) else None


def _sorted(sets: Integers) -> Integers:
    """Return sets of nodes, one per column, in an order that depends on what is in them only."""
    inside = np.sort(sets, axis=0)
    return inside[:, np.lexsort(inside)]
