"""Newton's method for the minimum of a sum of potentials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from ..arrays import Array, Integers
from ..errors import NotConvergedError
from ..parts import Evaluation, Potential
from .inertia import negative_pivots
from .line_search import evaluations, has_inner, rays, reached, total_energy
from .linear import NotPositiveDefinite, Solver, solver_for
from .sparsity import Gatherer, Pattern

CONVEXITY = (0.0, 0.1, 0.5, 1.0)  # shares of the projected Hessian, tried in this order
DOUBLINGS = 8  # of a step away from a saddle
NEAR = 3e-3  # of the way between two equilibria: a tangent this close to the second speaks for it
ARMIJO = 1e-4
SHORTEST = 2.0**-30


@dataclass
class Effort:
    """What was spent: iterations, factorisations, and seconds by kind of work."""

    iterations: int = 0
    factorizations: int = 0
    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, part: str, since: float) -> float:
        """Book the time since `since` to a part of the work and return the present time."""
        now = perf_counter()
        self.seconds[part] = self.seconds.get(part, 0.0) + now - since
        return now


@dataclass(frozen=True)
class Equilibrium:
    """An equilibrium: displacement (2 n_nodes,), energy, relative residual, and the tangent's pivots.

    negative_pivots: the number of independent directions in which the energy falls; 0 at a minimum. Where no
    walls touch, it may be that of a place NEAR it: in strain, three thousandths of the way from the last one.
    """

    x: Array
    energy: float
    residual: float
    negative_pivots: int

    @property
    def stable(self) -> bool:
        """Whether it is a minimum."""
        return self.negative_pivots == 0


@dataclass(frozen=True)
class Memory:
    """What a restart needs for the same bits: matrix places, convexity, where the kept tangent was made.

    missed: by how much the last guess missed its equilibrium, as a share of the way to it.
    """

    places: Integers
    level: int
    point: Array | None
    missed: float


@dataclass(frozen=True)
class System:
    """A factorised tangent and the displacement where it was made; of use until the next is factorised.

    lasting: the number of its Hessians if their places last, else 0, as where walls touch.
    """

    point: Array
    lasting: int
    pattern: Pattern
    values: Array
    solver: Solver

    def length(self, d: Array) -> float:
        """Return the length √(d·K d) of displacements of the free unknowns, which weighs them by strain."""
        return float(np.sqrt(max(float(d @ self.pattern.times(self.values, d)), 0.0)))


class Minimiser:
    """Minimises sums of potentials over the free degrees of freedom; keeps patterns and factorisations."""

    def __init__(
        self,
        n_dofs: int,
        fixed: Integers,
        tolerance: float,
        iterations: int,
        memory: Memory | None = None,
        solver: str = "auto",
    ) -> None:
        self.gatherer = Gatherer(n_dofs, fixed, None if memory is None else memory.places)
        self.tolerance, self.iterations = tolerance, iterations
        self.effort = Effort()
        self.deadline = float("inf")  # by perf_counter
        self._kind = solver
        self._solver: Solver | None = None
        self._solver_pattern: object = None
        self._level = 0 if memory is None else memory.level
        self._missed = float("inf") if memory is None else memory.missed
        self._tangent: System | None = None

    @property
    def memory(self) -> Memory:
        """What the next minimisation owes to the earlier ones."""
        point = None if self._tangent is None else self._tangent.point
        return Memory(self.gatherer.places, self._level, point, self._missed)

    def forget(self) -> None:
        """Let the next minimisation begin without the tangent of the last one, and make none at its guess."""
        self._tangent, self._missed = None, float("inf")

    def remember(self, potentials: Sequence[Potential], point: Array) -> None:
        """Factorise the tangent that an earlier minimisation kept."""
        at = evaluations(potentials, point)
        self._tangent = None if at is None else self._factorized(at, point, 0.0)

    def minimise(self, potentials: Sequence[Potential], x: Array, guess: Array | None = None) -> Equilibrium:
        """Return the equilibrium reached from x, or from the guess if its energy is lower.

        Raises NotConvergedError when the iterations run out or the energy cannot be lowered.
        """
        x, at = _lowest(potentials, x, guess)
        tangent, self._tangent = self._tangent, None  # the one that certified the last equilibrium
        origin, before = None if tangent is None else tangent.point, float("inf")
        if x is guess and self._missed < NEAR:
            tangent = None  # one made at a guess as good as the last will speak for the equilibrium
        for iteration in range(self.iterations + 1):
            begin = perf_counter()
            slope, residual = self._slope(at)
            self.effort.add("forces", begin)
            if not np.isfinite(residual):
                raise NotConvergedError("the forces are not finite", residual=residual)
            if residual <= self.tolerance:
                negative = self._certified(at, x, guess, origin, tangent)
                return Equilibrium(x, total_energy(at), residual, negative)
            if iteration == self.iterations:
                break
            self._heed_deadline(residual)
            # a factorisation costs more than two steps: keep the last one while two at this rate will do
            if tangent is None or residual * (residual / before) ** 2 > self.tolerance:
                tangent = self._factorized_convex(at, x)
            direction, before = self._solved(tangent, slope), residual
            x, at = self._search(potentials, x, at, slope, direction, residual)
            self.effort.iterations += 1
        raise NotConvergedError(f"{self.iterations} Newton iterations were not enough", residual=residual)

    def _heed_deadline(self, residual: float) -> None:
        if perf_counter() > self.deadline:
            raise NotConvergedError("the time is over", residual=residual)

    def _slope(self, at: list[Evaluation]) -> tuple[Array, float]:
        parts = [e.gradient() for e in at]
        slope = sum(g for g, _ in parts)[self.gatherer.free]  # type: ignore[index]
        scale = np.sqrt(sum(s for _, s in parts))
        return slope, float(np.linalg.norm(slope) / scale) if scale > 0 else float(np.linalg.norm(slope))

    def _factorized_convex(self, at: list[Evaluation], x: Array) -> System:
        """Return the factorised tangent, with as much convexity added as it needs."""
        for level in range(max(0, self._level - 1), len(CONVEXITY)):
            system = self._factorized(at, x, CONVEXITY[level])
            if system is not None:
                self._level = level
                return system
        self._level = 0
        raise NotConvergedError("no convex approximation of the tangent is positive definite")

    def _solved(self, system: System, slope: Array) -> Array:
        begin = perf_counter()
        direction = np.zeros(self.gatherer.n_dofs)
        direction[self.gatherer.free] = -system.solver.solve(slope)
        self.effort.add("factorisations", begin)
        return direction

    def _certified(
        self, at: list[Evaluation], x: Array, guess: Array | None, origin: Array | None, last: System | None
    ) -> int:
        """Keep the tangent if it is positive definite; return the number of its negative pivots.

        The last true tangent speaks for x if it was made within NEAR of the way from the last such place and
        forces change smoothly: a contact may come and go within any distance.
        """
        self._missed = float("inf")
        if last is not None and self._level == 0 and last.lasting == sum(e.curved for e in at):
            missed = self._share(last, x, guess, origin)
            near = missed if last.point is guess else self._share(last, x, last.point, origin)
            self._missed = missed
            if near < NEAR and not has_inner(at):
                self._tangent = last
                return 0
        found = self._factorized(at, x, 0.0)
        # inner unknowns settle anew in the next step: their tangent is not the same to the last bit
        self._tangent = None if has_inner(at) else found
        if found is not None:
            return 0
        return negative_pivots(*self.gatherer.gather([e.hessian(0.0) for e in at if e.curved]))

    def _share(self, system: System, x: Array, point: Array | None, origin: Array | None) -> float:
        """Return the way from a point to x as a share of that from the origin to x; infinite if not known."""
        if point is None or origin is None:
            return float("inf")
        free = self.gatherer.free
        way = system.length((x - origin)[free])
        return system.length((x - point)[free]) / way if way > 0 else float("inf")

    def _factorized(self, at: list[Evaluation], x: Array, convexity: float) -> System | None:
        """Return the factorised tangent, or None if it is not positive definite."""
        begin = perf_counter()
        hessians = [e.hessian(convexity) for e in at if e.curved]
        lasting = len(hessians) if all(h.lasting for h in hessians) else 0
        pattern, values = self.gatherer.gather(hessians)
        begin = self.effort.add("tangents", begin)
        if pattern is not self._solver_pattern:
            self._solver, self._solver_pattern = solver_for(pattern, self._kind), pattern
            begin = self.effort.add("orderings", begin)
        assert self._solver is not None
        self.effort.factorizations += 1
        try:
            self._solver.factorize(values)
        except NotPositiveDefinite:
            return None
        finally:
            self.effort.add("factorisations", begin)
        return System(x, lasting, pattern, values, self._solver)

    def _search(
        self,
        potentials: Sequence[Potential],
        x: Array,
        at: list[Evaluation],
        slope: Array,
        direction: Array,
        residual: float,
    ) -> tuple[Array, list[Evaluation]]:
        """Return the next configuration: the longest admissible step that lowers the energy enough."""
        begin = perf_counter()
        decrease = float(slope @ direction[self.gatherer.free])
        if not decrease <= 0:
            raise NotConvergedError("the Newton direction leads uphill", residual=residual)
        along = rays(potentials, at, x, direction, decrease)
        step = min(ray.longest for ray in along)
        begin = self.effort.add("step bounds", begin)
        merit, fall = sum(ray.start for ray in along), decrease + sum(ray.excess for ray in along)
        noise = sum(e.grain for e in at)  # near the minimum, round-off hides the decrease
        while step > SHORTEST:
            self._heed_deadline(residual)
            there = reached(along, step)
            if there is not None and there[0] <= merit + ARMIJO * step * fall + noise:
                end = x + step * direction, there[1]
                if self._level and step == 1.0 and not has_inner(at):
                    end = _lengthened(potentials, x, *end)
                self.effort.add("line searches", begin)
                return end
            step *= 0.5
        raise NotConvergedError("no step along the Newton direction lowers the energy", residual=residual)


def _lowest(
    potentials: Sequence[Potential], x: Array, guess: Array | None
) -> tuple[Array, list[Evaluation]]:
    """Return the place of lower energy and its evaluations."""
    at = evaluations(potentials, x)
    there = None if guess is None else evaluations(potentials, guess)
    if guess is not None and there is not None and (at is None or total_energy(there) <= total_energy(at)):
        return guess, there
    if at is None:
        raise NotConvergedError("the start of the step is not admissible (J* <= 0 or walls crossing)")
    return x, at


def _lengthened(
    potentials: Sequence[Potential], x: Array, trial: Array, there: list[Evaluation]
) -> tuple[Array, list[Evaluation]]:
    """Return the end of the step, doubled as long as that is admissible and lowers the energy.

    Near a saddle the added convexity makes steps far too short: each grows the way down by a few percent.
    """
    for _ in range(DOUBLINGS):
        onward = 2.0 * (trial - x)
        if min(p.largest_step(x, onward) for p in potentials) < 1.0:
            break
        farther = evaluations(potentials, x + onward)
        if farther is None or total_energy(farther) >= total_energy(there):
            break
        trial, there = x + onward, farther
    return trial, there
