"""Why a march stopped, how far it came, and what to try."""

from __future__ import annotations

import numpy as np

from ..errors import NotConvergedError, OutOfMemoryError, RoundOffError, SolveError
from ..scene import Scene
from ..state import State
from ..stepping import Stepping

USUAL = Stepping.iterations


def stopped(state: State, stepping: Stepping, until: float, cause: SolveError) -> NotConvergedError:
    """Return the error of a march of which no step is short enough."""
    more = "more iterations (Stepping(iterations=...)), " if stepping.iterations < USUAL else ""
    residual = f" (residual {cause.residual:.2g})" if np.isfinite(cause.residual) else ""
    return NotConvergedError(
        f"The march stopped at t = {state.time:.6g} of {until:g}: {cause}{residual}. The last good state is "
        f"kept. Try {more}smaller steps (Stepping(largest=...)), smaller elements, less load, or Drag(...), "
        "in a new run.",
        time=state.time,
        residual=cause.residual,
    )


def hopeless(state: State, until: float, cause: Exception) -> SolveError:
    """Return the error of a march that no other step would help: of round-off, or without memory."""
    words = f"The march stopped at t = {state.time:.6g} of {until:g}: "
    if isinstance(cause, RoundOffError):
        return NotConvergedError(f"{words}{cause}.", time=state.time, residual=cause.residual)
    lacks = cause if isinstance(cause, OutOfMemoryError) else f"memory is over ({cause}); use larger elements"
    return OutOfMemoryError(f"{words}{lacks}. The last good state is kept.", time=state.time)


def out_of_time(state: State, scene: Scene) -> NotConvergedError:
    """Return the error of a march whose time limit is reached."""
    return NotConvergedError(
        f"The march stopped at t = {state.time:.6g} of {scene.until:g}: the time limit of "
        f"{scene.stepping.seconds:g} s is reached. The last good state is kept. Try another "
        "Stepping(seconds=...) (--max-seconds); a run with results in a folder goes on with it by "
        "resume=True (--resume).",
        time=state.time,
    )
