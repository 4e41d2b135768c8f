"""A run that is taken one step at a time, so that a window stays alive between steps."""

from __future__ import annotations

from collections.abc import Iterator
from time import perf_counter

from ..results.result import Result, Row
from ..scene import Scene, reached
from ..solve.march import Progress, Step, begin, march
from ..state import State


class Trial:
    """A scene on its way to its end, with the same steps, to the last bit, as in `simulate`."""

    def __init__(self, scene: Scene, label: str = "", line: str = "") -> None:
        """Make the fields that the scene starts from; raises what its processes raise.

        label: what is changed in the scene.  line: the command line that makes the same run.
        """
        began = perf_counter()
        progress = begin(scene)
        self.scene, self.label, self.line = scene, label, line
        self.states: list[State] = [progress.state]
        self.history: list[Row] = []
        self.seconds = perf_counter() - began
        self._steps: Iterator[tuple[Step, Progress]] | None = march(scene, progress)

    def advance(self) -> bool:
        """Take a step and return whether there is one to take.

        Raises ValueError and SolveError as the march does; the last good state is kept.
        """
        if self._steps is None:
            return False
        began = perf_counter()
        taken = next(self._steps, None)
        self.seconds += perf_counter() - began
        if taken is None:
            return False
        self.states.append(taken[0].state)
        self.history.append(taken[0].numbers)
        return True

    def close(self) -> None:
        """Give up what the march holds; what was reached stays."""
        self._steps = None

    @property
    def ended(self) -> bool:
        """Whether the end of the scene is reached."""
        return reached(self.scene, self.states[-1].time)

    @property
    def result(self) -> Result:
        """What has come of the scene so far."""
        status = "converged" if self.ended else "interrupted"
        return Result(
            self.scene, tuple(self.states), tuple(self.history), status, seconds=self.seconds
        )
