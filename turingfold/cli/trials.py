"""What runs of a case with other elements and steps say of their errors, and which to try next."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

LONGEST = 2.0  # times as fine as the best run yet at most
RUNS = 7
SAFETY = 1.4  # of what is claimed: estimates of Figure 3 on eleven meshes were short by 1.32 at most
ROOM = 0.85  # share of the error asked for that is aimed at
SLOWEST, USUAL, FASTEST = 0.7, 1.0, 3.0  # orders of the error in the size of the elements
CONFIRMS = 1.3  # times as many elements, from which on the difference of two runs tells their errors
ANOTHER = 1.12  # times as many elements as the finest run that was no better: errors scatter with the mesh
Numbers = dict[tuple[str, str], float]  # by scene and name


@dataclass(frozen=True)
class Size:
    """Elements through the cortex, and how many times as short as usual steps are."""

    elements: float
    shorter: float = 1.0

    def share_of_difference(self, other: Size) -> float:
        """Return the error, in differences to another size, if it falls as the size of the elements.

        0 where they are too close to tell.
        """
        few, more = sorted((self.elements, other.elements))
        if more < (CONFIRMS - 1e-6) * few:
            return 0.0
        return (few if self.elements == more else more) / (more - few)

    def __str__(self) -> str:
        steps = f", steps {self.shorter:.3g} times as short" if self.shorter > 1 else ""
        return f"elements={self.elements:g}{steps}"


@dataclass(frozen=True)
class Errors:
    """What the results of a run say of their numbers.

    values: of the numbers that have an estimate.  units: what errors are relative to, the value or where that
    is nothing a size of the body.  mesh, steps: relative errors.  folds: by scene.
    """

    values: Numbers
    units: Numbers
    mesh: Numbers
    steps: Numbers
    folds: Mapping[str, int]

    def bounds(self, others: Sequence[Errors] = ()) -> Numbers:
        """Return bounds of the relative errors, no smaller than what those of other runs leave."""
        found = {key: SAFETY * self.mesh[key] + self.steps.get(key, 0.0) for key in self.mesh}
        for other in others:
            theirs = other.bounds()
            for key, apart in self.apart(other).items():
                found[key] = max(found[key], apart - theirs[key] * other.units[key] / self.units[key])
        return found

    def apart(self, other: Errors) -> Numbers:
        """Return how far numbers of another run are from these."""
        both = self.values.keys() & other.values.keys()
        return {key: abs(self.values[key] - other.values[key]) / self.units[key] for key in both}

    def far_from(self, other: Errors) -> bool:
        """Return whether a number differs by more than both estimates."""
        mine, theirs = self.bounds(), other.bounds()
        return any(
            apart > mine[key] + theirs[key] * other.units[key] / self.units[key]
            for key, apart in self.apart(other).items()
        )


@dataclass(frozen=True)
class Trial:
    """A run of all scenes; errors: None where there is no estimate of them.

    worst: the largest relative error, of the number `of`.  why: there is no estimate.  soft: it is near a
    limit of stability, so that no estimate of its errors counts.
    """

    size: Size
    errors: Errors | None = None
    worst: float = math.inf
    of: tuple[str, str] = ("", "")
    why: str = ""
    soft: bool = False

    @classmethod
    def judged(cls, size: Size, errors: Errors, others: Sequence[Trial]) -> Trial:
        """Return a run with its worst error, judged also by other runs."""
        own = cls(size, errors)
        bounds = own.bounds(others)
        of = max(bounds, key=lambda key: bounds[key])
        return replace(own, worst=bounds[of], of=of)

    def bounds(self, others: Sequence[Trial]) -> Numbers:
        """Return bounds of the relative errors by this run and by others, without those that are refuted.

        They are no smaller than what the difference of two meshes, beyond what steps explain, tells if errors
        fall as the size of the elements.
        """
        assert self.errors is not None
        left = [one for one in standing([*others, self]) if one is not self]
        found = self.errors.bounds([one.errors for one in left if one.errors is not None])
        for one in left:
            assert one.errors is not None
            share = self.size.share_of_difference(one.size)
            for key, apart in self.errors.apart(one.errors).items():
                steps = self.errors.steps.get(key, 0.0) + one.errors.steps.get(key, 0.0)
                found[key] = max(found[key], share * (apart - steps))
        return found

    def refuted_by(self, other: Trial) -> bool:
        """Return whether a finer run lies farther from this one than both estimates say."""
        if self.errors is None or other.errors is None or other.size.elements <= self.size.elements:
            return False
        return self.errors.far_from(other.errors)

    @property
    def rank(self) -> tuple[float, bool, float]:
        """What is smaller of a better run; of those that are not believed, the finest that ended."""
        ended = self.soft or self.errors is not None
        return self.worst, not ended, -self.size.elements if ended else 0.0


def standing(trials: Sequence[Trial]) -> list[Trial]:
    """Return the runs with an estimate that are not refuted.

    One is, where two finer ones lie farther from it than both estimates say: it may have ended before a snap
    which they are past.
    """
    judged = [one for one in trials if one.errors is not None]
    return [one for one in judged if sum(one.refuted_by(other) for other in judged) < 2]


def judged_anew(trials: Sequence[Trial]) -> list[Trial]:
    """Return all runs, each judged by all others; none is believed that is coarser than one that is soft."""
    found, least = [], _finest_soft(trials)
    for one in trials:
        if one.errors is not None:
            one = Trial.judged(one.size, one.errors, [other for other in trials if other is not one])
        found.append(one if one.size.elements > least else replace(one, worst=math.inf))
    return found


def _finest_soft(trials: Sequence[Trial]) -> float:
    """Return the elements of the finest run near a limit of stability, 0 without any."""
    return max((one.size.elements for one in trials if one.soft), default=0.0)


def best(trials: Sequence[Trial]) -> Trial:
    """Return the run with the smallest errors."""
    return min(trials, key=lambda trial: trial.worst)


def confirmed(trials: Sequence[Trial]) -> bool:
    """Return whether the best run is compared with another mesh, both finer than any that is soft.

    One mesh may be before or past a snap by chance, and an estimate on it knows nothing of that.
    """
    own, least = best(trials), _finest_soft(trials)
    finer = [one.size for one in standing(trials) if one.size.elements > least]
    return own.size in finer and any(own.size.share_of_difference(size) > 0 for size in finer)


def onward(trials: Sequence[Trial], accuracy: float, allowed: Callable[[float], float]) -> Size | None:
    """Return the size of the next run; None where there is none to try.

    allowed: makes of a number of elements one that the case can have.
    """
    if len(trials) == RUNS:
        return None
    own, finest = best(trials), max(trial.size.elements for trial in trials)
    soft = _finest_soft(trials) > 0
    if own.errors is None:
        wanted = Size(allowed((CONFIRMS if soft else ANOTHER) * finest), own.size.shorter)
    else:
        wanted = _expected(own, _order(trials), accuracy, allowed)
        if not confirmed(trials):
            wanted = replace(wanted, elements=max(wanted.elements, allowed(CONFIRMS * finest)))
        elif wanted.shorter == own.size.shorter and wanted.elements <= finest:  # such a run was no better
            wanted = Size(allowed(ANOTHER * finest), wanted.shorter)
    return None if wanted in [trial.size for trial in trials] else wanted


def _expected(own: Trial, order: float, accuracy: float, allowed: Callable[[float], float]) -> Size:
    """Return the size that a run's errors, if they fall with an order, ask for."""
    assert own.errors is not None
    steps = max(own.errors.steps.values())
    aim = ROOM * accuracy * (0.5 if steps > 0 else 1.0)
    finer = (max(own.worst - steps, 0.0) / aim) ** (1 / order)
    return Size(
        allowed(own.size.elements * min(max(finer, 1.0), LONGEST)),
        own.size.shorter * min(max(steps / aim, 1.0), LONGEST),
    )


def _order(trials: Sequence[Trial]) -> float:
    """Return the order of the mesh's errors in the size of the elements, as the two best runs have it."""
    judged = sorted((one for one in trials if one.errors is not None), key=lambda one: one.size.elements)
    if len(judged) < 2 or judged[0].size.elements == judged[-1].size.elements:
        return USUAL
    one, other = judged[0], best(judged)
    if one is other or one.size.elements == other.size.elements:  # the best may differ in its steps only
        return SLOWEST
    assert one.errors is not None
    assert other.errors is not None
    fall = max(one.errors.mesh.values()) / max(other.errors.mesh.values())
    seen = math.log(fall) / math.log(other.size.elements / one.size.elements)
    return min(max(seen, SLOWEST), FASTEST)
