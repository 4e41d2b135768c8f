"""Triangle meshes as the body needs them: straight or quadratic, positive, with nothing reordered."""

from __future__ import annotations

from math import factorial

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
# ∂x/∂ξ and ∂x/∂η of a quadratic triangle at its corners, from its corners and the middles of 01, 12, 20
ALONG_XI = np.array([(-3.0, -1, 0, 4, 0, 0), (1, 3, 0, -4, 0, 0), (1, -1, 0, 0, 4, -4)])
ALONG_ETA = np.array([(-3.0, 0, -1, 0, 0, 4), (1, 0, -1, -4, 4, 0), (1, 0, 3, 0, 0, -4)])


LATTICE = np.array([(4 - i - j, i, j) for i in range(5) for j in range(5 - i)]) / 4  # barycentric, (15, 3)
POWERS = np.rint(4 * LATTICE).astype(int)
# of a polynomial of degree four: Bernstein coefficients from its values on the lattice
COEFFICIENTS = np.linalg.inv(
    (LATTICE[:, None] ** POWERS).prod(2) * [24 / np.prod([factorial(n) for n in row]) for row in POWERS]
)
QUARTERS = 0.5 * np.array([  # of a triangle: corners, (4, 3, 3)
    [(2, 0, 0), (1, 1, 0), (1, 0, 1)], [(1, 1, 0), (0, 2, 0), (0, 1, 1)],
    [(1, 0, 1), (0, 1, 1), (0, 0, 2)], [(1, 1, 0), (0, 1, 1), (1, 0, 1)],
])  # fmt: skip
HALVINGS = 6
CORNERS = np.array([(0, 1, 2), (1, 2, 0), (2, 0, 1)])  # i, j and k of each side


def folded_over(mesh: MeshTri2, nodes: Array, bubbles: Array | None = None) -> Integers:
    """Return the triangles whose Jacobian is not positive everywhere; nodes: (2, n), in the mesh's order.

    bubbles: how far the inside of each triangle bulges by 27 λ₀ λ₁ λ₂ beside, (2, e).
    """
    triangles = nodes[:, np.vstack([mesh.t, mesh.nvertices + mesh.t2f])]
    return turned_over(triangles) if bubbles is None else bulged_over(triangles, bubbles)


def bulged_over(triangles: Array, bubbles: Array) -> Integers:
    """Return which quadratic triangles, (2, 6, e), with bubbles, (2, e), are `turned_over`.

    The Jacobian is of degree four: positive where all its Bernstein coefficients are, on the triangle or on
    each of its quarters, their quarters and so on; what is not decided after HALVINGS counts as turned over.
    """
    corners = ALONG_XI @ triangles, ALONG_ETA @ triangles  # (2, 3, e)
    left, parts = np.arange(triangles.shape[2]), np.broadcast_to(np.eye(3), (triangles.shape[2], 3, 3))
    turned: list[Integers] = []
    for _ in range(HALVINGS):
        places = LATTICE @ parts  # (n, 15, 3)
        one, two, three = np.moveaxis(places, 2, 0)
        bulges = 27 * three * (one - two), 27 * two * (one - three)
        u, v = (
            np.einsum("icn,nkc->ink", slopes[:, :, left], places) + bubbles[:, left, None] * bulge
            for slopes, bulge in zip(corners, bulges, strict=True)
        )
        jacobian = u[0] * v[1] - u[1] * v[0]
        lost = ~(jacobian > 0).all(1)
        turned.append(left[lost])
        open_yet = ~lost & ~(jacobian @ COEFFICIENTS.T > 0).all(1) & ~np.isin(left, left[lost])
        left = np.repeat(left[open_yet], len(QUARTERS))
        parts = (QUARTERS @ parts[open_yet][:, None]).reshape(-1, 3, 3)
    return np.unique(np.concatenate([*turned, left]))


def bernstein(triangles: Array) -> Array:
    """Return the Bernstein coefficients of the Jacobian of quadratic triangles, (2, 6, e): (6, e).

    It is their sum with λ_i² at the corners, then with 2 λ_i λ_j of the sides 01, 12, 20; λ barycentric.
    """
    (ux, uy), (vx, vy) = ALONG_XI @ triangles, ALONG_ETA @ triangles  # (3, e) each
    i, j, _ = CORNERS
    between = 0.5 * (ux[i] * vy[j] - uy[i] * vx[j] + ux[j] * vy[i] - uy[j] * vx[i])
    return np.concatenate([ux * vy - uy * vx, between])


def turned_over(triangles: Array) -> Integers:
    """Return which quadratic triangles, (2, 6, e), have a Jacobian that is not positive everywhere.

    In barycentric coordinates λ the Jacobian is the quadratic form λ·C λ; it is positive on the whole
    triangle where C is strictly copositive, for which there is a test without sampling. Where all entries of
    C, the Bernstein coefficients, are positive, it is.
    Source: Hadeler 1983, On copositive matrices, Linear Algebra and its Applications 49, 79 (order 3).
    """
    i, j, k = CORNERS
    own, between = np.split(bernstein(triangles), 2)
    doubtful = np.flatnonzero(~((own > 0).all(0) & (between > 0).all(0)))
    root, between = np.sqrt(np.maximum(own[:, doubtful], 0.0)), between[:, doubtful]
    pairs = between + root[i] * root[j]
    inside = root.prod(0) + (between * root[k]).sum(0) + np.sqrt(2 * np.maximum(pairs, 0.0).prod(0))
    found: Integers = doubtful[~((root > 0).all(0) & (pairs > 0).all(0) & (inside > 0))]
    return found


def check_elements(mesh: MeshTri2) -> None:
    """Raise ValueError if a quadratic triangle folds over itself."""
    folded = folded_over(mesh, mesh.doflocs)
    if folded.size:
        k = int(folded[0])
        centre = mesh.p[:, mesh.t[:, k]].mean(1)
        raise ValueError(
            f"triangle {k} of the mesh at ({centre[0]:.4g}, {centre[1]:.4g}) m folds over itself: its "
            "Jacobian is not positive everywhere; move its edge middles, or use smaller elements along the "
            "curved side."
        )
