"""The command line; `turingfold` alone names its commands.

Exit status: 0 everything asked for was done; 1 `doctor` has found something wrong; 2 bad input; 3 a solve
stopped; 4 reading or writing failed; 130 Ctrl-C. Numpy is imported after the number of threads is set, so
nothing heavy is imported at the top.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout, suppress
from pathlib import Path

from .parser import parser
from .status import BAD_INPUT, INTERRUPTED, IO_FAILED, STOPPED, Answer, Interrupted, complain, note, say

ASKED = "_ARGCOMPLETE"  # by a shell: how words go on
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the command line asks for and return the exit status."""
    _hear_break()
    commands = parser()
    if ASKED in os.environ:
        from .completion import complete

        complete(commands)
    options = commands.parse_args(arguments)
    if options.version:
        from importlib.metadata import version

        say(f"turingfold {version('turingfold')}")
        return 0
    if "command" not in options:
        say(commands.format_help().rstrip())
        return 0
    with _aside(options), _told_if_old(getattr(options, "figure", None)):
        answer = _answered(options)
    if _has(options, "json"):
        import json

        from ..results.plain import as_plain

        facts = as_plain({"exit_status": answer.status, **answer.facts})
        say(json.dumps(facts, allow_nan=False))
    return answer.status


def _hear_break() -> None:
    """Let Ctrl-Break stop as Ctrl-C does, where there is one: on Windows others ask to stop by it."""
    if hasattr(signal, "SIGBREAK"):
        with suppress(ValueError):  # only the first thread may
            signal.signal(signal.SIGBREAK, signal.default_int_handler)


def run_case(file: str) -> None:
    """Run a case from its own file, `if __name__ == "__main__": run_case(__file__)`, and end the program."""
    path, here = Path(file).resolve(), Path.cwd()
    shown = path.relative_to(here) if path.is_relative_to(here) else path
    raise SystemExit(main(["run", str(shown), *sys.argv[1:]]))


def _has(options: argparse.Namespace, name: str) -> bool:
    """Return whether an option was given; not every command has every one."""
    return bool(getattr(options, name, False))


@contextmanager
def _aside(options: argparse.Namespace) -> Iterator[None]:
    """Keep standard output free for one JSON object, or for nothing, if that is asked for."""
    if _has(options, "quiet"):
        with Path(os.devnull).open("w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
            yield
    elif _has(options, "json"):
        with redirect_stdout(sys.stderr):
            yield
    else:
        yield


@contextmanager
def _told_if_old(figure: Path | None) -> Iterator[None]:
    """Say of a file that the command was to draw, and has not, that it is of an earlier one."""
    before = _identity(figure)
    yield
    if before is not None and _identity(figure) == before:
        complain(f"note: {figure} is of an earlier command; this one has drawn nothing there.")


def _identity(file: Path | None) -> tuple[int, int] | None:
    """Return what tells a file from one that replaces it; None where there is none."""
    with suppress(OSError):
        if file is not None:
            found = file.stat()
            return found.st_ino, found.st_mtime_ns
    return None


def _answered(options: argparse.Namespace) -> Answer:
    """Do it, and say where it was interrupted."""
    try:
        return _done(options)
    except Interrupted as stopped:
        words = f"stopped; nothing before the last checkpoint is lost. Go on with: {stopped.again}"
        return _failed(options, words, INTERRUPTED)
    except KeyboardInterrupt:
        return _failed(options, "stopped.", INTERRUPTED)
    except Exception as error:
        if _interrupted(error):
            return _failed(options, "stopped.", INTERRUPTED)
        raise


def _done(options: argparse.Namespace) -> Answer:
    """Do it, in one thread if not asked otherwise, and say in words what fails."""
    import logging
    import warnings

    for name in THREADS:  # one thread repeats bit for bit, and the matrices are too sparse to gain from more
        os.environ[name] = str(options.threads)
    os.environ["MPLBACKEND"] = "agg"  # a notebook's may not be installed here; files need none
    logging.getLogger("skfem").setLevel(logging.ERROR)  # it reports copies of arrays
    from ..errors import SolveError
    from .commands import COMMANDS

    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if _has(options, "quiet") else "default", UserWarning)
        warnings.showwarning = note
        try:
            answer = COMMANDS[options.command](options)
            return answer if isinstance(answer, Answer) else Answer(answer, {})
        except SolveError as error:
            return _failed(options, str(error), STOPPED)
        except OSError as error:
            from ..results.files import OutputError

            named = isinstance(error, OutputError) or error.filename is None
            words = error.strerror or str(error) if named else f"{error.filename}: {error.strerror}"
            return _failed(options, words, IO_FAILED)
        except ValueError as error:
            return _failed(options, str(error), BAD_INPUT)
        except MemoryError as error:
            return _failed(options, f"memory is over ({error}); use larger elements.", STOPPED)


def _interrupted(error: BaseException | None) -> bool:
    """Return whether Ctrl-C is behind an error: libraries that are being imported make others of it."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _failed(options: argparse.Namespace, message: str, status: int) -> Answer:
    if options.debug:
        import traceback

        traceback.print_exc()
    complain(message)
    return Answer(status, {"error": message})
