"""Arguments that several commands share; a command has those, and only those, that it heeds."""

from __future__ import annotations

import argparse
from pathlib import Path

from .kinds import assignment, at_least_one, figure, seconds


def _group() -> argparse.ArgumentParser:
    return argparse.ArgumentParser(add_help=False)


def common() -> argparse.ArgumentParser:
    """Return the arguments of all commands."""
    found = _group()
    found.add_argument("--threads", type=at_least_one, default=1, metavar="N", help="BLAS threads (1)")
    found.add_argument("--debug", action="store_true", help="show the traceback of an error")
    return found


def of_a_case(*, chosen: bool = True) -> argparse.ArgumentParser:
    """Return the arguments that say which case is meant, and which of its scenes with which parameters."""
    found = _group()
    found.add_argument("case", metavar="CASE", help="a name of turingfold list, or a file with scenes()")
    found.add_argument("--quick", action="store_true", help="the small version, kept apart")
    if not chosen:
        return found
    found.add_argument("--only", action="append", metavar="SCENE", help="only this scene; may be repeated")
    found.add_argument(
        "--set", action="append", type=assignment, metavar="NAME=VALUE", dest="assigned",
        help="value of a parameter of the case, such as thickness=3e-3; may be repeated",
    )  # fmt: skip
    return found


def of_results() -> argparse.ArgumentParser:
    """Return the argument that says where results are."""
    found = _group()
    found.add_argument("--out", type=Path, metavar="DIR", help="results in DIR/<case>/<scene> (results)")
    return found


def of_earlier_results() -> argparse.ArgumentParser:
    """Return the arguments that say what becomes of results that are there."""
    found = _group()
    there = found.add_mutually_exclusive_group()
    there.add_argument("--resume", action="store_true", help="go on where an earlier run was stopped")
    there.add_argument("--overwrite", action="store_true", help="replace results that are there")
    return found


def of_jobs() -> argparse.ArgumentParser:
    """Return the argument that says how many scenes are run at a time."""
    found = _group()
    found.add_argument("-j", "--jobs", type=at_least_one, default=1, metavar="N", help="scenes at a time")
    return found


def of_errors() -> argparse.ArgumentParser:
    """Return the argument that says whether errors are estimated."""
    found = _group()
    found.add_argument(
        "--no-errors", action="store_false", dest="errors", help="do not estimate how far the numbers are off"
    )
    return found


def of_keeping() -> argparse.ArgumentParser:
    """Return the arguments that say how long scenes may run, and which of their states are kept."""
    found = _group()
    found.add_argument(
        "--max-seconds", type=seconds, default=float("inf"), metavar="S",
        help="stop the march of each scene after that time, without error estimates; --resume goes on",
    )  # fmt: skip
    found.add_argument("--frames", type=at_least_one, metavar="N", help="states kept, evenly in time (20)")
    found.add_argument("--no-vtu", action="store_false", dest="vtu", help="write no files for ParaView")
    return found


def of_answers(*, steps: bool = True, pictured: bool = True) -> argparse.ArgumentParser:
    """Return the arguments that say what is printed, and where the figure goes."""
    found = _group()
    how = found.add_mutually_exclusive_group()
    how.add_argument("-q", "--quiet", action="store_true", help="print errors only")
    if steps:
        how.add_argument("-v", "--verbose", action="store_true", help="print a line for each step")
    found.add_argument("--json", action="store_true", help="print one JSON object, other lines on stderr")
    if pictured:
        found.add_argument("--figure", type=figure, metavar="FILE", help="draw it there: .png, .pdf, .svg")
    return found
