"""How forces and energy change with a parameter of a part while the body stays where it is.

The part is made anew with the parameter a little larger and smaller, and with it the processes that its
change reaches; everything else is kept. Differences over h and h/2 are extrapolated, so that errors are of
order h⁴. How far the two lie apart, and what is left of a kink between the two sides, says how large they
are. At a limit of its part, as a Poisson's ratio of 0, the parameter goes the other way only.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..parts import Operator, Process, TimeStep
from ..scene import Scene, stress_scale
from ..solve.problem import Problem
from ..state import State
from .parameters import CENTRAL, FORWARD, STEP, changed_in, number_of

ROUNDED = 1e-6  # an error of ∂g/∂p beyond which other steps are tried, for what bends more or is next to 0
TINY = 1e-9  # a parameter that is next to 0
ROUND_OFF = 1e-13  # share of its part's forces below which a change of them is none
ROUGH = 1e-2  # an error of ∂g/∂p that is told
FAR = (0.1, -0.1, 0.5, -0.5)  # changes, relative, at which it is seen whether what changes no force ever does
ONSET = 1e-6  # of itself within which the value is found from which on it does
JUMP = 1e-2  # share of the change of forces that comes at once there, beyond which it acts in steps
# weights over h of differences of fourth order, of coarser ones, and of what a kink leaves
BOTH = ((1 / 6, -4 / 3, 0.0, 4 / 3, -1 / 6), (0.0, -1.0, 0.0, 1.0, 0.0), (-0.5, 2.0, -3.0, 2.0, -0.5))
ONE = ((-25 / 6, 8.0, -6.0, 8 / 3, -0.5), (-11 / 3, 6.0, -3.0, 2 / 3, 0.0), (0.0,) * 5)

Still = dict[tuple[int, ...], Array]  # forces and energy of some terms as they are, by their numbers


@dataclass(frozen=True, eq=False)
class Change:
    """∂g/∂p, (2 n_nodes,), and ∂E/∂p at a fixed displacement.  error: of ∂g/∂p, relative.

    lost, lost_energy: by how much they may err, as by half of what the two sides of a kink differ.
    reach: of what changes no force, the share of itself within which it changes none, if that is known.
    """

    gradient: Array
    energy: float
    error: float
    lost: Array
    lost_energy: float
    reach: float = float("inf")


def change(
    problem: Problem, state: State, x: Array, parameter: str, step: TimeStep, still: Still | None = None
) -> Change:
    """Return how forces and energy at x change with a parameter, "Part.name".

    state: the fields at x; those that the parameter changes are made anew.  still: kept between parameters.
    Raises ValueError for what is no number of a part, where the part takes no values beside it, and for what
    acts in steps, as a depth that takes one integration point after another into a layer.
    """
    value = number_of(problem.scene, parameter)
    at = _At(problem, state, x, step, parameter, value, {} if still is None else still)
    found = at.change(STEP * abs(value) if value else STEP)
    if not value:
        return found
    if found.error <= ROUNDED and abs(value) >= TINY:
        return found if found.gradient.any() else replace(found, reach=at.reach())
    for h in (0.1 * STEP * abs(value), STEP):
        try:
            other = at.change(h)
        except ValueError:  # its part refuses so large a change
            continue
        if other.gradient.any() and (other.error < found.error or not found.gradient.any()):
            found = other
    return found


def rough_words(parameters: Sequence[str], errors: Array) -> list[str]:
    """Return what to say of parameters with which forces do not change smoothly; errors: of ∂g/∂p, (p,)."""
    return [
        f"{name}: forces do not change smoothly with it, to one side of its value by as much as {error:.0%} "
        "otherwise; run the scene with values beside it"
        for name, error in zip(parameters, errors, strict=True)
        if error > ROUGH
    ]


def warn_of_rough(parameters: Sequence[str], errors: Array) -> None:
    """Warn of parameters with which forces do not change smoothly."""
    for words in rough_words(parameters, errors):
        warnings.warn(words, stacklevel=4)


@dataclass(frozen=True, eq=False)
class _At:
    """A parameter at one of its values, and a displacement."""

    problem: Problem
    state: State
    x: Array
    step: TimeStep
    parameter: str
    value: float
    still: Still

    def change(self, h: float) -> Change:
        """Return how forces and energy change, by differences over h; where a part refuses them, to one side.

        Raises ValueError where it refuses both.
        """
        refusals = []
        for length, places, rule in ((h, CENTRAL, BOTH), (h, FORWARD, ONE), (-h, FORWARD, ONE)):
            try:
                return self._differences(length, places, rule)
            except ValueError as error:
                refusals.append(str(error))
        raise ValueError(
            f"{self.parameter} is {self.value!r}, and a derivative needs values up to {2 * h:.3g} above or "
            f"below it, which are refused: {'; '.join(dict.fromkeys(refusals[1:]))}"
        )

    def reach(self) -> float:
        """Return the share of itself within which what changes no force here changes none; inf: unknown.

        Raises ValueError where forces then jump: derivatives are 0 almost everywhere, and say nothing.
        """
        nearest = float("inf")
        for share in FAR:
            inside, outside = 0.0, share
            if not (most := self._moved(share)):
                continue
            while abs(outside - inside) > ONSET:
                middle = 0.5 * (inside + outside)
                inside, outside = (inside, middle) if self._moved(middle) else (middle, outside)
            if self._moved(outside) > JUMP * most:
                raise ValueError(
                    f"{self.parameter} acts in steps: forces are the same from {self.value:g} to "
                    f"{(1 + outside) * self.value:.4g}, where they jump, so that no derivative says "
                    "anything; run the scene with values that lie far apart."
                )
            nearest = min(nearest, abs(inside))
        return nearest

    def _moved(self, share: float) -> float:
        """Return by how much forces change with a share of the value, N/m; 0: round-off, or it is refused."""
        try:
            forces = self._forces([0.0, share * self.value])[:, :-1]
        except ValueError:
            return 0.0
        moved = float(np.linalg.norm(forces[1] - forces[0]))
        return moved if moved > ROUND_OFF * float(np.linalg.norm(forces, axis=1).max()) else 0.0

    def _differences(
        self, h: float, places: tuple[float, ...], rule: tuple[tuple[float, ...], ...]
    ) -> Change:
        """Return how forces and energy change, by a rule for differences over h."""
        forces = self._forces([place * h for place in places])
        found, rough, kink = (np.array(weights) @ forces / h for weights in rule)
        size = float(np.linalg.norm(found[:-1]))
        if size * abs(h) <= ROUND_OFF * float(np.linalg.norm(forces[:, :-1], axis=1).max()):
            still = np.zeros_like(found[:-1])
            return Change(still, float(found[-1]), 0.0, still, 0.0)
        lost = max(found - rough, kink, key=lambda one: float(np.linalg.norm(one[:-1])))
        error = float(np.linalg.norm(lost[:-1])) / size
        return Change(found[:-1], float(found[-1]), error, lost[:-1], abs(float(lost[-1])))

    def _forces(self, moves: list[float]) -> Array:
        """Return forces and energy with the parameter moved, (moves, 2 n_nodes + 1).

        Of the terms that any of the moves reaches: all rows are of the same ones.
        """
        scenes = {
            move: changed_in(self.problem.scene, self.parameter, self.value + move) for move in moves if move
        }
        fields = {move: fields_of(self.problem.scene, one, self.state) for move, one in scenes.items()}
        operators = {move: operators_of(self.problem, one) for move, one in scenes.items()}
        reached = tuple(
            k
            for k, (term, own) in enumerate(
                zip(self.problem.scene.terms, self.problem.operators, strict=True)
            )
            if any(
                operators[move][k] is not own or {*term.reads, *term.optional} & set(fields[move])
                for move in scenes
            )
        )
        if 0.0 in moves and reached not in self.still:
            self.still[reached] = self._sum(self.problem.operators, reached, self.state)
        return np.stack(
            [
                self._sum(operators[move], reached, self.state.updated(**fields[move]))
                if move
                else self.still[reached]
                for move in moves
            ]
        )

    def _sum(self, operators: list[Operator], reached: tuple[int, ...], state: State) -> Array:
        """Return forces and energy of some terms, (2 n_nodes + 1,)."""
        total = np.zeros(len(self.x) + 1)
        for k in reached:
            potential = operators[k].during(state, self.step)
            if potential is None:  # it does not act
                continue
            at = potential.evaluate(self.x)
            if at is None:
                term = type(self.problem.scene.terms[k]).__name__
                raise ValueError(
                    f"the energy of {term} is infinite beside {self.parameter} = {self.value:g}."
                )
            total[:-1] += at.gradient()[0]
            total[-1] += at.energy
        return total


def operators_of(problem: Problem, changed: Scene) -> list[Operator]:
    """Return the operators of a changed scene's terms; those of terms that did not change are kept."""
    same = changed.body is problem.scene.body
    return [
        own if same and new is old else new.on(changed.body)
        for old, new, own in zip(problem.scene.terms, changed.terms, problem.operators, strict=True)
    ]


def fields_of(scene: Scene, changed: Scene, state: State) -> dict[str, Array]:
    """Return the fields that are otherwise in the changed scene at the state's time."""
    fields, scale = _processed(scene, changed, state), stress_scale(changed.terms)
    if scale != stress_scale(scene.terms):  # the unit of stress is that of the stiffest layer
        fields["stress_scale"] = np.array(scale)
    return fields


def _processed(scene: Scene, changed: Scene, state: State) -> dict[str, Array]:
    """Return the fields that the processes of the changed scene make otherwise."""
    reached: list[Process] = []
    names: set[str] = set()
    for old, new in zip(scene.processes, changed.processes, strict=True):
        other = new is not old or changed.body is not scene.body
        if other or names & {*new.reads, *new.optional, *new.writes}:
            reached.append(new)
            names |= set(new.writes)
    if not reached:
        return {}
    # laws that multiply or rewrite one field are needed from the first one on
    reached = [p for p in changed.processes if names & set(p.writes)]
    made = {name for process in reached for name in process.writes}
    kept = {name: state[name] for name in state.fields if name not in made}
    evolutions = [(process, process.on(changed.body)) for process in reached]
    before, now = State(0.0, kept), State(state.time, kept)
    for _, evolution in evolutions:
        before = before.updated(**evolution.start(before, scene.seed))
    for process, evolution in evolutions:
        own = {name: before[name] for name in process.writes if name in before and name not in now}
        now = now.updated(**{**own, **evolution.advance(before, now, state.time)})
    return {name: now[name] for name in made}


def check_path(problem: Problem, start: State) -> None:
    """Raise ValueError for parts whose fields depend on the steps taken, by name."""
    from ..stability.path_dependence import refuse_memory, refuse_motion

    refuse_motion(problem.scene)
    refuse_memory(problem, start)
