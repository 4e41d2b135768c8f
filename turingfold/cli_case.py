"""Case files: Python files with scenes(quick=False) -> {name: Scene} and draw(results, figure)."""

from __future__ import annotations

import re
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, is_dataclass
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from .results import Result
from .scene import Scene

# what a mistake in a case raises, apart from ValueError, which already says what is wrong
MISTAKES = (ArithmeticError, AttributeError, ImportError, LookupError, NameError, SyntaxError, TypeError)
EXPECTED = (
    "a case has a docstring and two functions: scenes(quick=False), which returns a dict of names and "
    "Scenes, and draw(results, figure), which draws the Results of the same names on a matplotlib figure"
)


@dataclass(frozen=True)
class Case:
    """A case file that was read."""

    path: Path
    module: ModuleType

    @property
    def name(self) -> str:
        """Name of the file, which its results and its figure have too."""
        return self.path.stem

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
        """Return its scenes by name, or only some; raises ValueError for an unknown name."""
        with _explained(self.path):
            found = self.module.scenes(quick=quick)
        if not isinstance(found, dict) or not found:
            raise ValueError(f"{self.path}: scenes() must return a dict with at least one Scene; {EXPECTED}.")
        for name, scene in found.items():
            if not isinstance(name, str) or not isinstance(scene, Scene):
                raise ValueError(f"{self.path}: scenes() has {name!r}: {type(scene).__name__}; {EXPECTED}.")
        unknown = [name for name in only if name not in found]
        if unknown:
            names = ", ".join(map(repr, found))
            raise ValueError(f"{self.path} has no scene {unknown[0]!r}; it has: {names}.")
        folders = {folder_name(name) for name in found}
        if len(folders) < len(found):
            raise ValueError(f"{self.path}: scenes must differ in the letters of their names: {list(found)}.")
        return {name: scene for name, scene in found.items() if not only or name in only}

    @property
    def draw(self) -> Callable[[dict[str, Result], Any], object] | None:
        """Its function that draws, if it has one."""
        return getattr(self.module, "draw", None)


def load_case(path: Path) -> Case:
    """Read a case file; raises ValueError if it is missing, has a mistake or has no scenes."""
    if not path.is_file():
        raise ValueError(f"there is no case file {path}; turingfold list names those in the folder cases.")
    name = f"turingfold_case_{re.sub(r'[^0-9A-Za-z_]', '_', path.stem)}"
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ValueError(f"{path} is no Python file; {EXPECTED}.")
    module = module_from_spec(spec)
    sys.modules[name] = module
    with _explained(path):
        spec.loader.exec_module(module)
    if not callable(getattr(module, "scenes", None)):
        raise ValueError(f"{path} has no function scenes; {EXPECTED}.")
    return Case(path, module)


def find_cases(paths: Iterable[Path]) -> list[Path]:
    """Return the case files among files and folders; raises ValueError where there are none."""
    found: list[Path] = []
    for path in paths:
        files = sorted(path.glob("*.py")) if path.is_dir() else [path]
        if not files:
            raise ValueError(f"{path} holds no case files (*.py).")
        found += files
    return found


def folder_name(scene: str) -> str:
    """Return the name of a scene's folder: letters, digits and hyphens."""
    return re.sub(r"[^\w.+=]+", "-", scene).strip("-.") or "scene"


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """Turn a mistake in a case into a ValueError that names the line."""
    try:
        yield
    except MISTAKES as error:
        frames = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if frame.filename == str(path)]
        line = error.lineno if isinstance(error, SyntaxError) else (lines or [None])[-1]
        raise ValueError(
            f"{path}{f', line {line}' if line else ''}: {type(error).__name__}: {error}. "
            "Correct the case; --debug shows the traceback."
        ) from error
