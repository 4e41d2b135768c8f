"""Triangle meshes as the body needs them: straight or quadratic, positive, with nothing reordered."""

from __future__ import annotations

import numpy as np
from skfem import MeshTri1, MeshTri2

from ..arrays import Array, Integers


def straight_mesh(points: Array, triangles: Integers) -> MeshTri1:
    """Return straight triangles without letting scikit-fem reorder their corners."""
    return MeshTri1(
        np.ascontiguousarray(points), np.ascontiguousarray(triangles), sort_t=False, validate=False
    )


def quadratic_mesh(mesh: MeshTri1) -> MeshTri2:
    """Return a triangle mesh with quadratic, positive triangles; raises ValueError for degenerate ones."""
    if not isinstance(mesh, MeshTri1):  # MeshTri2 is one too
        raise ValueError(f"mesh must be a scikit-fem triangle mesh, not {type(mesh).__name__}.")
    if not np.isfinite(mesh.doflocs).all():
        raise ValueError(f"mesh has {np.sum(~np.isfinite(mesh.doflocs))} coordinates that are not finite.")
    corners = mesh.p[:, mesh.t]
    (ax, ay), (bx, by) = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (ax * by - ay * bx)
    flat = np.abs(area) <= 1e-12 * np.ptp(mesh.p, axis=1).max() ** 2
    if flat.any():
        k = int(np.flatnonzero(flat)[0])
        raise ValueError(
            f"triangle {k} of the mesh is degenerate: its area is {area[k]:.3g} m²; remove or repair it."
        )
    quadratic = mesh if isinstance(mesh, MeshTri2) else MeshTri2.from_mesh(mesh)
    names = {"_boundaries": mesh.boundaries, "_subdomains": mesh.subdomains}
    turned = quadratic.t.copy()
    turned[1:, area < 0] = turned[:0:-1, area < 0]
    return MeshTri2(quadratic.doflocs, turned, validate=False, **names)


CORNERS_AND_MIDDLES = np.array([[0, 1, 0, 0.5, 0.5, 0], [0, 0, 1, 0, 0.5, 0.5]])


def folded_over(mesh: MeshTri2, nodes: Array) -> Integers:
    """Return the triangles whose Jacobian at a corner or an edge middle is not positive; nodes: (2, n)."""
    moved = MeshTri2(np.ascontiguousarray(nodes), mesh.t, validate=False, sort_t=False)
    return np.flatnonzero((moved.mapping().detDF(CORNERS_AND_MIDDLES) <= 0).any(1))


def check_elements(mesh: MeshTri2) -> None:
    """Raise ValueError if a quadratic triangle folds over itself."""
    jacobian = mesh.mapping().detDF(CORNERS_AND_MIDDLES)
    if (jacobian <= 0).any():
        k, _ = np.argwhere(jacobian <= 0)[0]
        centre = mesh.p[:, mesh.t[:, k]].mean(1)
        raise ValueError(
            f"triangle {k} of the mesh at ({centre[0]:.4g}, {centre[1]:.4g}) m folds over itself (Jacobian "
            f"{jacobian[k].min():.3g}); move its edge middles, or use smaller elements along the curved side."
        )
