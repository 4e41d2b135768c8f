"""turingfold app: a window to change a case's parameters by hand and watch what happens."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..app import App
from ..results.simulate import CoarseMeshWarning, coarseness
from .case import find_case, folder_name
from .figure import save_figure
from .plan import base_folder, planned
from .request import Request

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def app(request: Request) -> int:
    """Open the window and return when it is closed.

    Pictures go to results/<case>-app, those of a quick version to results/quick/<case>-app. What is run is
    printed as a command line. Raises ValueError without a display, or for a mistake in the case.
    """
    case = find_case(request.case)
    scenes = {one.name: one.scene for one in planned(case, request) if one.scene is not None}
    figure, show = _window(f"turingfold {case.name}")
    if words := coarseness(min(scene.body.elements_through_cortex for scene in scenes.values())):
        warnings.warn(words, CoarseMeshWarning, stacklevel=2)
    base = base_folder(case, request)

    def save(name: str, draw: Callable[[Figure], object]) -> Path:
        path = base / f"{folder_name(name)}.png"
        with save_figure(path) as canvas:
            draw(canvas)
        return path

    def command(scene: str, assignments: tuple[tuple[str, str], ...]) -> str:
        words = tuple(word for name, value in assignments for word in ("--vary", f"{name}={value}"))
        return replace(request, command=("sweep", *words) if words else ("run",), only=(scene,)).words()

    window = App(figure, scenes, command=command, save=save)
    show()
    window.stop()
    return 0


def _window(title: str) -> tuple[Figure, Callable[[], None]]:
    """Return an empty window and what shows it until it is closed; raises ValueError without a display."""
    from matplotlib import get_backend

    remedy = (
        "run it on a machine with a display and with one of matplotlib's window systems (Tk, Qt, GTK, wx, "
        "macOS; MPLBACKEND=TkAgg chooses one), or vary parameters by turingfold sweep."
    )
    try:
        from matplotlib import pyplot

        figure = pyplot.figure(num=title)
    except (ImportError, RuntimeError) as error:  # by the window system that was asked for
        raise ValueError(f"a window cannot be opened ({error}); {remedy}") from error
    if figure.canvas.required_interactive_framework is None:
        pyplot.close(figure)
        nowhere = sys.platform == "linux" and not {"DISPLAY", "WAYLAND_DISPLAY"} & set(os.environ)
        backend = f"matplotlib's backend {get_backend()!r} opens no window"
        raise ValueError(f"{'there is no display' if nowhere else backend}; {remedy}")
    return figure, pyplot.show
