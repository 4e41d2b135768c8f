"""turingfold atlas: scenes drawn at random, each judged by checks that are not the solver's."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..verification.atlas.picture import draw, summed
from ..verification.atlas.run import FORBIDDEN, Row, run
from .figure import save_figure
from .status import STOPPED, say


def atlas(folder: Path, counts: Mapping[str, int], *, seed: int, seconds: float, jobs: int) -> int:
    """Run the cells that the folder's tables lack, say what became of all, draw them; return the exit status.

    The status is 3 for a result that says it is valid and is not, for an error that is none of ours, and for
    a cell that does not end.
    """

    def told(kind: str, row: Row) -> None:
        if row["outcome"] in FORBIDDEN:
            say(f"{kind} {row['number']}, seed {seed}: {row['outcome']}: {row['reason']}")

    rows = run(folder, counts, seed=seed, seconds=seconds, jobs=jobs, progress=told)
    for kind, own in rows.items():
        say(f"{kind}: {summed(own)}")
    with save_figure(folder / "atlas.png") as figure:
        draw(figure, rows)
    say(f"figure: {folder / 'atlas.png'}")
    return STOPPED if any(row["outcome"] in FORBIDDEN for own in rows.values() for row in own) else 0
