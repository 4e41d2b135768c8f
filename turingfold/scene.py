"""A scene: a body, the parts that act on it, and how it is marched through time.

A `Process` changes fields between equilibria (pattern, growth). A `Term` contributes potential energy
(elasticity, tension, contact, inertia). Both are frozen descriptions; what is computed from them lives in the
objects they return. Parts do not know each other: they meet in the state, by field name.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

from .checks import instance, positive, whole
from .errors import MissingFieldError
from .geometry.body import Body
from .parts import Load, Process, Solid, Term, Timed
from .stepping import Stepping as Stepping


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


def reached(scene: Scene, time: float) -> bool:
    """Return whether a time is the end of a scene, to round-off."""
    return time >= scene.until * (1 - 1e-12)


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
