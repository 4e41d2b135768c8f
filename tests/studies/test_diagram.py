"""Pictures of studies: cells and colours of a grid, medians of repeated points, percentiles of bands."""

import csv
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from turingfold.cli import plot as command
from turingfold.cli.main import main
from turingfold.studies.columns import NUMBERS, Column
from turingfold.studies.diagram import bands, phase_diagram, values_of

AREA = "area over that at rest"
THICKNESS = Column("thickness of the cortex", "m")


@pytest.fixture
def axes():
    return Figure().add_subplot()


def column(name, values):
    return values_of(NUMBERS[name], values)


def test_lengths_are_in_mm_and_words_are_places():
    found = values_of(THICKNESS, [2e-3, 3e-3])
    assert found.heading == "thickness of the cortex (mm)"
    np.testing.assert_allclose(found.numbers, [2, 3])
    words = values_of(Column("what holds the base"), ["free", "roller", "free"])
    assert words.words == ("free", "roller")
    assert words.numbers.tolist() == [0, 1, 0]
    assert values_of(Column("axons pull"), [True, False]).words == ("on", "off")


def test_a_grid_is_drawn_as_cells_with_the_median_of_points_of_one_place(axes):
    # thicknesses 2, 3, 5 mm; growth 1.5, 2; the last place has three points, the first has no value
    x = values_of(THICKNESS, [2e-3, 2e-3, 3e-3, 3e-3, 5e-3, 5e-3, 5e-3, 5e-3])
    y = values_of(Column("growth"), [1.5, 2.0, 1.5, 2.0, 1.5, 2.0, 2.0, 2.0])
    phase_diagram(axes, x, y, column("folds", [None, 4, 2, 8, 1, 5, 7, 6]))
    (mesh,) = axes.collections
    assert np.ma.filled(mesh.get_array(), -1).ravel().tolist() == [-1, 2, 1, 4, 8, 6]
    edges = mesh.get_coordinates()
    np.testing.assert_allclose(edges[0, :, 0], [1.5, 2.5, 4.0, 6.0])
    np.testing.assert_allclose(edges[:, 0, 1], [1.25, 1.75, 2.25])
    (cross,) = axes.lines
    np.testing.assert_allclose(cross.get_xydata(), [[2, 1.5]])
    assert axes.get_xlabel() == "thickness of the cortex (mm)"
    assert [text.get_text() for text in axes.get_xticklabels()] == ["2", "3", "5"]


def test_points_that_are_no_grid_are_scattered(axes):
    x, y = values_of(THICKNESS, [2e-3, 3e-3, 4e-3]), values_of(Column("growth"), [1.5, 1.6, 1.7])
    phase_diagram(axes, x, y, column("sulcal_depth", [1e-3, 2e-3, 3e-3]))
    (dots,) = axes.collections
    np.testing.assert_allclose(dots.get_offsets(), np.transpose([[2, 3, 4], [1.5, 1.6, 1.7]]))
    np.testing.assert_allclose(dots.get_array(), [1, 2, 3])


def test_bands_hold_half_and_nine_tenths_of_the_points(axes):
    values = np.arange(101.0)
    x = values_of(THICKNESS, [2e-3] * 101 + [3e-3] * 101)
    bands(axes, x, column("gyrification_index", [*values, *(2 * values)]))
    middle = axes.lines[0]
    np.testing.assert_allclose(middle.get_xydata(), [[2, 50], [3, 100]])
    spans = [np.ptp(band.get_paths()[0].vertices[:, 1][np.isclose(band.get_paths()[0].vertices[:, 0], 2.0)])
             for band in axes.collections]  # fmt: skip
    np.testing.assert_allclose(spans, [90, 50])


def test_a_continuous_parameter_is_put_into_bins_of_equally_many(axes):
    x = np.linspace(2e-3, 4e-3, 100)
    bands(axes, values_of(THICKNESS, x), column("gyrification_index", list(1 + x)))
    middle = axes.lines[0].get_xydata()
    assert len(middle) == 10
    np.testing.assert_allclose(1e3 * (middle[:, 1] - 1), middle[:, 0], rtol=1e-6)


def test_nothing_to_draw_is_said(axes):
    x = values_of(THICKNESS, [2e-3])
    for draw in (lambda y: bands(axes, x, y), lambda y: phase_diagram(axes, x, x, y)):
        with pytest.raises(ValueError, match="no point has a value of sulci"):
            draw(column("folds", [None]))


CASE = '''"""A coarse patch of cortex that grows. Less than a second."""
from turingfold import Elastic, NeoHookean, Scene, Stepping, TangentialGrowth, semicircle
from turingfold import parameters as p


def scenes(quick=False, *, thickness: p.Thickness = 0.01, radius: p.Radius = 0.03):
    body = semicircle(radius=radius, thickness=thickness, elements=1, base="roller")
    solid, steps = Elastic(gray=NeoHookean.from_young(1e3, 0.4)), Stepping(first=1.0, largest=1.0)
    grow = TangentialGrowth(cortex=1.1)
    return {"only": Scene(body=body, terms=(solid,), processes=(grow,), stepping=steps)}
'''


def test_a_stored_study_is_drawn_from_its_records(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("patch.py").write_text(CASE)
    vary = ["--vary", "thickness=0.008,0.012", "--vary", "radius=0.02,0.03"]
    assert main(["sweep", "patch", *vary, "--keep", "summary"]) == 2  # one is too thick
    study = Path("results/patch-sweep")
    with (study / "sweep.csv").open(newline="") as file:
        assert [row["status"] for row in csv.DictReader(file)].count("refused") == 1
    (study / "sweep.csv").unlink()  # not needed: every point has its record
    axes = ["--x", "thickness", "--y", "radius"]
    assert main(["plot", str(study), *axes, "--colour", "area_growth", "--figure", "phases.pdf"]) == 0
    assert Path("phases.pdf").read_bytes().startswith(b"%PDF")
    assert main(["plot", str(study), "--x", "radius"]) == 0
    assert (study / "plot.png").read_bytes().startswith(b"\x89PNG")
    capsys.readouterr()
    assert main(["plot", str(study), "--x", "thicknes"]) == 2
    assert "no column thicknes; did you mean thickness?" in capsys.readouterr().err
    assert main(["plot", "elsewhere", "--x", "thickness"]) == 2
    assert "holds no study" in capsys.readouterr().err


def test_what_alone_is_varied_is_drawn_along_x(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("patch.py").write_text(CASE)
    drawn = []
    for kind in (bands, phase_diagram):

        def noted(axes, *columns, draw=kind):
            drawn.append(tuple(column.heading for column in columns))
            draw(axes, *columns)

        monkeypatch.setattr(command, kind.__name__, noted)

    def said(*words):
        assert main(["plot", *words]) == 2
        return " ".join(capsys.readouterr().err.split())

    swept = ["sweep", "patch", "--keep", "summary", "--vary", "thickness=0.005,0.008"]
    thickness = "thickness of the cortex (mm)"
    assert main([*swept, "--vary", "radius=0.03"]) == 0
    assert main(["plot", "results/patch-sweep", "--colour", "growth"]) == 0
    assert main(["plot", "results/patch-sweep", "--y", "area_growth", "--colour", "growth"]) == 0
    assert drawn == [(thickness, "largest growth factor"), (thickness, AREA, "largest growth factor")]
    words = said("results/patch-sweep", "--y", "thickness")
    assert "no other parameter takes several values in the study; name what x shows (--x NAME)." in words

    assert main([*swept, "--vary", "radius=0.02,0.03", "--out", "two"]) == 0
    words = said("two/patch-sweep")
    assert "thickness, radius take several values in the study; name what x shows (--x NAME)." in words
    assert main(["plot", "two/patch-sweep", "--y", "radius"]) == 0
    assert drawn[2][0] == thickness
    assert drawn[2][1].startswith("radius")
