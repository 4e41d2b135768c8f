"""log.txt: when a result was made, by which command and versions, how far it came, and how it ended."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import TextIO

from .files import open_unlinked, writing

NAME = "log.txt"
LINES = 10  # of progress


def append(path: Path, text: str) -> None:
    """Add a line with the time in front, further lines of the text indented; raises OutputError."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    content = f"{now} {text}".replace("\n", "\n  ") + "\n"
    with writing(path), os.fdopen(open_unlinked(path, os.O_APPEND | os.O_CREAT), "ab") as file:
        file.write(content.encode())


def is_due(before: float, now: float) -> bool:
    """Return whether a line is due at a share of a run, the last step having ended at another."""
    return int(LINES * now + 1e-9) > int(LINES * before + 1e-9)


@contextmanager
def warnings_to(tell: Callable[[str], object]) -> Iterator[None]:
    """Tell of warnings that are shown inside, and show them all the same."""
    shown = warnings.showwarning

    def both(
        message: Warning | str, category: type[Warning], filename: str, lineno: int,
        file: TextIO | None = None, line: str | None = None,
    ) -> None:  # fmt: skip
        tell(f"warning: {message}")
        shown(message, category, filename, lineno, file, line)

    warnings.showwarning = both
    try:
        yield
    finally:
        warnings.showwarning = shown
