"""What the command line leaves behind: exit statuses, and lines on standard output and error."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from typing import Any, NamedTuple, TextIO

BAD_INPUT = 2
STOPPED = 3  # a solve
IO_FAILED = 4
INTERRUPTED = 130

WIDTH = 100


class Answer(NamedTuple):
    """What a command has done: its exit status, and facts for programs."""

    status: int
    facts: Mapping[str, Any]


class Interrupted(KeyboardInterrupt):
    """Ctrl-C while scenes ran; `again` is the command line that goes on."""

    def __init__(self, again: str) -> None:
        super().__init__(again)
        self.again = again


def say(text: str) -> None:
    """Print a line at once; where nobody reads any more (`| head`), go on in silence."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        silence = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silence, sys.stdout.fileno())
        os.close(silence)


def note(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, file: TextIO | None = None,
    line: str | None = None,
) -> None:  # fmt: skip
    """Print a warning on standard error, as `warnings.showwarning` does."""
    print(f"turingfold: note: {message}", file=sys.stderr)


def progress(text: str) -> None:
    """Print on standard error how far a command has come."""
    print(f"turingfold: {text}", file=sys.stderr, flush=True)


def complain(message: str) -> None:
    """Print an error: tables keep their columns, long sentences are wrapped."""
    import textwrap

    for line in f"turingfold: {message}".splitlines():
        wrapped = textwrap.fill(line, WIDTH, break_on_hyphens=False) if len(line) > WIDTH else line
        print(wrapped, file=sys.stderr)
