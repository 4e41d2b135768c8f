"""What a command line asks for, as frozen values that commands hand on; nothing heavy is imported here."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

Assignments = tuple[tuple[str, str], ...]  # name and value, as given


@dataclass(frozen=True)
class Request:
    """Scenes of a case, and where their results are.

    case: a file, or the name of a case that comes with the package.  assigned: values of parameters, as
    text.  command: its name with the arguments that it alone has.
    """

    case: str
    quick: bool = False
    out: Path | None = None
    only: tuple[str, ...] = ()
    assigned: Assignments = ()
    command: tuple[str, ...] = ("run",)

    def with_only(self, names: Iterable[str]) -> Request:
        """Return the request for some of the scenes; for all without names."""
        return replace(self, only=tuple(names))

    def words(self, *more: str) -> str:
        """Return the command line that asks for this."""
        name, *own = self.command
        words = ["turingfold", name, self.case, *own]
        words += [word for name, value in self.assigned for word in ("--set", f"{name}={value}")]
        words += ["--quick"] if self.quick else []
        words += ["--out", str(self.out)] if self.out else []
        words += [word for name in self.only for word in ("--only", name)]
        return shlex.join([*words, *more])


@dataclass(frozen=True)
class Running:
    """How scenes are run: what becomes of earlier results, how many at a time, and if errors are told."""

    resume: bool = False
    overwrite: bool = False
    jobs: int = 1
    errors: bool = True
