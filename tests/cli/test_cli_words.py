"""Words: of runs that stopped, numbers without an error, cases by name, list --parts; ticks of plots."""

import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from test_cli import GROWS, STOPS, TWO, unwrapped, written  # noqa: F401  (a fixture)

from turingfold import figures, load
from turingfold.cli.case import find_case
from turingfold.cli.files import shipped, short
from turingfold.cli.main import main
from turingfold.results.loading import read_result
from turingfold.studies.columns import NUMBERS, Column
from turingfold.studies.diagram import phase_diagram, values_of
from turingfold.studies.sweep import settable, with_value


@pytest.fixture
def stopped(written, capsys):  # noqa: F811
    """Run a scene that stops on its way; return its result, and what was printed."""
    case = written(STOPS)
    assert main(["run", case, "--only", "stops"]) == 3
    return read_result("results/tiny/stops", known=find_case(case).known), capsys.readouterr().out


def test_a_run_that_stopped_says_so_before_any_number(stopped):
    result, out = stopped
    assert 0 < result.last.time < 1
    first, second, *_ = out.splitlines()
    assert first == f"NOT FINISHED: all numbers are of t = {result.last.time:.6g} of 1"
    assert "stopped at t =" in second
    assert figures.measures(result).startswith(f"stopped at t = {result.last.time:.6g} of 1, growth")
    assert result.plot().axes[0].get_title().startswith("stopped at t =")
    axes = figures.grid(Figure(), {"it": (result, -1)}, columns=1)[0]
    assert axes.texts[0].get_text().startswith("stopped at t =")


def test_a_stopped_scene_of_several_and_a_stopped_point_say_when(written, capsys):  # noqa: F811
    assert main(["run", written(STOPS)]) == 3
    lines = capsys.readouterr().out.splitlines()
    (line,) = (one for one in lines if one.startswith("stops "))
    assert re.match(r"stops +STOPPED at t = \S+ of 1:  growth ", line)
    assert not any("STOPPED" in one for one in lines if one.startswith("grows"))
    words = ["sweep", written(STOPS), "--only", "stops", "--vary", "Scene.seed=1"]
    assert main(words) == 3
    assert re.search(r"seed=1: stopped at t = 0\.\d+ at growth 1\.\d+", capsys.readouterr().out)


def test_numbers_without_an_estimate_say_that_they_have_none(written, capsys):  # noqa: F811
    assert main(["run", written(GROWS), "--no-errors"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"gyrification index \d\.\d\d ± \?", out)
    assert "errors of mesh and steps: not estimated" in out
    result = load("results/tiny/grows")
    assert "± ?" in figures.measures(result)
    assert "± ?" in result._repr_html_()
    estimated = replace(result, errors={"gyrification_index": 0.25})
    assert "± 0.2" in figures.measures(estimated)
    assert "± 0.2" in estimated._repr_html_()


def test_the_picture_of_a_state_on_the_way_has_no_numbers_of_the_end(written):  # noqa: F811
    assert main(["run", written(GROWS), "-q"]) == 0
    result = load("results/tiny/grows")
    title = result.plot(1).axes[0].get_title()
    assert title == "t = 0.25, growth 1.05"  # of the end: growth 1.20, sulci, gyrification index


def test_a_time_alone_is_the_time_of_the_scene(written):  # noqa: F811
    assert main(["run", written(GROWS), "-q"]) == 0
    result = load("results/tiny/grows")
    assert result.at(0.5) is result.at(time=0.5)
    with pytest.raises(ValueError, match="takes one of time, week and day"):
        result.at(0.5, week=30)


def test_half_waves_of_the_pattern_are_in_tables_of_studies_with_a_name_of_their_own():
    case = find_case("figure3")
    assert "pattern_half_waves" in NUMBERS
    assert "pattern_half_waves" not in case.parameters


def test_a_case_of_the_package_is_named_and_not_its_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["run", "figure3", "--only", "nothing"]) == 2
    err = unwrapped(capsys)
    assert "figure3 has no scene 'nothing'" in err
    assert str(shipped()["figure3"].parent) not in err
    assert main(["run", "figure3", "--set", "thickness=0.1"]) == 2
    assert str(shipped()["figure3"].parent) not in unwrapped(capsys)
    assert main(["list", "figure3"]) == 0
    assert capsys.readouterr().out.startswith("figure3: Figure 3")
    own = tmp_path / "figure3.py"
    own.write_text("1 / 0\n")
    assert main(["run", "figure3.py"]) == 2
    assert "figure3.py, line 1: ZeroDivisionError" in unwrapped(capsys)
    assert short(own) == "figure3.py"
    assert short(Path("/elsewhere/figure3.py")) == "/elsewhere/figure3.py"


def test_every_name_that_list_prints_can_be_set(written, capsys):  # noqa: F811
    case = written(TWO)
    assert main(["list", case]) == 0
    assert "parts:" not in capsys.readouterr().out
    assert main(["list", case, "--parts"]) == 0
    names = re.findall(r"--set (\w+\.[\w.]+)=", capsys.readouterr().out)
    assert {"Stepping.first", "TangentialGrowth.cortex", "Elastic.gray.mu", "Scene.until"} <= set(names)
    for scene in find_case(case).scenes({}, quick=True).values():
        known = settable(scene)
        assert set(known) <= set(names)
        for name, value in known.items():
            assert with_value(scene, name, value).stepping == scene.stepping


def test_ticks_are_as_far_apart_as_their_numbers_are_long():
    places = np.array([1.0, 1.02, 1.04, 1.06, 1.08, 1.1, 1.5, 3.0])
    grid = [(x, y) for x in places for y in (1.0, 2.0)]
    figure = Figure(figsize=(5.6, 4.2))
    axes = figure.subplots()
    column = Column("growth")
    x, y = (values_of(column, [pair[k] for pair in grid]) for k in (0, 1))
    phase_diagram(axes, x, y, values_of(Column("sulci"), list(range(len(grid)))))
    figure.canvas.draw()
    boxes = [label.get_window_extent() for label in axes.get_xticklabels()]
    assert len(boxes) > 2
    assert all(after.x0 > before.x1 for before, after in pairwise(boxes))
    bar = figure.axes[1]
    boxes = [label.get_window_extent() for label in bar.get_yticklabels()]
    assert all(after.y0 > before.y1 for before, after in pairwise(boxes))
    assert {1.0, 3.0} <= set(axes.get_xticks())


def test_long_words_along_x_do_not_run_into_each_other():
    words = ["Schnakenberg", "GiererMeinhardt", "KochMeinhardt", "FitzHughNagumo", "LengyelEpstein"]
    figure = Figure(figsize=(5.6, 4.2))
    axes = figure.subplots()
    x = values_of(Column("kinetics"), [word for word in words for _ in range(2)])
    y = values_of(Column("growth"), [1.0, 2.0] * len(words))
    phase_diagram(axes, x, y, values_of(Column("sulci"), list(range(2 * len(words)))))
    assert {label.get_rotation() for label in axes.get_xticklabels()} == {30.0}
