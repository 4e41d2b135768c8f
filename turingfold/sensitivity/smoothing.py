"""How smooth a fitted map is to be: as smooth as the outlines allow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

import numpy as np

from ..arrays import Array

WEIGHTS = 10.0 ** np.arange(0.0, -4.1, -0.5)


class Fitted(Protocol):
    """What is read of a fit: parameters, values, misfits at each age, number and size of all residuals; m."""

    @property
    def parameters(self) -> tuple[str, ...]: ...  # noqa: D102

    @property
    def values(self) -> Array: ...  # noqa: D102

    @property
    def misfits(self) -> dict[float, float]: ...  # noqa: D102

    @property
    def count(self) -> int: ...  # noqa: D102

    @property
    def rms(self) -> float: ...  # noqa: D102


Fit = TypeVar("Fit", bound=Fitted)


def second_differences(parameters: Sequence[str]) -> Array:
    """Return the second differences of values that are neighbours in one map, (rows, p)."""
    rows = []
    for k in range(1, len(parameters) - 1):
        near = [name.rpartition(".") for name in parameters[k - 1 : k + 2]]
        places = [int(tail) if tail.isdecimal() else None for _, _, tail in near]
        follow = None not in places and set(np.diff(np.array(places, dtype=int))) in ({1}, {-1})
        if follow and len({stem for stem, _, _ in near}) == 1:
            row = np.zeros(len(parameters))
            row[k - 1 : k + 2] = 1.0, -2.0, 1.0
            rows.append(row)
    return np.array(rows).reshape(-1, len(parameters))


def smoothest(fitted: Callable[[float, Fit | None], Fit], noise: float | None) -> tuple[Fit, str]:
    """Return a fit of well chosen weight of smoothness, and how it was chosen.

    fitted: makes a fit with a weight, starting from another one.  noise: of the targets, m. With it, the
    largest weight that raises the sum of (residual / noise)² by no more than the number of parameters above
    that of the least weight: what it moves them by is then about what the noise does. Without, that at the
    corner of the curve of log roughness over log misfit, where more smoothness begins to cost misfit (the
    L-curve: Hansen, SIAM Review 34:561, 1992).
    """
    found: list[Fit] = []
    for weight in WEIGHTS.tolist():
        found.append(fitted(weight, found[-1] if found else None))
    if noise is not None:
        squares = np.array([one.count * (one.rms / noise) ** 2 for one in found])
        k = int(np.argmax(squares <= squares[-1] + len(found[-1].values)))
        ends = {0: ", the largest tried", len(found) - 1: ", the least tried"}.get(k, "")
        how = f"the most that moves the map by no more than the noise{ends}"
        return found[k], f"smoothness {WEIGHTS[k]:.2g}, {how}"
    differences = second_differences(found[0].parameters)
    rough = np.array([np.linalg.norm(differences @ one.values) for one in found])
    k = corner(np.log([misfit(one) for one in found]), np.log(np.maximum(rough, 1e-300)))
    return found[k], f"smoothness {WEIGHTS[k]:.2g}, at the corner of the L-curve"


def misfit(found: Fitted) -> float:
    """Return the root mean square distance over all ages; m."""
    return float(np.sqrt(np.mean(np.square(list(found.misfits.values())))))


def corner(x: Array, y: Array) -> int:
    """Return the number of the inner point at which a curve through points (n,) bends most.

    By the circle through it and its neighbours, on axes scaled to their ranges.
    """
    at = np.stack([(x - x.min()) / max(np.ptp(x), 1e-300), (y - y.min()) / max(np.ptp(y), 1e-300)])
    a, b, c = at[:, :-2], at[:, 1:-1], at[:, 2:]
    area = np.abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0])
    sides = [np.hypot(*(one - other)) for one, other in ((a, b), (b, c), (c, a))]
    return 1 + int(np.argmax(2 * area / np.maximum(np.prod(sides, axis=0), 1e-300)))
