"""turingfold list and new: which cases there are, what can be set of them, and a copy to change."""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .files import case_files, shipped, title_of
from .status import BAD_INPUT, WIDTH, complain, say

if TYPE_CHECKING:
    from ..scene import Scene
    from .case import Case

NARROWEST = 40  # letters of a line


def listing(given: Sequence[str], *, parts: bool = False) -> int:
    """Print titles of cases, of those that are named also parameters and scenes; return the exit status.

    parts: whether also every value of the parts of the scenes that --set and --vary take.

    given: names, files, or folders; without any the cases of the package and of the current folder. What a
    case needs and does not find is said and no failure; a mistake in a case is, after all others are listed.
    """
    if not given:
        files = shipped() | {str(path): path for path in case_files(Path())}
        status = max((_tell(name, path) for name, path in files.items()), default=0)
        say("\nturingfold list CASE: its parameters and scenes.  turingfold run CASE: run it.")
        return status
    return max(status for text in given for status in _listed(text, parts=parts))


def _listed(text: str, *, parts: bool) -> list[int]:
    if Path(text).is_dir():
        if not (found := case_files(Path(text))):
            raise ValueError(f"{text} holds no case files (*.py with a function scenes).")
        return [_tell(str(path), path) for path in found]
    from .case import find_case

    try:
        case = find_case(text)
        _say(f"{case.shown}: {case.title}", indent=4)
        _say_parameters(case)
        scenes = _say_scenes(case)
        if parts:
            _say_parts(scenes)
    except ValueError as error:  # the other cases are listed all the same
        complain(str(error))
        return [BAD_INPUT]
    return [0]


def _tell(name: str, file: Path) -> int:
    """Print the title of a case, which is not run for that; return the exit status."""
    try:
        _say(f"{name}: {title_of(file)}", indent=4)
    except ValueError as error:
        complain(str(error))
        return BAD_INPUT
    return 0


def _say(text: str, *, indent: int, first: str = "") -> None:
    """Print a text in lines as wide as the terminal, further lines indented."""
    width = max(shutil.get_terminal_size((WIDTH, 24)).columns, indent + NARROWEST)
    options = {"subsequent_indent": indent * " ", "break_long_words": False, "break_on_hyphens": False}
    say(textwrap.fill(text, width, initial_indent=first, **options))  # type: ignore[arg-type]


def _say_scenes(case: Case) -> dict[str, Scene]:
    import warnings

    from ..results.simulate import CoarseMeshWarning

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", CoarseMeshWarning)  # of a case that runs some of its scenes
            found = case.scenes({}, quick=True)
    except FileNotFoundError as error:
        _say(f"(needs a file that is not here: {error.strerror or error})", indent=4, first="    ")
        return {}
    say("  scenes:")
    for name in found:
        say(f"    {name}")
    return found


def _say_parts(scenes: Mapping[str, Scene]) -> None:
    """Print the values of parts, each once; of those that not all scenes have, which ones do."""
    from ..models.declared import as_text
    from ..studies.sweep import settable

    values = {name: settable(scene) for name, scene in scenes.items()}
    say("  parts:")
    for part in dict.fromkeys(part for own in values.values() for part in own):
        have = [name for name, own in values.items() if part in own]
        some = "" if len(have) == len(scenes) else f"  (of {', '.join(have)})"
        shown = dict.fromkeys(as_text(values[name][part]) for name in have)
        _say(f"--set {part}={' or '.join(shown)}{some}", indent=6, first="    ")


def _say_parameters(case: Case) -> None:
    from ..models.declared import as_text

    rows = {
        f"  --set {name}={as_text(one.default)}  ": (one.meaning.label, one.range)
        for name, one in case.parameters.items()
    }
    width = max(map(len, rows), default=0)
    for first, (label, values) in rows.items():
        _say(f"{label} ({values})" if label else values, indent=width, first=first.ljust(width))


def new_case(file: Path, source: str) -> str:
    """Copy a case to a new file, whose docstring then says how to run that; return what to do with it.

    Raises ValueError for a file that is there, or is no .py.
    """
    from ..results.files import write_whole
    from .case import find_case

    if file.suffix != ".py" or file.exists():
        why = "is there already" if file.exists() else "must end with .py"
        raise ValueError(f"{file} {why}; choose another name.")
    case = find_case(source)
    text = case.path.read_text(encoding="utf-8")
    for old, new in {
        f"turingfold run cases/{case.name}.py": f"turingfold run {file}",
        f"results/{case.name}": f"results/{file.stem}",
        f"figures/{case.name}": f"results/{file.stem}/{file.stem}",
    }.items():
        text = text.replace(old, new)
    write_whole(file, text.encode())
    return f"{file}: a copy of {case.name} to change. Run it with: turingfold run {file}"
