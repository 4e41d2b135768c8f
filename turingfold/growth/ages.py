"""Ages as a scene's axis: gestational weeks and postnatal days, and how far growth is at each."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..checks import between, finite, one_of, positive
from ..errors import InadmissibleStateError
from .histories import LAST_DAY, growth_time, postnatal_day

FIRST_WEEK, LAST_WEEK = 22.0, 44.0  # at which Wang's polynomial is 0 and 1, to 1 %
SLACK = 1e-9  # share of the duration by which round-off may pass its end
CURVES: dict[str, Callable[[float], float]] = {
    "wang": lambda week: ((6.926e-5 * week - 0.00665) * week + 0.250) * week - 3.0189,
    "gompertz": lambda week: 0.987 * float(np.exp(-np.exp(-0.134 * (week - 29.433)))),
}


class Ages(ABC):
    """A history of growth whose time stands for an age; the age is `unit` in `Result.at`."""

    unit: ClassVar[str]

    @abstractmethod
    def factor(self, final: float, time: float) -> float:
        """Return the growth factor at `time`."""

    @abstractmethod
    def check(self, time: float) -> None:
        """Raise InadmissibleStateError for a time of the scene beyond the last age that is known."""

    @abstractmethod
    def time(self, age: float) -> float:
        """Return the scene's time at an age; raises ValueError outside the history's range."""

    @abstractmethod
    def age(self, time: float) -> float:
        """Return the age at a time of the scene."""

    @abstractmethod
    def label(self, time: float) -> str:
        """Return the age at a time in words."""

    def times(self, *ages: float) -> tuple[float, ...]:
        """Return the scene's times at ages, such as for Stepping(stops=...)."""
        return tuple(self.time(age) for age in ages)


@dataclass(frozen=True, kw_only=True)
class Weeks(Ages):
    """Growth by gestational age, g = 1 + (final - 1) (s(w) - s(start))/(s(end) - s(start)).

    Weeks run evenly: w = start + (end - start) t/duration.
    curve "wang": s = 6.926e-5 w³ - 0.00665 w² + 0.250 w - 3.0189; "gompertz": s = 0.987 exp(-exp(-0.134 (w -
    29.433))), both for weeks 22 to 44.
    start: week of the body's shape.  end: week of the final factor, at t = duration.
    Source: Wang et al. (2019), as cited for its shares of growth.
    """

    unit: ClassVar[str] = "week"
    start: float = 28.0
    end: float = 40.0
    duration: float = 1.0
    curve: str = "wang"

    def __post_init__(self) -> None:
        for name in ("start", "end"):
            between(name, getattr(self, name), FIRST_WEEK, LAST_WEEK, "the curves hold for these weeks")
        if not self.start < self.end:
            raise ValueError(f"start={self.start:g} must be an earlier week than end={self.end:g}.")
        positive("duration", self.duration)
        one_of("curve", self.curve, tuple(CURVES))

    def factor(self, final: float, time: float) -> float:
        """Return the growth factor at `time`."""
        self.check(time)
        share = CURVES[self.curve]
        start, end = share(self.start), share(self.end)
        return 1.0 + (final - 1.0) * (share(self.age(time)) - start) / (end - start)

    def check(self, time: float) -> None:
        """Raise InadmissibleStateError for a time after week 44."""
        if (now := self.age(time)) > LAST_WEEK:
            raise InadmissibleStateError(
                f"Weeks: t = {time:.4g} is week {now:.4g}, but the curves of growth end at {LAST_WEEK:g}; "
                f"end the scene by until={self.duration:g}, which is week {self.end:g}",
                time=time,
            )

    def time(self, age: float) -> float:
        """Return the scene's time at a week; raises ValueError for one not from start to end."""
        between("week", age, self.start, self.end, "other weeks need another start or end of Weeks(...)")
        return self.duration * (age - self.start) / (self.end - self.start)

    def age(self, time: float) -> float:
        """Return the week at a time of the scene."""
        return self.start + (self.end - self.start) * time / self.duration

    def label(self, time: float) -> str:
        """Return such as "week 32"."""
        return f"week {round(self.age(time), 1):g}"


@dataclass(frozen=True, kw_only=True)
class Days(Ages):
    """Growth of the ferret from P0 to P32, g = 1 + (final - 1) t/duration, by the days of `growth_time`.

    slowing: days in which growth slows down to 1/e.
    """

    unit: ClassVar[str] = "day"
    duration: float = 1.0
    slowing: float = 12.0

    def __post_init__(self) -> None:
        positive("duration", self.duration)
        positive("slowing", self.slowing)

    def factor(self, final: float, time: float) -> float:
        """Return the growth factor at `time`."""
        self.check(time)
        return 1.0 + (final - 1.0) * time / self.duration

    def check(self, time: float) -> None:
        """Raise InadmissibleStateError for a time after P32."""
        if time > self.duration * (1 + SLACK):
            raise InadmissibleStateError(
                f"Days: t = {time:.4g} is after P{LAST_DAY:g}, where growth by days ends; end the scene by "
                f"until={self.duration:g}",
                time=time,
            )

    def time(self, age: float) -> float:
        """Return the scene's time at a postnatal day; raises ValueError for one not from 0 to 32."""
        return growth_time(age, duration=self.duration, slowing=self.slowing)

    def age(self, time: float) -> float:
        """Return the postnatal day at a time of the scene; raises ValueError for a time beyond P32."""
        if 0 <= finite("time", time) - self.duration <= SLACK * self.duration:
            return LAST_DAY
        return postnatal_day(time, duration=self.duration, slowing=self.slowing)

    def label(self, time: float) -> str:
        """Return such as "P8"."""
        return f"P{round(self.age(time), 1):g}"


def ages_of(processes: Iterable[object]) -> Ages | None:
    """Return the ages that processes have as `history` or `ages`; None for none.

    Raises ValueError where they disagree.
    """
    every = [getattr(one, name, None) for one in processes for name in ("history", "ages")]
    found = [ages for ages in every if isinstance(ages, Ages)]
    if any(ages != found[0] for ages in found):
        raise ValueError(f"the processes give different ages, {found!r}; give them the same one.")
    return found[0] if found else None
