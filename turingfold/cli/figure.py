"""Figures made at the command line: where they go, and how they are saved."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..figures.style import compact
from ..results.files import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESOLUTION = 200  # dots per inch


def figure_path(case: Path, base: Path, *, apart: bool) -> Path:
    """Return where the figure of a case goes.

    For a case in the folder "cases" of the working folder that is figures/<case>.png; a quick run, one with
    other parameters or a folder of its own (`apart`), and a case elsewhere, keep it with their results.
    """
    if apart or case.resolve().parent != Path("cases").resolve():
        return base / f"{case.stem}.png"
    return Path("figures") / f"{case.stem}.png"


@contextmanager
def save_figure(path: Path) -> Iterator[Figure]:
    """Give an empty figure to draw on and save it; nothing is saved if drawing fails.

    The ending of the name says the format: .png, .pdf, .svg or another one that matplotlib writes.
    """
    from matplotlib.figure import Figure

    figure = Figure(layout="constrained")
    yield figure
    content = io.BytesIO()
    kind = path.suffix[1:].lower()
    options: dict[str, Any] = {"format": kind, "dpi": RESOLUTION, "facecolor": "white"}
    if kind == "png":
        options["pil_kwargs"] = {"compress_level": 1}  # it is coded again below
    figure.savefig(content, **options)
    picture = content.getvalue()
    write_whole(path, compact(picture) if kind == "png" else picture)
