"""How growth proceeds in time: each history turns a final factor into the factor at time t."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Protocol, runtime_checkable

import numpy as np

from ..arrays import Array
from ..checks import finite, finite_array, positive

LAST_DAY = 32.0


@runtime_checkable
class History(Protocol):
    """Growth from the factor 1 at t = 0 to `final` at the end of its duration, and on beyond that."""

    def factor(self, final: float, time: float) -> float:
        """Return the growth factor at `time`."""


@dataclass(frozen=True, kw_only=True)
class Linear:
    """g = 1 + (final - 1) t/duration."""

    duration: float = 1.0

    def __post_init__(self) -> None:
        positive("duration", self.duration)

    def factor(self, final: float, time: float) -> float:
        """Return the growth factor at `time`."""
        return 1.0 + (final - 1.0) * time / self.duration


@dataclass(frozen=True, kw_only=True)
class Exponential:
    """g = final^(t/duration): a constant relative rate, ln(final)/duration."""

    duration: float = 1.0

    def __post_init__(self) -> None:
        positive("duration", self.duration)

    def factor(self, final: float, time: float) -> float:
        """Return the growth factor at `time`."""
        return float(final ** (time / self.duration))


@dataclass(frozen=True, kw_only=True)
class _Curve(ABC):
    """g = 1 + (final - 1) (s(t/duration) - s(0))/(s(1) - s(0)); parameters of s are positive, at most 100."""

    duration: float = 1.0

    def __post_init__(self) -> None:
        for name in (field.name for field in fields(self)):
            positive(name, getattr(self, name), at_most=float("inf") if name == "duration" else 100.0)

    def factor(self, final: float, time: float) -> float:
        """Return the growth factor at `time`."""
        start, now, end = self._at(np.array([0.0, time / self.duration, 1.0]))
        return float(1.0 + (final - 1.0) * (now - start) / (end - start))

    @abstractmethod
    def _at(self, share: Array) -> Array:
        """Return s at shares of the duration."""


@dataclass(frozen=True, kw_only=True)
class Logistic(_Curve):
    """g = 1 + (final - 1) (s(t) - s(0))/(s(1) - s(0)), s = 1/(1 + exp(-steepness (t/duration - middle)))."""

    steepness: float = 10.0
    middle: float = 0.5

    def _at(self, share: Array) -> Array:
        return np.asarray(1 / (1 + np.exp(-self.steepness * (share - self.middle))))


@dataclass(frozen=True, kw_only=True)
class Gompertz(_Curve):
    """g = 1 + (final - 1) (s(t) - s(0))/(s(1) - s(0)), s = exp(-delay exp(-steepness t/duration))."""

    steepness: float = 6.0
    delay: float = 6.0

    def _at(self, share: Array) -> Array:
        return np.asarray(np.exp(-self.delay * np.exp(-self.steepness * share)))


@dataclass(frozen=True, kw_only=True)
class Table:
    """g = 1 + (final - 1) f(t), f linear between the given shares at the given times, constant outside."""

    times: tuple[float, ...]
    shares: tuple[float, ...]

    def __post_init__(self) -> None:
        times = finite_array("times", self.times, (None,))
        shares = finite_array("shares", self.shares, (None,))
        if times.size < 2 or times.size != shares.size or not (np.diff(times) > 0).all():
            raise ValueError(
                f"times has {times.size} and shares {shares.size} entries; give at least two of each, "
                "equally many, with the times in increasing order."
            )
        object.__setattr__(self, "times", tuple(times.tolist()))
        object.__setattr__(self, "shares", tuple(shares.tolist()))

    def factor(self, final: float, time: float) -> float:
        """Return the growth factor at `time`."""
        return float(1.0 + (final - 1.0) * np.interp(time, self.times, self.shares))


def growth_time(day: float, *, duration: float = 1.0, slowing: float = 12.0) -> float:
    """Return the growth time at an age in postnatal days, from P0 at t = 0 to P32 at t = duration.

    t = duration (1 - e^{-day/slowing})/(1 - e^{-32/slowing}): growth slows down with age, to 1/e in `slowing`
    days.
    The ages P0, P4, P8, P16 and P32 are those of Choi et al. 2025; how they are spread over time is our
    choice.
    """
    if not 0.0 <= finite("day", day) <= LAST_DAY:
        raise ValueError(f"day={day:g} must be between 0 and {LAST_DAY:g}.")
    rate = 1.0 / positive("slowing", slowing)
    return positive("duration", duration) * float(np.expm1(-day * rate) / np.expm1(-LAST_DAY * rate))


def postnatal_day(time: float, *, duration: float = 1.0, slowing: float = 12.0) -> float:
    """Return the age in postnatal days at a growth time, the inverse of `growth_time`."""
    share = finite("time", time) / positive("duration", duration)
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"time={time:g} must be between 0 and duration={duration:g}.")
    return float(-slowing * np.log1p(share * np.expm1(-LAST_DAY / positive("slowing", slowing))))
