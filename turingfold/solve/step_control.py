"""Steps of a motion as long as a bound on the error of each allows."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..errors import StepTooLongError
from ..stepping import Stepping
from .prediction import Past

TOLERATED = 1.5  # times the bound that an accepted step may reach, so that few are taken twice
AIM = 0.8  # share of the longest step that is tried
SHORTEST, LONGEST = 0.25, 1.3  # of a step, in units of the one before it


def error_of_step(before: tuple[Past, ...], time: float, displacement: Array) -> float:
    """Return how far a step moved the worst node off the motion: ½ |∂²u/∂t²| dt², by differences; m.

    That is the error of a backward Euler step to first order, and more than that of one with the midpoint
    rule.  before: earlier states, the newest last; one alone is at rest.  displacement: (2, n), at `time`.
    """
    now = before[-1]
    dt = time - now.time
    velocity = (displacement - now.displacement) / dt
    if len(before) > 1:
        earlier = now.time - before[-2].time
        change = velocity - (now.displacement - before[-2].displacement) / earlier
    else:
        earlier, change = dt, velocity
    return float(np.hypot(*change).max()) * dt * dt / (dt + earlier)


def longest_next(before: tuple[Past, ...], time: float, displacement: Array, stepping: Stepping) -> float:
    """Return the longest step after one that the bound on the error allows; inf without a bound.

    Raises StepTooLongError for one that is too far off itself.
    """
    if stepping.local_error is None:
        return np.inf
    dt, error = time - before[-1].time, error_of_step(before, time, displacement)
    share = AIM * np.sqrt(stepping.local_error / max(error, 1e-300))
    length = dt * float(np.clip(share, SHORTEST, LONGEST))
    if error > TOLERATED * stepping.local_error:
        raise StepTooLongError(
            f"a step of {dt:.3g} is off by {error:.3g}, more than "
            f"Stepping(local_error={stepping.local_error:g}); allow shorter ones (smallest=), or add damping",
            length=length,
            time=time,
        )
    return length
