"""The command that solves problems with known answers and compares."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

from ..errors import SolveError
from ..verification.check import Check, Quantity
from .status import STOPPED, Answer, complain, say
from .table import write_table

COLUMNS = ("problem", "quantity", "expected", "got", "error", "tolerance", "holds", "source")


def verify(checks: Sequence[Check], out: Path | None = None) -> Answer:
    """Print what is expected and what is found, and write it as CSV on request.

    Errors are relative, absolute where zero is expected. The status is 3 if one is beyond its tolerance, or a
    problem's solve stopped.
    """
    begin, stopped = perf_counter(), 0
    rows: list[tuple[Check, Quantity]] = []
    say(f"{'quantity':52} {'expected':>14} {'got':>14} {'error':>8} {'tolerance':>9}")
    for check in checks:
        say(f"{check.problem} ({check.source})")
        try:
            found = check.compute()
        except SolveError as error:
            complain(f"{check.problem}: {error}")
            stopped += 1
            continue
        for one in found:
            say(_line(one))
            rows.append((check, one))
    if out is not None:
        write_table(out, COLUMNS, (_row(check, one) for check, one in rows))
    held = sum(one.holds for _, one in rows)
    say(f"{held} of {len(rows)} numbers of {len(checks)} problems hold; {perf_counter() - begin:.0f} s")
    for check, one in rows:
        if not one.holds:
            complain(
                f"{check.problem}: {one.name} is {one.got:.9g}, expected {one.expected:.9g}; the error "
                f"{one.error:.1e} is beyond the tolerance {one.tolerance:.1e}."
            )
    numbers = [dict(zip(COLUMNS, _row(check, one), strict=True)) for check, one in rows]
    facts = {"numbers": numbers, "problems": len(checks), "table": None if out is None else str(out)}
    return Answer(0 if held == len(rows) and not stopped else STOPPED, facts)


def _line(one: Quantity) -> str:
    verdict = "" if one.holds else "  FAIL"
    numbers = f"{one.expected:14.9g} {one.got:14.9g} {one.error:8.1e} {one.tolerance:9.1e}"
    return f"  {one.name:50} {numbers}{verdict}"


def _row(check: Check, one: Quantity) -> tuple[object, ...]:
    return (
        check.problem, one.name, one.expected, one.got, one.error, one.tolerance, one.holds, check.source
    )  # fmt: skip
