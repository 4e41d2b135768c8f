"""The body: a triangle mesh with a pial surface, a cortex of given thickness and a base."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from skfem import Basis, ElementTriP2, MeshTri2

from ..arrays import Array, Booleans, Integers
from ..checks import one_of, positive
from .band import Band, band
from .changes import Changes
from .curve import Curve
from .paths import Curves, Path, paths
from .quadrature import Quadrature
from .supports import clamped, components, holds, sliding
from .triangles import check_elements, quadratic_mesh

BASES = ("clamped", "roller", "free")
SHARP, SIGMOID = LAYERS = ("sharp", "sigmoid")
HOLES = ("free", "clamped")
DEPTHS = ("thickness", "interface")


@dataclass(frozen=True, eq=False)
class Body:
    """A mesh whose boundary has a part named "pial" and, unless `base` is free, one named "base".

    mesh: straight or isoparametric quadratic triangles in m; straight ones become quadratic. A part named
    "mirror" makes it half of a mirror-symmetric body: there, displacement across the line is zero.
    Each may have several parts, as of several pieces of tissue. "hole" is the wall of ventricles.
    thickness: of the cortex, in m. Elements in the subdomain "cortex" are gray matter; without that name it
    is those with their centre less than `thickness` below the pial surface.
    base: "clamped" (no displacement), "roller" (none across the base line) or "free".
    layers: how moduli and growth change from gray to white matter: "sharp", between elements, or "sigmoid",
    by θ(y) = 1/(1 + exp(10 (y/T - 1))) of the depth y (Choi et al. 2025).
    hole: "free" or "clamped" walls of ventricles.
    depth_by: how deep a point is as a share of the cortex: "thickness", its distance y to the pial surface
    over `thickness`; "interface", d_pial/(d_pial + d_white), for a cortex of varying thickness.
    changes: what was changed of measured curves to make the body.
    Raises ValueError for missing parts, wrong lengths, inverted or degenerate triangles.
    """

    mesh: MeshTri2
    thickness: float
    base: str = "clamped"
    layers: str = SHARP
    hole: str = "free"
    depth_by: str = "thickness"
    changes: Changes | None = None

    order: ClassVar[int] = 4  # of polynomials that are integrated exactly

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness", positive("thickness", self.thickness))
        one_of("base", self.base, BASES)
        one_of("layers", self.layers, LAYERS)
        one_of("hole", self.hole, HOLES)
        one_of("depth_by", self.depth_by, DEPTHS)
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
        _ = self.pial_paths, self.supported  # both refuse some bodies
        if self.depth_by == "interface":
            _ = self.interface_paths

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

    def boundary_paths(self, name: str) -> tuple[Path, ...]:
        """Return the parts of a named boundary, the longest first, with the tissue on their left."""
        facets = (self.mesh.boundaries or {}).get(name, np.zeros(0, dtype=np.int64))
        everywhere = np.ones(self.mesh.nelements, dtype=bool)
        return paths(self.mesh, np.asarray(facets), everywhere, f"boundary {name!r}")

    def boundary_path(self, name: str) -> tuple[Integers, bool]:
        """Return the nodes of a named boundary with the tissue on its left, and whether it is closed.

        Raises ValueError for a boundary in several parts.
        """
        path = _only(self.boundary_paths(name), f"boundary {name!r}", f"boundary_paths({name!r})")
        return path.nodes, path.closed

    @cached_property
    def pial_paths(self) -> tuple[Path, ...]:
        """The parts of the pial surface: of each piece of tissue, and closed-off sulci; the longest first."""
        return self.boundary_paths("pial")

    @cached_property
    def interface_paths(self) -> tuple[Path, ...]:
        """The parts of the gray-white interface, the longest first, with white matter on their left."""
        f2t, gray = self.mesh.f2t, self.in_cortex
        inner = f2t[1] >= 0
        across = np.flatnonzero(inner & (gray[f2t[0]] != gray[np.where(inner, f2t[1], 0)]))
        if across.size == 0:
            raise ValueError(
                f"thickness={self.thickness:g} leaves no white matter: there is no gray-white interface."
            )
        return paths(self.mesh, across, ~gray, "the gray-white interface")

    @property
    def pial(self) -> Integers:
        """Nodes along the pial surface, tissue on the left; (n_pial,). ValueError if it has several parts."""
        return self._pial.nodes

    @cached_property
    def _pial(self) -> Path:
        return _only(self.pial_paths, "the pial surface", "pial_paths")

    @cached_property
    def pial_curve(self) -> Curve:
        """The pial surface before deformation. ValueError if it has several parts."""
        return Curve(self.nodes[:, self._pial.nodes], self._pial.closed)

    @cached_property
    def pial_curves(self) -> Curves:
        """All parts of the pial surface before deformation."""
        return Curves(tuple(Curve(self.nodes[:, path.nodes], path.closed) for path in self.pial_paths))

    @property
    def pial_arc(self) -> Array:
        """Arc length along the undeformed pial surface, shape (n_pial,); m."""
        return self.pial_curve.arc

    def pial_share(self, arc: Array) -> Array:
        """Return arc lengths as shares of the whole pial surface; half a body has the first half of it."""
        return arc / (self.pial_curves.length * (2.0 if self.mirror else 1.0))

    @cached_property
    def first_arcs(self) -> tuple[float, ...]:
        """On each part of the pial surface the arc length where its shares count from, m.

        On closed ones it is that of the outline's first point: where the mesh starts a part is by chance.
        Bodies that no outline made have nothing else, and open parts count from their end: 0.
        """
        starts, found = np.array(self.changes.starts if self.changes else ()), []
        for curve in self.pial_curves.parts:
            found.append(0.0)
            if curve.closed and len(starts):
                away, _, arc = curve.nearest(starts.T)
                k = int(np.argmin(away))
                found[-1] = float(arc[k]) if away[k] < self.thickness else 0.0
        return tuple(found)

    def share_from_start(self, arc: Array) -> Array:
        """Return arc lengths on the only part of the pial surface as shares counted from its start.

        Counter-clockwise, from the outline's first point on a closed one, see `first_arcs`.
        """
        share = self.pial_share(arc - self.first_arcs[0])
        return share % 1.0 if self.pial_curve.closed else share

    @cached_property
    def interface(self) -> Integers:
        """Nodes along the gray-white interface, in the direction of the pial surface; (n_interface,).

        ValueError if it has several parts.
        """
        return _only(self.interface_paths, "the gray-white interface", "interface_paths").nodes

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
        return self.pial_curves.nearest(centres)[0] < self.thickness

    @cached_property
    def elements_through_cortex(self) -> float:
        """How many elements lie on top of each other in the cortex: T over the median depth they span."""
        gray = self.mesh.t[:, self.in_cortex]
        depth = self.pial_curves.nearest(self.mesh.p[:, gray.ravel()])[0].reshape(gray.shape)
        return float(self.thickness / np.median(np.ptp(depth, axis=0)))

    @cached_property
    def cortex(self) -> Band:
        """The cortical band as a mesh of its own, with the boundaries "pial" and "interface"."""
        lines = {name: self.boundary_paths(name) for name in self.mesh.boundaries}
        lines["interface"] = self.interface_paths
        return band(self.mesh, np.flatnonzero(self.in_cortex), lines)

    def spread(self, band: Band, values: Array, outside: float = float("nan")) -> Array:
        """Return nodal values of a band, (n_band_nodes,), at all nodes, (n_nodes,)."""
        everywhere = np.full(self.nodes.shape[1], outside)
        everywhere[band.nodes] = values
        return everywhere

    # integration

    @cached_property
    def _basis(self) -> Basis:
        return Basis(self.mesh, ElementTriP2(), intorder=self.order)

    @cached_property
    def quadrature(self) -> Quadrature:
        """Integration points of its `order`, with everything that is computed on them once."""
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
    def relative_depth(self) -> Array:
        """Depth as a share of the cortical thickness at the integration points: 1 at the interface; (q, e).

        y/T, or by both surfaces d_pial/(d_pial + d_white), d the distances, that to the interface negative in
        white matter.
        """
        if self.depth_by == "thickness":
            return self.depth / self.thickness
        curves = tuple(Curve(self.nodes[:, path.nodes], path.closed) for path in self.interface_paths)
        points = self.quadrature.points
        distance = Curves(curves).nearest(points.reshape(2, -1))[0].reshape(points.shape[1:])
        between = self.depth + np.where(self.in_cortex, distance, -distance)
        return np.asarray(self.depth / np.maximum(between, 1e-9 * self.length))

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
        distance, tangent, arc = self.pial_curves.nearest(points.reshape(2, -1))
        shape = points.shape[1:]
        return distance.reshape(shape), tangent.reshape(2, *shape), arc.reshape(shape)

    # constraints

    @cached_property
    def fixed(self) -> Integers:
        """Fixed degrees of freedom 2·node + component, with those that only hold free parts in place."""
        return np.union1d(self.supported, holds(self.nodes, components(self.triangles), self.supported))

    @cached_property
    def supported(self) -> Integers:
        """Degrees of freedom 2·node + component that base, mirror and clamped holes prevent."""
        kinds = {"base": self.base, "hole": self.hole, "mirror": "roller"}
        dofs = np.zeros(0, dtype=np.int64)
        for name, kind in kinds.items():
            if kind == "clamped":
                dofs = np.union1d(dofs, clamped(self.boundary_paths(name)))
            elif kind == "roller":
                across = sliding(self.nodes, self.boundary_paths(name), name, 1e-9 * self.length)
                dofs = np.union1d(dofs, across)
        return dofs


def _only(found: tuple[Path, ...], name: str, plural: str) -> Path:
    if len(found) != 1:
        raise ValueError(
            f"{name} has {len(found)} parts, and one is needed here; the body's {plural} has all."
        )
    return found[0]


def by_node(vectors: Array) -> Array:
    """Return nodal vectors (2, n_nodes) as one, (2 n_nodes,), in the order 2·node + component."""
    return vectors.T.ravel()
