"""Diffusion from a boundary into a body, at any time and without steps in time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementTriP2, LinearForm
from skfem.helpers import dot, grad

from ..arrays import Array, Complexes, Integers
from ..geometry.body import Body

SPAN = 16.0  # ratio of the last to the first time that one contour serves
POINTS = 16  # of a contour: the error is then 1e-6, by a factor of 2.5 less with each more
OPENING = 0.9917  # of the contour's asymptotes, rad; the best one for this span
_REACH = np.arccosh(
    ((np.pi - 2 * OPENING) * SPAN + 4 * OPENING - np.pi) / ((4 * OPENING - np.pi) * np.sin(OPENING))
)
_U = (np.arange(POINTS) + 0.5) * _REACH / POINTS
# on the contour that serves times from 1/SPAN to 1: z, and dz/du times the step in u over π
Z = (4 * np.pi * OPENING - np.pi**2) / _REACH * POINTS * (1 + np.sin(1j * _U - OPENING))
DZ = (4 * np.pi * OPENING - np.pi**2) / np.pi * 1j * np.cos(1j * _U - OPENING)


@dataclass(frozen=True, eq=False)
class Diffusion:
    """The solution of ∂c/∂t = D ∇²c with c = 0 at t = 0, c = 1 at the source, no flux through the rest.

    On quadratic elements, M ẇ + D K w = 0 for w = c - 1. Its solution is the contour integral
    w(t) = 1/(2πi) ∫ e^{zt} (z M + D K)⁻¹ M w(0) dz, by the midpoint rule on a hyperbola round the negative
    real axis, to 1e-6 at any time: no error adds up, and no earlier time is needed.
    source: nodes at which c = 1.  diffusivity: D, m² per unit of time.
    Source: Weideman, Trefethen (2007) Math. Comp. 76:1341.
    """

    body: Body
    source: Integers
    diffusivity: float
    # what the solves of a contour found, by the power of SPAN at its last time
    _found: dict[int, Complexes] = field(default_factory=dict, init=False, repr=False)

    def at(self, time: float) -> Array:
        """Return c at the nodes, (n_nodes,); not clipped, so that thin fronts may overshoot."""
        c = np.zeros(self.body.nodes.shape[1])
        if time > 0:
            window = int(np.ceil(np.log(time) / np.log(SPAN)))
            last = SPAN**window
            if window not in self._found:
                self._found[window] = self._solved(last)
            weights = np.exp(Z * time / last) * DZ / last
            c += 1.0 + np.imag(weights @ self._found[window])
            c[self.source] = 1.0
        return c

    def _solved(self, last: float) -> Complexes:
        """Return (z M + D K)⁻¹ M w(0) at the points of a contour, (POINTS, n_nodes)."""
        basis = Basis(self.body.mesh, ElementTriP2(), intorder=4)
        mass = BilinearForm(lambda u, v, _: u * v).assemble(basis)
        flux = self.diffusivity * BilinearForm(lambda u, v, _: dot(grad(u), grad(v))).assemble(basis)
        free = np.setdiff1d(np.arange(basis.N), self.source)
        right = -LinearForm(lambda v, _: 1.0 * v).assemble(basis)[free].astype(complex)
        found = np.zeros((POINTS, basis.N), dtype=complex)
        for k, z in enumerate(Z / last):
            # turned by a phase, its real part is positive definite: no pivots are needed
            matrix = csc_matrix((z * mass + flux)[free][:, free])
            lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                      options={"SymmetricMode": True})  # fmt: skip
            found[k, free] = lu.solve(right)
        return found
