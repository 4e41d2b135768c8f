"""A problem whose answer is known, and the numbers that are compared."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """A number that the program finds, beside what it must be.

    tolerance: the largest |got - expected|, as a share of |expected|; in units of the number where that is 0.
    """

    name: str
    expected: float
    got: float
    tolerance: float

    @property
    def error(self) -> float:
        """The error: relative, or absolute where zero is expected."""
        return abs(self.got - self.expected) / (abs(self.expected) or 1.0)

    @property
    def holds(self) -> bool:
        """Whether the error is within the tolerance; not for what is no number."""
        return self.error <= self.tolerance


@dataclass(frozen=True)
class Check:
    """A problem, the function that solves it, and where its answer comes from.

    compute: returns the quantities to compare; its docstring has the formula and the tolerance's reason.
    full: whether it takes longer, as orders of convergence do, and is left out if not asked for.
    """

    problem: str
    compute: Callable[[], Sequence[Quantity]]
    source: str
    full: bool = False


def quantities(
    names: Iterable[str], expected: Iterable[float], got: Iterable[float], tolerance: float
) -> list[Quantity]:
    """Return the quantities of one problem that share a tolerance."""
    rows = zip(names, expected, got, strict=True)
    return [Quantity(name, float(known), float(found), tolerance) for name, known, found in rows]


def printed(names: Iterable[str], expected: Iterable[str], got: Iterable[float]) -> list[Quantity]:
    """Return the quantities of one problem whose numbers are known to the digits that are given as text."""
    found = []
    for name, text, number in zip(names, expected, got, strict=True):
        known, decimals = float(text), len(text.partition(".")[2])
        found.append(Quantity(name, known, float(number), 0.6 * 10.0**-decimals / abs(known)))
    return found
