"""The errors that a scene or a run can end with."""

from __future__ import annotations

from typing import Any


class SolveError(RuntimeError):
    """A solve that stopped; `time` says when, `residual` how far from balance, the message what to try."""

    def __init__(self, message: str, *, time: float = float("nan"), residual: float = float("nan")) -> None:
        super().__init__(message)
        self.time = time
        self.residual = residual

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what a copy is made of, also one of a class with other arguments."""
        return _copied, (type(self), str(self), self.__dict__)


def _copied(kind: type[SolveError], message: str, values: dict[str, Any]) -> SolveError:
    error = kind.__new__(kind, message)
    error.__dict__.update(values)
    return error


class NotConvergedError(SolveError):
    """An equilibrium or steady state was not reached."""


class OutOfMemoryError(SolveError):
    """A solve that does not fit into the memory that is left."""


class RoundOffError(NotConvergedError):
    """A residual that round-off keeps above the tolerance, whatever the step."""


class InadmissibleStateError(SolveError):
    """A state with a non-finite value, an inverted element or an intersection."""


class StepTooLongError(SolveError):
    """A step that is to be taken again, shorter: the solve did not fail, but the step is too coarse."""

    def __init__(self, message: str, *, length: float, time: float = float("nan")) -> None:
        """Take the length, in the scene's time, that may do."""
        super().__init__(message, time=time)
        self.length = length


class MissingFieldError(ValueError):
    """A part reads a field that no earlier process writes, or that it does not declare."""
