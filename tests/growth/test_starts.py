"""Where shares of a closed surface are counted from: the outline's first point, on any mesh."""

import numpy as np
import pytest

from turingfold import AxonalTension, BoundaryLoads, GrowthTable, Weeks, Window, outline
from turingfold.geometry.surface_table import SurfaceTable
from turingfold.parts import TimeStep
from turingfold.sensitivity.landmarks import landmarks_of
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


@pytest.mark.parametrize("first", [0.0, 1.0, 4.0])
@pytest.mark.parametrize("elements", [1, 2])
def test_windows_and_patches_begin_at_the_outlines_first_point(first, elements):
    points = ellipse(first)
    body = outline(points, thickness=3e-3, elements=elements)
    quarter = points[:, 50]  # of the points, and nearly of the length
    share = Window(start=0.15, end=0.35, edge=0.1).share(body)
    gray = np.where(body.in_cortex, share, 0.0).ravel()
    middle = np.average(body.quadrature.points.reshape(2, -1), axis=1, weights=gray)
    assert np.hypot(*(middle - quarter)) < 6e-3
    tension = AxonalTension(strength=1.0, patches=1, ramp=0.0).on(body)
    pattern = tension.pattern(State(0.0))
    k = np.unravel_index(np.argmax(pattern), pattern.shape)
    most = body.nodes[:, tension.line.edges[k]]
    assert np.hypot(*(most - points[:, 0])) < 5e-3


@pytest.mark.parametrize("first", [0.0, 1.0, 4.0])
@pytest.mark.parametrize("elements", [1, 2])
def test_loads_and_landmarks_by_shares_begin_at_the_outlines_first_point(first, elements):
    points = ellipse(first)
    body = outline(
        points, thickness=3e-3, elements=elements, holes=[0.3 * ellipse(0.0)], hole="clamped"
    )  # landmarks are for bodies that something holds
    loads = BoundaryLoads(places=(0.0,), forces=((1.0, 2.0),), width=3e-3, ramp=0.0)
    still = State(1.0, {"displacement": np.zeros_like(body.nodes)})
    forces = loads.on(body).during(still, TimeStep(0.1)).evaluate(np.zeros(body.nodes.size)).gradient()[0]
    weight = -forces.reshape(-1, 2)[:, 0]
    assert weight @ body.nodes.T == pytest.approx(points[:, 0], abs=1e-3)
    found = landmarks_of(body, 1.0, [(0.0, tuple(points[:, 0])), (0.25, tuple(points[:, 50]))])
    assert np.hypot(*found.apart(np.zeros(body.nodes.size))).max() < 3e-3


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
