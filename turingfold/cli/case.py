"""Case files: Python files with scenes(quick=False, *, ...) -> {name: Scene} and draw(results, figure)."""

from __future__ import annotations

import re
import subprocess
import sys
import traceback
import unicodedata
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, is_dataclass
from functools import cached_property
from hashlib import sha256
from importlib import invalidate_caches
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader, FileFinder, SourceFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

from ..errors import SolveError
from ..models.declared import Declared, declared, nearest, values_of
from ..results.result import Result
from ..scene import Scene
from .files import shipped, short, title

# what a mistake in a case raises, apart from ValueError, which already says what is wrong; SystemExit would
# end the program as if all had been done
MISTAKES = (
    ArithmeticError, AssertionError, AttributeError, ImportError, LookupError, NameError, RuntimeError,
    SyntaxError, SystemExit, TypeError,
)  # fmt: skip
EXPECTED = (
    "a case has a docstring and two functions: scenes(quick=False, *, ...), which returns a dict of names "
    "and Scenes, and draw(results, figure), which draws the Results of the same names on a matplotlib figure"
)
RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)  # names of devices on Windows
LONGEST = 150  # letters of a folder's name


@dataclass(frozen=True, eq=False)
class Case:
    """A case file that was read.  sha256: of its text when it was; a run may outlast that."""

    path: Path
    module: ModuleType
    sha256: str

    @property
    def name(self) -> str:
        """Name of the file, which its results and its figure have too."""
        return self.path.stem

    @property
    def shown(self) -> str:
        """How messages name it."""
        return short(self.path)

    @property
    def title(self) -> str:
        """First paragraph of its docstring, as one line."""
        return title(self.module.__doc__)

    @property
    def known(self) -> tuple[Any, ...]:
        """Classes and functions of its own and of files beside it, which its scenes may be made of."""
        return parts_of(self.module)

    @cached_property
    def parameters(self) -> dict[str, Declared]:
        """Its parameters by name."""
        with explained(self.path):
            return declared(self.module.scenes)

    @property
    def draw(self) -> Callable[..., object] | None:
        """Its function that draws, if it has one."""
        return getattr(self.module, "draw", None)

    @property
    def computed(self) -> Callable[[dict[str, Result]], object] | None:
        """Its function that computes arrays from results, for `draw` to draw, if it has one."""
        return getattr(self.module, "computed", None)

    @property
    def table(self) -> Callable[[dict[str, Result]], object] | None:
        """Its function that sums up results as rows, dicts with the same keys, if it has one."""
        return getattr(self.module, "table", None)

    def scenes(self, given: Mapping[str, Any], *, quick: bool) -> dict[str, Scene]:
        """Return its scenes by name, with some parameters given; to make them may take long."""
        with explained(self.path):
            found = self.module.scenes(quick=quick, **given)
        if not isinstance(found, dict) or not found:
            wrong = "scenes() must return a dict with at least one Scene"
            raise ValueError(f"{self.shown}: {wrong}; {EXPECTED}.")
        for name, scene in found.items():
            if not isinstance(name, str) or not isinstance(scene, Scene):
                raise ValueError(f"{self.shown}: scenes() has {name!r}: {type(scene).__name__}; {EXPECTED}.")
        check_apart(found, self.path)
        return found

    def provenance(self, given: Mapping[str, Any], *, quick: bool) -> dict[str, Any]:
        """Return what is stored with a result of the case: its name, its source by hash, its parameters.

        "commit": of the git working tree that it lies in, "...-dirty" where files differ from it.
        "changed": names of the parameters that differ from the defaults.
        """
        values, usual = (values_of(self.module.scenes, own, quick=quick) for own in (given, {}))
        return {
            "name": self.name,
            "sha256": self.sha256,
            **({"commit": commit} if (commit := _commit(self.path.parent)) else {}),
            "quick": quick,
            "parameters": values,
            "changed": [name for name, value in values.items() if value != usual[name]],
        }


def find_case(given: str) -> Case:
    """Read a case: a file, or by name one in the current folder or one that comes with the package.

    Raises ValueError if there is none, or if it has a mistake or no scenes.
    """
    paths = [Path(given)] if given.endswith(".py") else [Path(given), Path(f"{given}.py")]
    known = shipped()
    if Path(given).name == given:
        paths += [known[name] for name in (given.removesuffix(".py"),) if name in known]
    path = next((path for path in paths if path.is_file()), None)
    if path is None:
        what = f"no case file {given}" if given.endswith(".py") else f"no case {given}"
        there = f"{', '.join(known)} come with the package" if known else "none come with the package"
        raise ValueError(f"there is {what}{nearest(given, known)}; {there}, others are files.")
    return load_case(path)


def parts_of(module: ModuleType) -> tuple[Any, ...]:
    """Return the dataclasses and functions of a file and of those beside it that it imports."""
    folder = Path(module.__file__ or "").resolve().parent
    found = []
    for item in vars(module).values():
        if isinstance(item, FunctionType) or (isinstance(item, type) and is_dataclass(item)):
            source = getattr(sys.modules.get(item.__module__), "__file__", None)
            if source is not None and Path(source).resolve().parent == folder:
                found.append(item)
    return tuple(found)


def named_parts(files: Iterable[Path]) -> tuple[Any, ...]:
    """Return the dataclasses and functions of files that are named, by the names they have when imported."""
    found: tuple[Any, ...] = ()
    for file in files:
        if not file.is_file():
            raise ValueError(f"--with {file}: there is no such file; name the one that defines the parts.")
        module = _module(file, file.stem)
        found += parts_of(module)
        if callable(getattr(module, "scenes", None)):  # a case with parts of its own, which are stored as its
            found += load_case(file).known
    return found


def load_case(path: Path) -> Case:
    """Read a case file; raises ValueError if it is missing, has a mistake or has no scenes."""
    text = path.read_bytes() if path.is_file() else b""
    module = _module(path, f"turingfold_case_{re.sub(r'[^0-9A-Za-z_]', '_', path.stem)}")
    if not callable(getattr(module, "scenes", None)):
        raise ValueError(f"{short(path)} has no function scenes; {EXPECTED}.")
    return Case(path, module, sha256(text).hexdigest())


def _module(path: Path, name: str) -> ModuleType:
    """Run a Python file as a module of that name."""
    spec = spec_from_file_location(name, path, loader=_Uncached(name, str(path)))
    if path.suffix != ".py" or spec is None or spec.loader is None:
        raise ValueError(f"{short(path)} is no Python file; {EXPECTED}.")
    module = module_from_spec(spec)
    sys.modules[name] = module
    beside = str(path.resolve().parent)
    if beside not in sys.path:  # as for a script, though last: a case may have the name of a library
        sys.path.append(beside)
        own = (_Uncached, [".py"]), (ExtensionFileLoader, EXTENSION_SUFFIXES)
        sys.path_importer_cache[beside] = FileFinder(beside, *own)  # files that it imports, likewise
    invalidate_caches()  # it may import a file that was written just now
    with explained(path):
        spec.loader.exec_module(module)
    return module


class _Uncached(SourceFileLoader):
    """Runs the text of a file as it is: Python takes stored bytecode for its own if second and size agree."""

    def get_code(self, fullname: str) -> CodeType:
        return self.source_to_code(self.get_data(self.path), self.path)


def folder_name(scene: str) -> str:
    """Return the name of a scene's folder: letters, digits and hyphens, and nothing that Windows reserves."""
    name = re.sub(r"[^\w.+=]+", "-", unicodedata.normalize("NFC", scene)).strip("-.") or "scene"
    if len(name) > LONGEST:
        name = f"{name[:LONGEST]}-{sha256(scene.encode()).hexdigest()[:8]}"
    return f"{name}-scene" if RESERVED.fullmatch(name) else name


def check_apart(names: Collection[str], path: Path) -> None:
    """Raise ValueError where two scenes would share a folder, on any system: capitals do not tell apart."""
    seen: dict[str, str] = {}
    for name in names:
        other = seen.setdefault(folder_name(name).casefold(), name)
        if other != name:
            raise ValueError(
                f"{short(path)}: the scenes {other!r} and {name!r} would have one folder, "
                f"{folder_name(name)}; names must differ in letters or digits, and not only in capitals."
            )


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


def _commit(folder: Path) -> str:
    """Return the commit that git has checked out where a folder is, "" where there is none."""
    words = ("git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*")
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=10, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip()


def _place(path: Path, error: BaseException) -> str:
    """Return the case and the line of it that an error comes from."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if Path(frame.filename).resolve() == path.resolve()]
    line = error.lineno if isinstance(error, SyntaxError) else (lines or [None])[-1]
    return f"{short(path)}, line {line}" if line else short(path)
