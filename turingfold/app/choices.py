"""The cases that a page may run, their parameters, and the command line of a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..models.declared import Declared, find


@dataclass(frozen=True)
class Choice:
    """A case that can be run.

    given: what the command line calls it.  file: where it is.  usual: the values of its parameters, by name,
    of the quick version (True) and of the other.  scenes: returns the names of its scenes, which may take
    seconds.  known: classes that its scenes are made of, see `results.load`.
    """

    name: str
    title: str
    given: str
    file: Path
    parameters: Mapping[str, Declared]
    usual: Mapping[bool, Mapping[str, Any]]
    scenes: Callable[[], Sequence[str]]
    known: tuple[Any, ...] = ()

    def described(self) -> dict[str, Any]:
        """Return what a page shows of it, as JSON; bounds that do not exist are None."""
        return {
            "name": self.name,
            "title": self.title,
            "parameters": [self._described(one) for one in self.parameters.values()],
        }

    def _described(self, one: Declared) -> dict[str, Any]:
        low, high = (bound if math.isfinite(bound) else None for bound in (one.meaning.low, one.meaning.high))
        return {
            "name": one.name, "kind": one.kind.__name__, "unit": one.meaning.unit, "low": low, "high": high,
            "label": one.meaning.label, "choices": one.meaning.choices,
            "usual": self.usual[False][one.name], "quick": self.usual[True][one.name],
        }  # fmt: skip

    def changed(self, values: Mapping[str, Any], *, quick: bool) -> dict[str, Any]:
        """Return the values that differ from the usual ones.

        Raises ValueError for unknown names, and for values of another kind or out of range.
        """
        checked = {name: find(self.parameters, name).checked(value) for name, value in values.items()}
        return {name: value for name, value in checked.items() if value != self.usual[quick][name]}

    def words(self, scene: str, values: Mapping[str, Any], *, quick: bool) -> list[str]:
        """Return the command line that runs a scene with these values, without `turingfold`."""
        texts = {
            name: str(value) if not isinstance(value, bool) else "on" if value else "off"
            for name, value in values.items()
        }
        changes = [word for name, text in texts.items() for word in ("--set", f"{name}={text}")]
        return ["run", self.given, *changes, *(["--quick"] if quick else []), "--only", scene]
