"""What the command line leaves behind: exit statuses, and lines on standard output and error."""

from __future__ import annotations

import os
import sys
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

BAD_INPUT = 2
STOPPED = 3  # a solve
IO_FAILED = 4
INTERRUPTED = 130

STATUSES = {  # of runs
    "converged": 0, "invalid": STOPPED, "interrupted": STOPPED, "stopped": STOPPED, "killed": STOPPED,
    "failed": STOPPED, "refused": BAD_INPUT,
}  # fmt: skip
WIDTH = 100


@dataclass(frozen=True)
class Outcome:
    """How a run ended, and why.

    status: of its result; or "refused" (bad input), "killed", or "failed" by an error in the program.
    summary: the numbers of its last state, of a point of a study.
    """

    name: str
    status: str
    message: str = ""
    summary: Mapping[str, Any] = field(default_factory=dict)


def say(text: str) -> None:
    """Print a line at once; where nobody reads any more (`| head`), go on in silence."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        silence = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silence, sys.stdout.fileno())
        os.close(silence)


def complain(message: str) -> None:
    """Print an error: tables keep their columns, long sentences are wrapped."""
    for line in f"turingfold: {message}".splitlines():
        wrapped = textwrap.fill(line, WIDTH, break_on_hyphens=False) if len(line) > WIDTH else line
        print(wrapped, file=sys.stderr)
