"""Case files: Python files with scenes(quick=False) -> {name: Scene} and draw(results, figure)."""

from __future__ import annotations

import re
import sys
import traceback
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, is_dataclass
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, Protocol

from ..errors import SolveError
from ..results.result import Result
from ..scene import Scene

# what a mistake in a case raises, apart from ValueError, which already says what is wrong; SystemExit would
# end the program as if all had been done
MISTAKES = (
    ArithmeticError, AssertionError, AttributeError, ImportError, LookupError, NameError, RuntimeError,
    SyntaxError, SystemExit, TypeError,
)  # fmt: skip
EXPECTED = (
    "a case has a docstring and two functions: scenes(quick=False), which returns a dict of names and "
    "Scenes, and draw(results, figure), which draws the Results of the same names on a matplotlib figure"
)


class Variation(Protocol):
    """What a command other than `run` makes of a case's scenes, and how it draws what becomes of them."""

    @property
    def command(self) -> str:
        """Its name, which the folder of the results ends with."""

    @property
    def arguments(self) -> tuple[str, ...]:
        """Its own arguments on the command line."""

    def scenes(self, scenes: dict[str, Scene]) -> dict[str, Scene]:
        """Return the scenes to run, by name."""

    def draw(self, results: dict[str, Result], figure: Any) -> object:
        """Draw their results."""


@dataclass(frozen=True, eq=False)
class Case:
    """A case file that was read.

    variation: what is run instead of its own scenes, if something is.
    """

    path: Path
    module: ModuleType
    variation: Variation | None = None
    _own: dict[bool, dict[str, Scene]] = field(init=False, default_factory=dict)
    _made: dict[tuple[bool, tuple[str, ...]], dict[str, Scene]] = field(init=False, default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the file, which its results and its figure have too."""
        return f"{self.path.stem}-{self.variation.command}" if self.variation else self.path.stem

    @property
    def title(self) -> str:
        """First paragraph of its docstring, as one line."""
        return " ".join((self.module.__doc__ or "").strip().partition("\n\n")[0].split())

    @property
    def known(self) -> tuple[Any, ...]:
        """Classes and functions of its own, which its scenes may be made of."""
        name = self.module.__name__
        own = [item for item in vars(self.module).values() if getattr(item, "__module__", "") == name]
        return tuple(
            item
            for item in own
            if isinstance(item, FunctionType) or (isinstance(item, type) and is_dataclass(item))
        )

    def scenes(self, *, quick: bool, only: Iterable[str] = ()) -> dict[str, Scene]:
        """Return its scenes by name, or only some, made once; raises ValueError for an unknown name."""
        every, wanted = self._all(quick), tuple(only)
        unknown = [name for name in wanted if name not in every]
        if unknown:
            names = ", ".join(map(repr, every))
            raise ValueError(f"{self.path} has no scene {unknown[0]!r}; it has: {names}.")
        chosen = {name: scene for name, scene in every.items() if not wanted or name in wanted}
        if self.variation is None:
            return chosen
        if (quick, wanted) not in self._made:
            made = self.variation.scenes(chosen)
            self._check_apart(made)
            self._made[quick, wanted] = made
        return self._made[quick, wanted]

    def _all(self, quick: bool) -> dict[str, Scene]:
        """Return what the case's own function makes; to make it may take long."""
        if quick in self._own:
            return self._own[quick]
        with explained(self.path):
            found = self.module.scenes(quick=quick)
        if not isinstance(found, dict) or not found:
            raise ValueError(f"{self.path}: scenes() must return a dict with at least one Scene; {EXPECTED}.")
        for name, scene in found.items():
            if not isinstance(name, str) or not isinstance(scene, Scene):
                raise ValueError(f"{self.path}: scenes() has {name!r}: {type(scene).__name__}; {EXPECTED}.")
        self._check_apart(found)
        self._own[quick] = found
        return found

    def _check_apart(self, names: Collection[str]) -> None:
        folders = {folder_name(name) for name in names}
        if len(folders) < len(names):
            raise ValueError(f"{self.path}: scenes must differ in the letters of their names: {list(names)}.")

    @property
    def draw(self) -> Callable[[dict[str, Result], Any], object] | None:
        """Its function that draws, if it has one."""
        return self.variation.draw if self.variation else getattr(self.module, "draw", None)


def load_case(path: Path, variation: Variation | None = None) -> Case:
    """Read a case file; raises ValueError if it is missing, has a mistake or has no scenes."""
    if not path.is_file():
        raise ValueError(f"there is no case file {path}; turingfold list names those in the folder cases.")
    name = f"turingfold_case_{re.sub(r'[^0-9A-Za-z_]', '_', path.stem)}"
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ValueError(f"{path} is no Python file; {EXPECTED}.")
    module = module_from_spec(spec)
    sys.modules[name] = module
    beside = str(path.resolve().parent)
    if beside not in sys.path:  # as for a script, though last: a case may have the name of a library
        sys.path.append(beside)
    with explained(path):
        spec.loader.exec_module(module)
    if not callable(getattr(module, "scenes", None)):
        raise ValueError(f"{path} has no function scenes; {EXPECTED}.")
    return Case(path, module, variation)


def find_cases(paths: Iterable[Path]) -> list[Path]:
    """Return the files named, and in the folders named those with scenes; raises ValueError for none."""
    found: list[Path] = []
    marked = re.compile(rb"^def scenes\(", re.MULTILINE)
    for path in paths:
        files = [path]
        if path.is_dir():  # reading a case runs it: nothing else in the folder is touched
            files = [file for file in sorted(path.glob("*.py")) if marked.search(file.read_bytes())]
        if not files:
            raise ValueError(f"{path} holds no case files (*.py with a function scenes).")
        found += files
    return found


def folder_name(scene: str) -> str:
    """Return the name of a scene's folder: letters, digits and hyphens."""
    return re.sub(r"[^\w.+=]+", "-", scene).strip("-.") or "scene"


@contextmanager
def explained(path: Path) -> Iterator[None]:
    """Turn a mistake in a case into a ValueError that names the line."""
    try:
        yield
    except SolveError:
        raise
    except ValueError as error:
        raise ValueError(f"{_place(path, error)}: {error}") from error
    except MISTAKES as error:
        raise ValueError(
            f"{_place(path, error)}: {type(error).__name__}: {error}. "
            "Correct the case; --debug shows the traceback."
        ) from error


def _place(path: Path, error: BaseException) -> str:
    """Return the case and the line of it that an error comes from."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if Path(frame.filename).resolve() == path.resolve()]
    line = error.lineno if isinstance(error, SyntaxError) else (lines or [None])[-1]
    return f"{path}, line {line}" if line else str(path)
