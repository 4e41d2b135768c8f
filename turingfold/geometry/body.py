"""The body: a triangle mesh with a pial surface, a cortex of given thickness and a base."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from skfem import Basis, ElementTriP2, MeshTri2

from ..arrays import Array, Booleans, Integers
from ..checks import one_of, positive
from .curve import Curve, chain
from .triangles import check_elements, quadratic_mesh, straight_mesh

BASES = ("clamped", "roller", "free")
SHARP, SIGMOID = LAYERS = ("sharp", "sigmoid")


@dataclass(frozen=True, eq=False)
class Band:
    """The part of a body's mesh that is cortex: `mesh` and, per node of it, the node of the body."""

    mesh: MeshTri2
    nodes: Integers


@dataclass(frozen=True)
class Quadrature:
    """The body's integration points, q of them in each of e elements; the rule has positive weights only.

    derivatives: of the 6 shape functions in the reference triangle, shape (6, 2, q).
    shapes: the shape functions, (6, q).  inverse: ∂ξ/∂X, (2, 2, q, e).  weights: area of each point, (q, e).
    """

    points: Array
    shapes: Array
    derivatives: Array
    inverse: Array
    weights: Array

    @classmethod
    def of(cls, basis: Basis) -> Quadrature:
        """Return the integration points of a basis of quadratic triangles."""
        mapping, points = basis.mapping, basis.X
        values = [basis.elem.lbasis(points, i) for i in range(6)]
        return cls(
            points=np.ascontiguousarray(np.swapaxes(mapping.F(points), 1, 2)),
            shapes=np.stack([shape for shape, _ in values]),
            derivatives=np.stack([slope for _, slope in values]),
            inverse=np.ascontiguousarray(np.swapaxes(mapping.invDF(points), 2, 3)),
            weights=np.ascontiguousarray(basis.dx.T),
        )


@dataclass(frozen=True, eq=False)
class Body:
    """A mesh whose boundary has a part named "pial" and, unless `base` is free, one named "base".

    mesh: straight or isoparametric quadratic triangles in m; straight ones become quadratic. A part named
    "mirror" makes it half of a mirror-symmetric body: there, displacement across the line is zero.
    thickness: of the cortex, in m. Elements in the subdomain "cortex" are gray matter; without that name it
    is those with their centre less than `thickness` below the pial surface.
    base: "clamped" (no displacement), "roller" (none across the base line) or "free".
    layers: how moduli and growth change from gray to white matter: "sharp", between elements, or "sigmoid",
    by θ(y) = 1/(1 + exp(10 (y/T - 1))) of the depth y (Choi et al. 2025).
    Raises ValueError for missing parts, wrong lengths, inverted or degenerate triangles.
    """

    mesh: MeshTri2
    thickness: float
    base: str = "clamped"
    layers: str = SHARP

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness", positive("thickness", self.thickness))
        one_of("base", self.base, BASES)
        one_of("layers", self.layers, LAYERS)
        object.__setattr__(self, "mesh", quadratic_mesh(self.mesh))
        needed = ("pial",) if self.base == "free" else ("pial", "base")
        known = self.mesh.boundaries or {}
        for name in needed:
            if name not in known or len(known[name]) == 0:
                raise ValueError(
                    f"mesh has no boundary named {name!r} (it names: {', '.join(known) or 'none'}); "
                    "add it with mesh.with_boundaries({...})."
                )
        check_elements(self.mesh)
        if not self.in_cortex.any():
            raise ValueError(
                f"thickness={self.thickness:g} m is less than the depth of the outermost elements: no gray "
                'matter; use smaller elements, or name the subdomain "cortex".'
            )
        self.boundary_path("pial")  # refuses a surface in several parts
        for line in self._sliding:
            self._normal_axis(line)

    # nodes and curves

    @property
    def nodes(self) -> Array:
        """Reference positions, vertices first, then edge middles; shape (2, n_nodes)."""
        return self.mesh.doflocs  # type: ignore[no-any-return]

    @cached_property
    def triangles(self) -> Integers:
        """Nodes of each quadratic triangle, shape (6, n_elements)."""
        return np.asarray(self._basis.element_dofs, dtype=np.int64)

    @cached_property
    def length(self) -> float:
        """Half the body's largest extent, the unit of length for tolerances; m."""
        extent = np.ptp(self.nodes, axis=1)
        return float(max(0.5 * extent[0], extent[1]) if not self.mirror else extent.max())

    @property
    def mirror(self) -> bool:
        """Whether this is the half of a mirror-symmetric body."""
        return "mirror" in (self.mesh.boundaries or {})

    @cached_property
    def pial(self) -> Integers:
        """Nodes along the pial surface, with the body on its left; shape (n_pial,)."""
        return self.boundary_path("pial")[0]

    @cached_property
    def pial_curve(self) -> Curve:
        """The pial surface before deformation."""
        nodes, closed = self.boundary_path("pial")
        return Curve(self.nodes[:, nodes], closed)

    @property
    def pial_arc(self) -> Array:
        """Arc length along the undeformed pial surface, shape (n_pial,); m."""
        return self.pial_curve.arc

    def pial_share(self, arc: Array) -> Array:
        """Return arc lengths as shares of the whole pial surface; half a body has the first half of it."""
        return arc / (self.pial_curve.length * (2.0 if self.mirror else 1.0))

    @cached_property
    def interface(self) -> Integers:
        """Nodes along the gray-white interface, in the direction of the pial surface; (n_interface,)."""
        f2t, gray = self.mesh.f2t, self.in_cortex
        inner = f2t[1] >= 0
        across = np.flatnonzero(inner & (gray[f2t[0]] != gray[np.where(inner, f2t[1], 0)]))
        if across.size == 0:
            raise ValueError(
                f"thickness={self.thickness:g} leaves no white matter: there is no gray-white interface."
            )
        nodes, closed = self._path(across, "the gray-white interface")
        arc = self.pial_curve.nearest(self.nodes[:, nodes])[2]
        return nodes if np.sum(np.diff(arc) > 0) > len(arc) / 2 else _reversed(nodes, closed)

    def boundary_path(self, name: str) -> tuple[Integers, bool]:
        """Return the nodes of a named boundary with the body on its left, and whether it is closed.

        That is counter-clockwise round the body, and clockwise round a hole in it.
        """
        facets = np.asarray(self.mesh.boundaries[name])
        nodes, closed = self._path(facets, f"boundary {name!r}")
        first = self._facet_of[nodes[0], nodes[2 % len(nodes)]]
        element = self.mesh.f2t[0, first]
        corner = list(self.mesh.t[:, element])
        follows = corner[(corner.index(nodes[0]) + 1) % 3] == nodes[2 % len(nodes)]
        return (nodes, closed) if follows else (_reversed(nodes, closed), closed)

    def _path(self, facets: Integers, name: str) -> tuple[Integers, bool]:
        vertices, closed = chain(self.mesh.facets[:, facets], name)
        onward = np.roll(vertices, -1) if closed else vertices[1:]
        mids = [self.mesh.nvertices + self._facet_of[a, b] for a, b in zip(vertices, onward, strict=False)]
        path = np.empty(len(vertices) + len(mids), dtype=np.int64)
        path[0::2], path[1::2] = vertices, mids
        return path, closed

    @cached_property
    def _facet_of(self) -> dict[tuple[int, int], int]:
        a, b = self.mesh.facets.tolist()
        return {pair: k for k, pair in enumerate(zip(a, b, strict=True))} | {
            pair: k for k, pair in enumerate(zip(b, a, strict=True))
        }

    # layers

    @cached_property
    def in_cortex(self) -> Booleans:
        """Whether each element is gray matter, shape (n_elements,)."""
        named = (self.mesh.subdomains or {}).get("cortex")
        if named is not None:
            mask = np.zeros(self.mesh.nelements, dtype=bool)
            mask[named] = True
            return mask
        centres = self.mesh.p[:, self.mesh.t].mean(1)
        return self.pial_curve.nearest(centres)[0] < self.thickness

    @cached_property
    def elements_through_cortex(self) -> float:
        """How many elements lie on top of each other in the cortex: T over the median depth they span."""
        gray = self.mesh.t[:, self.in_cortex]
        depth = self.pial_curve.nearest(self.mesh.p[:, gray.ravel()])[0].reshape(gray.shape)
        return float(self.thickness / np.median(np.ptp(depth, axis=0)))

    @cached_property
    def cortex(self) -> Band:
        """The cortical band as a mesh of its own, with the boundaries "pial" and "interface"."""
        return _submesh(self, np.flatnonzero(self.in_cortex))

    def spread(self, band: Band, values: Array, outside: float = float("nan")) -> Array:
        """Return nodal values of a band, (n_band_nodes,), at all nodes, (n_nodes,)."""
        everywhere = np.full(self.nodes.shape[1], outside)
        everywhere[band.nodes] = values
        return everywhere

    def part(self, elements: Integers) -> tuple[MeshTri2, Integers]:
        """Return some elements as a mesh with straight sides, and the node of the body per node of it."""
        vertices, local = np.unique(self.mesh.t[:, elements], return_inverse=True)
        mesh = MeshTri2.from_mesh(straight_mesh(self.mesh.p[:, vertices], local.reshape(3, -1)))
        facets = np.array([self._facet_of[a, b] for a, b in vertices[mesh.facets].T.tolist()])
        return mesh, np.concatenate([vertices, self.mesh.nvertices + facets])

    # integration

    @cached_property
    def _basis(self) -> Basis:
        return Basis(self.mesh, ElementTriP2(), intorder=4)

    @cached_property
    def quadrature(self) -> Quadrature:
        """Integration points of order 4, with everything that is computed on them once."""
        return Quadrature.of(self._basis)

    def at_quadrature(self, band: Band, values: Array) -> Array:
        """Return nodal values of a band, (n_band_nodes,), at the integration points, (q, e); zero outside."""
        everywhere = self.spread(band, values, outside=0.0)
        return np.asarray(np.einsum("aq,ae->qe", self.quadrature.shapes, everywhere[self.triangles]))

    @cached_property
    def depth(self) -> Array:
        """Distance y to the pial surface at the integration points, shape (q, e); m."""
        return self._foot[0]

    @cached_property
    def tangent(self) -> Array:
        """Unit tangent of the nearest pial point at the integration points, shape (2, q, e)."""
        return self._foot[1]

    @cached_property
    def arc(self) -> Array:
        """Arc length of the nearest pial point at the integration points, shape (q, e); m."""
        return self._foot[2]

    @cached_property
    def _foot(self) -> tuple[Array, Array, Array]:
        points = self.quadrature.points
        distance, tangent, arc = self.pial_curve.nearest(points.reshape(2, -1))
        shape = points.shape[1:]
        return distance.reshape(shape), tangent.reshape(2, *shape), arc.reshape(shape)

    # constraints

    @cached_property
    def fixed(self) -> Integers:
        """Fixed degrees of freedom 2·node + component, with those that only hold a free body in place.

        What holds it carries no force, as all static loads balance.
        """
        dofs = set(self.supported.tolist())
        return np.array(sorted(dofs | self._holds(dofs)), dtype=np.int64)

    @cached_property
    def supported(self) -> Integers:
        """Degrees of freedom 2·node + component that base and mirror prevent."""
        dofs: set[int] = set()
        if self.base == "clamped":
            nodes = self.boundary_path("base")[0]
            dofs |= set(2 * nodes) | set(2 * nodes + 1)
        for line in self._sliding:
            dofs |= set(2 * self.boundary_path(line)[0] + self._normal_axis(line))
        return np.array(sorted(dofs), dtype=np.int64)

    @property
    def _sliding(self) -> list[str]:
        """Boundaries without normal displacement."""
        return ["base"] * (self.base == "roller") + ["mirror"] * self.mirror

    def _holds(self, dofs: set[int]) -> set[int]:
        # each rigid motion that nothing else prevents is prevented at one degree of freedom near the middle
        centre = self.nodes.mean(1)
        middle = int(np.argmin(((self.nodes - centre[:, None]) ** 2).sum(0)))
        free_x, free_y = (not any(d % 2 == i for d in dofs) for i in (0, 1))
        if free_x and free_y:
            far = int(np.argmax(self.nodes[1] - np.abs(self.nodes[0] - self.nodes[0, middle])))
            return {2 * middle, 2 * middle + 1, 2 * far}
        return {2 * middle + (0 if free_x else 1)} if free_x or free_y else set()

    def _normal_axis(self, name: str) -> int:
        nodes = self.boundary_path(name)[0]
        spread = np.ptp(self.nodes[:, nodes], axis=1)
        axis = int(np.argmin(spread))
        if spread[axis] > 1e-9 * self.length:
            raise ValueError(
                f"boundary {name!r} is not a horizontal or vertical line (it spreads {spread[axis]:.3g} m), "
                'so it cannot slide on rollers; use base="clamped" or "free", or turn the body.'
            )
        return axis


def _reversed(nodes: Integers, closed: bool) -> Integers:
    return np.roll(nodes[::-1], 1) if closed else nodes[::-1].copy()


def by_node(vectors: Array) -> Array:
    """Return nodal vectors (2, n_nodes) as one, (2 n_nodes,), in the order 2·node + component."""
    return vectors.T.ravel()


def _submesh(body: Body, elements: Integers) -> Band:
    mesh = body.mesh
    part, nodes = body.part(elements)
    sides = {name: set(body.boundary_path(name)[0].tolist()) for name in mesh.boundaries}
    sides["interface"] = set(body.interface.tolist())
    edge = part.boundary_facets()
    named = {
        name: edge[[int(nodes[part.nvertices + f]) in side for f in edge]] for name, side in sides.items()
    }
    boundaries = {name: found for name, found in named.items() if len(found)}
    return Band(
        MeshTri2(
            np.ascontiguousarray(mesh.doflocs[:, nodes]), part.t, _boundaries=boundaries, validate=False
        ),
        nodes,
    )
