"""A pattern on the cortical band, and what was chosen to make it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Integers
from ..geometry.body import Body
from .modes import Mode, count_half_waves
from .reaction_diffusion import Discretisation, ReactionDiffusion
from .stability import Conditions
from .steady import SteadyState


@dataclass(frozen=True, eq=False)
class Design:
    """What is chosen for a body: conditions with its diffusivities (m² per unit of kinetic time) and the
    mode.

    space: quadratic elements on the band.  line: its nodes along the pial surface, in order; the first comes
    again at the end of a closed line.  middle: the node at the apex.
    """

    conditions: Conditions
    mode: Mode
    space: Discretisation
    line: Integers
    middle: int


@dataclass(frozen=True, eq=False)
class Pattern:
    """A steady pattern on the quadratic elements of a band, and the design it came from."""

    design: Design
    system: ReactionDiffusion
    steady: SteadyState

    @property
    def activator(self) -> Array:
        """Activator at the band's nodes, shape (n_band_nodes,)."""
        return np.asarray(self.steady.state[0 if self.design.conditions.activator == "u" else 1])

    @property
    def inhibitor(self) -> Array:
        """Inhibitor at the band's nodes, shape (n_band_nodes,)."""
        return np.asarray(self.steady.state[1 if self.design.conditions.activator == "u" else 0])

    @property
    def half_waves(self) -> int:
        """Number of half waves along the pial surface."""
        return count_half_waves(self.activator[self.design.line], self.design.line[0] == self.design.line[-1])

    @property
    def normalised(self) -> Array:
        """Activator mapped to [0, 1], whatever its sign and size."""
        return normalised(self.activator)


def normalised(values: Array) -> Array:
    """Return values mapped to [0, 1]; 0 where they are all equal."""
    low, high = values.min(), values.max()
    return np.asarray((values - low) / (high - low)) if high > low else np.zeros_like(values)


def pial_line(body: Body) -> tuple[Integers, int]:
    """Return the band's nodes along the pial surface, in order, and the one at the apex."""
    band = body.cortex
    place = np.full(body.nodes.shape[1], -1)
    place[band.nodes] = np.arange(len(band.nodes))
    line = place[body.pial]
    if body.pial_curve.closed:
        line = np.append(line, line[0])
    if body.mirror:
        ends = line[[0, -1]]
        return line, int(ends[np.argmin(np.abs(band.mesh.p[0, ends]))])
    return line, int(line[len(line) // 2])
