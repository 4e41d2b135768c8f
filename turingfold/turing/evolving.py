"""A Turing pattern that lives on the deforming cortex: a process staggered with the growth of the solid."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from skfem import MeshTri2

from ..arrays import Array
from ..checks import positive
from ..errors import NotConvergedError
from ..geometry.body import Body
from ..state import State
from .integrators.rosenbrock import march
from .process import Design, Turing, normalised, refuse_negative
from .reaction_diffusion import Discretisation, ReactionDiffusion, discretise


@dataclass(frozen=True)
class EvolvingTuring:
    """Pattern that starts steady on the undeformed band and goes on reacting and diffusing while tissue
    grows.

    On the tissue at x(X, t), J its change of area: ∂(J w)/∂t = J f(w) + ∇_X·(J F⁻¹ D F⁻ᵀ ∇_X w). Over a
    step the tissue first moves, which keeps ∫ w dA of every part (dilution), then the pattern evolves on it.

    turing: the pattern at the start; its diffusivities, in m² per unit of kinetic time, stay.
    pace: units of kinetic time per unit of the scene's time; small: the pattern hardly follows the growth.
    dilution: False lets the concentrations be carried along unchanged.
    tolerance: local error of the run, relative.

    Reads "displacement", the last equilibrium. Writes "activator", "inhibitor", "pattern" as `Turing` does,
    and "band_displacement", (2, n_band_nodes) in m, at which they hold. Raises as `Turing` does.
    """

    turing: Turing
    _: KW_ONLY
    pace: float = 1000.0
    dilution: bool = True
    tolerance: float = 1e-2

    reads: ClassVar[tuple[str, ...]] = ("displacement",)
    writes: ClassVar[tuple[str, ...]] = ("activator", "inhibitor", "pattern", "band_displacement")

    def __post_init__(self) -> None:
        """Check the options."""
        if not isinstance(self.turing, Turing):
            raise ValueError(f"turing={self.turing!r} must be a Turing(...), the pattern to start from.")
        positive("pace", self.pace)
        positive("tolerance", self.tolerance, at_most=0.1)

    def start(self, body: Body, state: State, seed: int) -> dict[str, Array]:
        """Return the steady pattern of the undeformed band."""
        fields = self.turing.start(body, state, seed)
        return {**fields, "band_displacement": np.zeros((2, len(body.cortex.nodes)))}

    def advance(self, body: Body, state: State, dt: float) -> dict[str, Array]:
        """Return the pattern after the tissue has moved to the last equilibrium and dt has passed."""
        found = _design(self.turing, body).conditions
        old, new = state["band_displacement"], state["displacement"][:, body.cortex.nodes]
        order = (0, 1) if found.activator == "u" else (1, 0)
        values = np.stack([state["activator"], state["inhibitor"]])[list(order)]
        space = deformed(body, new)
        if self.dilution and (new != old).any():
            # M_new w = M_old w_old: nothing is made or lost while the tissue moves
            solve = space.pattern.scalar_solver(space.mass.data)
            amounts = (deformed(body, old).mass @ values.T).T
            values = np.stack([solve(amount) for amount in amounts])
        system = ReactionDiffusion(space, self.turing.kinetics, found.d_u, found.d_v)
        for moment in march(system, values, until=self.pace * dt, tolerance=self.tolerance):
            values = moment.state
            if moment.steps > 1000:
                raise NotConvergedError(
                    f"the pattern took more than 1000 steps for {self.pace * dt:.4g} units of kinetic time, "
                    "from "
                    f"{state.time:.4g} on: it never rests; use a smaller pace, or kinetics that settle.",
                    time=state.time,
                )
        refuse_negative(self.turing.kinetics, values, state.time)
        activator, inhibitor = values[list(order)]
        return {
            "activator": activator,
            "inhibitor": inhibitor,
            "pattern": normalised(activator),
            "band_displacement": new,
        }


@lru_cache(maxsize=2)
def _design(turing: Turing, body: Body) -> Design:
    # the same at every step of a run, and a tenth of a second each time
    return turing.design(body)


def deformed(body: Body, displacement: Array) -> Discretisation:
    """Return quadratic elements on the band moved by a displacement of its nodes, (2, n_band_nodes)."""
    mesh = body.cortex.mesh
    return discretise(MeshTri2(mesh.doflocs + displacement, mesh.t, validate=False), 2)
