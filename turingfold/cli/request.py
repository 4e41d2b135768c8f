"""What a command line asks for, as frozen values that commands hand on; nothing heavy is imported here."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..scene import Scene

Assignments = tuple[tuple[str, str], ...]  # name and value, as given


@dataclass(frozen=True)
class Request:
    """Scenes of a case, where their results are, and where their figure goes (None: to its usual place).

    case: a file, or the name of a case that comes with the package.  assigned: values of parameters, as
    text.  command: its name with the arguments that it alone has.
    """

    case: str
    quick: bool = False
    out: Path | None = None
    only: tuple[str, ...] = ()
    assigned: Assignments = ()
    command: tuple[str, ...] = ("run",)
    figure: Path | None = None

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
        words += ["--figure", str(self.figure)] if self.figure else []
        return shlex.join([*words, *more])


class Telling(Enum):
    """What is told of progress: nothing, a bar or lines for all that runs, or a line for each step."""

    NOTHING = "--quiet"
    OVERALL = ""
    STEPS = "--verbose"


@dataclass(frozen=True)
class Running:
    """How scenes are run: what becomes of earlier results, how many at a time, what is kept and told.

    errors: whether they are estimated.  max_seconds: run time of each scene.  frames: states that are kept,
    None for the usual number.  vtu: whether these are also written for ParaView.  shorter: how many times as
    short as the scenes have them steps are.
    """

    resume: bool = False
    overwrite: bool = False
    jobs: int = 1
    errors: bool = True
    max_seconds: float = math.inf
    frames: int | None = None
    vtu: bool = True
    telling: Telling = Telling.OVERALL
    shorter: float = 1.0

    def words(self) -> list[str]:
        """Return the words of the command line that say this, but for what becomes of earlier results."""
        found = ["--jobs", str(self.jobs)] if self.jobs > 1 else []
        found += [] if self.errors else ["--no-errors"]
        found += ["--max-seconds", f"{self.max_seconds:g}"] if math.isfinite(self.max_seconds) else []
        found += ["--frames", str(self.frames)] if self.frames is not None else []
        return found + ([] if self.vtu else ["--no-vtu"])

    def limited(self, scene: Scene) -> Scene:
        """Return a scene with this limit on its run time, where there is one, and steps as short."""
        now = scene.stepping
        if math.isfinite(self.max_seconds):
            now = replace(now, seconds=self.max_seconds)
        if self.shorter != 1:
            lengths = {name: getattr(now, name) / self.shorter for name in ("first", "largest", "smallest")}
            now = replace(now, **lengths)
        return scene if now is scene.stepping else replace(scene, stepping=now)
