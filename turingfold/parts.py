"""What a part of a scene offers: processes change fields, terms contribute potential energy.

A `Process` changes fields between equilibria (pattern, growth). A `Term` contributes potential energy
(elasticity, tension, contact, inertia). Both are frozen descriptions; what is computed from them on a body
lives in the object that `on(body)` returns. Parts do not know each other: they meet in the state, by the
names of the fields that they declare. A part of a user's own derives from the classes here.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from .arrays import Array, Places
from .geometry.body import Body
from .state import State

Fields = dict[str, Array]
STRESS_FIELDS = (
    "stress_xx",
    "stress_yy",
    "stress_xy",
    "stress_zz",
)  # of the 3D Cauchy stress, where it is shown


class Part(ABC):
    """What processes and terms have in common: the fields by which they meet other parts."""

    @property
    def reads(self) -> tuple[str, ...]:
        """Names of the fields that it needs."""
        return ()

    @property
    def optional(self) -> tuple[str, ...]:
        """Names of the fields that it uses where they exist."""
        return ()

    @property
    def writes(self) -> tuple[str, ...]:
        """Names of the fields that it makes; of those of a term, only what some part reads is made."""
        return ()

    @abstractmethod
    def on(self, body: Body) -> object:
        """Return what is computed once on a body."""


class Evolution(ABC):
    """A process on a body."""

    @abstractmethod
    def start(self, state: State, seed: int) -> Fields:
        """Return the fields at the scene's start; `state` holds those of earlier processes."""

    @abstractmethod
    def advance(self, before: State, now: State, dt: float) -> Fields:
        """Return the fields at the time `now.time`, dt after `before`; empty where nothing changes.

        before: the last accepted state, complete and in equilibrium: displacement, growth and stress belong
        together.  now: the new time, and the fields that earlier processes have at that time.
        """


class LongEvolution(Evolution):
    """A process on a body whose start or steps may take long.

    deadline: of `time.perf_counter`, set before `start`; work that passes it ends with a NotConvergedError.
    """

    deadline: float = math.inf


class Process(Part):
    """Changes fields between equilibria."""

    @property
    def keeps(self) -> tuple[str, ...]:
        """Names of those it writes that no other part has to read: results in themselves, and its memory."""
        return ()

    @property
    def remembers(self) -> bool:
        """Whether its fields depend on the steps by which a time was reached, and not on the time alone."""
        return False

    @abstractmethod
    def on(self, body: Body) -> Evolution:
        """Return the process on a body."""


@dataclass(frozen=True, eq=False)
class Entries:
    """Places of matrix entries in the lower triangle; repeated places add up; both of one shape."""

    rows: Places
    columns: Places


@dataclass(frozen=True)
class Hessian:
    """Second derivatives: `values` at the places `entries`, of one shape.

    constant: whether the places are the same object at every evaluation, so that they are sorted once.
    expected: returns places of entries that may come soon, asked for when the matrix gets a new sparsity.
    """

    entries: Entries
    values: Array
    constant: bool = True
    expected: Callable[[], Entries] | None = None


class Evaluation(ABC):
    """A potential at one displacement, with everything that was computed there.

    energy: J per m of depth.  round_off: differences of energy below this are round-off.
    has_hessian: whether the energy has a Hessian other than zero.
    """

    energy: float
    round_off: float = 0.0
    has_hessian: bool = True

    @abstractmethod
    def gradient(self) -> tuple[Array, float]:
        """Return the gradient (2 n_nodes,) and the square of the force that it is small or large against."""

    @abstractmethod
    def hessian(self, convexity: float) -> Hessian:
        """Return the Hessian, blended from the true one (0) to its positive semi-definite projection (1)."""

    def largest_step(self, direction: Array) -> float:
        """Return a step in (0, 1] along a direction (2 n_nodes,) that keeps the state admissible: any."""
        return 1.0

    def finer(self) -> Potential | None:
        """Return a finer potential with which the step is to be taken again: none, this one does."""
        return None

    def is_valid(self) -> bool:
        """Return whether this may be a body: nothing is turned over and no walls cross, as far as it sees."""
        return True

    def finish(self, wanted: frozenset[str]) -> Fields:
        """Return, of the fields that the term writes, those wanted: none."""
        return {}

    def observe(self) -> Fields:
        """Return fields to look at, such as stresses, each (q, e): none."""
        return {}

    def measure(self) -> dict[str, float]:
        """Return numbers for the history, such as the smallest gap: none."""
        return {}


class Abrupt(Evaluation):
    """An evaluation whose curvature comes and goes within a short way, as that of walls which touch.

    Where a tangent is not positive definite, such energies are made convex first, and alone if that will do.
    """


class SearchLine(ABC):
    """One energy along x + s d, as a line search sees it.

    start: merit at s = 0.  excess: by how much the slope of the merit there exceeds that of the energy.
    longest: step in (0, 1] that keeps the state admissible.
    """

    start: float
    excess: float = 0.0
    longest: float

    @abstractmethod
    def at(self, step: float) -> tuple[float, Evaluation] | None:
        """Return merit and evaluation at s = step, or None where the energy is infinite."""


class Condensed(Evaluation):
    """An evaluation whose unknowns inside the elements are eliminated, and move along with the nodes.

    A nearly incompressible solid has a narrow, curved valley of admissible volume: a step along the straight
    Newton direction climbs its wall, and a search on the energy alone would cut every step down. So it gives
    the merit of the search itself.
    """

    @abstractmethod
    def along(self, direction: Array, decrease: float) -> SearchLine:
        """Return the search line along `direction` (2 n_nodes,); decrease: slope of all energy along it."""


class Potential(ABC):
    """A term on a body with the fields of one step frozen: an energy as a function of the displacement."""

    @abstractmethod
    def evaluate(self, x: Array) -> Evaluation | None:
        """Return the evaluation at a displacement (2 n_nodes,), node by node; None for infinite energy."""


@dataclass(frozen=True)
class TimeStep:
    """A step in time: its length, and the share of it after which forces balance, 1 (end) or 1/2 (middle).

    over: whether the state is that at the step's end, to be seen as it was found, and not the one before.
    """

    length: float
    balance: float = 1.0
    over: bool = False

    @property
    def span(self) -> float:
        """The time from the start of the step until forces balance."""
        return self.balance * self.length


class Operator(ABC):
    """A term on a body: everything that is computed once."""

    @property
    def resists_rigid_motions(self) -> bool:
        """Whether it holds a body that nothing else supports."""
        return False

    def check_balance(self) -> None:
        """Raise ValueError for forces that would move the body where neither base nor a term holds it."""
        return

    @abstractmethod
    def during(self, state: State, step: TimeStep) -> Potential | None:
        """Return the potential of a step, or None if the term does nothing in it.

        state: has the time at which forces balance and the fields of the processes at that time; displacement
        and what terms have written are those before the step, or, if that is over, at its end.
        """


class Term(Part):
    """Contributes potential energy, in J per m of depth."""

    @property
    def resists_motion(self) -> bool:
        """Whether its energy depends on the equilibrium before the step, as of inertia and drag."""
        return False

    @abstractmethod
    def on(self, body: Body) -> Operator:
        """Return the term on a body."""

    def for_states_of(self, body: Body) -> Term:
        """Return the term for a finer mesh on which states of a body are looked at.

        It is the term itself, unless what it admits depends on the mesh.
        """
        return self


class Load(Term):
    """Base of terms of which different ones may act in one scene: tensions along two lines add up."""

    def doubt(self, body: Body, shear_modulus: float) -> str:
        """Return why its size looks like a mistake on a body of this stiffness (Pa), or ""."""
        return ""


class Solid(Term):
    """Base of terms with moduli; the largest shear modulus is the scene's unit of stress."""

    @property
    @abstractmethod
    def shear_modulus(self) -> float:
        """The largest shear modulus; Pa."""

    @abstractmethod
    def moduli(self, body: Body) -> tuple[Array, Array]:
        """Return shear and bulk modulus at the integration points, each (q, e); Pa."""


def check_kind(part: Part, found: object, kind: type) -> None:
    """Raise ValueError where a part's `on` returned something else than what derives from a class."""
    if not isinstance(found, kind):
        raise ValueError(
            f"{type(part).__name__}.on returned {str(found)[:60]}; it must return what derives from "
            f"turingfold.extend.{kind.__name__}."
        )


def declared(part: Part, fields: object, by: str) -> Mapping[str, Array]:
    """Return the fields that a part made; raises ValueError for what is no dict of those it declares.

    by: "start", which makes all of them, or "advance", which may leave out what does not change.
    """
    name, writes = f"{type(part).__name__}.{by}", ", ".join(part.writes) or "none"
    if not isinstance(fields, dict) or not set(fields) <= set(part.writes):
        raise ValueError(
            f"{name} returned {str(fields)[:60]}; it must be a dict of the fields it declares in `writes` "
            f"({writes}), {{}} where nothing changes."
        )
    if by == "start" and (missing := [field for field in part.writes if field not in fields]):
        raise ValueError(
            f"{name} made no {missing[0]!r}; it makes every field that it declares in `writes` ({writes})."
        )
    for field, values in fields.items():
        if not isinstance(values, np.ndarray):
            raise ValueError(f"{name} made {field!r} of {type(values).__name__}; it must be a numpy array.")
    return fields
