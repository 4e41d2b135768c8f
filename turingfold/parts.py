"""What a part of a scene offers: processes change fields, terms contribute potential energy.

A `Process` changes fields between equilibria (pattern, growth). A `Term` contributes potential energy
(elasticity, tension, contact, inertia). Both are frozen descriptions; what is computed from them lives in the
objects they return. Parts do not know each other: they meet in the state, by field name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from .arrays import Array, Integers
from .geometry.body import Body
from .state import State


@runtime_checkable
class Process(Protocol):
    """Changes fields between equilibria."""

    @property
    def reads(self) -> tuple[str, ...]:
        """Names of the fields needed."""

    @property
    def writes(self) -> tuple[str, ...]:
        """Names of the fields made."""

    def start(self, body: Body, state: State, seed: int) -> dict[str, Array]:
        """Return the fields at the start; `state` holds those of earlier processes."""

    def advance(self, body: Body, state: State, dt: float) -> dict[str, Array]:
        """Return the fields at `state.time + dt`; empty where nothing changes."""


class Evaluation(Protocol):
    """A potential at one configuration; gradient and Hessian are computed when asked for, once."""

    energy: float
    grain: float  # differences of energy below this are round-off
    curved: bool  # whether there is a Hessian

    def gradient(self) -> tuple[Array, float]:
        """Return the gradient (2 n_nodes,) and the square of the force it is small or large against."""

    def hessian(self, convexity: float) -> Hessian:
        """Return the Hessian, blended from the true one (0) to its positive semi-definite projection (1)."""


@dataclass(frozen=True)
class Hessian:
    """Lower-triangle entries: `values` at (`rows`, `columns`), repeated places adding up.

    lasting: the two index arrays are the same objects each time, so their places need be found only once.
    room: rows and columns of entries that may come soon, asked for when places are made.
    """

    rows: Integers
    columns: Integers
    values: Array
    lasting: bool
    room: Callable[[], tuple[Integers, Integers]] | None = None


class Potential(Protocol):
    """A term on a body with the fields of one step frozen; x: displacement (2 n_nodes,), node by node."""

    def evaluate(self, x: Array) -> Evaluation | None:
        """Return the evaluation at x, or None where the energy is infinite there."""

    def largest_step(self, x: Array, direction: Array) -> float:
        """Return a step in (0, 1] along `direction` that keeps the state admissible."""

    def finish(self, x: Array) -> dict[str, Array]:
        """Return the fields that the next step needs, such as a velocity, or a displacement other than x."""

    def observe(self, x: Array) -> dict[str, Array]:
        """Return fields to look at, such as a stress."""

    def measure(self, x: Array) -> dict[str, float]:
        """Return numbers for the history, such as the smallest gap."""


class SimplePotential:
    """What most potentials do beside having an energy: bound no step, leave nothing behind, show nothing."""

    def largest_step(self, x: Array, direction: Array) -> float:
        """Any step is admissible."""
        return 1.0

    def finish(self, x: Array) -> dict[str, Array]:
        """Nothing is left for the next step."""
        return {}

    def observe(self, x: Array) -> dict[str, Array]:
        """Nothing to look at."""
        return {}

    def measure(self, x: Array) -> dict[str, float]:
        """Nothing to report."""
        return {}


class Operator(Protocol):
    """A term discretised on a body: everything that is computed once.

    grounds: whether it resists rigid motions, so that a free body need not be held in place.
    """

    grounds: bool

    def during(self, state: State, dt: float) -> Potential | None:
        """Return the potential of the step that ends in `state`, or None if the term does nothing in it.

        `state` has the new time and the new fields of the processes, and the old displacement and velocity.
        """


@runtime_checkable
class Term(Protocol):
    """Contributes potential energy, in J per m of depth."""

    @property
    def reads(self) -> tuple[str, ...]:
        """Names of the fields needed."""

    def on(self, body: Body) -> Operator:
        """Return the term discretised on `body`."""


class Load:
    """Base of terms of which different ones may act in one scene: tensions along two lines add up."""


@runtime_checkable
class Solid(Protocol):
    """A term with moduli; they set the unit of stress."""

    @property
    def stress(self) -> float:
        """The largest shear modulus; Pa."""

    def moduli(self, body: Body) -> tuple[Array, Array]:
        """Return shear and bulk modulus at the integration points, each (q, e); Pa."""


@runtime_checkable
class Timed(Protocol):
    """A term that resists motion, by the scheme that says at what time of a step forces balance."""

    @property
    def scheme(self) -> str:
        """The scheme, "euler" for the end and "midpoint" for the middle of the step."""

    @property
    def ends_step(self) -> bool:
        """Whether its potential moves the body on from the middle to the end of the step (`finish`)."""
