"""Half of Figure 3 by an explicit scheme as in the field's codes, until its index is off by 1 %. About 5 min.

    python tests/benchmarks/peer_explicit.py [--elements 6 9 12] [--steps 5000 10000 20000]

Same body, loads and growth as ours: linear triangles on the vertices of our meshes, the same neo-Hookean
energy with nodal averages of J in its volumetric part (Bonet and Burton 1998) against locking, central
differences with masses scaled so that every node has the same stable step, damping adapted to the slowest
mode (Underwood 1983), penalties between nodes and edges of the pial surface, at the mirror and the base line.
numpy only; the number of element updates says what a compiled code would take. Growth rises over four fifths
of the steps; "forces left" are those on free nodes at the end, over those of the tension.
"""

from argparse import ArgumentParser
from dataclasses import dataclass
from itertools import product
from time import process_time

import numpy as np
from common import CASES, THICKNESS, timed
from scipy.spatial import cKDTree

from turingfold import find_folds, self_intersections
from turingfold.cli.case import load_case
from turingfold.parts import TimeStep
from turingfold.results.measures import shape_numbers
from turingfold.results.surface import along_pial
from turingfold.solve.problem import Problem
from turingfold.terms.line import DeadLoad

INDEX = 1.4541  # of 12 elements through the cortex, 18 as long along it, and a core as fine as 0.05
SAFETY = 0.7  # of the largest stable step
RISE = 0.8  # share of the steps in which growth rises
TABLE = 41  # times at which growth is known; straight lines between
AGAIN = 50  # steps after which masses and pairs in contact are looked for again
NEAR = 0.2  # of an edge of the pial surface at rest: where contact begins
PUSH = 0.3  # of a node's stiffness, which a contact has
REACH = 1.5  # edges: how far pairs are looked for
FASTEST, SLOWEST = 0.5, 1e-3  # damping in a step, at most and at least


def scene(elements, along=1.0):
    """Return half of the case figure3."""
    given = {"elements": elements, "along": along, "halved": True}
    (found,) = load_case(CASES / "figure3.py").scenes(given, quick=False).values()
    return found


class Loads:
    """Growth of the triangles and forces on the vertices, by time: as our processes and tension have them."""

    def __init__(self, problem):
        body, start = problem.scene.body, problem.start()
        n, weights = body.mesh.nvertices, body.quadrature.weights
        times = np.linspace(0.0, 1.0, TABLE)
        states = [problem.processed(start, time) if time else start for time in times]
        self.growth = np.array([(s["growth"] * weights).sum(1) / weights.sum(0) for s in states])
        tangent = (body.tangent * weights).sum(1)
        self.tangent = tangent / np.hypot(*tangent)
        acting = [one for one in problem.potentials(states[-1], TimeStep(1.0)) if isinstance(one, DeadLoad)]
        forces = sum(one.forces for one in acting).reshape(-1, 2)
        ends = body.mesh.facets
        self.forces = forces[:n].T.copy()
        for side in ends:  # what pulls at the middle of an edge pulls at both of its ends
            for axis in (0, 1):
                self.forces[axis] += np.bincount(side, 0.5 * forces[n:, axis], n)

    def at(self, time):
        """Return growth factors along, across and out of the plane, (3, e), and forces, (2, n)."""
        place = min(time, 1.0) * (TABLE - 1)
        k = min(int(place), TABLE - 2)
        growth = self.growth[k] + (place - k) * (self.growth[k + 1] - self.growth[k])
        return growth, min(1.0, time / 0.1) * self.forces


@dataclass
class Triangles:
    """Linear triangles of a body with its moduli, in the state of growth that `grow` sets."""

    at: np.ndarray  # (3, e)
    inverse: np.ndarray  # (2, 2, e), of the edges at rest
    area: np.ndarray
    mu: np.ndarray
    kappa: np.ndarray
    n: int

    @classmethod
    def of(cls, problem):
        body, weights = problem.scene.body, problem.scene.body.quadrature.weights
        at, x = body.mesh.t, body.nodes[:, : body.mesh.nvertices]
        edges = np.stack([x[:, at[1]] - x[:, at[0]], x[:, at[2]] - x[:, at[0]]], axis=1)
        area = edges[0, 0] * edges[1, 1] - edges[0, 1] * edges[1, 0]
        inverse = np.stack([[edges[1, 1], -edges[0, 1]], [-edges[1, 0], edges[0, 0]]]) / area
        mu, kappa = ((m * weights).sum(0) / weights.sum(0) for m in problem.scene.terms[0].moduli(body))
        return cls(at, inverse, 0.5 * area, mu, kappa, x.shape[1])

    def grow(self, growth, tangent):
        """Take growth factors (3, e) along a tangent, (2, e)."""
        along, across, out = growth
        (tx, ty), D = tangent, self.inverse
        xx, yy = tx * tx / along + ty * ty / across, ty * ty / along + tx * tx / across
        xy = tx * ty * (1 / along - 1 / across)
        self.D = np.stack([D[:, 0] * xx + D[:, 1] * xy, D[:, 0] * xy + D[:, 1] * yy], axis=1)
        self.out, self.weights = 1 / out, self.area * along * across * out
        self.slopes = np.stack([-self.D[0] - self.D[1], self.D[0], self.D[1]])  # (3, 2, e)
        self.volumes = self._summed(np.broadcast_to(self.weights, self.at.shape))

    def stiffness(self, x):
        """Return a bound on each node's stiffness at places (2, n): the sums of its rows, (n,)."""
        F, J = self._deformed(x)
        C = self.out * _cofactor(F)
        turned = np.einsum("abe,ibe->iae", C, self.slopes)
        a = self.mu * J ** (-2 / 3)
        squeezed = self.kappa + 5 * a * ((F * F).sum((0, 1)) + self.out**2) / (9 * J**2)
        rows = a * np.abs(np.einsum("iae,jae->ije", self.slopes, self.slopes)).sum(1)
        rows += squeezed * np.abs(np.einsum("iae,jae->ije", turned, turned)).sum(1)
        return self._summed(self.weights * rows)

    def _deformed(self, x):
        """Return F*, (2, 2, e), and J* at places (2, n)."""
        corners = x[:, self.at]
        edges = corners[:, 1:] - corners[:, :1]
        F = edges[:, :1] * self.D[0] + edges[:, 1:] * self.D[1]
        J = (F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0]) * self.out
        if not J.min() > 0:
            raise FloatingPointError("a triangle turned over")
        return F, J

    def forces(self, x):
        """Return the forces of the elastic energy, (2, n), at places (2, n)."""
        F, J = self._deformed(x)
        volume = self._summed(np.broadcast_to(self.weights * J, self.at.shape)) / self.volumes
        pressure = self.kappa * (volume[self.at].mean(0) - 1.0)
        a = self.mu * J ** (-2 / 3)
        b = (pressure - a * ((F * F).sum((0, 1)) + self.out**2) / (3 * J)) * self.out
        P = a * F + b * _cofactor(F)
        P *= -self.weights
        each = P[:, :1] * self.slopes[:, 0] + P[:, 1:] * self.slopes[:, 1]  # (2, 3, e)
        return np.stack([self._summed(one) for one in each])

    def _summed(self, values):
        return np.bincount(self.at.ravel(), values.ravel(), self.n)


def _cofactor(F):
    return np.stack([[F[1, 1], -F[1, 0]], [-F[0, 1], F[0, 0]]])


class Walls:
    """Penalties between nodes and edges of the pial surface, the mirror x = 0 and the base line y = 0."""

    def __init__(self, body):
        self.nodes = body.pial[::2]
        x = body.nodes[:, self.nodes]
        self.edge = float(np.hypot(*np.diff(x)).mean())
        self.near = NEAR * self.edge
        # the tissue lies to the left or to the right of the path
        inner = body.nodes[:, body.mesh.t[:, body.mesh.f2t[0, body.mesh.boundaries["pial"][0]]]].mean(1)
        k = int(np.argmin(np.hypot(*(x - inner[:, None]))))
        k = min(k, x.shape[1] - 2)
        along, to = x[:, k + 1] - x[:, k], inner - x[:, k]
        self.side = -np.sign(along[0] * to[1] - along[1] * to[0])
        self.pairs = np.empty((2, 0), dtype=int)

    def look(self, x):
        """Find nodes and edges that are close and no neighbours, as places (2, n) are."""
        at = x[:, self.nodes]
        middles, longest = 0.5 * (at[:, 1:] + at[:, :-1]).T, float(np.hypot(*np.diff(at)).max())
        near = cKDTree(at.T).sparse_distance_matrix(
            cKDTree(middles), REACH * longest, output_type="coo_matrix"
        )
        node, edge = near.row, near.col
        apart = np.minimum(np.abs(node - edge), np.abs(node - edge - 1)) > 1
        self.pairs = np.stack([node, edge])[:, apart]

    def add(self, x, stiffness, forces):
        """Add what walls that are closer than `near` push with."""
        at, rigid = x[:, self.nodes], PUSH * stiffness[self.nodes]
        pushed = np.zeros_like(at)
        pushed[0] += rigid * np.clip(0.5 * self.near - at[0], 0, None)  # its image is as far beyond
        pushed[1] += rigid * np.clip(-at[1], 0, None)
        node, edge = self.pairs
        start, along = at[:, edge], at[:, edge + 1] - at[:, edge]
        length = np.hypot(*along)
        normal = self.side * np.stack([-along[1], along[0]]) / length
        to = at[:, node] - start
        share, gap = (to * along).sum(0) / length**2, (to * normal).sum(0)
        # beyond an edge's end the next one acts; far inside, the node belongs to the edge's own wall
        meets = (gap < self.near) & (gap > -2 * self.near) & (share >= 0) & (share <= 1)
        node, edge, share = node[meets], edge[meets], share[meets]
        push = np.minimum(rigid[node], np.minimum(rigid[edge], rigid[edge + 1])) * (self.near - gap[meets])
        for axis in (0, 1):
            force = push * normal[axis, meets]
            m = at.shape[1]
            pushed[axis] += np.bincount(node, force, m) - np.bincount(edge, (1 - share) * force, m)
            pushed[axis] -= np.bincount(edge + 1, share * force, m)
        forces[:, self.nodes] += pushed


def explicit(made, steps):
    """March the scene in so many steps; return the displacement of all nodes, (2, n), and the forces left."""
    problem = Problem(made)
    body, loads, triangles = made.body, Loads(problem), Triangles.of(problem)
    walls, n = Walls(body), body.mesh.nvertices
    rest = body.nodes[:, :n]
    free = np.ones(2 * n)
    free[problem.held[problem.held < 2 * n]] = 0.0
    free = free.reshape(n, 2).T
    x, v, damping = rest.copy(), np.zeros_like(rest), FASTEST
    before = None
    for step in range(steps):
        time = min(1.0, (step + 1) / (RISE * steps))
        if step % AGAIN == 0 or time < 1.0:
            growth, outer = loads.at(time)
            triangles.grow(growth, loads.tangent)
        if step % AGAIN == 0:
            stiffness = triangles.stiffness(x)
            mass = (1 + 2 * PUSH) * stiffness / (4 * SAFETY**2)
            walls.look(x)
        inner = triangles.forces(x)
        force = inner + outer
        walls.add(x, stiffness, force)
        force *= free
        if before is not None and step % 10 == 0:
            work, kinetic = float((v * (before - inner)).sum()), float((mass * v * v).sum())
            found = 2 * np.sqrt(max(work, 0.0) / kinetic) if kinetic > 0 else FASTEST
            damping = 0.9 * damping + 0.1 * min(max(found, SLOWEST), FASTEST)
        before = inner
        v = ((2 - damping) * v + 2 * force / mass) / (2 + damping)
        x += v
    u = np.empty_like(body.nodes)
    u[:, :n] = x - rest
    u[:, n:] = 0.5 * u[:, body.mesh.facets].sum(1)
    return u, float(np.linalg.norm(force) / np.linalg.norm(outer))


def told(elements, along, steps, ours):
    """March with so many elements and steps; return what came out in words."""
    made, began = scene(elements, along), process_time()
    try:
        u, left = explicit(made, steps)
    except FloatingPointError as error:
        return f"{error} after {process_time() - began:.3g} s"
    seconds = process_time() - began
    index = shape_numbers(made.body, u)["gyrification_index"]
    pial = along_pial(made.body, (made.body.nodes + u)[:, made.body.pial])
    folds, crossed = find_folds(pial, thickness=THICKNESS), self_intersections(pial[:, ::2], closed=False)
    return (
        f"{seconds:.3g} s, {seconds / ours:.3g} x ours, {made.body.mesh.nelements * steps:.2g} element "
        f"updates; {folds.count} sulci, {crossed} crossings, index {off(index)}, depth "
        f"{folds.depth / THICKNESS:.3f} T, forces left {left:.1e}"
    )


def off(index):
    return f"{index:.4f} ({100 * (index / INDEX - 1):+.2f} %)"


def main():
    parser = ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", type=float, nargs="+", default=[6, 9, 12], help="through the cortex")
    parser.add_argument("--along", type=float, default=1.0, help="elements along it over those across it")
    parser.add_argument("--steps", type=int, nargs="+", default=[5000, 10000, 20000])
    given = parser.parse_args()
    timed(scene(2))  # what the first run imports
    ours = timed(scene(3, 2.0))
    print(f"ours: {ours.seconds:.3g} s, index {off(ours.summary()['gyrification_index'])}")
    for elements, steps in product(given.elements, given.steps):
        print(f"explicit, {elements:g} elements, {steps} steps:", end=" ", flush=True)
        print(told(elements, given.along, steps, ours.seconds), flush=True)


if __name__ == "__main__":
    main()
