"""A path of growth and loads in NGSolve: energy by `Variation`, sparsecholesky, its symbolic part reused."""

import os
import sys
from pathlib import Path

import netgen.meshing as netgen
import ngsolve as ngs
import numpy as np
from common import GRAY, WHITE, Step
from ngsolve.comp import IntegrationRuleSpace
from scipy.sparse import csr_matrix, hstack, identity, vstack
from scipy.spatial import cKDTree

from turingfold.geometry.body import Body

ORDER = (0, 1, 2, 4, 5, 3)  # netgen's second-order triangle names its edges after the opposite corner
# the compiler that its kernels are built with is found by name, beside the interpreter
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])


class Peer:
    """The problem in NGSolve on the body's own mesh, curved edges and quadrature included."""

    name = "NGSolve"

    def __init__(self, body: Body, predict: bool, threads: int) -> None:
        self.predict, self.threads = predict, threads
        self.mesh = ngs.Mesh(_mesh(body))
        self.space = ngs.VectorH1(self.mesh, order=2, dirichlet="base")
        self.points = IntegrationRuleSpace(self.mesh, order=2)  # its rule is ours
        self.place = self._places(body)
        self.growth = [self._field(np.ones(body.quadrature.weights.shape)) for _ in range(3)]
        self.form = ngs.BilinearForm(self.space, symmetric=True)
        self.form += self._energy(body)
        self.free = np.array(list(self.space.FreeDofs()), dtype=bool)
        self.nodal = _nodal(self.mesh, body)

    def _places(self, body: Body) -> np.ndarray:
        """Return which of the body's integration points each of NGSolve's is."""
        at = ngs.GridFunction(self.points)
        found = []
        for coordinate in (ngs.x, ngs.y):
            at.Interpolate(coordinate)
            found.append(at.vec.FV().NumPy().copy())
        apart, place = cKDTree(body.quadrature.points.reshape(2, -1).T).query(np.transpose(found))
        assert apart.max() < 1e-12 * body.length
        assert len(np.unique(place)) == len(place)
        return np.asarray(place)

    def _field(self, values: np.ndarray) -> ngs.GridFunction:
        """Return a field of values at the integration points, (q, e)."""
        field = ngs.GridFunction(self.points)
        field.vec.FV().NumPy()[:] = values.ravel()[self.place]
        return field

    def _energy(self, body: Body) -> ngs.comp.SumOfIntegrals:
        """Return ∫ J_G ψ(F G⁻¹) dA, the trace with its out-of-plane entry."""
        mu = self.mesh.MaterialCF({"cortex": GRAY.mu, "core": WHITE.mu})
        kappa = self.mesh.MaterialCF({"cortex": GRAY.kappa, "core": WHITE.kappa})
        tangent = ngs.CF(tuple(self._field(values) for values in body.tangent))
        along, across, thick = self.growth
        eye = ngs.Id(2)
        inverse = 1 / across * eye + (1 / along - 1 / across) * ngs.OuterProduct(tangent, tangent)
        F = (eye + ngs.Grad(self.space.TrialFunction())) * inverse
        J, I1 = ngs.Det(F) / thick, ngs.InnerProduct(F, F) + 1 / thick**2
        density = mu / 2 * (I1 * J ** (-2 / 3) - 3) + kappa / 2 * (J - 1) ** 2
        grown = along * across * thick * density
        measure = ngs.dx(intrules=self.points.GetIntegrationRules())
        return ngs.Variation(grown.Compile(realcompile=True, wait=True) * measure)

    def run(self, steps: list[Step]) -> tuple[np.ndarray, int]:
        """Return the displacement of the nodes (2, n) and the iterations, down to the forces of each step."""
        ngs.SetNumThreads(self.threads)
        u = ngs.GridFunction(self.space)
        slope, direction, before = (u.vec.CreateVector() for _ in range(3))
        before[:] = 0.0
        inverse, iterations = None, 0
        with ngs.TaskManager():
            for step in steps:
                for field, values in zip(self.growth, step.growth, strict=True):
                    field.vec.FV().NumPy()[:] = values.ravel()[self.place]
                load = (self.nodal.T @ step.load.reshape(-1, 2)).T.ravel()
                if self.predict:
                    direction.data = u.vec - before
                    before.data = u.vec
                    u.vec.data += direction
                while True:
                    self.form.Apply(u.vec, slope)
                    slope.FV().NumPy()[:] -= load
                    if np.linalg.norm(slope.FV().NumPy()[self.free]) <= step.force:
                        break
                    self.form.AssembleLinearization(u.vec)
                    if inverse is None:
                        inverse = self.form.mat.Inverse(self.space.FreeDofs(), "sparsecholesky")
                    else:
                        inverse.Update()
                    direction.data = inverse * slope
                    u.vec.data -= direction
                    iterations += 1
        return (self.nodal @ u.vec.FV().NumPy().reshape(2, -1).T).T, iterations


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


def _nodal(mesh: ngs.Mesh, body: Body) -> csr_matrix:
    """Return the values at the body's nodes that NGSolve's functions have: of vertices, then of edges.

    A function of a vertex is linear, 1/2 in the middle of its edges, and that of an edge is a bubble.
    """
    space, vertices = ngs.H1(mesh, order=2), body.mesh.nvertices
    own = {tuple(sorted(ends)): k for k, ends in enumerate(body.mesh.facets.T.tolist())}
    edges = [tuple(sorted(vertex.nr for vertex in edge.vertices)) for edge in mesh.edges]
    rows = np.array([own[ends] for ends in edges])
    columns = np.array([space.GetDofNrs(ngs.NodeId(ngs.EDGE, k))[0] for k in range(len(edges))]) - vertices
    inner = int(np.flatnonzero(~np.isin(rows, body.mesh.boundary_facets()))[0])
    bubble = ngs.GridFunction(space)
    bubble.vec[vertices + int(columns[inner])] = 1.0
    height = bubble(mesh(*body.nodes[:, vertices + rows[inner]]))
    halves = np.repeat(0.5, 2 * len(edges))
    middle = csr_matrix((halves, (np.repeat(rows, 2), np.ravel(edges))), shape=(len(edges), vertices))
    bubbles = csr_matrix((np.full(len(edges), height), (rows, columns)), shape=(len(edges), len(edges)))
    return csr_matrix(
        vstack([hstack([identity(vertices), csr_matrix((vertices, len(edges)))]), hstack([middle, bubbles])])
    )
