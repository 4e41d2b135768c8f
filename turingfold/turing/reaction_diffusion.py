"""A reaction–diffusion system on a triangle mesh: M ∂w/∂t = M f(w) − D K w with zero flux.

w holds u and v at the nodes, shape (2, n_nodes); M and K are mass and stiffness. Reactions are evaluated at
the nodes and interpolated, so that their Jacobian is M times a diagonal and uniform states react exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csc_array, csr_array, diags_array
from skfem import Basis, ElementTriP1, ElementTriP2, MeshTri1, MeshTri2
from skfem.models.poisson import laplace, mass

from ..arrays import Array
from ..checks import finite_array, positive
from ..geometry.triangles import straight_mesh
from .kinetics.base import Kinetics
from .linear.direct import Blocks, Solver, Sparsity
from .linear.multigrid import TwoLevel, prolongation

LARGE = 40_000  # linear nodes from which two levels beat a factorisation; see multigrid.py


@dataclass(frozen=True, eq=False)
class Discretisation:
    """Mass and stiffness of scalar finite elements on a mesh.

    nodes: positions (2, n_nodes).  mass, stiffness: (n_nodes, n_nodes), of one sparsity.
    edge: of the equilateral triangle as large as the largest element, same unit as the nodes.
    degree: of the elements, 1 or 2.
    """

    nodes: Array
    mass: csc_array
    stiffness: csc_array
    edge: float
    degree: int

    @property
    def size(self) -> int:
        """Number of nodes."""
        return int(self.nodes.shape[1])

    @cached_property
    def weights(self) -> Array:
        """Integral of each shape function, shape (n_nodes,); their sum is the area."""
        return np.asarray(self.mass.sum(axis=0), dtype=np.float64).ravel()

    @property
    def area(self) -> float:
        """Area of the mesh."""
        return float(self.weights.sum())

    def mean(self, values: Array) -> Array:
        """Return the mean over the area of nodal values, shape (..., n_nodes) to (...)."""
        return np.asarray(values @ self.weights / self.area)

    @cached_property
    def sparsity(self) -> Sparsity:
        """Where the matrices have entries."""
        indices, indptr = (part.astype(np.int64) for part in (self.mass.indices, self.mass.indptr))
        return Sparsity(indices, indptr, self.nodes)

    @cached_property
    def coarse(self) -> tuple[csr_array, Discretisation]:
        """Interpolation from aggregates of about nine nodes, (n_nodes, n_coarse), and the space they span."""
        up = prolongation(self.stiffness)
        down = csr_array(up.T)
        mass, stiffness = _one_sparsity(*(down @ matrix @ up for matrix in (self.mass, self.stiffness)))
        nodes = (down @ self.nodes.T).T / np.asarray(down.sum(axis=1)).ravel()
        return up, Discretisation(nodes, mass, stiffness, self.edge, self.degree)


def _one_sparsity(mass: csc_array, stiffness: csc_array) -> tuple[csc_array, csc_array]:
    both = csc_array(mass + 1j * stiffness)  # one sum, one sparsity
    both.sort_indices()
    real, imaginary = (
        csc_array((part.copy(), both.indices, both.indptr)) for part in (both.data.real, both.data.imag)
    )
    return real, imaginary


def discretise(mesh: MeshTri1, degree: int = 2, *, lumped: bool = False) -> Discretisation:
    """Assemble mass and stiffness on a triangle mesh.

    degree: 1 for linear elements on the straight triangles, 2 for isoparametric quadratic ones.
    lumped: put the mass of linear elements on the diagonal, which keeps concentrations positive where no
    triangle is obtuse.
    """
    if degree not in (1, 2):
        raise ValueError(f"degree={degree!r} must be 1 or 2.")
    if lumped and degree == 2:
        raise ValueError(
            "lumped=True needs degree=1: lumped quadratic elements have no mass at the vertices."
        )
    if degree == 1:
        nodes = np.asarray(mesh.p[:, : mesh.nvertices], dtype=float)
        basis = Basis(straight_mesh(nodes, mesh.t), ElementTriP1(), intorder=2)
    else:
        curved = mesh if isinstance(mesh, MeshTri2) else MeshTri2.from_mesh(mesh)
        basis = Basis(curved, ElementTriP2(), intorder=6)  # exact for the mass on curved triangles
        nodes = np.asarray(curved.doflocs, dtype=float)
    matrix = mass.assemble(basis)
    if lumped:
        matrix = diags_array(np.asarray(matrix.sum(axis=0)).ravel())
    parts = _one_sparsity(matrix, laplace.assemble(basis))
    largest = float(np.abs(basis.dx.sum(axis=1)).max())
    edge = float(np.sqrt(4 * largest / np.sqrt(3)))
    return Discretisation(nodes, parts[0], parts[1], edge, degree)


@dataclass(frozen=True, eq=False)
class ReactionDiffusion:
    """Two morphogens on a discretised mesh; diffusivities in mesh units² per unit of the kinetics' time."""

    space: Discretisation
    kinetics: Kinetics
    d_u: float
    d_v: float

    def __post_init__(self) -> None:
        """Check the diffusivities."""
        positive("d_u", self.d_u)
        positive("d_v", self.d_v)

    def uniform(self, u: float, v: float) -> Array:
        """Return a uniform state, shape (2, n_nodes)."""
        return np.repeat([[u], [v]], self.space.size, axis=1)

    def check(self, state: Array) -> Array:
        """Return the state as an array if it has two finite values per node."""
        return finite_array("state (u, v)", state, (2, self.space.size))

    def rate(self, state: Array) -> Array:
        """Return M f(w) − D K w, the rate of change times the mass; shape (2, n_nodes)."""
        return self.times_mass(np.stack(self.kinetics.rates(*state))) - self.diffusion(state)

    def diffusion(self, state: Array) -> Array:
        """Return D K w, shape (2, n_nodes)."""
        return np.asarray((self.space.stiffness @ (state.T * [self.d_u, self.d_v])).T)

    def _blocks(self, state: Array, shift: float) -> Blocks:
        space, at = self.space, self.space.sparsity.columns
        m, k = space.mass.data, space.stiffness.data
        p_u, p_v, q_u, q_v = (derivative[at] for derivative in self.kinetics.derivatives(*state))
        uu, vv = m * (shift - p_u) + self.d_u * k, m * (shift - q_v) + self.d_v * k
        return uu, -m * p_v, -m * q_u, vv

    def matrix(self, state: Array, shift: float = 0.0) -> csc_array:
        """Return shift·M − ∂rate/∂w, the unknowns in the order u₀ v₀ u₁ v₁ ..."""
        return self.space.sparsity.coupled(self._blocks(state, shift))

    def solver(self, state: Array, shift: float = 0.0) -> Solver:
        """Factorise shift·M − ∂rate/∂w; the function returned maps (2, n_nodes) to (2, n_nodes)."""
        return self.space.sparsity.coupled_solver(self._blocks(state, shift))

    def quick_solver(self, state: Array, shift: float, tolerance: float) -> Solver:
        """Return such a solver that, on LARGE linear meshes, iterates to a residual below tolerance·|right|.

        Quadratic elements are factorised: on two levels they need 31 cycles where linear ones need 10.
        """
        if self.space.size < LARGE or self.space.degree == 2:
            return self.solver(state, shift)
        up, space = self.space.coarse
        means = (up.T @ state.T / np.asarray(up.sum(axis=0))[:, None]).T
        coarse = ReactionDiffusion(space, self.kinetics, self.d_u, self.d_v).solver(means, shift)
        matrix = self.matrix(state, shift)
        return TwoLevel(matrix, up, coarse, tolerance, lambda: self.solver(state, shift))

    def times_mass(self, state: Array) -> Array:
        """Return M w, shape (2, n_nodes)."""
        return np.asarray((self.space.mass @ state.T).T)
