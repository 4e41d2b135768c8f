"""The fundamental path: a scene's smooth solution, stable or not, and the stiffness left on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BarycentricInterpolator
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from ..arrays import Array
from ..errors import NotConvergedError
from ..geometry.body import by_node
from ..parts import Potential, TimeStep
from ..scene import Scene
from ..solve.inertia import Factors, Indefinite, symmetric
from ..solve.problem import Configuration, Problem, configuration
from ..solve.sparsity import Assembler, Sparsity
from ..state import State

STRAY = 1.0  # a correction larger than this share of the step itself has left the path
JUMP = 0.1  # thicknesses of the cortex by which a correction may move a point: more is a snap to another path
NOTHING = 1e-9  # root mean square of a displacement, as a share of the body's length, that is none
ITERATIONS = 15  # of Newton's method on the path; it needs four or five


@dataclass(frozen=True, eq=False)
class Linearised:
    """The tangent of a configuration on the free unknowns, factorised whatever its signs."""

    sparsity: Sparsity
    values: Array
    factors: Factors
    assembler: Assembler

    def newton_step(self, gradient: Array) -> Array:
        """Return -K⁻¹ gradient, refined once as the pivots are not chosen, as (2 n_nodes,)."""
        move = -self.factors.solve(gradient)
        move -= self.factors.solve(self.sparsity.product(self.values)(move) + gradient)
        whole = np.zeros(self.assembler.n_dofs)
        whole[self.assembler.free] = move
        return whole


@dataclass(frozen=True, eq=False)
class FundamentalState:
    """A state on the fundamental path, stable or not: its tangent, and the number of its negative pivots."""

    state: State
    x: Array
    sparsity: Sparsity
    tangent: Array
    negative: int


class FundamentalPath:
    """The smooth solution of a scene, followed by plain Newton steps."""

    def __init__(self, scene: Scene) -> None:
        """Factorise the tangent at the scene's start."""
        self.scene = scene
        self.problem = Problem(scene)
        self.assembler = Assembler(self.problem.n_dofs, self.problem.held)
        first = self.problem.start()
        self._kept: tuple[Sparsity, Indefinite] | None = None
        x = by_node(first["displacement"])
        at = self._configuration(self.potentials(first, scene.stepping.first * scene.until), x)
        self.at_rest = at.hessians(0.0)
        sparsity, tangent = self.assembler.assemble(self.at_rest)
        negative = self.solver(sparsity).factorize(tangent).negative
        if negative:
            raise NotConvergedError("the scene is unstable at its start, before anything has grown", time=0.0)
        self.start = FundamentalState(first, x, sparsity, tangent, negative)

    def potentials(self, state: State, dt: float) -> tuple[Potential, ...]:
        """Return the potentials of the step of length dt that ends in `state`."""
        return self.problem.potentials(state, TimeStep(dt))

    def solver(self, sparsity: Sparsity) -> Indefinite:
        """Return the factoriser of a sparsity, kept until another one comes."""
        if self._kept is None or self._kept[0] is not sparsity:
            self._kept = sparsity, Indefinite(sparsity)
        return self._kept[1]

    def linearised(self, at: Configuration) -> Linearised:
        """Return the factorised tangent of a configuration."""
        sparsity, values = self.assembler.assemble(at.hessians(0.0))
        return Linearised(sparsity, values, self.solver(sparsity).factorize(values), self.assembler)

    def step(self, start: State, dt: float, ahead: Array | None) -> FundamentalState:
        """Return the equilibrium dt after `start`; ahead: the expected change of displacement (2 n_nodes,).

        Raises NotConvergedError where Newton fails, or ends too far from the expected place.
        """
        state, old = self.problem.processed(start, dt), by_node(start["displacement"])
        potentials = self.potentials(state, dt)
        try:
            at, tangent = self._newton(potentials, old, ahead)
        except NotConvergedError:
            if ahead is None:
                raise
            # the processes may have changed their pace: then the linear response to them is what to expect
            at = self._configuration(potentials, old)
            gradient, _ = at.forces(self.assembler.free)
            at, tangent = self._newton(potentials, old, self.linearised(at).newton_step(gradient))
        state = self.problem.finished(state, at).updated(displacement=at.x.reshape(-1, 2).T.copy())
        return FundamentalState(state, at.x, tangent.sparsity, tangent.values, tangent.factors.negative)

    def _newton(
        self, potentials: tuple[Potential, ...], old: Array, ahead: Array | None
    ) -> tuple[Configuration, Linearised]:
        """Return the equilibrium near old + ahead, with its tangent."""
        at = None if ahead is None else configuration(potentials, old + ahead)
        if at is None:
            at = self._configuration(potentials, old)
        for iteration in range(ITERATIONS):
            gradient, residual = at.forces(self.assembler.free)
            tangent = self.linearised(at)
            if residual <= self.scene.stepping.tolerance and iteration > 0:
                self._check_near(at.x - old, ahead)
                return at, tangent
            direction = tangent.newton_step(gradient)
            at = _moved(at, direction, float(gradient @ direction[self.assembler.free]))
        raise NotConvergedError("Newton does not find the fundamental path", residual=residual)

    def _configuration(self, potentials: tuple[Potential, ...], x: Array) -> Configuration:
        at = configuration(potentials, x)
        if at is None:
            raise NotConvergedError("the start of the step is not admissible")
        return at

    def _check_near(self, change: Array, ahead: Array | None) -> None:
        """Raise NotConvergedError for a change of displacement too far from the expected one."""
        if ahead is None:
            return
        floor = NOTHING * self.scene.body.length * np.sqrt(len(change))
        off = change - ahead
        far = np.linalg.norm(off) > max(STRAY * np.linalg.norm(ahead), floor)
        if far or np.abs(off).max() > JUMP * self.scene.body.thickness:  # one fold may snap, and the rest not
            raise NotConvergedError("Newton leaves the fundamental path")

    def between(self, nodes: Sequence[FundamentalState], time: float) -> FundamentalState:
        """Return the state at `time` with the displacement, and what the terms remember, interpolated."""
        start = nodes[-2].state
        state = self.problem.processed(start, time - start.time)
        made = {name for process in self.scene.processes for name in process.writes}
        for name in start.fields:
            if name not in made:
                known = [node.state for node in nodes if name in node.state]
                values = np.stack([at[name] for at in known])
                through = BarycentricInterpolator(np.array([at.time for at in known]), values)
                state = state.updated(**{name: through(time)})
        x = by_node(state["displacement"])
        at = configuration(self.potentials(state, nodes[-1].state.time - start.time), x)
        if at is None:
            raise NotConvergedError("the path turns too fast; make Stepping(largest=...) smaller", time=time)
        found = self.linearised(at)
        return FundamentalState(state, x, found.sparsity, found.values, found.factors.negative)

    def lowest(self, base: FundamentalState) -> tuple[float, Array]:
        """Return the lowest eigenvalue of (K, K₀), and its vector over the free unknowns."""
        sparsity, at_start = self.assembler.assemble(self.at_rest)
        solver, shift, below = self.solver(sparsity), 0.0, 0.01
        factors = solver.factorize(base.tangent)
        while factors.negative:  # below the whole spectrum the nearest eigenvalue is the lowest one
            shift, below = shift - below, 2 * below
            factors = solver.factorize(base.tangent - shift * at_start)
        inverse = LinearOperator((sparsity.n, sparsity.n), matvec=factors.solve, dtype=float)
        start = np.random.default_rng(self.scene.seed).standard_normal(sparsity.n)
        try:
            values, vectors = eigsh(
                symmetric(sparsity, base.tangent),
                k=1,
                M=symmetric(sparsity, at_start),
                sigma=shift,
                OPinv=inverse,
                v0=start,
                tol=1e-8,
            )
        except ArpackError as error:
            raise NotConvergedError(
                f"the lowest eigenpair at t = {base.state.time:.4g} is not found", time=base.state.time
            ) from error
        return float(values[0]), vectors[:, 0]


def _moved(at: Configuration, direction: Array, decrease: float) -> Configuration:
    """Return the configuration a full Newton step ahead, or the admissible part of one."""
    lines = at.search_lines(direction, decrease)
    step = min(line.longest for line in lines)
    while step > 1e-3:
        there = at.at(lines, direction, step)
        if there is not None:
            return there[1]
        step *= 0.5
    raise NotConvergedError("the Newton direction leaves the admissible states at once")
