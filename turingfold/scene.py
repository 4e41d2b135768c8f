"""What a scene is made of: state, processes, terms, and the errors a run can end with.

A `Process` changes fields between equilibria (pattern, growth). A `Term` contributes potential energy
(elasticity, tension, contact, inertia). Both are frozen descriptions; what is computed from them lives in the
objects they return. Parts do not know each other: they meet in the state, by field name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import combinations
from types import MappingProxyType
from typing import Any, Protocol, runtime_checkable

from .arrays import Array, Integers
from .body import Body
from .checks import instance, positive, whole
from .stepping import Stepping as Stepping


class SolveError(RuntimeError):
    """A solve that stopped; `time` says when, `residual` how far from balance, the message what to try."""

    def __init__(self, message: str, *, time: float = float("nan"), residual: float = float("nan")) -> None:
        super().__init__(message)
        self.time = time
        self.residual = residual


class NotConvergedError(SolveError):
    """An equilibrium or steady state was not reached."""


class InadmissibleStateError(SolveError):
    """A state with a non-finite value, an inverted element or an intersection."""


class MissingFieldError(ValueError):
    """A part reads a field that no earlier process writes."""


@dataclass(frozen=True)
class State:
    """Fields at one time: displacement (2, n_nodes) in m, and whatever processes and terms have written."""

    time: float
    fields: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "fields", MappingProxyType(dict(self.fields)))

    def __getitem__(self, name: str) -> Array:
        return self.fields[name]

    def __contains__(self, name: str) -> bool:
        return name in self.fields

    def updated(self, time: float | None = None, /, **fields: Array) -> State:
        """Return a copy with some fields, and possibly the time, replaced."""
        return State(self.time if time is None else time, {**self.fields, **fields})


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


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A body, the potential terms acting on it, and the processes that change it; only what is listed exists.

    Raises MissingFieldError if a part reads a field that no earlier process writes, ValueError for a process
    that would overwrite what an earlier one wrote, without reading it, for two terms of a kind that are no
    different loads, and for the rest.
    """

    body: Body
    terms: tuple[Term, ...]
    processes: tuple[Process, ...] = ()
    until: float = 1.0
    seed: int = 0
    stepping: Stepping = field(default_factory=Stepping)

    def __post_init__(self) -> None:
        instance("body", self.body, Body, "semicircle(radius=0.04, thickness=0.0025, size=0.001)")
        instance("stepping", self.stepping, Stepping, "Stepping(largest=0.02)")
        object.__setattr__(self, "terms", _parts("terms", self.terms, Term))
        object.__setattr__(self, "processes", _parts("processes", self.processes, Process))
        positive("until", self.until)
        whole("seed", self.seed, at_least=0)
        if not self.terms:
            raise ValueError("terms=() is empty; a scene needs at least one term, such as Elastic(...).")
        _distinct(self.terms)
        _at_one_time(self.terms)
        written = {"displacement", "stress_scale"}
        for part in self.processes:
            _written(part, part.reads, written)
            _kept(part, written)
            written |= set(part.writes)
        for term in self.terms:
            _written(term, term.reads, written)


def stress_scale(terms: tuple[Term, ...]) -> float:
    """Return the largest shear modulus of the solids among the terms, or 1 Pa: the unit of stress."""
    return max((float(term.stress) for term in terms if isinstance(term, Solid)), default=1.0)


def _parts(name: str, parts: Any, kind: type) -> tuple[Any, ...]:
    listed: tuple[Any, ...] = tuple(parts) if isinstance(parts, (tuple, list)) else (parts,)
    for part in listed:
        if isinstance(part, type):
            raise ValueError(f"{name} holds the class {part.__name__}; write {part.__name__}(...) instead.")
        if not isinstance(part, kind):
            raise ValueError(
                f"{name} holds {part!r}, which is no {kind.__name__}; "
                "patterns and growth go into processes, everything with an energy into terms."
            )
    return listed


def _distinct(terms: tuple[Term, ...]) -> None:
    for one, other in combinations(terms, 2):
        if not (isinstance(one, type(other)) or isinstance(other, type(one))):
            continue
        if not isinstance(other, Load) or one == other:
            raise ValueError(
                f"terms holds two {type(other).__name__}, {one!r} and {other!r}, and both would count; leave "
                "one of the two out (a class of loads that may differ derives from turingfold.scene.Load)."
            )


def _at_one_time(terms: tuple[Term, ...]) -> None:
    timed = [term for term in terms if isinstance(term, Timed)]
    names = " and ".join(f"{type(term).__name__}(scheme={term.scheme!r})" for term in timed)
    if len({term.scheme for term in timed}) > 1:
        raise ValueError(
            f"terms holds {names}, but forces balance at one time of a step; give them the same scheme."
        )
    if any(term.scheme == "midpoint" for term in timed) and not any(term.ends_step for term in timed):
        raise ValueError(
            f"terms holds {names}, by which forces balance in the middle of a step, but no term that moves "
            'the body on to its end; give scheme="euler", or add inertia, which does.'
        )


def _written(part: object, reads: tuple[str, ...], written: set[str]) -> None:
    for name in reads:
        if name not in written:
            raise MissingFieldError(
                f"{type(part).__name__} reads the field {name!r}, which no earlier process writes "
                f"(written: {', '.join(sorted(written))}); add a process that writes it, before this part."
            )


def _kept(part: Process, written: set[str]) -> None:
    for name in part.writes:
        if name in written and name not in part.reads:
            raise ValueError(
                f"{type(part).__name__} writes the field {name!r}, which an earlier process has written; "
                "leave one of the two out."
            )
