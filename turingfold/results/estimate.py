"""How far numbers of a state are off: what a mesh with half the element size changes of them.

The equilibrium u of a body, with tangent K, is carried over to the mesh whose triangles are split into four
(matrix I). There, forces r(I u) are left. The new nodes, W, answer them locally and the body to what that
changes of its balance (two-level hierarchical estimate; Bank and Smith 1993, SIAM J. Numer. Anal. 30, 921):

    e_W = -K_WW⁻¹ r_W,     e = e_W - I K⁻¹ Iᵀ (r + K' e_W),

K_WW the tangent of the finer mesh with its negative parts taken away, K' e_W a difference of its forces. It
takes no factorisation on the finer mesh. A number J is off by J(I u + e) - J(u), the energy by what its
quadrature and its contact change and ½ r·e; of an error of order p, that is the share 1 - 2⁻ᵖ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import LinearOperator, cg

from ..arrays import Array, Integers
from ..geometry.body import Body
from ..geometry.refinement import at_finer_points, prolongation, refined
from ..solve.newton import Minimiser
from ..solve.problem import Configuration, Problem, configuration
from ..solve.sparsity import Assembler
from ..state import State
from .carried import NoEstimateError, at_rest, forces_of, on_another_body, refuse_motion, solution
from .measures import shape_numbers

BEYOND = 1.5  # 1/(1 - 2⁻ᵖ) is 2 at creases and corners, of order 1, 1.14 of order 3: their geometric mean
OF_FOLDS, IN_CREASES = ("gyrification_index", "sulcal_depth"), 2.0  # folds end in creases, of order 1
# where a surface ends at a clamp, displacements are as r^0.595 (clamped and free side at a right angle, plane
# strain, ν = 1/2; Williams 1952, J. Appl. Mech. 19, 526), and the length of its last edge is off as h^0.595
AT_CLAMPS = 1 / (1 - 2**-0.595)
# at a clamped end the energy's error falls with order 0.7, and the local answer of the finer mesh has half of
# what that mesh changes. Both were chosen after seeing them where a cortex grows against a clamp, on half
# discs whose triangles were split into four three times
ENERGY_AT_CLAMPS, REACH = 2 / (1 - 2**-0.71), 1.5  # and how far from a clamped end that is, thicknesses
FARTHEST = 1.0  # cortical thicknesses that the finer mesh may move a node for the estimate to mean anything
NUDGE = 1e-6  # cortical thicknesses by which nodes move for a difference of forces
LOCAL, PATIENCE = 1e-3, 60  # residual and Newton iterations of the new nodes' answer
ENERGY, LENGTH = "energy", "perimeter"
Numbers = dict[str, float]


def estimated(problem: Problem, state: State) -> Numbers:
    """Return by how much energy (J/m), pial length (m), gyrification index and sulcal depth (m) are off.

    They are the errors of the mesh: of its elements, its quadrature and the distance that contact keeps.
    What the steps leave is told by `step_errors`.
    Raises NoEstimateError where terms resist motion, as errors then add up over all steps; where the finer
    mesh cannot take the state; and where it would move the body far.
    """
    refuse_motion(problem.scene)
    body = problem.scene.body
    at = at_rest(problem, state)
    finer = _Finer.of(problem, state)
    assembler = Assembler(problem.n_dofs, problem.held)
    solve = solution(*assembler.assemble(at.hessians(0.0)), problem.scene)
    local = finer.locally_balanced()
    whole = np.zeros(problem.n_dofs)
    whole[assembler.free] = -solve(finer.restricted(local.forces)[assembler.free])
    move = finer.prolonged(whole)
    e = local.move + move
    farthest = float(np.abs(e).max()) / body.thickness
    if not farthest <= FARTHEST:
        raise NoEstimateError(f"a finer mesh would move the body by {farthest:.2g} cortical thicknesses")
    there = (finer.at.x + e).reshape(-1, 2).T
    before, after = shape_numbers(body, state["displacement"]), shape_numbers(finer.body, there)
    off = {name: after[name] - before[name] for name in before}
    off[ENERGY] = local.energy - at.energy + 0.5 * float(local.forces @ move)
    clamps = _length_at_clamps(finer.body, there, 4) - _length_at_clamps(body, state["displacement"], 2)
    off[LENGTH] -= clamps
    work = finer.work_at_clamps(local.move)
    off[ENERGY] -= work
    found = {n: (IN_CREASES if n in OF_FOLDS else BEYOND) * abs(value) for n, value in off.items()}
    found[LENGTH] += AT_CLAMPS * abs(clamps)
    found[ENERGY] += ENERGY_AT_CLAMPS * abs(work)
    return found


def _clamped_ends(body: Body) -> list[Integers]:
    """Return the nodes of open pial paths, once from each end that is clamped."""
    ways = [way for path in body.pial_paths if not path.closed for way in (path.nodes, path.nodes[::-1])]
    return [way for way in ways if np.isin(2 * way[0] + np.arange(2), body.supported).all()]


def _length_at_clamps(body: Body, displacement: Array, chords: int) -> float:
    """Return the length, m, of so many chords of the deformed pial surface at each of its clamped ends."""
    moved = body.nodes + displacement
    length = sum(
        float(np.hypot(*np.diff(moved[:, nodes[: chords + 1]])).sum()) for nodes in _clamped_ends(body)
    )
    return 2 * length if body.mirror else length


@dataclass(frozen=True, eq=False)
class _Local:
    """A move of the new nodes, (2 n_finer,), the gradient after it, and the energy."""

    move: Array
    forces: Array
    energy: float


@dataclass(frozen=True, eq=False)
class _Finer:
    """A state on the body with its triangles split."""

    problem: Problem
    at: Configuration
    matrix: csr_matrix

    @property
    def body(self) -> Body:
        return self.problem.scene.body

    @classmethod
    def of(cls, problem: Problem, state: State) -> _Finer:
        """Return a state on the finer mesh, with the fields of processes as they are there."""
        body, finer = problem.scene.body, refined(problem.scene.body)
        matrix = prolongation(body, finer)
        return cls(*on_another_body(problem.scene, state, finer, _carrier(body, finer, matrix)), matrix)

    def locally_balanced(self) -> _Local:
        """Return what the new nodes do while those of the body stay."""
        at, n = self.at, self.problem.n_dofs
        held = np.union1d(self.problem.held, np.arange(2 * self.matrix.shape[1]))
        if at.is_condensed:  # volume is kept in each small triangle, by no small stiffness
            found = Minimiser(n, held, LOCAL, PATIENCE, solver=self.problem.scene.stepping.solver)
            end = found.minimise(at.potentials, at.x).at
            return _Local(end.x - at.x, forces_of(end), end.energy)
        new, move, forces = Assembler(n, held), np.zeros(n), forces_of(at)
        sparsity, values = new.assemble(at.hessians(1.0))
        diagonal, shape = sparsity.lower(values).diagonal(), (len(new.free), len(new.free))
        inverse = LinearOperator(shape, matvec=lambda x: x / diagonal)
        matrix = LinearOperator(shape, matvec=sparsity.product(values))
        move[new.free], failed = cg(matrix, -forces[new.free], rtol=LOCAL, maxiter=500, M=inverse)
        if failed:
            raise NoEstimateError("the finer mesh has no stiffness of its own")
        change = self._change(move, forces)
        return _Local(move, forces + change, at.energy + float((forces + 0.5 * change) @ move))

    def work_at_clamps(self, move: Array) -> float:
        """Return the energy that a move takes near clamped pial ends, ½ r·e, r the forces left; J/m."""
        if self.at.is_condensed:  # whose forces have the whole stiffness against changes of volume
            return 0.0
        near = np.zeros(self.body.nodes.shape[1], dtype=bool)
        for nodes in _clamped_ends(self.body):
            near |= np.hypot(*(self.body.nodes - self.body.nodes[:, nodes[:1]])) < REACH * self.body.thickness
        return 0.5 * float((forces_of(self.at) * move).reshape(-1, 2)[near].sum())

    def _change(self, direction: Array, forces: Array) -> Array:
        """Return the change of the forces along a direction, K' d, (2 n_finer,)."""
        largest = float(np.abs(direction).max())
        if not largest > 0:
            return np.zeros_like(direction)
        step = NUDGE * self.body.thickness / largest
        there = configuration(self.at.potentials, self.at.x + step * direction)
        if there is None:
            raise NoEstimateError("the state touches what is not admissible on a finer mesh")
        return (forces_of(there) - forces) / step

    def prolonged(self, vector: Array) -> Array:
        """Return a field of the body, (2 n,), on the finer mesh."""
        return np.asarray((self.matrix @ vector.reshape(-1, 2)).ravel())

    def restricted(self, forces: Array) -> Array:
        """Return what forces on the finer mesh do along displacements of the body, (2 n,)."""
        return np.asarray((self.matrix.T @ forces.reshape(-1, 2)).ravel())


def _carrier(body: Body, finer: Body, matrix: csr_matrix) -> Callable[[str, Array], Array]:
    """Return what carries a field over: of all nodes, of those of the cortical band, or of the points."""
    nodes, points = body.nodes.shape[1], body.quadrature.weights.shape

    def carried(name: str, values: Array) -> Array:
        if values.shape[-1:] == (nodes,):
            return np.asarray((matrix @ values.T).T)
        if values.shape[-2:] == points:
            return at_finer_points(body, values)
        if values.ndim == 1 and len(values) == len(body.cortex.nodes):
            return np.asarray((matrix @ body.spread(body.cortex, values, outside=0.0))[finer.cortex.nodes])
        raise NoEstimateError(f"the field {name!r} of shape {values.shape} belongs to no nodes or points")

    return carried
