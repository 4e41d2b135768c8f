"""A Turing pattern that lives on the deforming cortex: a process staggered with the growth of the solid."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np
from skfem import Basis, ElementTriP2, MeshTri2

from ..arrays import Array, add_up
from ..checks import between, positive
from ..errors import NotConvergedError
from ..geometry.body import Body
from ..parts import Fields, LongEvolution, Process
from ..state import State
from .integrators.rosenbrock import march
from .kinetics.base import Derivatives, Kinetics, Rates, UniformState
from .process import WRITTEN, Turing, refuse_negative
from .reaction_diffusion import Discretisation, ReactionDiffusion, discretise
from .steady import check_deadline


@dataclass(frozen=True)
class EvolvingTuring(Process):
    """Pattern that starts steady on the undeformed band and goes on reacting and diffusing as tissue grows.

    On the tissue at x(X, t) with change of area J: ∂(J w)/∂t = J J^m f(w) + ∇_X·(J F⁻¹ D F⁻ᵀ ∇_X w). Over a
    step the tissue first moves, which keeps ∫ w dA of every part (dilution), then the pattern evolves on it.

    turing: the pattern at the start; its diffusivities, in m² per unit of kinetic time, stay.
    pace: units of kinetic time per unit of the scene's time; small: the pattern hardly follows the growth.
    dilution: False lets the concentrations be carried along unchanged.
    stretch_exponent: m; reactions run J^m times as fast where the area has changed by J. 0: mechanics only
        moves the pattern; −1: reactions slow down as cells are pulled apart.
    tolerance: local error of the run, relative.

    Reads "displacement", the last equilibrium. Writes "activator" and "inhibitor" as `Turing` does;
    "pattern", the activator above its lowest value relative to its range at the start, so that a pattern
    that dies tends to 0; "activator_range", that range, (); and "band_displacement", (2, n_band_nodes) in m,
    at which they hold. Raises as `Turing` does.
    """

    turing: Turing
    _: KW_ONLY
    pace: float = 1000.0
    dilution: bool = True
    stretch_exponent: float = 0.0
    tolerance: float = 1e-2

    def __post_init__(self) -> None:
        """Check the options."""
        if not isinstance(self.turing, Turing):
            raise ValueError(f"turing={self.turing!r} must be a Turing(...), the pattern to start from.")
        positive("pace", self.pace)
        between("stretch_exponent", self.stretch_exponent, -4.0, 4.0)
        positive("tolerance", self.tolerance, at_most=0.1)

    @property
    def reads(self) -> tuple[str, ...]:
        """The last equilibrium."""
        return ("displacement",)

    @property
    def writes(self) -> tuple[str, ...]:
        """Those of `Turing`, the activator's range at the start, and the displacement at which they hold."""
        return (*WRITTEN, "activator_range", "band_displacement")

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


class EvolvingOnBody(LongEvolution):
    """An evolving pattern on one body."""

    def __init__(self, evolving: EvolvingTuring, body: Body) -> None:
        """Choose the diffusivities."""
        self.evolving, self.body = evolving, body
        self.conditions = evolving.turing.design(body).conditions

    def start(self, state: State, seed: int) -> Fields:
        """Return the steady pattern of the undeformed band."""
        steady = self.evolving.turing.on(self.body)
        steady.deadline = self.deadline
        fields = steady.start(state, seed)
        return {
            **fields,
            "activator_range": np.array(np.ptp(fields["activator"])),
            "band_displacement": np.zeros((2, len(self.body.cortex.nodes))),
        }

    def advance(self, before: State, now: State, dt: float) -> Fields:
        """Return the pattern after the tissue has moved to the last equilibrium and dt has passed."""
        evolving, found, body = self.evolving, self.conditions, self.body
        old, new = before["band_displacement"], before["displacement"][:, body.cortex.nodes]
        order = [0, 1] if found.activator == "u" else [1, 0]
        values = np.stack([before["activator"], before["inhibitor"]])[order]
        space = deformed(body, new)
        if evolving.dilution and (new != old).any():
            # M_new w = M_old w_old: nothing is made or lost while the tissue moves
            solve = space.sparsity.scalar_solver(space.mass.data)
            amounts = (deformed(body, old).mass @ values.T).T
            values = np.stack([solve(amount) for amount in amounts])
        kinetics = self._kinetics(new)
        system = ReactionDiffusion(space, kinetics, found.d_u, found.d_v)
        values = self._evolved(system, values, evolving.pace * dt, before.time)
        refuse_negative(evolving.turing.kinetics, values, before.time)
        activator, inhibitor = values[order]
        return {
            "activator": activator,
            "inhibitor": inhibitor,
            "pattern": (activator - activator.min()) / before["activator_range"],
            "activator_range": before["activator_range"],
            "band_displacement": new,
        }

    def _kinetics(self, new: Array) -> Kinetics:
        kinetics, exponent = self.evolving.turing.kinetics, self.evolving.stretch_exponent
        if exponent == 0:
            return kinetics
        return Accelerated(kinetics, area_change(self.body, new) ** exponent)

    def _evolved(self, system: ReactionDiffusion, values: Array, until: float, time: float) -> Array:
        for moment in march(system, values, until=until, tolerance=self.evolving.tolerance):
            values = moment.state
            check_deadline(self.deadline, time)
            if moment.steps > 1000:
                raise NotConvergedError(
                    f"the pattern took more than 1000 steps for {until:.4g} units of kinetic time, from "
                    f"{time:.4g} on: it never rests; use a smaller pace or other kinetics.",
                    time=time,
                )
        return values


@dataclass(frozen=True, eq=False)
class Accelerated(Kinetics):
    """Another kinetics whose rates are multiplied by a factor, (n_nodes,)."""

    kinetics: Kinetics
    factor: Array
    published_ratio: ClassVar[float] = 1.0

    def __post_init__(self) -> None:
        """Check the factor."""
        if not (self.factor > 0).all():
            raise ValueError(f"factor={self.factor.min():g} must be positive everywhere.")

    @property
    def non_negative(self) -> bool:  # type: ignore[override]
        """As the kinetics."""
        return self.kinetics.non_negative

    def rates(self, u: Array, v: Array) -> Rates:
        """Return the rates, faster by the factor."""
        p, q = self.kinetics.rates(u, v)
        return self.factor * p, self.factor * q

    def derivatives(self, u: Array, v: Array) -> Derivatives:
        """Return ∂p/∂u, ∂p/∂v, ∂q/∂u, ∂q/∂v, larger by the factor."""
        p_u, p_v, q_u, q_v = self.kinetics.derivatives(u, v)
        return self.factor * p_u, self.factor * p_v, self.factor * q_u, self.factor * q_v

    def steady_states(self) -> tuple[UniformState, ...]:
        """Return those of the kinetics."""
        return self.kinetics.steady_states()


def moved(body: Body, displacement: Array) -> MeshTri2:
    """Return the band moved by a displacement of its nodes, (2, n_band_nodes)."""
    mesh = body.cortex.mesh
    return MeshTri2(mesh.doflocs + displacement, mesh.t, validate=False)


def deformed(body: Body, displacement: Array) -> Discretisation:
    """Return quadratic elements on the band moved by a displacement of its nodes, (2, n_band_nodes)."""
    return discretise(moved(body, displacement), 2)


def area_change(body: Body, displacement: Array) -> Array:
    """Return the change of area J at the band's nodes, (n_nodes,): the mean of the elements around each."""
    sums = []
    for mesh in (body.cortex.mesh, moved(body, displacement)):
        basis = Basis(mesh, ElementTriP2(), intorder=4)
        areas = np.broadcast_to(basis.dx.sum(axis=1), basis.element_dofs.shape)
        sums.append(add_up(basis.element_dofs, areas, basis.N))
    return np.asarray(sums[1] / sums[0])
