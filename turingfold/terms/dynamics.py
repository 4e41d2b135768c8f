"""Inertia and drag as incremental potentials: ½‖u - û‖² in the mass norm over dt² or dt."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Array, add_up
from ..checks import one_of, positive
from ..geometry.body import Body, by_node
from ..parts import Hessian, SimplePotential
from ..state import State
from .element_matrices import HIGH, LOW, lower, pairs

SCHEMES = ("euler", "midpoint")


def balanced_at(scheme: str) -> float:
    """Return the share of a step after which forces balance by a scheme."""
    return 1.0 if scheme == "euler" else 0.5


@dataclass(frozen=True, kw_only=True)
class Inertia:
    """Mass per volume of the undeformed body; makes the march a motion from rest, with time in s.

    density in kg/m³. scheme "euler": backward Euler, first order, never gains energy; "midpoint": implicit
    midpoint, second order, loses none: Φ = 2/dt² ‖x - u - dt v/2‖²_M at the middle x of the step.
    """

    density: float
    scheme: str = "euler"

    ends_step = True

    def __post_init__(self) -> None:
        positive("density", self.density, remedy="give the mass density in kg/m³, 1100 for brain tissue")
        one_of("scheme", self.scheme, SCHEMES)

    @property
    def reads(self) -> tuple[str, ...]:
        """The displacement before the step; the velocity is its own."""
        return ("displacement",)

    def on(self, body: Body) -> InertiaOperator:
        """Return the term discretised on `body`."""
        return InertiaOperator(Mass(body, self.density), balanced_at(self.scheme))


@dataclass(frozen=True, kw_only=True)
class Drag:
    """Force per volume against the velocity, c ∂u/∂t; it carries quasi-static paths through instabilities.

    coefficient c in Pa·s/m² (with a dimensionless time: in Pa/m²).
    scheme: that of the scene's Inertia; with "midpoint" forces balance after half of the step, and the scene
    needs Inertia, which moves the body on to the end of it.
    """

    coefficient: float
    scheme: str = "euler"

    ends_step = False

    def __post_init__(self) -> None:
        positive("coefficient", self.coefficient, remedy="leave Drag out for none")
        one_of("scheme", self.scheme, SCHEMES)

    @property
    def reads(self) -> tuple[str, ...]:
        """The displacement before the step."""
        return ("displacement",)

    def on(self, body: Body) -> DragOperator:
        """Return the term discretised on `body`."""
        return DragOperator(Mass(body, self.coefficient), balanced_at(self.scheme))


class Mass:
    """The consistent mass matrix ∫ ρ u·v dA of a body, kept as element entries."""

    def __init__(self, body: Body, density: float) -> None:
        self.triangles, quadrature = body.triangles, body.quadrature
        shapes = quadrature.shapes
        self.entries = density * (shapes[LOW] * shapes[HIGH]) @ quadrature.weights  # (21, e)
        self.rows, self.columns = lower(*pairs(self.triangles))

    def times(self, x: Array) -> Array:
        """Return the product with a vector (2 n_nodes,)."""
        values = x.reshape(-1, 2)
        total = np.empty_like(values)
        for axis in (0, 1):
            at = values[:, axis][self.triangles]
            off = np.where((LOW != HIGH)[:, None], self.entries, 0.0)
            places = np.concatenate([self.triangles[LOW].ravel(), self.triangles[HIGH].ravel()])
            weights = np.concatenate([(self.entries * at[HIGH]).ravel(), (off * at[LOW]).ravel()])
            total[:, axis] = add_up(places, weights, len(values))
        return total.ravel()

    @cached_property
    def twice(self) -> Array:
        """Entries for both components, (42, e)."""
        return np.concatenate([self.entries, self.entries])


class InertiaOperator:
    """Inertia on one body; forces balance at the share `reach` of the step, 1 (end) or 1/2 (middle)."""

    grounds = True  # a body with mass needs no support

    def __init__(self, mass: Mass, reach: float) -> None:
        self.mass, self.reach = mass, reach

    def during(self, state: State, dt: float) -> InertiaPotential:
        """Return the potential of one step."""
        old = by_node(state["displacement"])
        velocity = by_node(state["velocity"]) if "velocity" in state else np.zeros_like(old)
        return InertiaPotential(
            self.mass, old + self.reach * dt * velocity, self.reach * dt, old, velocity, dt
        )


@dataclass(frozen=True)
class _TowardsTarget(SimplePotential):
    """½ weight ‖x - target‖²_M, with M and weight given by the part that uses it."""

    mass: Mass
    target: Array
    span: float  # the time over which the target is left

    weight_power = 2

    def evaluate(self, x: Array) -> MassEvaluation:
        """Return energy and derivatives at x."""
        return MassEvaluation(self.mass, x - self.target, self.span**-self.weight_power)


@dataclass(frozen=True)
class InertiaPotential(_TowardsTarget):
    """Inertia over one step from displacement `old` and `velocity`."""

    old: Array
    velocity: Array
    dt: float

    def finish(self, x: Array) -> dict[str, Array]:
        """Return displacement and velocity at the end of the step, each (2, n_nodes)."""
        end = x if self.span == self.dt else self.old + (x - self.old) * (self.dt / self.span)
        return {
            "displacement": end.reshape(-1, 2).T.copy(),
            "velocity": self._velocity(end).reshape(-1, 2).T.copy(),
        }

    def _velocity(self, end: Array) -> Array:
        mean = (end - self.old) / self.dt
        share = self.dt / self.span  # 1: the mean velocity is the new one; 2: the average of old and new
        return share * mean - (share - 1.0) * self.velocity

    def measure(self, x: Array) -> dict[str, float]:
        """Return the kinetic energy at the end of the step, J/m."""
        velocity = self._velocity(x)
        return {"kinetic_energy": 0.5 * float(velocity @ self.mass.times(velocity))}


class DragOperator:
    """Drag on one body; forces balance at the share `reach` of the step, 1 (end) or 1/2 (middle)."""

    grounds = True

    def __init__(self, mass: Mass, reach: float) -> None:
        self.mass, self.reach = mass, reach

    def during(self, state: State, dt: float) -> DragPotential:
        """Return the potential of one step."""
        return DragPotential(self.mass, by_node(state["displacement"]), self.reach * dt)


@dataclass(frozen=True)
class DragPotential(_TowardsTarget):
    """½ c/dt ‖x - u‖²: dissipation over one step."""

    weight_power = 1


class MassEvaluation:
    """½ weight ‖x‖²_M with its derivatives."""

    curved = True

    def __init__(self, mass: Mass, x: Array, weight: float) -> None:
        self.mass, self.weight = mass, weight
        self.force = weight * mass.times(x)
        self.energy = 0.5 * float(self.force @ x)
        self.grain = 1e-15 * self.energy

    def gradient(self) -> tuple[Array, float]:
        """Return the forces and their sum of squares."""
        return self.force, float(self.force @ self.force)

    def hessian(self, convexity: float) -> Hessian:
        """Return the weighted mass matrix."""
        return Hessian(self.mass.rows, self.mass.columns, self.weight * self.mass.twice, lasting=True)
