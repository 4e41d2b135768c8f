"""The window: controls on the left, the folding body on the right, what is known of it below."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, TypeAlias

from ..errors import SolveError
from ..figures.sections import measures
from ..figures.style import INK
from ..scene import Scene
from .knobs import Settings
from .panel import BESIDE, BLUE, CHOICE, INDENT, LEFT, Panel
from .picture import TISSUE, VIEWS, Before, Box, extent, picture
from .trial import Trial

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.widgets import Button

Assignments: TypeAlias = tuple[tuple[str, str], ...]  # as `--vary` takes them
Command: TypeAlias = Callable[[str, Assignments], str]
Save: TypeAlias = Callable[[str, Callable[["Figure"], object]], "Path"]

SIZE = 12.0, 7.2  # inch
PICTURE = (0.39, 0.30, 0.60, 0.68)  # of the figure
CASE = "the values of the case"
PAUSE = 15  # ms between steps, for the window to draw and to listen
RED = "#c00000"
WIDTH = 98  # letters in a line of the message


class App:
    """A window on scenes: change parameters, run, watch, stop, save.

    figure: an empty one; its canvas's timer takes the steps, one at a time.
    scenes: by name.  command(scene, assignments): the command line that makes the same run.
    save(name, draw): lets `draw` draw on a figure, stores it and returns where.
    Whatever the scene or its run refuses is said in `message`, and the last good state stays.
    """

    def __init__(self, figure: Figure, scenes: Mapping[str, Scene], *, command: Command, save: Save) -> None:
        """Show the first scene, as it starts."""
        self.figure, self.scenes = figure, dict(scenes)
        self._command, self._save = command, save
        self.view = TISSUE
        self.trial: Trial | None = None  # what is drawn
        self.running = False
        self.name = next(iter(self.scenes))
        self._next: tuple[Scene, str, str] | None = None  # to begin at the next tick
        self._before: Before | None = None
        self._box: Box | None = None
        self._drawn: list[Axes] = []
        self._timer = figure.canvas.new_timer(interval=PAUSE, callbacks=[(self.tick, (), {})])
        figure.canvas.mpl_connect("close_event", lambda _: self._timer.stop())
        figure.set_size_inches(*SIZE)
        self._layout()
        self._enter()

    def _layout(self) -> None:
        """Put up what stays whatever the scene."""
        from matplotlib.widgets import RadioButtons

        self.heading = self.figure.text(LEFT, 0.955, "", fontsize=12, va="center", color=INK)
        self.numbers = self.figure.text(0.39, 0.235, "", fontsize=11, va="top", color=INK, linespacing=1.4)
        self.message = self.figure.text(0.39, 0.16, "", fontsize=8.5, va="top", color=INK, linespacing=1.4)
        actions = {"Run": self.run, "Stop": self.stop, "Reset": self.reset, "Save": self.save}
        self.buttons = {
            word: self._button((LEFT + 0.082 * k, 0.12, 0.074, 0.055), word, action)
            for k, (word, action) in enumerate(actions.items())
        }
        if len(self.scenes) > 1:
            self.buttons["<"] = self._button((0.30, 0.935, 0.02, 0.04), "<", lambda: self.choose(-1))
            self.buttons[">"] = self._button((0.325, 0.935, 0.02, 0.04), ">", lambda: self.choose(1))
        axes = self.figure.add_axes((LEFT - INDENT, 0.02, CHOICE, 0.09))
        axes.set_axis_off()
        self.views = RadioButtons(axes, VIEWS, useblit=False, activecolor=BLUE, radio_props={"s": [60]})
        for label in self.views.labels:
            label.set_x(BESIDE)
        self.views.on_clicked(self.look)

    def _button(
        self, place: tuple[float, float, float, float], word: str, action: Callable[[], object]
    ) -> Button:
        from matplotlib.widgets import Button

        button = Button(self.figure.add_axes(place), word, useblit=False)
        button.on_clicked(lambda _: action())
        return button

    def choose(self, onward: int) -> None:
        """Show the scene that comes so many after the present one, as it starts."""
        names = list(self.scenes)
        self.name = names[(names.index(self.name) + onward) % len(names)]
        self.panel.remove()
        self._enter()

    def _enter(self) -> None:
        """Put up the controls of the present scene, and show how it starts."""
        names = list(self.scenes)
        many = f"  ({names.index(self.name) + 1} of {len(names)})" if len(names) > 1 else ""
        self.heading.set_text(textwrap.shorten(self.name, 34, placeholder=" ...") + many)
        self.trial = self._before = self._box = None
        self.numbers.set_text("")
        self._controls()
        self._next, self.running = (self.scenes[self.name], "", self.line()), True
        self.tick()
        self._end()
        if self.message.get_color() != RED:
            self._say("Change something, then press Run.")

    def _controls(self) -> None:
        self.panel = Panel(self.figure, Settings(self.scenes[self.name]), self._changed)

    def reset(self) -> None:
        """Return all parameters to the scene's own values; what is drawn stays."""
        self.panel.remove()
        self._controls()
        self._changed("")

    def _changed(self, refusal: str) -> None:
        """Say what the controls stand for now, or why a value is refused."""
        try:
            label, _ = self.panel.settings.made()
        except ValueError as error:
            refusal = refusal or str(error)
        if refusal:
            self._say(refusal, RED)
        else:
            when = "This run goes on as it began; press Run for" if self.running else "Press Run for"
            self._say(f"{when} {label or CASE}.")

    def run(self) -> None:
        """Begin a run with the present settings, from the start."""
        try:
            label, scene = self.panel.settings.made()
        except ValueError as error:
            self._say(str(error), RED)
            return
        self._end()
        self._say("Starting ...")
        self._next, self.running = (scene, label, self.line()), True
        print(self.line(), flush=True)  # to copy: the words in a window cannot be selected
        self._timer.start()

    def tick(self) -> None:
        """Begin the run that waits, or take a step of the one under way, and draw it."""
        if not self.running:
            return
        try:
            if self._next is not None:
                self._show(Trial(*self._next))
            elif self.trial is not None and not self.trial.advance():
                self._end()
                self._say(_told("End reached", self.trial))
                return
        except (ValueError, SolveError) as error:
            self._end()
            self._say(str(error), RED)
        self._draw()

    def _show(self, trial: Trial) -> None:
        """Draw this run from now on, beside the surface that the one before came to."""
        if self.trial is not None and self.trial.history and self._box is not None:
            self._before = self.trial.result.pial(), self.trial.label or CASE
        self.trial, self._next = trial, None
        self._say(_told("Running", trial))

    def stop(self) -> None:
        """End the run; its last state stays."""
        if self.running:
            self._end()
            if self.trial is not None:
                self._say(_told("Stopped", self.trial))

    def _end(self) -> None:
        self._timer.stop()
        self.running, self._next = False, None
        if self.trial is not None:
            self.trial.close()

    def line(self) -> str:
        """Return the command line that makes the same run as the present settings."""
        return self._command(self.name, self.panel.settings.assignments())

    def look(self, view: str | None) -> None:
        """Show another side of the body."""
        self.view = view or TISSUE
        self._draw()

    def save(self) -> None:
        """Store the picture with its numbers and the command line that makes the run."""
        trial = self.trial
        if trial is None:
            self._say("There is no picture to save yet; press Run.", RED)
            return
        words = f"{self.name}, {trial.label}" if trial.label else self.name
        try:
            path = self._save(words, lambda figure: self._page(figure, trial, words))
        except OSError as error:
            self._say(f"The picture is not saved: {error}", RED)
            return
        self._say(f"Picture: {path}")

    def _page(self, figure: Figure, trial: Trial, words: str) -> None:
        figure.set_size_inches(9, 6)
        axes = figure.add_subplot()
        picture(axes, trial.result, self.view, before=self._before, box=extent(trial.result, self._box))
        axes.set_title(f"{textwrap.fill(words, 90)}\n{measures(trial.result)}", fontsize=10)
        figure.supxlabel(textwrap.fill(trial.line, 130), fontsize=7)

    def _draw(self) -> None:
        for axes in self._drawn:
            axes.remove()
        self._drawn = []
        if self.trial is None:
            return
        there = set(self.figure.axes)
        result = self.trial.result
        self._box = extent(result, self._box)
        picture(self.figure.add_axes(PICTURE), result, self.view, before=self._before, box=self._box)
        self._drawn = [axes for axes in self.figure.axes if axes not in there][::-1]
        self.numbers.set_text(_numbers(self.trial))
        self.figure.canvas.draw_idle()

    def _say(self, message: str, color: str = INK) -> None:
        parts = (textwrap.fill(part, WIDTH, break_on_hyphens=False) for part in message.splitlines())
        self.message.set_text("\n".join(parts))
        self.message.set_color(color)
        self.figure.canvas.draw_idle()


def _numbers(trial: Trial) -> str:
    """Return what is known of the state that is drawn, in two lines."""
    when = f"t = {trial.states[-1].time:.3g} of {trial.scene.until:g}"
    if not trial.history:
        return f"{when}: undeformed"
    falls = int(trial.history[-1]["negative_pivots"])
    stable = "a minimum of the energy" if falls == 0 else f"no minimum: energy falls in {falls} direction(s)"
    return f"{measures(trial.result)}\n{when}, {stable}"


def _told(what: str, trial: Trial) -> str:
    changes = textwrap.shorten(trial.label or CASE, WIDTH - 20, placeholder=" and more")
    return f"{what}: {changes}.\n{trial.line}"
