"""turingfold list and new: which cases there are, what can be set of them, and a copy to change."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

from ..models.declared import as_text
from ..results.files import write_whole
from ..results.simulate import CoarseMeshWarning
from .case import Case, case_files, find_case, load_case, shipped
from .status import BAD_INPUT, complain, say


def listing(given: Sequence[str]) -> int:
    """Print cases with their scenes, those that are named with their parameters; return the exit status.

    given: names, files, or folders; without any the cases of the package and of the current folder. What a
    case needs and does not find is said and no failure; a mistake in a case is, after all others are listed.
    """
    named = [path for text in given for path in _named(text)]
    files = {str(path): path for path in named or case_files(Path())}
    if not given:
        files = shipped() | files
    status = 0
    for name, path in files.items():
        try:
            case = load_case(path)
            say(f"{name}: {case.title}")
            if given:
                _say_parameters(case)
            _say_scenes(case)
        except ValueError as error:  # the other cases are listed all the same
            complain(str(error))
            status = BAD_INPUT
    return status


def _named(text: str) -> list[Path]:
    if not Path(text).is_dir():
        return [find_case(text).path]
    if not (found := case_files(Path(text))):
        raise ValueError(f"{text} holds no case files (*.py with a function scenes).")
    return found


def _say_scenes(case: Case) -> None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", CoarseMeshWarning)  # of a case that runs some of its scenes
            names = list(case.scenes({}, quick=True))
    except FileNotFoundError as error:
        say(f"    (needs a file that is not here: {error.strerror or error})")
        return
    for name in names:
        say(f"    {name}")


def _say_parameters(case: Case) -> None:
    rows = [
        (f"{name}={as_text(one.default)}", one.range, one.meaning.label)
        for name, one in case.parameters.items()
    ]
    widths = [max((len(row[k]) for row in rows), default=0) for k in (0, 1)]
    for first, second, label in rows:
        say(f"  --set {first:<{widths[0]}}  {second:<{widths[1]}}  {label}".rstrip())


def new_case(file: Path, source: str) -> str:
    """Copy a case to a new file, whose docstring then says how to run that; return what to do with it.

    Raises ValueError for a file that is there, or is no .py.
    """
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
