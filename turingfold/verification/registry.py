"""All problems with known answers, in the order in which they are shown."""

from __future__ import annotations

from collections.abc import Sequence

from . import contact, documents, dynamics, elasticity, growth, line, shapes, stability, turing
from .check import Check


def checks(named: Sequence[str] = (), *, full: bool = False) -> tuple[Check, ...]:
    """Return the problems whose name holds one of the words given, all of them without any.

    full: with those that take longer, such as orders of convergence.
    Raises ValueError for a word that no problem has.
    """
    rooms = (turing, line, growth, elasticity, stability, contact, dynamics, shapes, documents)
    every = [check for room in rooms for check in room.CHECKS if full or not check.full]
    for word in named:
        if not any(word.lower() in check.problem.lower() for check in every):
            raise ValueError(f"no problem has {word!r} in its name; without words all are shown.")
    return tuple(
        check for check in every
        if not named or any(word.lower() in check.problem.lower() for word in named)
    )  # fmt: skip
