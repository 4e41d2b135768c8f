"""A pattern on a straight strip that grows evenly along and across, with dilution: the modes double."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from skfem import MeshTri

from ..arrays import Array, Integers
from ..checks import positive, whole
from .growing_domain import march_on_growing_domain
from .kinetics.base import Kinetics
from .modes import sign_changes
from .reaction_diffusion import ReactionDiffusion, discretise


@dataclass(frozen=True, eq=False)
class StripPattern:
    """Times (m,), positions on the initial strip (n,), the first species u (m, n), half waves (m,)."""

    times: Array
    positions: Array
    u: Array
    half_waves: Integers


def growing_strip(
    kinetics: Kinetics, size: Callable[[float], float], *, until: float, d_u: float = 0.01, d_v: float = 1.0,
    noise: float = 1e-3, elements: int = 160, tolerance: float = 1e-3,
) -> StripPattern:  # fmt: skip
    """Return how a pattern develops on a strip of initial length 1, one element wide.

    size: its length L(t), 1 at the start.  d_u, d_v: diffusivities.  noise: amplitude of one half wave that
    is added to u at the first steady state.  Raises ValueError for kinetics without one, and as
    `march_on_growing_domain` does.
    """
    whole("elements", elements, at_least=8)
    positive("noise", noise)
    if not (uniform := kinetics.steady_states()):
        raise ValueError(f"{type(kinetics).__name__} has no steady state; use other parameters.")
    mesh = MeshTri.init_tensor(np.linspace(0, 1, elements + 1), np.array([0, 1 / elements]))
    space = discretise(mesh, 2)
    line = np.flatnonzero(space.nodes[1] == 0.0)
    line = line[np.argsort(space.nodes[0, line])]
    system = ReactionDiffusion(space, kinetics, d_u, d_v)
    state = system.uniform(*uniform[0])
    state[0] += noise * np.cos(np.pi * space.nodes[0])
    run = march_on_growing_domain(system, state, size, until=until, dimensions=1, tolerance=tolerance)
    times, values = zip(*((moment.time, moment.state[0, line]) for moment in run), strict=True)
    counts = np.array([sign_changes(u - u.mean()) for u in values])
    return StripPattern(np.array(times), space.nodes[0, line], np.array(values), counts)
