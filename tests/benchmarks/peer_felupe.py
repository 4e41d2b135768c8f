"""A path of growth and loads in FElupe: its hand-written neo-Hookean solid, and SuperLU in symmetric mode."""

import felupe
import numpy as np
from common import GRAY, WHITE, Step
from scipy.sparse.linalg import splu

from turingfold.geometry.body import Body

SYMMETRIC = {
    "permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}
}  # fmt: skip


class Triangle(felupe.QuadraticTriangle):
    """FElupe's quadratic triangle, whose last function, 4s(1-r-s), has a wrong derivative in 11.3.0."""

    def gradient(self, rs: np.ndarray) -> np.ndarray:
        r, s = rs
        t = 1 - r - s
        return np.array(
            [[1 - 4 * t, 1 - 4 * t], [4 * r - 1, 0], [0, 4 * s - 1], [4 * (t - r), -4 * r], [4 * s, 4 * r],
             [-4 * s, 4 * (t - s)]]
        )  # fmt: skip


class Grown:
    """FElupe's neo-Hookean material seen from the grown state: F* = I + ∂u/∂X G⁻¹ + (G⁻¹ - I)."""

    def __init__(self) -> None:
        self.law = felupe.NeoHooke(mu=GRAY.mu, bulk=GRAY.kappa)
        self.x = self.law.x
        self.shift: np.ndarray | float = 0.0

    def gradient(self, x: list, **options: object) -> list:
        return self.law.gradient([x[0] + self.shift, *x[1:]], **options)

    def hessian(self, x: list, **options: object) -> list:
        return self.law.hessian([x[0] + self.shift, *x[1:]], **options)


class Peer:
    """The problem in FElupe on the body's own mesh and quadrature.

    Growth goes into the region's gradients and volumes, so that its material and assembly run as they are.
    So does the ratio of the two layers' moduli, one number as they have the same Poisson ratio: FElupe works
    through the elements in chunks that fit the cache, but only with moduli that are the same everywhere.
    """

    name = "FElupe"

    def __init__(self, body: Body, predict: bool, threads: int) -> None:
        self.predict, self.parallel, self.body = predict, threads > 1, body
        mesh = felupe.Mesh(body.nodes.T.copy(), body.triangles.T.copy(), "triangle6")
        basis = body._basis
        rule = felupe.quadrature.Scheme(basis.X.T.copy(), basis.W.copy())
        self.region = felupe.Region(mesh, Triangle(), rule)
        self.slopes, self.areas = self.region.dhdX.copy(), self.region.dV.copy()
        self.free = np.setdiff1d(np.arange(body.nodes.size), body.fixed)

    def grow(self, growth: np.ndarray, material: Grown) -> None:
        """Pull the region's gradients and areas back to the state grown by factors (3, q, e)."""
        along, across, thick = growth
        t = self.body.tangent
        shift = np.zeros((3, 3, *along.shape))
        shift[:2, :2] = (1 / along - 1 / across) * t[:, None] * t[None]
        shift[0, 0] += 1 / across - 1
        shift[1, 1] += 1 / across - 1
        shift[2, 2] = 1 / thick - 1
        self.region.dhdX = self.slopes + np.einsum("akqe,kjqe->ajqe", self.slopes, shift[:2, :2])
        ratio = np.where(self.body.in_cortex, 1.0, WHITE.mu / GRAY.mu)
        self.region.dV = self.areas * along * across * thick * ratio
        material.shift = shift

    def run(self, steps: list[Step]) -> tuple[np.ndarray, int]:
        """Return the displacement of the nodes (2, n) and the iterations, down to the forces of each step."""
        material = Grown()
        field = felupe.FieldContainer([felupe.FieldPlaneStrain(self.region, dim=2)])
        solid = felupe.SolidBody(material, field)
        u = field[0].values
        before, iterations = np.zeros_like(u), 0
        for step in steps:
            self.grow(step.growth, material)
            load = step.load[self.free]
            if self.predict:
                ahead = u - before
                before = u.copy()
                u += ahead
            while True:
                slope = solid.assemble.vector(field, parallel=self.parallel).toarray().ravel()[self.free]
                slope -= load
                if np.linalg.norm(slope) <= step.force:
                    break
                tangent = solid.assemble.matrix(field, parallel=self.parallel).tocsc()
                factor = splu(tangent[self.free][:, self.free], **SYMMETRIC)
                u.reshape(-1)[self.free] -= factor.solve(slope)
                iterations += 1
        return u.T.copy(), iterations
