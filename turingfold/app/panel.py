"""The controls of one scene: a switch per part, a slider per parameter, and a line to type any other into."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ..figures.style import INK
from .knobs import Knob, Settings, knobs, parts, removable

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Text
    from matplotlib.widgets import AxesWidget, CheckButtons, Slider

LEFT, RIGHT, TOP, BOTTOM = 0.02, 0.34, 0.905, 0.30  # of the figure
ROW = 0.046  # height of a row, at most
# matplotlib puts a box to tick at 0.15 of the Axes' width, and its label too far away
CHOICE, INDENT, BESIDE = 0.2, 0.022, 0.205
BLUE, FAINT = "#0072b2", "#aaaaaa"


class Panel:
    """Widgets that change the settings of a scene; every change calls `heed`, with a message if refused."""

    def __init__(self, figure: Figure, settings: Settings, heed: Callable[[str], object]) -> None:
        """Put the widgets on the figure."""
        self.figure, self.settings, self._heed = figure, settings, heed
        self.sliders: dict[str, Slider] = {}
        self.switches: dict[str, CheckButtons] = {}
        self._titles: list[Text] = []
        self._knobs = {knob.parameter: knob for knob in knobs(settings.original)}
        listed = parts(settings.original)
        self._height = min(ROW, (TOP - BOTTOM) / (len(listed) + len(self._knobs) + 1))
        level = TOP
        for part in listed:
            level -= self._height
            self._title(type(part).__name__, level, switch=removable(part))
            for knob in self._knobs.values():
                if knob.part == type(part).__name__:
                    level -= self._height
                    self._slider(knob, level)
        self._entry(level - 1.2 * self._height)

    def _title(self, name: str, level: float, *, switch: bool) -> None:
        from matplotlib.widgets import CheckButtons

        if not switch:
            x, y = LEFT + 0.019, level + 0.5 * self._height
            text = self.figure.text(x, y, name, va="center", fontsize=10, fontweight="bold", color=INK)
            self._titles.append(text)
            return
        axes = self.figure.add_axes((LEFT - INDENT, level, CHOICE, self._height))
        axes.set_axis_off()
        labels: dict[str, Sequence[Any]] = {"fontsize": [10], "fontweight": ["bold"], "color": [INK]}
        box = CheckButtons(
            axes, [name], [True], useblit=False, label_props=labels,
            frame_props={"s": [70], "edgecolor": [INK]}, check_props={"s": [45], "facecolor": [BLUE]},
        )  # fmt: skip
        box.labels[0].set_x(BESIDE)
        box.on_clicked(lambda _: self._switched(name))
        self.switches[name] = box

    def _slider(self, knob: Knob, level: float) -> None:
        from matplotlib.widgets import Slider

        axes = self.figure.add_axes((LEFT + 0.105, level, RIGHT - LEFT - 0.16, self._height))
        low, high = knob.values[0], knob.values[-1]
        slider = Slider(
            axes, knob.label, low, high, valinit=knob.value, valstep=knob.values, valfmt="%.5g",
            color=BLUE, initcolor=INK,
        )  # fmt: skip
        for text, x in ((slider.label, -0.05), (slider.valtext, 1.05)):
            text.set(x=x, fontsize=9)
        slider.on_changed(lambda value: self._slid(knob, value))
        self.sliders[knob.parameter] = slider

    def _entry(self, level: float) -> None:
        from matplotlib.widgets import TextBox

        axes = self.figure.add_axes((LEFT + 0.105, level, RIGHT - LEFT - 0.105, 0.85 * min(ROW, 0.04)))
        self.entry = TextBox(axes, "any other", initial="")
        self.entry.label.set_fontsize(9)
        self.entry.text_disp.set_fontsize(9)
        self.entry.on_submit(self._typed)
        self.entry.on_text_change(lambda text: self._hint.set_visible(not text))
        hint = "PART.NAME=VALUE, Enter"
        self._hint = axes.text(0.97, 0.5, hint, color=FAINT, fontsize=8, ha="right", va="center")

    def _slid(self, knob: Knob, value: float) -> None:
        self._set(knob.parameter, knob.nearest(value))
        self._heed("")

    def _set(self, parameter: str, value: Any) -> None:
        """Take a value into the settings, unless it is the case's own, and let a slider stand there."""
        values, knob = self.settings.values, self._knobs.get(parameter)
        values[parameter] = value
        if knob is None:
            return
        if value == knob.value:
            del values[parameter]
        slider = self.sliders[parameter]
        slider.eventson = False
        slider.set_val(min(max(value, slider.valmin), slider.valmax))
        slider.eventson = True
        slider.valtext.set_text(f"{value:.5g}")

    def _switched(self, name: str) -> None:
        there = self.switches[name].get_status()[0]
        (self.settings.absent.discard if there else self.settings.absent.add)(name)
        for parameter, slider in self.sliders.items():
            if parameter.startswith(f"{name}."):
                slider.set_active(there)
                slider.poly.set_alpha(1.0 if there else 0.15)
                for text in (slider.label, slider.valtext):
                    text.set_color(INK if there else FAINT)
        self._heed("")

    def _typed(self, text: str) -> None:
        """Take a value that was typed in, whether there is a slider for it or not."""
        if not text.strip():
            return
        own = dict(self.settings.values)
        try:
            parameter, value = self.settings.read(text)
            if parameter in self.switches:
                self._turn(parameter, value)
                return
            self.settings.values[parameter] = value
            self.settings.made()
        except ValueError as error:
            self.settings.values = own
            self._heed(str(error))
            return
        self._set(parameter, value)
        self._clear()
        self._heed("")

    def _turn(self, name: str, word: str) -> None:
        """Put a switch where a word says; raises ValueError for other words than on and off."""
        if word not in ("on", "off"):
            raise ValueError(f"{name}={word}: a part is 'on' or 'off'.")
        self._clear()
        if self.switches[name].get_status()[0] != (word == "on"):
            self.switches[name].set_active(0)
        self._heed("")

    def _clear(self) -> None:
        """Empty the line."""
        self.entry.text_disp.set_text("")  # not set_val, which would be another submission
        self.entry.cursor_index = 0
        self._hint.set_visible(True)

    def widgets(self) -> list[AxesWidget]:
        """Return everything that listens to the mouse."""
        return [*self.sliders.values(), *self.switches.values(), self.entry]

    def remove(self) -> None:
        """Take the widgets off the figure."""
        for widget in self.widgets():
            widget.disconnect_events()
            widget.ax.remove()
        for text in self._titles:
            text.remove()
