"""The growth path in NGSolve: energy by `Variation`, sparsecholesky with its symbolic part reused."""

import os
import sys
from pathlib import Path

import netgen.meshing as netgen
import ngsolve as ngs
import numpy as np
from common import GRAY, GROWTH, STEPS, WHITE

from turingfold.geometry.body import Body

ORDER = (0, 1, 2, 4, 5, 3)  # netgen's second-order triangle names its edges after the opposite corner
# the compiler that its kernels are built with is found by name, beside the interpreter
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])


class Peer:
    """The problem in NGSolve on the body's own mesh, curved edges and quadrature included."""

    name = "NGSolve"

    def __init__(self, body: Body, predict: bool, threads: int) -> None:
        self.predict, self.threads = predict, threads
        self.vertices = body.mesh.nvertices
        self.growth = ngs.Parameter(1.0)
        mesh = ngs.Mesh(_mesh(body))
        self.space = ngs.VectorH1(mesh, order=2, dirichlet="base")
        self.form = ngs.BilinearForm(self.space, symmetric=True)
        self.form += self._energy(mesh, body)
        self.free = np.array(list(self.space.FreeDofs()), dtype=bool)

    def _energy(self, mesh: ngs.Mesh, body: Body) -> ngs.comp.SumOfIntegrals:
        """Return ∫ J_G ψ(F G⁻¹) dA, the trace with its out-of-plane entry."""
        along = mesh.MaterialCF({"cortex": self.growth, "core": 1.0})
        mu = mesh.MaterialCF({"cortex": GRAY.mu, "core": WHITE.mu})
        kappa = mesh.MaterialCF({"cortex": GRAY.kappa, "core": WHITE.kappa})
        tangent = ngs.CF((-ngs.y, ngs.x)) / ngs.sqrt(ngs.x**2 + ngs.y**2)
        eye = ngs.Id(2)
        inverse = eye + (1 / along - 1) * ngs.OuterProduct(tangent, tangent)
        F = (eye + ngs.Grad(self.space.TrialFunction())) * inverse
        J, I1 = ngs.Det(F), ngs.InnerProduct(F, F) + 1
        density = along * (mu / 2 * (I1 * J ** (-2 / 3) - 3) + kappa / 2 * (J - 1) ** 2)
        basis = body._basis
        rule = ngs.IntegrationRule([tuple(point) for point in basis.X.T], list(basis.W))
        measure = ngs.dx(intrules={ngs.ET.TRIG: rule})
        return ngs.Variation(density.Compile(realcompile=True, wait=True) * measure)

    def run(self, forces: list[float]) -> tuple[np.ndarray, int]:
        """Return the displacement of the vertices (2, n) and the iterations, down to the given forces."""
        ngs.SetNumThreads(self.threads)
        u = ngs.GridFunction(self.space)
        slope, direction, before = (u.vec.CreateVector() for _ in range(3))
        before[:] = 0.0
        inverse, iterations = None, 0
        with ngs.TaskManager():
            for step, force in enumerate(forces, start=1):
                self.growth.Set(1 + (GROWTH - 1) * step / STEPS)
                if self.predict:
                    direction.data = u.vec - before
                    before.data = u.vec
                    u.vec.data += direction
                while True:
                    self.form.Apply(u.vec, slope)
                    if np.linalg.norm(slope.FV().NumPy()[self.free]) <= force:
                        break
                    self.form.AssembleLinearization(u.vec)
                    if inverse is None:
                        inverse = self.form.mat.Inverse(self.space.FreeDofs(), "sparsecholesky")
                    else:
                        inverse.Update()
                    direction.data = inverse * slope
                    u.vec.data -= direction
                    iterations += 1
        values = u.vec.FV().NumPy().reshape(2, -1)
        return values[:, : self.vertices].copy(), iterations


def _mesh(body: Body) -> netgen.Mesh:
    mesh = netgen.Mesh(dim=2)
    points = [mesh.Add(netgen.MeshPoint(netgen.Pnt(x, y, 0.0))) for x, y in body.nodes.T]
    regions = [mesh.AddRegion(name, dim=2) for name in ("core", "cortex")]
    for gray, triangle in zip(body.in_cortex, body.triangles.T[:, ORDER], strict=True):
        mesh.Add(netgen.Element2D(regions[int(gray)], [points[node] for node in triangle]))
    for name in ("base", "pial"):
        index = mesh.AddRegion(name, dim=1)
        for ends in body.mesh.facets[:, body.mesh.boundaries[name]].T:
            mesh.Add(netgen.Element1D([points[node] for node in ends], index=index))
    return mesh
