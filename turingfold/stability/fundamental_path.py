"""The base path of a scene: its smooth solution, stable or not, and the stiffness that is left on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BarycentricInterpolator
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from ..arrays import Array
from ..errors import NotConvergedError
from ..geometry.body import by_node
from ..parts import Evaluation, Potential
from ..scene import Scene
from ..solve.inertia import Indefinite, symmetric
from ..solve.line_search import evaluations, rays, reached
from ..solve.march import acting, begin, discretised, processed
from ..solve.sparsity import Gatherer, Pattern
from ..state import State

STRAY = 1.0  # a correction larger than this share of the step itself has left the base path
NOTHING = 1e-9  # root mean square of a displacement, as a share of the body's length, that is none
ITERATIONS = 15  # of Newton's method on the base path; it needs four or five


@dataclass(frozen=True)
class BaseState:
    """A state on the base path, stable or not: `tangent` on `pattern`, and its number of negative pivots."""

    state: State
    x: Array
    pattern: Pattern
    tangent: Array
    negative: int


class BasePath:
    """The smooth solution of a scene, followed by plain Newton steps."""

    def __init__(self, scene: Scene) -> None:
        """Factorise the tangent at the scene's start."""
        self.scene = scene
        self.operators, held = discretised(scene)
        self.gatherer = Gatherer(2 * scene.body.nodes.shape[1], held)
        first = begin(scene).state
        self._kept: tuple[Pattern, Indefinite] | None = None
        at_start = self.potentials(first, scene.stepping.first * scene.until)
        x = by_node(first["displacement"])
        at = evaluations(at_start, x)
        if at is None:
            raise NotConvergedError("the scene's start is not admissible", time=0.0)
        self.rest = [e.hessian(0.0) for e in at if e.curved]
        pattern, tangent = self.gatherer.gather(self.rest)
        negative = self.solver(pattern).factorize(tangent).negative
        if negative:
            raise NotConvergedError("the scene is unstable at its start, before anything has grown", time=0.0)
        self.start = BaseState(first, x, pattern, tangent, negative)

    def potentials(self, state: State, dt: float) -> tuple[Potential, ...]:
        """Return the potentials of the step of length dt that ends in `state`."""
        return acting(self.operators, state, dt)

    def solver(self, pattern: Pattern) -> Indefinite:
        """Return the factoriser of a pattern, kept until another pattern comes."""
        if self._kept is None or self._kept[0] is not pattern:
            self._kept = pattern, Indefinite(pattern)
        return self._kept[1]

    def processed(self, start: State, dt: float) -> State:
        """Return `start` with the fields that the processes have dt later."""
        return start.updated(start.time + dt, **processed(self.scene, start, dt))

    def step(self, start: State, dt: float, ahead: Array | None) -> BaseState:
        """Return the equilibrium dt after `start`; ahead: the expected change of displacement (2 n_nodes,).

        Raises NotConvergedError where Newton fails, or ends too far from the expected place.
        """
        state, old = self.processed(start, dt), by_node(start["displacement"])
        potentials = self.potentials(state, dt)
        try:
            found = self._newton(potentials, old, ahead)
        except NotConvergedError:
            if ahead is None:
                raise
            # the processes may have changed their pace: then the linear response to them is what to expect
            found = self._newton(potentials, old, self._response(potentials, old))
        x, tangent, pattern, negative = found
        for potential in potentials:
            state = state.updated(**potential.finish(x))
        state = state.updated(displacement=x.reshape(-1, 2).T.copy())
        return BaseState(state, x, pattern, tangent, negative)

    def _newton(
        self, potentials: Sequence[Potential], old: Array, ahead: Array | None
    ) -> tuple[Array, Array, Pattern, int]:
        """Return the equilibrium near old + ahead, with its tangent, pattern and negative pivots."""
        x = old if ahead is None else old + ahead
        at = evaluations(potentials, x)
        if at is None:
            x, at = old, evaluations(potentials, old)
        if at is None:
            raise NotConvergedError("the start of the step is not admissible")
        for iteration in range(ITERATIONS):
            tangent, pattern, negative, residual, decrease, direction = self._linearised(at)
            if residual <= self.scene.stepping.tolerance and iteration > 0:
                self._check_near(x - old, ahead)
                return x, tangent, pattern, negative
            x, at = _moved(potentials, at, x, direction, decrease)
        raise NotConvergedError("Newton does not find the base path", residual=residual)

    def _check_near(self, change: Array, ahead: Array | None) -> None:
        """Raise NotConvergedError for a change of displacement too far from the expected one."""
        if ahead is None:
            return
        floor = NOTHING * self.scene.body.length * np.sqrt(len(change))
        if np.linalg.norm(change - ahead) > max(STRAY * np.linalg.norm(ahead), floor):
            raise NotConvergedError("Newton leaves the base path")

    def _response(self, potentials: Sequence[Potential], x: Array) -> Array:
        """Return the first Newton step from x, (2 n_nodes,)."""
        at = evaluations(potentials, x)
        if at is None:
            raise NotConvergedError("the start of the step is not admissible")
        return self._linearised(at)[-1]

    def _linearised(self, at: list[Evaluation]) -> tuple[Array, Pattern, int, float, float, Array]:
        """Return tangent, its pattern and negative pivots, residual, slope along Newton's step, that step."""
        parts = [e.gradient() for e in at]
        slope = np.sum([g for g, _ in parts], axis=0)[self.gatherer.free]
        residual = float(np.linalg.norm(slope) / np.sqrt(sum(s for _, s in parts) or 1.0))
        pattern, tangent = self.gatherer.gather([e.hessian(0.0) for e in at if e.curved])
        factors = self.solver(pattern).factorize(tangent)
        move = -factors.solve(slope)
        move -= factors.solve(pattern.times(tangent, move) + slope)
        direction = np.zeros(self.gatherer.n_dofs)
        direction[self.gatherer.free] = move
        return tangent, pattern, factors.negative, residual, float(slope @ move), direction

    def between(self, nodes: Sequence[BaseState], time: float) -> BaseState:
        """Return the state at `time` with the displacement, and what the terms remember, interpolated."""
        start = nodes[-2].state
        state = self.processed(start, time - start.time)
        made = {name for process in self.scene.processes for name in process.writes}
        for name in start.fields:
            if name not in made:
                known = [node.state for node in nodes if name in node.state]
                values = np.stack([at[name] for at in known])
                through = BarycentricInterpolator(np.array([at.time for at in known]), values)
                state = state.updated(**{name: through(time)})
        x = by_node(state["displacement"])
        at = evaluations(self.potentials(state, nodes[-1].state.time - start.time), x)
        if at is None:
            raise NotConvergedError("the path turns too fast; make Stepping(largest=...) smaller", time=time)
        pattern, tangent = self.gatherer.gather([e.hessian(0.0) for e in at if e.curved])
        return BaseState(state, x, pattern, tangent, self.solver(pattern).factorize(tangent).negative)

    def lowest(self, base: BaseState) -> tuple[float, Array]:
        """Return the lowest eigenvalue of (K, K₀), and its vector over the free unknowns."""
        pattern, rest = self.gatherer.gather(self.rest)
        solver, shift, below = self.solver(pattern), 0.0, 0.01
        factors = solver.factorize(base.tangent)
        while factors.negative:  # below the whole spectrum the nearest eigenvalue is the lowest one
            shift, below = shift - below, 2 * below
            factors = solver.factorize(base.tangent - shift * rest)
        inverse = LinearOperator((pattern.n, pattern.n), matvec=factors.solve, dtype=float)
        start = np.random.default_rng(self.scene.seed).standard_normal(pattern.n)
        try:
            values, vectors = eigsh(
                symmetric(pattern, base.tangent), k=1, M=symmetric(pattern, rest), sigma=shift, OPinv=inverse,
                v0=start, tol=1e-8,
            )
        except ArpackError as error:
            raise NotConvergedError(
                f"the lowest eigenpair at t = {base.state.time:.4g} is not found", time=base.state.time
            ) from error
        return float(values[0]), vectors[:, 0]


def _moved(
    potentials: Sequence[Potential], at: list[Evaluation], x: Array, direction: Array, decrease: float
) -> tuple[Array, list[Evaluation]]:
    """Return the configuration a full Newton step ahead, or the admissible part of one."""
    along = rays(potentials, at, x, direction, decrease)
    step = min(ray.longest for ray in along)
    while step > 1e-3:
        there = reached(along, step)
        if there is not None:
            return x + step * direction, there[1]
        step *= 0.5
    raise NotConvergedError("the Newton direction leaves the admissible states at once")
