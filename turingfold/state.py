"""The state of a scene: its fields at one time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from .arrays import Array
from .errors import MissingFieldError


@dataclass(frozen=True)
class State:
    """Fields at one time: displacement (2, n_nodes) in m, and whatever processes and terms have written.

    Their arrays are read-only from then on: a state that was accepted stays as it was.
    """

    time: float
    fields: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", float(self.time))  # numpy's write themselves as np.float64(0.25)
        object.__setattr__(self, "fields", MappingProxyType(dict(self.fields)))
        for values in self.fields.values():
            if isinstance(values, np.ndarray):
                values.flags.writeable = False

    def __repr__(self) -> str:
        """Return it in a line; the arrays would fill pages."""
        return f"State(t = {self.time:.6g}, with {', '.join(self.fields) or 'no fields'})"

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what a copy is made of: the view of the fields itself cannot be pickled."""
        return State, (self.time, dict(self.fields))

    def __getitem__(self, name: str) -> Array:
        if name not in self.fields:
            raise MissingFieldError(
                f"the state has no field {name!r} (it has: {', '.join(sorted(self.fields))}); a part that "
                "uses a field names it in `reads`."
            )
        return self.fields[name]

    def __contains__(self, name: str) -> bool:
        return name in self.fields

    def updated(self, time: float | None = None, /, **fields: Array) -> State:
        """Return a copy with some fields, and possibly the time, replaced."""
        return State(self.time if time is None else time, {**self.fields, **fields})
