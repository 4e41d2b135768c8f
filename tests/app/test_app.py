"""The window: what its controls change, what a run shows, what it says when something is refused."""

import shlex
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backend_bases import MouseEvent
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from turingfold import (
    AxonalTension,
    Elastic,
    Imperfection,
    NeoHookean,
    Scene,
    Schnakenberg,
    SelfContact,
    Stepping,
    TangentialGrowth,
    Turing,
    figures,
    half,
    semicircle,
    simulate,
    varied,
)
from turingfold.app import App
from turingfold.app.knobs import Settings, knobs
from turingfold.app.picture import STRESS, extent
from turingfold.app.window import CASE, RED
from turingfold.cli import app as cli_app
from turingfold.cli.figure import save_figure
from turingfold.cli.main import parser
from turingfold.cli.request import Request
from turingfold.parts import Term
from turingfold.results.result import TISSUE
from turingfold.studies.sweep import read_values

STEPS = 2
GRAY, WHITE = NeoHookean(mu=500.0, kappa=5000.0), NeoHookean(mu=700.0, kappa=7000.0)


@pytest.fixture(scope="module")
def scene():
    body = semicircle(radius=0.04, thickness=0.006, size=0.003)
    return Scene(
        body=body,
        terms=(Elastic(gray=GRAY, white=WHITE), AxonalTension(strength=0.2), SelfContact()),
        processes=(Turing(Schnakenberg(), half_waves=8), TangentialGrowth(cortex=1.2)),
        stepping=Stepping(first=1 / STEPS, largest=1 / STEPS),
    )


@pytest.fixture
def window(tmp_path):
    """Return what opens a window that is never shown; pictures go to a folder of its own."""

    def command(scene, assignments):
        words = tuple(word for name, value in assignments for word in ("--vary", f"{name}={value}"))
        return Request("case.py", only=(scene,), command=("sweep", *words) if words else ("run",)).words()

    def save(name, draw):
        path = tmp_path / f"{name}.png"
        if path.exists():
            raise OSError("no space left")
        with save_figure(path) as figure:
            draw(figure)
        return path

    def opened(*scenes):
        figure = Figure()
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # once: widgets draw the whole window when they are touched, which takes long
        canvas.draw = canvas.draw_idle = lambda: None
        return App(figure, {f"scene {k}": one for k, one in enumerate(scenes)}, command=command, save=save)

    return opened


def finish(app):
    app.run()
    while app.running:
        app.tick()
    return app.trial.result


def click(app, axes, share=0.5):
    x, y = axes.transAxes.transform((share, 0.5))
    for name in ("button_press_event", "button_release_event"):
        app.figure.canvas.callbacks.process(name, MouseEvent(name, app.figure.canvas, x, y, 1))


def typed(app, text):
    click(app, app.panel.entry.ax)
    app.panel.entry.set_val(text)


def same(result, expected):
    assert [state.time for state in result.states] == [state.time for state in expected.states]
    for state, other in zip(result.states, expected.states, strict=True):
        assert state.fields.keys() == other.fields.keys()
        for name in state.fields:
            assert np.array_equal(state[name], other[name]), name
    assert result.converged == expected.converged
    measured = result.summary(), expected.summary()
    for name in measured[0].keys() - {"seconds", "seconds_by_part"}:
        assert measured[0][name] == measured[1][name], name


def test_each_part_offers_its_main_parameters(scene):
    offered = {knob.parameter: knob for knob in knobs(scene)}
    assert len(offered) <= 8
    main = {"Turing.half_waves", "TangentialGrowth.cortex", "Elastic.white.mu", "AxonalTension.strength"}
    assert main < offered.keys()
    for knob in offered.values():
        part, _, name = knob.parameter.partition(".")
        assert knob.value in knob.values
        assert list(knob.values) == sorted(set(knob.values))
        assert (knob.part, knob.label) == (part, name)
        for value in (knob.values[0], knob.values[-1]):  # every value in the range is accepted
            varied(scene, {knob.parameter: [value]})


def test_numbers_are_round_and_whole_numbers_whole(scene):
    offered = {knob.parameter: knob for knob in knobs(scene)}
    assert offered["Turing.half_waves"].values == tuple(range(4, 17))
    cortex = offered["TangentialGrowth.cortex"].values
    assert cortex[:3] == (1.0, 1.002, 1.004)
    assert cortex[-1] == 1.5
    assert all(isinstance(value, int) for value in offered["Turing.half_waves"].values)


@pytest.mark.parametrize("how", ["half body", "symmetric pattern"])
def test_mirror_symmetric_patterns_have_even_numbers_of_half_waves(scene, how):
    turing = replace(scene.processes[0], symmetric=how == "symmetric pattern")
    body = half(scene.body) if how == "half body" else scene.body
    (knob,) = [
        knob
        for knob in knobs(replace(scene, body=body, processes=(turing, scene.processes[1])))
        if knob.parameter == "Turing.half_waves"
    ]
    assert knob.values == (4, 6, 8, 10, 12, 14, 16)


def test_what_the_scene_refuses_is_not_offered(scene):
    without = replace(scene, processes=scene.processes[1:], terms=scene.terms[:1])
    assert "TangentialGrowth.modulation" in [knob.parameter for knob in knobs(scene)]
    assert "TangentialGrowth.modulation" not in [knob.parameter for knob in knobs(without)]  # no pattern
    two = replace(scene, terms=(*scene.terms, AxonalTension(strength=0.1, surface="pial")))
    assert not [knob for knob in knobs(two) if knob.part == "AxonalTension"]  # which of the two?


@dataclass(frozen=True)
class Weight(Term):
    """A part that turingfold does not have, and whose float is written as a whole number."""

    load: float = 2
    layers: int = 6
    name: str = "weight"

    reads = ()

    def on(self, body):
        return self


def test_parts_of_the_case_itself_offer_their_numbers(scene):
    own = [knob for knob in knobs(replace(scene, terms=(scene.terms[0], Weight()))) if knob.part == "Weight"]
    assert [knob.label for knob in own] == ["load", "layers"]
    assert 2.02 in own[0].values
    assert own[1].values == tuple(range(3, 13))


def test_a_run_is_that_of_simulate_with_the_value_of_the_slider(scene, window, capsys):
    app = window(scene)
    app.panel.sliders["TangentialGrowth.cortex"].set_val(1.1)
    result = finish(app)
    (expected,) = varied(scene, {"TangentialGrowth.cortex": [1.1]}).values()
    assert app.trial.scene == expected
    same(result, simulate(expected))
    assert len(result.history) == STEPS
    words = app.numbers.get_text()
    assert figures.measures(result) in words
    assert "growth 1.10" in words
    assert "t = 1 of 1, a minimum" in words
    assert app.message.get_text().startswith("End reached: cortex=1.1.")
    assert "--vary TangentialGrowth.cortex=1.1" in capsys.readouterr().out


def test_a_state_that_is_no_minimum_is_called_so(scene, window):
    app = window(scene)
    finish(app)
    app.trial.history[-1]["negative_pivots"] = 2
    app.look(TISSUE)
    assert app.numbers.get_text().endswith("no minimum: energy falls in 2 direction(s)")


def test_the_mouse_moves_sliders_and_presses_buttons(scene, window):
    app = window(scene)
    slider = app.panel.sliders["Turing.half_waves"]
    click(app, slider.ax, (10 - 4) / (16 - 4))
    assert app.panel.settings.values == {"Turing.half_waves": 10}
    assert isinstance(app.panel.settings.values["Turing.half_waves"], int)
    assert "half_waves=10" in app.message.get_text()
    click(app, slider.ax, (8 - 4) / (16 - 4))  # the case's own value
    assert app.panel.settings.values == {}
    assert CASE in app.message.get_text()
    click(app, app.buttons["Run"].ax)
    assert app.running
    click(app, app.buttons["Stop"].ax)
    assert not app.running


def test_a_switch_leaves_a_part_out_and_takes_it_in_again(scene, window):
    app = window(scene)
    app.panel.sliders["AxonalTension.strength"].set_val(0.3)
    click(app, app.panel.switches["AxonalTension"].ax, 0.15)
    result = finish(app)
    assert result.scene == replace(scene, terms=(scene.terms[0], scene.terms[2]))
    assert not app.panel.sliders["AxonalTension.strength"].active
    click(app, app.panel.switches["AxonalTension"].ax, 0.15)
    _, made = app.panel.settings.made()
    assert made.terms[1] == AxonalTension(strength=0.3)
    assert "Elastic" not in app.panel.switches  # a body without elasticity is none


def test_parts_that_need_each_other_can_be_left_out_together(scene, window):
    app = window(scene)
    shown = app.trial
    click(app, app.panel.switches["Turing"].ax, 0.15)
    app.run()
    assert not app.running
    assert app.trial is shown
    assert app.message.get_color() == RED
    assert "AxonalTension reads the field 'pattern'" in " ".join(app.message.get_text().split())
    click(app, app.panel.switches["AxonalTension"].ax, 0.15)
    assert app.message.get_color() != RED
    assert finish(app).scene.processes == scene.processes[1:]


def test_a_process_goes_before_the_one_it_reads(scene):
    noisy = replace(scene, processes=(*scene.processes, Imperfection(amplitude=0.01)))
    settings = Settings(noisy)
    settings.absent = {"TangentialGrowth", "Imperfection"}
    assert settings.made()[1] == replace(scene, processes=scene.processes[:1])


def test_stop_keeps_the_last_state_and_a_new_run_begins_afresh(scene, window):
    app = window(scene)
    app.run()
    for _ in range(1 + 1):  # the start, and a step
        app.tick()
    app.stop()
    kept = app.trial.result
    assert [state.time for state in kept.states] == [0.0, 0.5]
    assert not kept.converged
    assert app.message.get_text().startswith("Stopped")
    app.tick()
    assert app.trial.result.states == kept.states
    assert "t = 0.5 of 1" in app.numbers.get_text()
    assert not app.trial.advance()
    same(finish(app), simulate(scene))


def test_controls_moved_during_a_run_are_for_the_next_one(scene, window):
    app = window(scene)
    app.run()
    app.tick()
    app.panel.sliders["TangentialGrowth.cortex"].set_val(1.1)
    assert "goes on as it began" in app.message.get_text()
    while app.running:
        app.tick()
    assert app.trial.scene == scene
    assert "--vary" not in app.trial.line


def test_a_refused_value_is_said_and_changes_nothing(scene, window):
    app = window(scene)
    typed(app, "TangentialGrowth.cortex=-1")
    assert app.message.get_color() == RED
    assert "cortex=-1 must be positive" in app.message.get_text()
    assert app.panel.settings.made() == ("", scene)
    for wrong, words in {
        "cortex": "PART.NAME=VALUE",
        "TangentialGrowth.cortex=1.1,1.2": "lists 2 values",
        "TangentialGrowth.bark=2": "it has: cortex",
        "Drag.coefficient=2": "the scene has no Drag",
        "Turing.half_waves=7.5": "half_waves=7.5 must be a whole number",
    }.items():
        typed(app, wrong)
        assert words in " ".join(app.message.get_text().split())
        assert app.panel.settings.values == {}


def test_what_a_run_refuses_at_its_start_is_said_and_the_picture_stays(scene, window):
    app = window(scene)
    result = finish(app)
    typed(app, "Turing.half_waves=80")  # more than the band can hold
    assert app.message.get_color() != RED
    finish(app)
    assert app.message.get_color() == RED
    assert "half_waves=80 must be below" in app.message.get_text()
    assert app.trial.result.states == result.states


def test_a_run_that_stops_says_why_and_keeps_its_last_state(scene, window):
    app = window(replace(scene, stepping=Stepping(first=0.5, largest=0.5, smallest=0.5)))
    app.run()
    app.tick()
    app.tick()
    typed(app, "Stepping.iterations=1")
    finish(app)
    assert app.message.get_color() == RED
    words = " ".join(app.message.get_text().split())
    assert "The march stopped at t = 0 of 1" in words
    assert "Try smaller steps" in words
    assert app.trial.states[-1].time == 0.0
    assert not app.running
    click(app, app.buttons["Reset"].ax)
    assert finish(app).converged


def test_exact_values_beyond_sliders_can_be_typed(scene, window):
    app = window(scene)
    typed(app, "TangentialGrowth.cortex=1.829")
    typed(app, " AxonalTension.surface = pial")
    typed(app, "Stepping.first=0.1")
    typed(app, "Stepping.largest=0.1")  # by itself below the first step of the case
    slider = app.panel.sliders["TangentialGrowth.cortex"]
    assert slider.val == slider.valmax == 1.5
    assert slider.valtext.get_text() == "1.829"
    assert app.panel.entry.text == ""
    _, made = app.panel.settings.made()
    assert made.processes[1].cortex == 1.829
    assert made.terms[1].surface == "pial"
    assert made.stepping.largest == 0.1


def test_the_command_line_makes_the_same_scene(scene, window):
    app = window(scene)
    assert "<" not in app.buttons  # of a single scene
    assert app.line() == "turingfold run case.py --only 'scene 0'"
    app.panel.sliders["Elastic.gray.mu"].set_val(1234.5678)
    typed(app, f"TangentialGrowth.cortex={1 + 1 / 3}")
    typed(app, "AxonalTension.follower=on")
    typed(app, "Turing.half_waves=6")
    click(app, app.panel.switches["SelfContact"].ax, 0.15)
    options = parser().parse_args(shlex.split(app.line())[1:])
    assert options.only == ["scene 0"]
    values = {name: read_values(text, scene, name) for name, text in options.vary}
    ((name, again),) = varied(scene, values).items()
    assert (name, again) == app.panel.settings.made()
    assert again != scene
    assert again.processes[1].cortex == 1 + 1 / 3


def test_reset_returns_to_the_case_but_keeps_the_picture(scene, window):
    app = window(scene)
    typed(app, "TangentialGrowth.cortex=1.1")
    result = finish(app)
    count = len(app.figure.axes)
    app.reset()
    assert app.panel.settings.made() == ("", scene)
    assert app.panel.sliders["TangentialGrowth.cortex"].val == 1.2
    assert app.trial.result.states == result.states
    assert len(app.figure.axes) == count


def test_the_picture_is_the_deformed_body_beside_the_run_before(scene, window):
    app = window(scene)
    before = finish(app)
    count = len(app.figure.axes)
    typed(app, "TangentialGrowth.cortex=1.1")
    result = finish(app)
    assert len(app.figure.axes) == count  # nothing is left of earlier pictures
    (axes,) = [axes for axes in app.figure.axes if axes.get_legend()]
    lines = {line.get_label(): line.get_xydata().T for line in axes.lines}
    assert np.array_equal(lines[f"run before: {CASE}"], 1e3 * before.pial())
    assert any(np.array_equal(points, 1e3 * result.pial()) for points in lines.values())
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    x, y = 1e3 * before.pial()
    assert left < x.min()
    assert right > x.max()
    assert low < y.min()
    assert high > y.max()
    for view, label in ((STRESS, "von Mises stress"), (TISSUE, "activator")):
        app.look(view)
        assert len([axes for axes in app.figure.axes if label in axes.get_ylabel()]) == 1
        assert len(app.figure.axes) == count
        app.figure.draw_without_rendering()


def test_the_frame_grows_with_the_body(scene):
    result = simulate(replace(scene, processes=(TangentialGrowth(cortex=1.5, core=1.5, radial_core=1.5),),
                              terms=(scene.terms[0],)))  # fmt: skip
    moved = 1e3 * (scene.body.nodes + result.last["displacement"])
    low, high = extent(result)
    assert (low < moved.min(axis=1)).all()
    assert (high > moved.max(axis=1)).all()
    at_rest = extent(replace(result, states=result.states[:1]))
    assert (high > at_rest[1]).any()
    wide = at_rest[0] - 10.0, high + 10.0
    assert all(map(np.array_equal, extent(result, wide), wide))


def test_no_two_words_lie_on_each_other(scene, window):
    app = window(scene, scene)
    finish(app)
    app.figure.draw_without_rendering()
    panel = app.panel
    words = [label for box in panel.switches.values() for label in box.labels]
    words += [text for slider in panel.sliders.values() for text in (slider.label, slider.valtext)]
    words += [panel.entry.label, app.heading, app.numbers, app.message, *app.views.labels]
    words += [button.label for button in app.buttons.values()]
    boxes = [text.get_window_extent() for text in words]
    for k, box in enumerate(boxes):
        assert not [words[l] for l in range(k) if box.overlaps(boxes[l])], words[k]
        assert app.figure.bbox.fully_contains(*box.min), words[k]
        assert app.figure.bbox.fully_contains(*box.max), words[k]


def test_other_scenes_come_with_their_own_controls(scene, window):
    grown = replace(scene, processes=scene.processes[1:], terms=(scene.terms[0], scene.terms[2]))
    app = window(scene, grown)
    finish(app)
    count = len(app.figure.axes)
    click(app, app.buttons[">"].ax)
    assert app.name == "scene 1"
    assert "Turing" not in app.panel.switches
    assert app.trial.result.history == ()
    same(finish(app), simulate(grown))
    click(app, app.buttons[">"].ax)
    assert app.name == "scene 0"
    assert len(app.figure.axes) == count


def test_a_scene_that_cannot_start_is_said_at_once(scene, window):
    wrong = replace(scene, processes=(Turing(Schnakenberg(), half_waves=80), scene.processes[1]))
    app = window(wrong)
    assert app.message.get_color() == RED
    assert app.trial is None
    app.look(STRESS)
    app.save()
    assert "no picture" in app.message.get_text()
    typed(app, "Turing.half_waves=8")
    assert finish(app).converged


def test_save_stores_the_picture(scene, window, tmp_path):
    from PIL import Image

    app = window(scene)
    typed(app, "TangentialGrowth.cortex=1.1")
    finish(app)
    app.save()
    path = tmp_path / "scene 0, cortex=1.1.png"
    assert path.name in app.message.get_text().replace("\n", " ")
    with Image.open(path) as image:
        assert len(image.getcolors(256)) > 20
    app.save()  # which the fixture refuses when it is there
    assert app.message.get_color() == RED
    assert "no space left" in app.message.get_text()


CASE_FILE = '''"""A patch of cortex that grows."""
from turingfold import Elastic, NeoHookean, Scene, SelfContact, Stepping, TangentialGrowth, semicircle


def scenes(quick=False):
    body = semicircle(radius=1.0, thickness=0.3, size=0.15, base="roller")
    solid, grow = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), TangentialGrowth(cortex=1.2)
    steps = Stepping(first=0.5, largest=0.5)
    return {"patch": Scene(body=body, terms=(solid,), processes=(grow,), stepping=steps)}
'''


@pytest.fixture
def options(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("patch.py").write_text(CASE_FILE, encoding="utf-8")
    return Request("patch.py", quick=True, command=("app",))


def test_the_command_opens_a_window_on_the_case(options, monkeypatch, capsys):
    opened = []

    class Kept(App):
        def __init__(self, *arguments, **named):
            super().__init__(*arguments, **named)
            opened.append(self)

    def show():
        (app,) = opened
        typed(app, "TangentialGrowth.cortex=1.1")
        finish(app)
        app.save()

    figure = Figure()
    FigureCanvasAgg(figure).draw_idle = lambda: None
    monkeypatch.setattr(cli_app, "App", Kept)
    monkeypatch.setattr(cli_app, "_window", lambda title: (figure, show))
    assert cli_app.app(options) == 0
    assert Path("results/quick/patch-app/patch-cortex=1.1.png").is_file()
    line = "turingfold sweep patch.py --vary TangentialGrowth.cortex=1.1 --quick --only patch"
    assert capsys.readouterr().out.splitlines() == [line]


def test_without_a_display_the_command_says_what_to_do(options, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(ValueError, match="there is no display; run it on a machine with a display"):
        cli_app.app(options)
    monkeypatch.setenv("DISPLAY", ":0")
    with pytest.raises(ValueError, match=r"'[Aa]gg' opens no window; run it on a machine with a display"):
        cli_app.app(options)


def test_a_window_system_that_is_not_there_is_an_input_error(options, monkeypatch):
    from matplotlib import pyplot

    def missing(**named):
        raise ImportError("Cannot load backend 'TkAgg'")

    monkeypatch.setattr(pyplot, "figure", missing)
    with pytest.raises(ValueError, match=r"Cannot load backend 'TkAgg'.*turingfold sweep"):
        cli_app.app(options)


def test_unknown_scenes_are_named(options):
    with pytest.raises(ValueError, match="it has: 'patch'"):
        cli_app.app(options.with_only(["path"]))


def test_a_part_that_is_typed_off_can_be_switched_on(scene, window):
    app = window(scene)
    typed(app, "AxonalTension=off")
    assert not app.panel.switches["AxonalTension"].get_status()[0]
    assert app.panel.settings.assignments() == (("AxonalTension", "off"),)
    app.panel.switches["AxonalTension"].set_active(0)
    assert app.panel.settings.assignments() == ()
    typed(app, "AxonalTension=perhaps")
    assert app.message.get_color() == RED
    assert "'on' or 'off'" in app.message.get_text()
    typed(app, "AxonalTension=on")
    assert app.panel.settings.assignments() == ()
