"""Newton's method for the minimum of a sum of potentials."""

from __future__ import annotations

from time import perf_counter

import numpy as np
from scipy.sparse import csr_matrix

from ..arrays import Array, Integers
from ..errors import NotConvergedError, RoundOffError
from ..parts import Potential
from .descent import Descent, descent, lengthened
from .equilibrium import Effort, Equilibrium, Memory, Tangent
from .inertia import negative_pivots
from .linear import NotPositiveDefinite, Solver, solver_for
from .problem import Configuration, configuration
from .sparsity import Assembler, Sparsity

# shares of the projected Hessian, tried in this order: of all energies, and of those that are abrupt
CONVEXITY = ((0.0, 0.0), (0.0, 1.0), (0.1, 1.0), (0.5, 1.0), (1.0, 1.0))
KEPT = 5  # iterations of conjugate gradients, after which their preconditioner is made anew
NEAR = 3e-3  # of the way between two equilibria: a tangent made this close to the second certifies it
ARMIJO = 1e-4
OF_LOAD, ROUND_OFF = 1e-3, 1e-13  # residuals that need no iteration: as a share of the load's, and at all
SHORTEST = 2.0**-30
FLOOR, PATIENCE = 1e-10, 4  # below this residual, so many full steps that do not halve it show round-off


class Minimiser:
    """Minimises sums of potentials over the free degrees of freedom; keeps sparsities and factorisations."""

    def __init__(
        self,
        n_dofs: int,
        fixed: Integers,
        tolerance: float,
        iterations: int,
        memory: Memory | None = None,
        solver: str = "auto",
    ) -> None:
        self.assembler = Assembler(n_dofs, fixed, None if memory is None else memory.changing)
        self.tolerance, self.iterations = tolerance, iterations
        self.effort = Effort()
        self.deadline = float("inf")  # by perf_counter
        self.strict = False  # whether a tangent that is not positive definite ends a minimisation
        self._kind = solver
        self._solver: Solver | None = None
        self._solver_sparsity: Sparsity | None = None
        self._convexity = 0 if memory is None else memory.convexity
        self._missed = float("inf") if memory is None else memory.missed
        self._tangent: Tangent | None = None
        self._certifying: Tangent | None = None  # the last that was found positive definite at an equilibrium

    @property
    def memory(self) -> Memory:
        """What the next minimisation owes to the earlier ones."""
        point = None if self._tangent is None else self._tangent.point
        return Memory(self.assembler.changing, self._convexity, point, self._missed)

    def forget(self) -> None:
        """Let the next minimisation begin without the last tangent, and make none at its prediction."""
        self._tangent, self._missed = None, float("inf")

    def remember(self, potentials: tuple[Potential, ...], point: Array) -> None:
        """Factorise the tangent that an earlier minimisation kept."""
        at = configuration(potentials, point)
        self._tangent = None if at is None else self._factorized(at, 0.0)

    def softest_mode(self, mass: csr_matrix, powers: int) -> Array:
        """Return the eigenvector of the last minimum's tangent and a mass matrix of the lowest eigenvalue.

        Roughly, as (2 n_nodes,), by powers of the inverse; zero where there was none yet.
        """
        mode, free = np.zeros(self.assembler.n_dofs), self.assembler.free
        if self._certifying is not None:
            mode[free] = np.random.default_rng(0).standard_normal(len(free))
            for _ in range(powers):
                mode[free] = self._certifying.solver.solve((mass @ mode)[free])
                mode /= np.abs(mode).max()
        return mode

    def minimise(
        self, potentials: tuple[Potential, ...], x: Array, predicted: Array | None = None
    ) -> Equilibrium:
        """Return the equilibrium reached from x, or from a prediction if its energy is lower.

        predicted: the displacement expected; of the way there, the admissible part is taken.
        Raises NotConvergedError when the iterations run out or the energy cannot be lowered.
        """
        start, at, guess = _lowest(potentials, x, predicted)
        tangent, self._tangent = self._tangent, None  # the one that certified the last equilibrium
        origin, before = None if tangent is None else tangent.point, float("inf")
        least, idle = float("inf"), 0  # the least residual yet, and the iterations since it was halved
        if at.x is guess and self._missed < NEAR:
            tangent = None  # one made at a prediction as good as the last holds for the equilibrium, too
        descended: Descent | None = None  # how the last step was found, if not by solving once
        for iteration in range(self.iterations + 1):
            begin = perf_counter()
            gradient, residual = at.forces(self.assembler.free)
            self.effort.add("forces", begin)
            if not np.isfinite(residual):
                raise NotConvergedError("the forces are not finite", residual=residual)
            if residual <= self.tolerance and (iteration or self._is_balanced(residual, start)):
                return Equilibrium(at, residual, self._certified(at, guess, origin, tangent))
            start = at  # lets go of what was computed there
            if iteration == self.iterations:
                break
            self._heed_deadline(residual)
            idle = 0 if residual < 0.5 * least or residual > FLOOR or self._convexity else idle + 1
            least = min(least, residual)
            if idle > PATIENCE:
                raise _rounded(least, self.tolerance)
            # a factorisation costs more than two steps: keep the last one while two at this rate will do
            if tangent is None or not self._serves(descended, residual, before):
                tangent = self._factorized_convex(at, descended is not None and descended.curved)
            direction, descended = self._direction(tangent, at, gradient, residual)
            before = residual
            at = self._search(at, gradient, direction, residual, descended is not None and descended.curved)
            self.effort.iterations += 1
        raise NotConvergedError(f"{self.iterations} Newton iterations were not enough", residual=residual)

    def _is_balanced(self, residual: float, start: Configuration) -> bool:
        """Return whether forces are small against the change of the loads since the start, too.

        A load may be so small that the residual, relative to the moduli, does not see it.
        """
        return residual <= ROUND_OFF or residual <= OF_LOAD * start.forces(self.assembler.free)[1]

    @property
    def out_of_time(self) -> bool:
        """Whether the limit on the run time is reached."""
        return perf_counter() > self.deadline

    def _heed_deadline(self, residual: float) -> None:
        if self.out_of_time:
            raise NotConvergedError("the time is over", residual=residual)

    def _serves(self, descended: Descent | None, residual: float, before: float) -> bool:
        """Return whether the last tangent will do for another step, as it did for the one before."""
        if self._convexity:
            return descended is not None and descended.curved and descended.iterations <= KEPT
        return residual * (residual / before) ** 2 <= self.tolerance

    def _factorized_convex(self, at: Configuration, curved: bool) -> Tangent:
        """Return the factorised tangent, with as much convexity added as it needs.

        curved: whether the true one was not positive definite along the last step.
        """
        levels = self._levels(at, curved)
        for level in levels[:1] if self.strict else levels:
            tangent = self._factorized(at, *CONVEXITY[level])
            if tangent is not None:
                self._convexity = level
                return tangent
        self._convexity = 0
        if self.strict:
            raise NotConvergedError("the tangent is not positive definite")
        raise NotConvergedError("no convex approximation of the tangent is positive definite")

    def _levels(self, at: Configuration, curved: bool) -> list[int]:
        """Return the levels of CONVEXITY to try; the true tangent first where it may do."""
        if at.is_condensed:  # whose steps are no better for a true tangent that fails
            own = [0, *range(2, len(CONVEXITY))]
            return [level for level in own if level >= self._convexity - 1] if self._convexity > 2 else own
        first = max(1, self._convexity - (not curved))
        levels = [level for level in range(first, len(CONVEXITY)) if level > 1 or at.is_abrupt]
        return levels if curved else [0, *levels]

    def _direction(
        self, tangent: Tangent, at: Configuration, gradient: Array, residual: float
    ) -> tuple[Array, Descent | None]:
        """Return Newton's direction, (2 n_nodes,), and how it was found if convexity was added."""
        begin, descended = perf_counter(), None
        if self._convexity and not at.is_condensed:  # the merit of those takes the curvature of their tangent
            sparsity, values = self.assembler.assemble(at.hessians(0.0))
            begin = self.effort.add("tangents", begin)
            times = sparsity.product(values)
            descended = descent(tangent.solver.solve, times, -gradient, residual)
            found = descended.direction
        else:
            found = -tangent.solver.solve(gradient)
        direction = np.zeros(self.assembler.n_dofs)
        direction[self.assembler.free] = found
        self.effort.add("directions", begin)
        return direction, descended

    def _certified(
        self, at: Configuration, guess: Array | None, origin: Array | None, last: Tangent | None
    ) -> int:
        """Keep the tangent if it is positive definite; return the number of its negative pivots.

        The last true tangent holds for x if it was made within NEAR of the way from the last such place and
        forces change smoothly: a contact may come and go within any distance.
        """
        self._missed = float("inf")
        counted = sum(e.has_hessian for e in at.evaluations)
        if last is not None and self._convexity == 0 and last.constant == counted:
            missed = self._share(last, at.x, guess, origin)
            near = missed if last.point is guess else self._share(last, at.x, last.point, origin)
            self._missed = missed
            if near < NEAR and not at.is_condensed:
                self._tangent = self._certifying = last
                return 0
        found = self._certifying = self._factorized(at, 0.0)
        # inner unknowns settle anew in the next step: their tangent is not the same to the last bit
        self._tangent = None if at.is_condensed else found
        if found is not None:
            self._convexity = 0
            return 0
        return negative_pivots(*self.assembler.assemble(at.hessians(0.0)))

    def _share(self, tangent: Tangent, x: Array, point: Array | None, origin: Array | None) -> float:
        """Return the way from a point to x as a share of that from the origin to x; infinite if not known."""
        if point is None or origin is None:
            return float("inf")
        free = self.assembler.free
        way = tangent.length((x - origin)[free])
        return tangent.length((x - point)[free]) / way if way > 0 else float("inf")

    def _factorized(self, at: Configuration, convexity: float, abrupt: float = 0.0) -> Tangent | None:
        """Return the factorised tangent, or None if it is not positive definite."""
        begin = perf_counter()
        hessians = at.hessians(convexity, abrupt)
        constant = len(hessians) if all(h.constant for h in hessians) else 0
        sparsity, values = self.assembler.assemble(hessians)
        del hessians  # four times as large as their sum
        begin = self.effort.add("tangents", begin)
        if sparsity is not self._solver_sparsity:
            self._solver, self._solver_sparsity = solver_for(sparsity, self._kind), sparsity
            begin = self.effort.add("orderings", begin)
        assert self._solver is not None
        self.effort.factorizations += 1
        try:
            self._solver.factorize(values)
        except NotPositiveDefinite:
            return None
        finally:
            self.effort.add("factorisations", begin)
        return Tangent(at.x, constant, sparsity, values, self._solver)

    def _search(
        self, at: Configuration, gradient: Array, direction: Array, residual: float, curved: bool
    ) -> Configuration:
        """Return the next configuration: the longest admissible step that lowers the energy enough.

        curved: whether the energy curves down along the direction, so that a longer step may be better.
        """
        begin = perf_counter()
        decrease = float(gradient @ direction[self.assembler.free])
        if not decrease <= 0:
            raise NotConvergedError("the Newton direction leads uphill", residual=residual)
        lines = at.search_lines(direction, decrease)
        step = min(line.longest for line in lines)
        begin = self.effort.add("step bounds", begin)
        merit, fall = sum(line.start for line in lines), decrease + sum(line.excess for line in lines)
        noise = at.round_off  # near the minimum, it hides the decrease
        while step > SHORTEST:
            self._heed_deadline(residual)
            there = at.at(lines, direction, step)
            if there is not None and there[0] <= merit + ARMIJO * step * fall + noise:
                end = there[1]
                if curved and step == 1.0 and not at.is_condensed:
                    end = lengthened(at, end)
                self.effort.add("line searches", begin)
                return end
            step *= 0.5
        raise NotConvergedError("no step along the Newton direction lowers the energy", residual=residual)


def _rounded(residual: float, tolerance: float) -> RoundOffError:
    return RoundOffError(
        f"round-off keeps the residual at {residual:.2g}, above tolerance={tolerance:g}: no step brings it "
        f"lower; take Stepping(tolerance={10.0 ** np.ceil(np.log10(10 * residual)):g}) or more",
        residual=residual,
    )


def _lowest(
    potentials: tuple[Potential, ...], x: Array, predicted: Array | None
) -> tuple[Configuration, Configuration, Array | None]:
    """Return the configuration at x, the one of lower energy of it and the prediction's, and the latter's x.

    Of the way to the prediction the admissible part is taken.
    """
    at = configuration(potentials, x)
    if at is None:
        raise NotConvergedError("the start of the step is not admissible (J* <= 0 or walls crossing)")
    if predicted is None:
        return at, at, None
    ahead = predicted - x
    guess = np.asarray(x + at.largest_step(ahead) * ahead)
    there = configuration(potentials, guess)
    if there is not None and there.energy <= at.energy:
        return at, there, guess
    return at, at, guess
