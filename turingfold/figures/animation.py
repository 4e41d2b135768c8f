"""A film of a result: its states one after the other, on one scale and with the same colours."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..checks import one_of, whole
from ..growth.measure import largest_growth
from ..results.files import FilePath, write_whole
from ..results.measures import sulci_of
from ..results.result import Result
from .sections import FIELDS, field_limits, section
from .style import MM, copies, sulci

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, RESOLUTION = 8.0, 120  # inch, dots per inch
PAUSE = 1.0  # s, on the last state


def animate(result: Result, file: FilePath, *, field: str = "von_mises", rate: int = 8) -> Path:
    """Write the deforming body as a film and return its path.

    file: ends in .gif, or in .mp4, which needs the extra `movie`.  field: as in `plots.section`.
    rate: states per second, a whole number.
    Raises ValueError for other endings, fields and rates, and for a result with a single state.
    """
    path = Path(file)
    one_of("field", field, tuple(FIELDS))
    whole("rate", rate, at_least=1)
    if len(result.states) < 2:
        raise ValueError("the result has a single state, of which there is no film; run its scene first.")
    writer, settings = _writer(path.suffix.lower(), rate)
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    figure = Figure(layout="constrained")
    with tempfile.TemporaryDirectory() as folder, rc_context(settings):
        unfinished = Path(folder) / path.name
        with writer.saving(figure, unfinished, RESOLUTION):
            for _ in frames(figure, result, field, last=1 + round(PAUSE * rate)):
                writer.grab_frame()
        write_whole(path, unfinished.read_bytes())
    return path


def frames(figure: Figure, result: Result, field: str, *, last: int = 1) -> Iterator[int]:
    """Draw one state after the other on the figure, the last one `last` times; yield the state's place."""
    body, limits = result.scene.body, field_limits(result, field=field)
    low, high = _box(result)
    figure.set_size_inches(WIDTH, _even(0.9 * WIDTH * float((high - low)[1] / (high - low)[0]) + 0.5))
    unfinished = f"; {result.unfinished}" if result.unfinished else ""
    for step in range(len(result.states)):
        figure.clear()
        axes = figure.add_subplot()
        section(axes, result, step, field=field, limits=limits)
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        folds = sulci_of(body, result.states[step]["displacement"])[0]
        age = f"{result.label(step)}, " if result.label(step) else ""
        axes.set_title(f"{age}growth {largest_growth(result.states[step]):.2f}, {sulci(folds)}{unfinished}")
        for _ in range(1 if step < len(result.states) - 1 else last):
            yield step


def _box(result: Result) -> tuple[Array, Array]:
    """Return the corners of all the states' places; mm."""
    body = result.scene.body
    places = [
        MM * points for state in result.states for points in copies(body, body.nodes + state["displacement"])
    ]
    low, high = np.min([p.min(1) for p in places], axis=0), np.max([p.max(1) for p in places], axis=0)
    margin = 0.04 * (high - low).max()
    return low - [margin, 2.5 * margin], high + margin  # below, there is the scale bar


def _even(height: float) -> float:
    """Return a height of an even number of dots, as films are coded."""
    return 2 * round(height * RESOLUTION / 2) / RESOLUTION


def _writer(ending: str, rate: int) -> tuple[Any, Any]:
    """Return matplotlib's writer of films with this ending, and the settings it needs."""
    if ending == ".gif":
        from matplotlib.animation import PillowWriter

        return PillowWriter(fps=rate), {}
    if ending != ".mp4":
        raise ValueError(f"a film ends in .gif or .mp4, not in {ending!r}.")
    try:
        ffmpeg: Any = import_module("imageio_ffmpeg")
    except ImportError as error:
        raise ValueError("an .mp4 needs ffmpeg: pip install 'turingfold[movie]', or write a .gif.") from error
    from matplotlib.animation import FFMpegWriter

    settings = {"animation.ffmpeg_path": ffmpeg.get_ffmpeg_exe()}
    return FFMpegWriter(fps=rate, codec="libx264", extra_args=["-pix_fmt", "yuv420p"]), settings
