"""Files of cases: which there are, and their titles. None is run for that, and nothing heavy is imported."""

from __future__ import annotations

import ast
import re
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
# cases that come with the package: inside it where it is installed, beside it in a checkout
SHIPPED = next((folder for folder in (PACKAGE / "cases", PACKAGE.parent / "cases") if folder.is_dir()), None)


def shipped() -> dict[str, Path]:
    """Return the files of the cases that come with the package, by name."""
    return {path.stem: path for path in case_files(SHIPPED)} if SHIPPED else {}


def case_files(folder: Path) -> list[Path]:
    """Return the Python files of a folder that have scenes."""
    marked = re.compile(rb"^def scenes\(", re.MULTILINE)
    return [file for file in sorted(folder.glob("*.py")) if marked.search(file.read_bytes())]


def short(path: Path) -> str:
    """Return how messages name a file: a case that comes with the package by its name, others from here."""
    if shipped().get(path.stem) == path:
        return path.stem
    here = Path.cwd()
    return str(path.relative_to(here) if path.is_relative_to(here) else path)


def title(text: str | None) -> str:
    """Return the first paragraph of a docstring as one line."""
    return " ".join((text or "").strip().partition("\n\n")[0].split())


def parameter_names(file: Path) -> list[str]:
    """Return the names of a case's parameters; none of a file that is no case."""
    try:
        body = ast.parse(file.read_bytes()).body
    except (SyntaxError, ValueError):
        return []
    made = [item for item in body if isinstance(item, ast.FunctionDef) and item.name == "scenes"]
    return [argument.arg for function in made for argument in function.args.kwonlyargs]


def title_of(file: Path) -> str:
    """Return the title of a case file; raises ValueError for one that is no Python."""
    try:
        return title(ast.get_docstring(ast.parse(file.read_bytes())))
    except SyntaxError as error:
        words = f"{file}, line {error.lineno}: SyntaxError: {error.msg}. Correct the case."
        raise ValueError(words) from error
