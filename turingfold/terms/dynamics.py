"""Inertia and drag as incremental potentials: ½‖x - x₀‖² in the mass norm over dt² or dt."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..checks import positive
from ..geometry.body import Body, by_node
from ..parts import Entries, Fields, Hessian, Operator, Term, TimeStep
from ..state import State
from .element_matrices import HIGH, LOW, lower, pairs
from .quadratic_energy import Quadratic, QuadraticEvaluation, SymmetricMatrix


@dataclass(frozen=True, kw_only=True)
class Inertia(Term):
    """Mass per volume of the undeformed body; makes the march a motion from rest, with time in s.

    With forces that balance after the share β of a step dt (`Stepping.scheme`),
    Φ = ½ ‖x - u - β dt v‖²_M / (β dt)² at the displacement x of that time, u and v those before the step.
    density in kg/m³.  Writes "velocity", (2, n_nodes) in m/s.
    """

    density: float

    def __post_init__(self) -> None:
        positive("density", self.density, remedy="give the mass density in kg/m³, 1100 for brain tissue")

    @property
    def reads(self) -> tuple[str, ...]:
        """The displacement before the step."""
        return ("displacement",)

    @property
    def optional(self) -> tuple[str, ...]:
        """The velocity before the step; at the start the body is at rest."""
        return ("velocity",)

    @property
    def writes(self) -> tuple[str, ...]:
        """The velocity at the end of the step."""
        return ("velocity",)

    @property
    def resists_motion(self) -> bool:
        """It does."""
        return True

    def on(self, body: Body) -> InertiaOperator:
        """Return the term on a body."""
        return InertiaOperator(mass(body, self.density))


@dataclass(frozen=True, kw_only=True)
class Drag(Term):
    """Force per volume against the velocity, c ∂u/∂t; it carries quasi-static paths through instabilities.

    coefficient c in Pa·s/m² (with a dimensionless time: in Pa/m²).
    """

    coefficient: float

    def __post_init__(self) -> None:
        positive("coefficient", self.coefficient, remedy="leave Drag out for none")

    @property
    def reads(self) -> tuple[str, ...]:
        """The displacement before the step."""
        return ("displacement",)

    @property
    def resists_motion(self) -> bool:
        """It does."""
        return True

    def on(self, body: Body) -> DragOperator:
        """Return the term on a body."""
        return DragOperator(mass(body, self.coefficient))


def mass(body: Body, density: float) -> SymmetricMatrix:
    """Return the consistent mass matrix ∫ ρ u·v dA of a body."""
    shapes = body.quadrature.shapes
    entries = density * (shapes[LOW] * shapes[HIGH]) @ body.quadrature.weights  # (21, e)
    both = Hessian(Entries(*lower(*pairs(body.triangles))), np.concatenate([entries, entries]))
    return SymmetricMatrix.from_lower(both, body.nodes.size)


@dataclass(frozen=True, eq=False)
class InertiaOperator(Operator):
    """Inertia on one body."""

    mass: SymmetricMatrix

    @property
    def resists_rigid_motions(self) -> bool:
        """A body with mass needs no support."""
        return True

    def during(self, state: State, step: TimeStep) -> InertiaPotential:
        """Return the potential of one step."""
        old = by_node(state["displacement"])
        velocity = by_node(state["velocity"]) if "velocity" in state else np.zeros_like(old)
        target = old + step.span * velocity
        return InertiaPotential(self.mass, target, step.span**-2, old=old, velocity=velocity, step=step)


@dataclass(frozen=True, eq=False, kw_only=True)
class InertiaPotential(Quadratic):
    """Inertia over one step from the displacement `old` and the velocity before it."""

    old: Array
    velocity: Array
    step: TimeStep

    def evaluate(self, x: Array) -> InertiaEvaluation:
        """Return energy and derivatives at x."""
        return InertiaEvaluation(self, x)

    def velocity_at_end(self, end: Array) -> Array:
        """Return the velocity at the end of a step to a displacement, (2 n_nodes,)."""
        mean = (end - self.old) / self.step.length
        share = 1 / self.step.balance  # 1: the mean velocity is the new one; 2: the average of old and new
        return share * mean - (share - 1.0) * self.velocity


class InertiaEvaluation(QuadraticEvaluation):
    """Inertia at one displacement."""

    potential: InertiaPotential

    def finish(self, wanted: frozenset[str]) -> Fields:
        """Return the velocity at the end of the step, (2, n_nodes)."""
        potential = self.potential
        end = potential.old + (self.x - potential.old) / potential.step.balance
        return {"velocity": potential.velocity_at_end(end).reshape(-1, 2).T.copy()}

    def measure(self) -> dict[str, float]:
        """Return the kinetic energy, x being the end of the step; J/m."""
        velocity = self.potential.velocity_at_end(self.x)
        return {"kinetic_energy": 0.5 * float(velocity @ (self.potential.matrix.whole @ velocity))}


@dataclass(frozen=True, eq=False, kw_only=True)
class Dissipation(Quadratic):
    """The potential ½ (x - u)·C (x - u)/(β dt) of forces against the velocity, C v, over a step.

    name: of the work done against them, in the history.
    """

    step: TimeStep
    name: str

    def evaluate(self, x: Array) -> DissipationEvaluation:
        """Return energy and derivatives at x."""
        return DissipationEvaluation(self, x)


class DissipationEvaluation(QuadraticEvaluation):
    """Dissipation at one displacement."""

    potential: Dissipation

    def measure(self) -> dict[str, float]:
        """Return the work that the step turns into heat, dt v·C v, x being the end of the step; J/m."""
        return {self.potential.name: 2.0 * self.potential.step.balance * self.energy}


@dataclass(frozen=True, eq=False)
class DragOperator(Operator):
    """Drag on one body."""

    mass: SymmetricMatrix

    @property
    def resists_rigid_motions(self) -> bool:
        """A body in a viscous medium needs no support."""
        return True

    def during(self, state: State, step: TimeStep) -> Dissipation:
        """Return the potential of one step, ½ c/dt ‖x - u‖²."""
        old = by_node(state["displacement"])
        return Dissipation(self.mass, old, 1 / step.span, step=step, name="drag_work")
