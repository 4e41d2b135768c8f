"""Damping proportional to stiffness: with drag, which is proportional to mass, it is Rayleigh's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..checks import instance, positive
from ..geometry.body import Body, by_node
from ..parts import Operator, Term, TimeStep
from ..state import State
from .dynamics import Dissipation
from .elastic.term import Elastic
from .quadratic_energy import SymmetricMatrix


@dataclass(frozen=True, kw_only=True)
class StiffnessDamping(Term):
    """Force β K₀ ∂u/∂t against deformation, with K₀ the tangent of the undeformed, ungrown body.

    Over one step Φ = β/(2 dt) (x - u)ᵀ K₀ (x - u). With Drag(coefficient=α ρ) it makes Rayleigh's damping
    α M + β K₀, under which a small vibration of frequency ω has the damping ratio ζ = (α/ω + β ω)/2.
    elastic: the solid whose stiffness it is, usually that of the scene; the field "modulus_factor" scales it.
    time: β in s (in units of the scene's time).
    It does not resist translation. As K₀ does not turn with the body, it resists rotation at the rate ω once
    the body has turned by an angle φ, with forces in proportion to ω sin φ; use it where rotations are small.
    """

    elastic: Elastic
    time: float

    def __post_init__(self) -> None:
        instance("elastic", self.elastic, Elastic, "Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))")
        positive("time", self.time, remedy="leave StiffnessDamping out for none")

    @property
    def reads(self) -> tuple[str, ...]:
        """The displacement before the step."""
        return ("displacement",)

    @property
    def optional(self) -> tuple[str, ...]:
        """The factor of the moduli."""
        return ("modulus_factor",)

    @property
    def resists_motion(self) -> bool:
        """It does."""
        return True

    def on(self, body: Body) -> DampingOperator:
        """Return the term on a body."""
        return DampingOperator(self.elastic.on(body), self.time)


class DampingOperator(Operator):
    """Damping on one body."""

    def __init__(self, elastic: Operator, time: float) -> None:
        self.elastic, self.time = elastic, time
        self._known: tuple[Array | None, SymmetricMatrix] | None = None  # the factor, and K₀ with it

    def during(self, state: State, step: TimeStep) -> Dissipation:
        """Return the potential of one step."""
        old, factor = by_node(state["displacement"]), state.fields.get("modulus_factor")
        if self._known is None or self._known[0] is not factor:
            self._known = factor, self._at_rest(state)
        return Dissipation(self._known[1], old, self.time / step.span, step=step, name="damping_work")

    def _at_rest(self, state: State) -> SymmetricMatrix:
        factor = {name: state[name] for name in ("modulus_factor",) if name in state}
        solid = self.elastic.during(State(0.0, factor), TimeStep(1.0))
        at = None if solid is None else solid.evaluate(np.zeros(state["displacement"].size))
        assert at is not None  # an undeformed body is admissible
        return SymmetricMatrix.from_lower(at.hessian(0.0), state["displacement"].size)
