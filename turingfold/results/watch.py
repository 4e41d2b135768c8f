"""Watching a run: functions that are called with its states, and a line of progress."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, TextIO

from ..arrays import Array
from ..checks import finite_array
from ..state import State
from .result import Row

BETWEEN = 0.1  # s between two updates of the line
TENTHS = 10  # lines of a run whose progress is written to a file


@dataclass(frozen=True, kw_only=True)
class Tracker:
    """A function that is called with states of a run while it is made, for what is not to be kept.

    call: takes the state and its fields, as `Result.observe` returns them, each (q, e) at the integration
    points.  times: at which it is called, in the scene's time: with the first
    accepted state at or after each, which is the state of that very time where a step ends there
    (`Stepping(stops=times)`); without times, with the first state and every accepted one.
    Its errors end the run. A run that goes on (`resume`) calls it for the states from there on.
    """

    call: Callable[[State, Mapping[str, Array]], object]
    times: Sequence[float] = ()

    def __post_init__(self) -> None:
        if not callable(self.call):
            raise ValueError(f"call={self.call!r} must be a function of a state and its fields.")
        finite_array("times", self.times, (None,))

    def is_due(self, before: float, now: float) -> bool:
        """Return whether it is called with a state at `now`, the one before it at `before`."""
        slack = 1e-12 * abs(now)
        return not len(self.times) or any(before < time - slack <= now for time in self.times)


def progress_line(until: float, stream: TextIO | None = None) -> Callable[[Row], None]:
    """Return what shows a run's progress as one line, in a terminal and in a notebook; elsewhere as ten.

    until: time at which the scene ends.
    """
    out = stream or sys.stderr
    in_place = out.isatty() or "ipykernel" in sys.modules
    began, shown, width = perf_counter(), 0.0, 0

    def show(row: Row) -> None:
        nonlocal shown, width
        now, share = perf_counter(), min(1.0, row["time"] / until)
        last = share >= 1 - 1e-12
        due = now - shown > BETWEEN if in_place else int(TENTHS * share) > int(TENTHS * shown)
        if not (due or last):
            return
        shown = now if in_place else share
        left = "" if last else f", about {(now - began) * (1 / share - 1):.0f} s left"
        full = round(20 * share)
        text = f"{full * '#'}{(20 - full) * '.'} {share:4.0%}, growth {row['growth']:.3f}{left}"
        end = "\n" if last or not in_place else ""
        print(f"\r{text.ljust(width)}" if in_place else text, end=end, file=out, flush=True)
        width = len(text)

    return show


def watcher(progress: Any, until: float) -> Callable[[Row], object] | None:
    """Return what is called with each row: the function itself, a line of progress for True, or nothing."""
    if progress is True:
        return progress_line(until)
    if progress not in (None, False) and not callable(progress):
        raise ValueError(f"progress={progress!r} must be True for a line of it, or a function of a row.")
    return progress or None
