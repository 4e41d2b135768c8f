"""How far scenes or points of a study have come: one bar on a terminal, lines elsewhere, or all the steps."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from time import perf_counter

from ..results.result import Row
from .request import Telling

LINES = 10  # of a command whose progress is written to a file
STEP = {  # what is told of a step, where it has that
    "newton_iterations": "{:.0f} iterations", "residual": "residual {:.1e}", "seconds": "{:.2f} s",
}  # fmt: skip
BETWEEN = 5.0  # s at least between two of them


class Shares:
    """Which share of each scene has been run, and how long the rest may take.

    ends: time at which each scene ends, by name.
    """

    def __init__(self, ends: Mapping[str, float]) -> None:
        self._ends, self._now = dict(ends), dict.fromkeys(ends, 0.0)
        self._first: dict[str, float] = {}  # of those that have begun: where this run of theirs did
        self._ended: set[str] = set()
        self._began = perf_counter()

    def reached(self, name: str, row: Row) -> None:
        """Take down the newest row of a scene."""
        end = self._ends[name]
        self._now[name] = min(1.0, row["time"] / end)
        self._first.setdefault(name, max(0.0, row["time"] - row["step"]) / end)

    def finished(self, name: str) -> None:
        """Take down that a scene has ended, wherever."""
        self._now[name] = 1.0
        self._first.setdefault(name, 0.0)
        self._ended.add(name)

    @property
    def total(self) -> float:
        """The share of all."""
        return sum(self._now.values()) / len(self._now)

    def counted(self, things: str) -> str:
        """Return how many have ended, as text."""
        return f"{len(self._ended)} of {len(self._now)} {things}"

    def left(self) -> str:
        """Return about how much time is left, as text; nothing where that is not known."""
        done = sum(self._now[name] - first for name, first in self._first.items())
        rest = sum(1.0 - share for share in self._now.values())
        if done <= 0 or rest <= 0:
            return ""
        return f"about {duration((perf_counter() - self._began) * rest / done)} left"


def duration(seconds: float) -> str:
    """Return a time in a unit that suits it."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


class Watch:
    """Is told of each step and of each end, and tells nothing."""

    def row(self, name: str, row: Row, iterations: int) -> None:
        """Hear the newest row of a scene, and its Newton iterations so far."""

    def ended(self, name: str) -> None:
        """Hear that a scene has ended."""


class _Steps(Watch):
    """Tells of every step."""

    def row(self, name: str, row: Row, iterations: int) -> None:
        words = [f"t = {row['time']:.6g}", f"growth {row['growth']:.4f}"]
        words += [text.format(row[own]) for own, text in STEP.items() if own in row]
        _line(f"{name}: {', '.join(words)}")


class _Overall(Watch):
    """Tells how far all have come together."""

    def __init__(self, ends: Mapping[str, float], things: str) -> None:
        self.shares, self.things, self.single = Shares(ends), things, len(ends) == 1
        self.latest = ""

    def row(self, name: str, row: Row, iterations: int) -> None:
        self.shares.reached(name, row)
        count = f", {iterations} iterations" if self.single and iterations else ""
        self.latest = f"{name} at growth {row['growth']:.3f}{count}"
        self.show()

    def ended(self, name: str) -> None:
        self.shares.finished(name)
        self.show()

    def words(self) -> str:
        """Return what is told beside the share."""
        count = "" if self.single else self.shares.counted(self.things)
        return ", ".join(word for word in (count, self.latest, self.shares.left()) if word)

    def show(self) -> None:
        """Tell it."""


class _Lines(_Overall):
    """Tells it in lines, few of them."""

    def __init__(self, ends: Mapping[str, float], things: str) -> None:
        super().__init__(ends, things)
        self._told, self._when = 0.0, perf_counter()

    def show(self) -> None:
        now, share = perf_counter(), self.shares.total
        if int(LINES * share) > int(LINES * self._told) and now - self._when >= BETWEEN and share < 1:
            self._told, self._when = share, now
            _line(f"{share:4.0%}, {self.words()}")


class _Bar(_Overall):
    """Tells it in one bar, which rich draws."""

    def __init__(self, ends: Mapping[str, float], things: str) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
        from rich.table import Column

        super().__init__(ends, things)
        line = Column(no_wrap=True, overflow="ellipsis")
        words = TextColumn("{task.description}", markup=False, table_column=line)
        self.bars = Progress(BarColumn(), TaskProgressColumn(), words, console=Console(stderr=True))
        self._task = self.bars.add_task("", total=1.0)

    def show(self) -> None:
        self.bars.update(self._task, completed=self.shares.total, description=self.words())


@contextmanager
def watching(ends: Mapping[str, float], telling: Telling, things: str = "scenes") -> Iterator[Watch]:
    """Give what is to be told of steps and ends, and shows them as is wished, on standard error.

    ends: time at which each scene ends, by name.
    """
    if telling is Telling.NOTHING or not ends:
        yield Watch()
    elif telling is Telling.STEPS:
        yield _Steps()
    elif sys.stderr.isatty():
        bar = _Bar(ends, things)
        with bar.bars:
            yield bar
    else:
        yield _Lines(ends, things)


def _line(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
