"""A scene: a body, the parts that act on it, and how it is marched through time."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from difflib import get_close_matches
from itertools import combinations
from typing import Any

from .checks import instance, positive, whole
from .errors import MissingFieldError
from .geometry.body import Body
from .parts import Load, Part, Process, Solid, Term
from .stepping import MIDPOINT, Stepping

GIVEN = ("displacement", "stress_scale")  # fields that every state has


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A body, the potential terms acting on it, and the processes that change it; only what is listed exists.

    until: end of the run, in the scene's time.  seed: of everything random in it.
    Raises MissingFieldError if a part reads a field that no part makes in time; ValueError for a field that
    nobody reads, for a process that would overwrite what an earlier one wrote, for two terms of a kind that
    are no different loads, for a scheme that the terms do not suit, and for the rest.
    Warns of loads far beyond the stiffness.
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
        object.__setattr__(self, "terms", _listed("terms", self.terms, Term))
        object.__setattr__(self, "processes", _listed("processes", self.processes, Process))
        positive("until", self.until)
        if (last := max(self.stepping.stops, default=0.0)) > self.until * (1 + 1e-12):
            raise ValueError(
                f"Stepping(stops=...) holds {last:g}, after the scene's end until={self.until:g}; leave that "
                "stop out or make until larger."
            )
        whole("seed", self.seed, at_least=0)
        if not self.terms:
            raise ValueError("terms=() is empty; a scene needs at least one term, such as Elastic(...).")
        _check_distinct(self.terms)
        _check_scheme(self.terms, self.processes, self.stepping)
        by_terms = {name for term in self.terms for name in term.writes}
        written = {*GIVEN, *by_terms}
        for process in self.processes:
            _check_reads(process, written)
            _check_overwrites(process, written)
            written |= set(process.writes)
        for term in self.terms:
            _check_reads(term, written)
        for process in self.processes:
            _check_read(process, self.processes, self.terms)
        for load in (term for term in self.terms if isinstance(term, Load)):
            if words := load.doubt(self.body, stress_scale(self.terms)):
                warnings.warn(words, stacklevel=3)

    @property
    def wanted(self) -> frozenset[str]:
        """Names of the fields that some part reads."""
        return frozenset(name for part in (*self.processes, *self.terms) for name in _read_by(part))


def reached(scene: Scene, time: float) -> bool:
    """Return whether a time is the end of a scene, to round-off."""
    return time >= scene.until * (1 - 1e-12)


def stress_scale(terms: Iterable[Term]) -> float:
    """Return the largest shear modulus of the solids among the terms, or 1 Pa: the unit of stress."""
    return max((float(term.shear_modulus) for term in terms if isinstance(term, Solid)), default=1.0)


def _read_by(part: Part) -> tuple[str, ...]:
    return (*part.reads, *part.optional)


def _listed(name: str, parts: Any, kind: type) -> tuple[Any, ...]:
    listed: tuple[Any, ...] = tuple(parts) if isinstance(parts, (tuple, list)) else (parts,)
    for part in listed:
        if isinstance(part, type):
            raise ValueError(f"{name} holds the class {part.__name__}; write {part.__name__}(...) instead.")
        if not isinstance(part, kind):
            raise ValueError(
                f"{name} holds {part!r}, which is no {kind.__name__}; patterns and growth go into processes, "
                "everything with an energy into terms; a part of your own derives from turingfold.extend."
                f"{kind.__name__}."
            )
        for fields in ("reads", "optional", "writes"):
            if isinstance(word := getattr(part, fields), str):
                raise ValueError(
                    f"{type(part).__name__}.{fields}={word!r} must be a tuple of names, ({word!r},)."
                )
    return listed


def _check_distinct(terms: tuple[Term, ...]) -> None:
    for one, other in combinations(terms, 2):
        if not (isinstance(one, type(other)) or isinstance(other, type(one))):
            continue
        if not isinstance(other, Load) or one == other:
            raise ValueError(
                f"terms holds two {type(other).__name__}, {one!r} and {other!r}, and both would count; leave "
                "one of the two out (a class of loads that may differ derives from turingfold.extend.Load)."
            )


def _check_scheme(terms: tuple[Term, ...], processes: tuple[Process, ...], stepping: Stepping) -> None:
    resting = {name for term in terms if not term.resists_motion for name in term.writes}
    for process in processes:
        read = sorted(resting & set(_read_by(process)))
        if stepping.scheme == MIDPOINT and read:
            raise ValueError(
                f"{type(process).__name__} reads {', '.join(read)}, known where forces balance; that is not "
                f"the end of a step by Stepping(scheme={MIDPOINT!r}). Leave the scheme out."
            )
    moving = any(term.resists_motion for term in terms)
    if stepping.local_error is not None and not moving:
        raise ValueError(
            f"Stepping(local_error={stepping.local_error:g}) is about a motion, but no term resists any: "
            "equilibria may jump in a step of any length; leave it out, or add Inertia(...) or Drag(...)."
        )
    if stepping.scheme == MIDPOINT and not moving:
        raise ValueError(
            f"Stepping(scheme={MIDPOINT!r}): forces would balance in the middle of each step, but no term "
            "resists motion, so the state at its end would be no equilibrium; leave the scheme out, or add "
            "Inertia(...) or Drag(...)."
        )


def _nearest(name: str, known: set[str]) -> str:
    near = get_close_matches(name, known, 1)
    return f"did you mean {near[0]!r}? Or " if near else ""


def _check_reads(part: Part, written: set[str]) -> None:
    for name in part.reads:
        if name not in written:
            raise MissingFieldError(
                f"{type(part).__name__} reads the field {name!r}, which no earlier process writes "
                f"(written: {', '.join(sorted(written))}); {_nearest(name, written)}add a process that "
                "writes it, before this part."
            )


def _check_overwrites(process: Process, written: set[str]) -> None:
    for name in process.writes:
        if name in written and name not in _read_by(process):
            raise ValueError(
                f"{type(process).__name__} writes the field {name!r}, which is written already, without "
                "reading it; leave one of the two out."
            )


def _check_read(process: Process, processes: Iterable[Process], terms: Iterable[Term]) -> None:
    read = {name for part in (*processes, *terms) for name in _read_by(part) if part is not process}
    for name in process.writes:
        if name not in read and name not in process.keeps:
            raise ValueError(
                f"{type(process).__name__} writes the field {name!r}, which no other part of the scene reads "
                f"(read: {', '.join(sorted(read)) or 'none'}); {_nearest(name, read)}add the term that it is "
                "for, or leave the process out (its `keeps` names fields that need no reader)."
            )
