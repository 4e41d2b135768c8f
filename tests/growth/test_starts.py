"""Where shares of a closed surface are counted from: the outline's first point, on any mesh."""

import numpy as np
import pytest

from turingfold import GrowthTable, Weeks, outline
from turingfold.geometry.surface_table import SurfaceTable
from turingfold.state import State
from turingfold.testing import advanced

TABLE = "s,28,40\n0,1,2\n.1,1,1\n.9,1,1\n"  # most at the start


def ellipse(first, *, clockwise=False):
    angle = first + np.linspace(0, 2 * np.pi, 200, endpoint=False) * (-1 if clockwise else 1)
    return np.array([30e-3 * np.cos(angle), 25e-3 * np.sin(angle)])


def place_of_most(body, table):
    growth = advanced(table, body, State(0.0), 1.0)["growth"][0]
    k = np.unravel_index(np.argmax(growth), growth.shape)
    return body.quadrature.points[:, *k]


@pytest.mark.parametrize("first", [0.0, 1.0, 4.0])
@pytest.mark.parametrize("clockwise", [False, True])
@pytest.mark.parametrize("elements", [1, 2])
def test_growth_by_shares_begins_at_the_outlines_first_point(tmp_path, first, clockwise, elements):
    (tmp_path / "growth.csv").write_text(TABLE)
    points = ellipse(first, clockwise=clockwise)
    body = outline(points, thickness=3e-3, elements=elements)
    most = place_of_most(body, GrowthTable.read(tmp_path / "growth.csv", ages=Weeks(start=28.0, end=40.0)))
    assert np.hypot(*(most - points[:, 0])) < 5e-3


@pytest.mark.parametrize("clockwise", [False, True])
def test_thickness_and_growth_run_the_same_way(clockwise):
    """A quarter of the length on, counter-clockwise, is the top of an ellipse that begins on its right."""
    points = ellipse(0.0, clockwise=clockwise)
    table = SurfaceTable(
        names=("",) * 3,
        places=(0.0, 0.25, 0.5),
        columns=("T",),
        units=("mm",),
        values=((2.0,), (4.0,), (2.0,)),
    )
    thick = table.along("T", points)
    assert thick.max() == pytest.approx(4e-3, rel=1e-3)
    np.testing.assert_allclose(points[:, np.argmax(thick)], [0.0, 25e-3], atol=1e-3)
    assert thick[0] == pytest.approx(2e-3)
