"""Neumann eigenmodes of the Laplacian on a band, and diffusivities that make a wanted one grow fastest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from ..arrays import Array, Integers
from .linear.direct import factorised
from .reaction_diffusion import Discretisation
from .stability import Conditions, conditions_at_ratio


@dataclass(frozen=True)
class Mode:
    """A Laplace–Neumann mode: K φ = μ M φ with ∫φ² = 1; half_waves: sign changes of φ along the line of
    nodes.

    value: μ, one over length².  shape: φ, (n_nodes,).
    """

    value: float
    shape: Array
    half_waves: int


def sign_changes(values: Array, negligible: float = 1e-3) -> int:
    """Count the sign changes of values along a line, those below `negligible` times the largest left out."""
    clear = values[np.abs(values) > negligible * np.abs(values).max()]
    return int(np.sum(np.diff(np.sign(clear)) != 0))


def count_half_waves(values: Array, closed: bool, least: float = 0.1) -> int:
    """Count the rises and falls of values along a line, those below `least` times their range left out.

    closed: whether the line is a loop whose first value comes again at its end.
    """
    if closed:
        top = int(np.argmax(values[:-1]))
        values = np.append(np.roll(values[:-1], -top), values[top])
    enough = least * float(np.ptp(values))
    low = high = values[0]
    way, count = 0, 0  # 1 in a rise, -1 in a fall
    for value in values:
        low, high = min(low, value), max(high, value)
        if way <= 0 and value - low > enough:
            way, count, high = 1, count + 1, value
        elif way >= 0 and high - value > enough:
            way, count, low = -1, count + 1, value
    return count


def modes_near(space: Discretisation, target: float, count: int, line: Integers) -> list[Mode]:
    """Return the `count` modes with eigenvalues nearest to `target`, in ascending order.

    line: nodes in order along one side of the band.  Signs make the first value on the line positive.
    """
    n = space.size
    shift = target - 0.1 / space.area  # below the eigenvalue 0, and off `target` if it is an eigenvalue
    inverse = LinearOperator((n, n), matvec=factorised(space.stiffness - shift * space.mass).solve)
    start = 1 + np.cos(np.arange(n))  # a fixed start: the same modes, to the last bit, in every run
    values, shapes = eigsh(
        space.stiffness, min(count, n - 1), M=space.mass, sigma=shift, OPinv=inverse, v0=start
    )
    found = []
    for k in np.argsort(values):
        shape = shapes[:, k] / math.sqrt(shapes[:, k] @ (space.mass @ shapes[:, k]))
        shape = shape if shape[line[0]] >= 0 else -shape
        found.append(Mode(max(0.0, float(values[k])), shape, sign_changes(shape[line])))
    return found


def mode_with(space: Discretisation, half_waves: int, line: Integers, length: float, width: float) -> Mode:
    """Return the mode with a number of half waves along a band of mean length and width, and none across.

    Raises ValueError if the band is too short for them or the mesh too coarse.
    """
    target = (half_waves * math.pi / length) ** 2
    longest = length / width
    if half_waves >= longest:
        raise ValueError(
            f"half_waves={half_waves} must be below {longest:.4g}, the length of the band over its width "
            f"({length:.4g} / {width:.4g}), or the pattern varies across the band; ask for fewer, or for a "
            "thinner band."
        )
    resolved = length / half_waves / space.edge
    if resolved < 2:
        raise ValueError(
            f"half_waves={half_waves} leaves {resolved:.3g} elements to a half wave of "
            f"{length / half_waves:.4g}, and it needs 2: the largest element has edges of {space.edge:.4g}; "
            "use elements of at most "
            f"{length / half_waves / 2:.4g}."
        )
    for count in (6, 24):  # the eigenvalues of a curved band lie near those of the straight one
        for mode in modes_near(space, target, count, line):
            if mode.half_waves == half_waves:
                return mode
    raise ValueError(
        f"half_waves={half_waves}: none of the 24 modes of the band nearest to k² = {target:.4g} has that "
        "many sign changes along the pial surface; ask for another number, or for a band of more even width."
    )


def spectrum(space: Discretisation, upto: float, line: Integers) -> list[Mode]:
    """Return every mode with eigenvalue at most `upto`, in ascending order."""
    count = 16
    while True:
        found = modes_near(space, 0.0, count, line)
        if found[-1].value > upto or len(found) == space.size - 1:
            return [mode for mode in found if mode.value <= upto]
        count *= 2


def largest_isolating_ratio(found: Conditions, mode: Mode, others: list[Mode]) -> float:
    """Return the largest ratio d_inhibitor / d_activator at which the mode, made the fastest, grows alone.

    At most the ratio examined. Raises ValueError if another mode has the same eigenvalue, so that no ratio
    separates them.
    """
    values = np.array([other.value for other in others if other.half_waves != mode.half_waves])
    below, above = (
        values[values < mode.value].max(initial=0.0),
        values[values > mode.value].min(initial=np.inf),
    )

    def alone(ratio: float) -> bool:
        low, high = conditions_at_ratio(found.kinetics, ratio).scaled_to(mode.value).band
        return bool(below <= low and high <= above)

    low, high = found.critical_ratio * (1 + 1e-9), found.ratio
    if np.isclose(values, mode.value, rtol=1e-4).any() or not alone(low):
        raise ValueError(
            f"the mode with {mode.half_waves} half waves shares its eigenvalue {mode.value:.6g} with "
            "another one: no "
            "ratio of diffusivities makes it grow alone."
        )
    if alone(high):
        return high
    while high - low > 1e-10 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if alone(middle) else (low, middle)
    return low
