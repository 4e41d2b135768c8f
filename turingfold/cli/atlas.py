"""turingfold atlas: scenes drawn at random, each judged by checks that are not the solver's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter

from ..verification.atlas.known import reached
from ..verification.atlas.known import told as reaching
from ..verification.atlas.picture import draw, summed
from ..verification.atlas.run import FORBIDDEN, Row, run
from .figure import save_figure
from .request import Telling
from .status import STOPPED, Answer, complain, progress, say

BETWEEN = 30.0  # s between lines that say how far it has come


def atlas(
    folder: Path, counts: Mapping[str, int], *, seed: int, seconds: float, jobs: int, telling: Telling
) -> Answer:
    """Run the cells that the folder's tables lack, say what became of all, and draw them.

    The status is 3 for a result that says it is valid and is not, for an error that is none of ours, and for
    a cell that does not end.
    """
    ended, last = 0, perf_counter()

    def told(kind: str, row: Row) -> None:
        nonlocal ended, last
        ended += 1
        if row["outcome"] in FORBIDDEN:
            complain(f"{kind} {row['number']}, seed {seed}: {row['outcome']}: {row['reason']}")
        if telling is Telling.STEPS:
            progress(f"{kind} {row['number']}: {row['outcome']}, {row['seconds']} s")
        elif telling is Telling.OVERALL and perf_counter() - last > BETWEEN:
            last = perf_counter()
            progress(f"{ended} cells have ended, the last is {kind} {row['number']} of {counts[kind]}")

    rows = run(folder, counts, seed=seed, seconds=seconds, jobs=jobs, progress=told)
    known = {kind: reached(kind, own) for kind, own in rows.items()}
    for kind, own in rows.items():
        words = reaching(known[kind])
        say(f"{kind}: {summed(own)}" + (f"; {words}" if words else ""))
    picture = folder / "atlas.png"
    with save_figure(picture) as figure:
        draw(figure, rows)
    say(f"figure: {picture}")
    outcomes = {kind: Counter(row["outcome"] for row in own) for kind, own in rows.items()}
    facts = {
        "folder": str(folder), "outcomes": {kind: dict(own) for kind, own in outcomes.items()},
        "known": {kind: {"reached": found, "cells": count} for kind, (found, count) in known.items()},
    }  # fmt: skip
    wrong = any(own[outcome] for own in outcomes.values() for outcome in FORBIDDEN)
    return Answer(STOPPED if wrong else 0, {**facts, "figures": [str(picture)]})
