"""Films of results: as many pictures as states, of one size; refusals."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image
from small import elastic_scene

from turingfold import animate, half, semicircle, simulate
from turingfold.cli.main import main
from turingfold.figures.animation import frames


@pytest.fixture(scope="module")
def result():
    return simulate(elastic_scene())


def test_a_gif_has_a_picture_per_state(result, tmp_path):
    few = replace(result, states=result.states[::3])
    path = animate(few, tmp_path / "film.gif", rate=2)
    with Image.open(path) as film:
        assert film.n_frames >= len(few.states)  # the last one is shown longer
        pictures = []
        for place in (0, len(few.states) - 1):
            film.seek(place)
            pictures.append(np.asarray(film.convert("L"), dtype=float))
    assert pictures[0].shape == pictures[1].shape
    assert np.abs(pictures[1] - pictures[0]).mean() > 1  # something has moved


def test_scale_and_colours_stay(result):
    figure, seen = Figure(layout="constrained"), set()
    for step in frames(figure, result, "jacobian"):
        axes, bar = figure.axes
        seen.add((axes.get_xlim(), axes.get_ylim(), bar.get_ylim()))
        assert f"growth {result.history[step - 1]['growth']:.2f}" in axes.get_title() or step == 0
    assert len(seen) == 1
    assert step == len(result.states) - 1


def test_half_a_body_is_shown_whole():
    body = half(semicircle(radius=1.0, thickness=0.25, size=0.25))
    figure = Figure(layout="constrained")
    next(frames(figure, simulate(elastic_scene(body=body)), "von_mises"))
    left, right = figure.axes[0].get_xlim()
    assert left == pytest.approx(-right)


def test_an_mp4_is_one(result, tmp_path):
    pytest.importorskip("imageio_ffmpeg")
    few = replace(result, states=result.states[-2:])
    assert animate(few, tmp_path / "film.mp4", rate=2).read_bytes()[4:8] == b"ftyp"


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("film.avi", {}, r"not in '\.avi'"),
        ("film.gif", {"field": "heat"}, "field='heat'"),
        ("film.gif", {"rate": 0}, "rate=0"),
    ],
)
def test_what_cannot_be_filmed_is_refused(result, tmp_path, name, options, message):
    with pytest.raises(ValueError, match=message):
        animate(result, tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_one_state_is_no_film(result, tmp_path):
    with pytest.raises(ValueError, match="single state"):
        animate(replace(result, states=result.states[:1]), tmp_path / "film.gif")


def test_an_mp4_without_ffmpeg_says_what_to_install(result, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ValueError, match=r"turingfold\[movie\]"):
        animate(result, tmp_path / "film.mp4")


def test_the_command_puts_the_film_beside_the_result(tmp_path, capsys):
    folder = tmp_path / "result"
    simulate(elastic_scene(), folder, frames=2)
    assert main(["animate", str(folder), "--field", "pressure", "--rate", "1"]) == 0
    assert (folder / "film.gif").read_bytes().startswith(b"GIF8")
    assert "film.gif" in capsys.readouterr().out
    assert main(["animate", str(tmp_path / "none")]) == 2
