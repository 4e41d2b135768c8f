"""What the command line leaves behind: exit statuses, errors in readable lines, the command to run next."""

from __future__ import annotations

import argparse
import shlex
import sys
import textwrap
from collections.abc import Iterable

BAD_INPUT = 2
STOPPED = 3  # a solve
IO_FAILED = 4
INTERRUPTED = 130

WIDTH = 100


def complain(message: str) -> None:
    """Print an error: tables keep their columns, long sentences are wrapped."""
    for line in f"turingfold: {message}".splitlines():
        wrapped = textwrap.fill(line, WIDTH, break_on_hyphens=False) if len(line) > WIDTH else line
        print(wrapped, file=sys.stderr)


def run_command(options: argparse.Namespace, only: Iterable[str], *more: str) -> str:
    """Return the command that runs some scenes of a case, or all for none, to the same place."""
    command, arguments = "run", ()
    if options.variation is not None:
        command, arguments = options.variation.command, options.variation.arguments
    words = ["turingfold", command, str(options.case), *arguments]
    words += ["--quick"] if options.quick else []
    words += ["--out", str(options.out)] if options.out else []
    words += [word for name in only for word in ("--only", name)]
    return shlex.join([*words, *more])
