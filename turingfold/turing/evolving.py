"""A Turing pattern that lives on the deforming cortex: a process staggered with the growth of the solid."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np
from skfem import MeshTri2

from ..arrays import Array
from ..checks import positive
from ..errors import NotConvergedError
from ..geometry.body import Body
from ..parts import Evolution, Fields, Process
from ..state import State
from .integrators.rosenbrock import march
from .process import WRITTEN, Turing, normalised, refuse_negative
from .reaction_diffusion import Discretisation, ReactionDiffusion, discretise


@dataclass(frozen=True)
class EvolvingTuring(Process):
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

    def __post_init__(self) -> None:
        """Check the options."""
        if not isinstance(self.turing, Turing):
            raise ValueError(f"turing={self.turing!r} must be a Turing(...), the pattern to start from.")
        positive("pace", self.pace)
        positive("tolerance", self.tolerance, at_most=0.1)

    @property
    def reads(self) -> tuple[str, ...]:
        """The last equilibrium."""
        return ("displacement",)

    @property
    def writes(self) -> tuple[str, ...]:
        """Those of `Turing`, and the displacement of the band at which they hold."""
        return (*WRITTEN, "band_displacement")

    @property
    def keeps(self) -> tuple[str, ...]:
        """All: a pattern is a result in itself."""
        return self.writes

    @property
    def remembers(self) -> bool:
        """It does: reaction and diffusion go on from where they are."""
        return True

    def on(self, body: Body) -> EvolvingOnBody:
        """Return the pattern on a body."""
        return EvolvingOnBody(self, body)


class EvolvingOnBody(Evolution):
    """An evolving pattern on one body."""

    def __init__(self, evolving: EvolvingTuring, body: Body) -> None:
        """Choose the diffusivities."""
        self.evolving, self.body = evolving, body
        self.conditions = evolving.turing.design(body).conditions

    def start(self, state: State, seed: int) -> Fields:
        """Return the steady pattern of the undeformed band."""
        fields = self.evolving.turing.on(self.body).start(state, seed)
        return {**fields, "band_displacement": np.zeros((2, len(self.body.cortex.nodes)))}

    def advance(self, before: State, now: State, dt: float) -> Fields:
        """Return the pattern after the tissue has moved to the last equilibrium and dt has passed."""
        evolving, found, body = self.evolving, self.conditions, self.body
        old, new = before["band_displacement"], before["displacement"][:, body.cortex.nodes]
        order = (0, 1) if found.activator == "u" else (1, 0)
        values = np.stack([before["activator"], before["inhibitor"]])[list(order)]
        space = deformed(body, new)
        if evolving.dilution and (new != old).any():
            # M_new w = M_old w_old: nothing is made or lost while the tissue moves
            solve = space.pattern.scalar_solver(space.mass.data)
            amounts = (deformed(body, old).mass @ values.T).T
            values = np.stack([solve(amount) for amount in amounts])
        system = ReactionDiffusion(space, evolving.turing.kinetics, found.d_u, found.d_v)
        for moment in march(system, values, until=evolving.pace * dt, tolerance=evolving.tolerance):
            values = moment.state
            if moment.steps > 1000:
                raise NotConvergedError(
                    f"the pattern took more than 1000 steps for {evolving.pace * dt:.4g} units of kinetic "
                    f"time, from {before.time:.4g} on: it never rests; use a smaller pace or other kinetics.",
                    time=before.time,
                )
        refuse_negative(evolving.turing.kinetics, values, before.time)
        activator, inhibitor = values[list(order)]
        return {
            "activator": activator,
            "inhibitor": inhibitor,
            "pattern": normalised(activator),
            "band_displacement": new,
        }


def deformed(body: Body, displacement: Array) -> Discretisation:
    """Return quadratic elements on the band moved by a displacement of its nodes, (2, n_band_nodes)."""
    mesh = body.cortex.mesh
    return discretise(MeshTri2(mesh.doflocs + displacement, mesh.t, validate=False), 2)
