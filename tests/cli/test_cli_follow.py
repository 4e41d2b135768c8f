"""turingfold buckling --follow: paths through limit points as CSV and as a bifurcation diagram."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from turingfold import Elastic, NeoHookean, Scene
from turingfold.cli.follow import write_path
from turingfold.cli.main import main
from turingfold.figures.bifurcation import bifurcation_diagram, fold_amplitude, pial_measures
from turingfold.geometry.mirror import half
from turingfold.geometry.shapes import semicircle
from turingfold.stability.arc_length import EquilibriumPath, PathPoint
from turingfold.state import State

CASE = '''
"""Half of a clamped disc that creases and snaps."""
from turingfold import (
    Drag, Elastic, NeoHookean, Scene, Stepping, TangentialGrowth, half, semicircle,
)

def scenes(quick=False):
    body = half(semicircle(radius=1.0, thickness=0.2, size=0.2, base="clamped"))
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), Drag(coefficient=1.0))
    grow = TangentialGrowth(cortex=1.2)
    return {
        "calm one": Scene(body=body, terms=terms, processes=(grow,)),
        "hurried": Scene(body=body, terms=terms, processes=(grow,), stepping=Stepping(seconds=1e-9)),
        "in a rush": Scene(body=body, terms=terms, processes=(grow,), stepping=Stepping(seconds=1e-9)),
    }
'''


def rows(file):
    with file.open(newline="") as text:
        return list(csv.DictReader(text))


def test_paths_and_diagram_are_written(tmp_path, capsys):
    case, out = tmp_path / "disc.py", tmp_path / "paths"
    case.write_text(CASE)
    assert main(["buckling", str(case), "--only", "calm one", "--follow", str(out)]) == 0
    shown = capsys.readouterr().out
    found = rows(out / "calm-one.csv")
    assert str(out) in shown
    assert "none" in shown.splitlines()[1]
    assert float(found[0]["growth"]) == 1.0
    assert float(found[-1]["time"]) == 1.0
    assert float(found[-1]["growth"]) == pytest.approx(1.2, rel=1e-12)
    assert {row["negative_pivots"] for row in found} == {"0"}
    assert float(found[-1]["normal_displacement"]) > 0.02
    assert (out / "disc.png").read_bytes().startswith(b"\x89PNG")


def test_a_path_that_stops_is_written_before_the_error(tmp_path, capsys):
    case, out = tmp_path / "disc.py", tmp_path / "paths"
    case.write_text(CASE)
    assert main(["buckling", str(case), "--follow", str(out)]) == 3
    shown = capsys.readouterr()
    told = " ".join(shown.err.split())
    assert "hurried: The path" in told
    assert "in a rush: The path" in told
    assert told.count("time limit of 1e-09 s") == 2
    table = {line.split("  ")[0]: line for line in shown.out.splitlines()}
    assert "STOPPED" not in table["calm one"]
    assert table["hurried"].endswith("STOPPED EARLY")
    assert table["in a rush"].endswith("STOPPED EARLY")
    assert str(out) in shown.out
    assert len(rows(out / "hurried.csv")) == 1
    assert len(rows(out / "calm-one.csv")) > 1
    assert (out / "disc.png").exists()


def test_modes_and_paths_are_not_drawn_at_once(tmp_path, capsys):
    with pytest.raises(SystemExit) as caught:
        main(["buckling", "case.py", "--figure", "modes.png", "--follow", str(tmp_path)])
    assert caught.value.code == 2
    assert "--figure" in capsys.readouterr().err


def path_of(body, times, radial, pivots, rates):
    """Return a path of states that move outward by given amounts."""
    points = [
        PathPoint(
            state=State(time, {"displacement": amount * body.nodes}),
            arc=float(k),
            rate=rate,
            growth=1 + time,
            energy=0.0,
            residual=0.0,
            negative_pivots=negative,
        )
        for k, (time, amount, negative, rate) in enumerate(zip(times, radial, pivots, rates, strict=True))
    ]
    return EquilibriumPath(tuple(points))


@pytest.mark.parametrize("halved", [False, True])
def test_normal_displacement_is_that_of_the_pial_surface(halved):
    body = semicircle(radius=2.0, thickness=0.4, size=0.2)
    body = half(body) if halved else body
    path = path_of(body, [0.0, 0.5], [0.0, -0.1], [0, 0], [1.0, 1.0])
    found = pial_measures(body, [point.state["displacement"] for point in path.points])
    assert found["normal_displacement"] == pytest.approx([0.0, 0.2], rel=1e-3)
    assert found["fold_amplitude"] == pytest.approx([0.0, 0.0], abs=1e-4)
    assert found["sulcal_depth"].tolist() == [0.0, 0.0]


def test_fold_amplitude_leaves_out_what_moves_as_a_whole():
    """Of 0.3 + 0.1 cos 8θ the mean square about the mean is 0.1²/2."""
    body = semicircle(radius=2.0, thickness=0.4, size=0.1)
    angle = np.arctan2(body.nodes[1], body.nodes[0])
    outward = (0.3 + 0.1 * np.cos(8 * angle)) * np.stack([np.cos(angle), np.sin(angle)])
    point = path_of(body, [0.5], [0.0], [0], [1.0]).points[0]
    path = EquilibriumPath((replace(point, state=State(0.5, {"displacement": outward})),))
    found = pial_measures(body, [point.state["displacement"] for point in path.points])
    assert found["fold_amplitude"] == pytest.approx([0.1 / np.sqrt(2)], rel=1e-3)
    both = fold_amplitude(body, [outward, 2 * outward])
    assert both == pytest.approx([0.1 / np.sqrt(2), 0.2 / np.sqrt(2)], rel=1e-3)
    assert found["normal_displacement"] == pytest.approx([0.4], rel=1e-3)


def test_a_path_without_a_point_is_an_empty_table(tmp_path):
    solid = Elastic(gray=NeoHookean.from_young(1389.0, 0.4))
    scene = Scene(body=semicircle(radius=0.02, thickness=0.004, size=0.004), terms=(solid,))
    write_path(tmp_path / "none.csv", scene, EquilibriumPath(()))
    assert rows(tmp_path / "none.csv") == []
    head = (tmp_path / "none.csv").read_text()
    assert "energy [J/m],negative_pivots" in head
    assert "sulcal_depth [m]" in head


def test_unstable_pieces_are_dashed_and_turns_marked():
    body = semicircle(radius=2.0, thickness=0.4, size=0.4)
    times, pivots, rates = [0.0, 0.4, 0.5, 0.45, 0.3, 0.4], [0, 0, 0, 1, 1, 0], [1, 1, 0.1, -0.3, -0.1, 1]
    axes = Figure().add_subplot()
    bifurcation_diagram(axes, body, path_of(body, times, np.linspace(0, 0.1, 6), pivots, rates))
    first, second, turns = axes.get_lines()
    assert first.get_linestyle() == "-"
    assert first.get_xdata() == pytest.approx([1.0, 1.4, 1.5])
    assert second.get_linestyle() == "--"
    assert second.get_xdata() == pytest.approx([1.5, 1.45, 1.3, 1.4])
    assert turns.get_xdata().shape == (2,)
    assert axes.get_xlabel() == "growth"
    assert "(T)" in axes.get_ylabel()


def test_turns_are_marked_where_they_are_between_the_points():
    """t = 3 s² - 4 s³ turns at s = 1/2, t = 1/4, where the amplitude of 0.1 s (cos 8θ) is half of 0.1."""
    body = semicircle(radius=2.0, thickness=0.4, size=0.1)
    angle = np.arctan2(body.nodes[1], body.nodes[0])
    wave = np.cos(8 * angle) * np.stack([np.cos(angle), np.sin(angle)])
    points = [
        PathPoint(
            state=State(3 * s**2 - 4 * s**3, {"displacement": 0.1 * s * wave}),
            arc=s,
            rate=6 * s - 12 * s**2,
            growth=1 + 3 * s**2 - 4 * s**3,
            energy=0.0,
            residual=0.0,
            negative_pivots=int(s > 0.5),
        )
        for s in (0.1, 0.3, 0.45, 0.6, 0.7)
    ]
    axes = Figure().add_subplot()
    bifurcation_diagram(axes, body, EquilibriumPath(tuple(points)))
    turns = axes.get_lines()[-1]
    assert turns.get_xdata() == pytest.approx([1.25], rel=1e-9)
    assert turns.get_ydata() == pytest.approx([0.05 / np.sqrt(2) / 0.4], rel=1e-3)
