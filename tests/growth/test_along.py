"""Growth and thickness given at places along the pial surface, and at ages, against formulas on circles."""

import numpy as np
import pytest

from turingfold import (
    Days,
    Elastic,
    GrowthMap,
    GrowthTable,
    InadmissibleStateError,
    NeoHookean,
    Scene,
    Stepping,
    SurfaceTable,
    Weeks,
    half,
    load,
    outline,
    semicircle,
    simulate,
)
from turingfold.state import State

AT = 2 * np.pi * np.arange(180) / 180
CIRCLE = np.stack([np.cos(AT), np.sin(AT)])


def at_places(angles, shift=0.0):
    return tuple((np.cos(a) + shift, np.sin(a)) for a in angles)


@pytest.fixture(scope="module")
def disc():
    return outline(np.roll(CIRCLE, 50, axis=1), thickness=0.2, size=0.1)


def tangential(law, body, time=1.0):
    """Return angles and g_t at the integration points of the cortex, (n,)."""
    along, across = law.factors(body, State(time), time)
    assert (across == 1).all()
    assert (along[:, ~body.in_cortex] == 1).all()
    x, y = body.quadrature.points[:, :, body.in_cortex]
    return np.arctan2(y, x).ravel(), along[:, body.in_cortex].ravel()


def test_factors_at_all_points_of_an_outline_are_found_wherever_it_begins(disc):
    values = 1.5 + 0.3 * np.cos(3 * AT)
    law = GrowthMap(cortex=tuple(values), places=at_places(AT))
    angle, found = tangential(law, disc)
    linear = 0.3 * 9 * (AT[1] ** 2) / 8  # largest error of linear interpolation, max |f''| h²/8
    assert found == pytest.approx(1.5 + 0.3 * np.cos(3 * angle), abs=1.1 * linear)
    # in any order, and half way in time
    mixed = np.random.default_rng(0).permutation(len(AT))
    shuffled = GrowthMap(cortex=tuple(values[mixed]), places=at_places(AT[mixed]))
    assert tangential(shuffled, disc)[1] == pytest.approx(found, abs=1e-12)
    assert tangential(law, disc, 0.5)[1] == pytest.approx(0.5 * (1 + found), abs=1e-12)


def test_regions_have_the_growth_of_the_nearest_place_and_landmarks_are_joined_linearly(disc):
    places = at_places((0.0, np.pi))
    angle, found = tangential(GrowthMap(cortex=(1.2, 1.6), places=places, between="nearest"), disc)
    assert (found[np.abs(angle) < 1.55] == 1.2).all()
    assert (found[np.abs(angle) > 1.60] == 1.6).all()
    angle, found = tangential(GrowthMap(cortex=(1.2, 1.6), places=places), disc)
    assert found == pytest.approx(1.2 + 0.4 * np.abs(angle) / np.pi, abs=1e-3)


def test_shares_of_an_open_surface_count_from_its_right_end_also_in_half_a_body():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    law = GrowthMap(cortex=(1.2, 1.2, 1.8, 1.4), places=(0.0, 0.25, 0.75, 1.0))
    even = GrowthMap(cortex=(1.2, 1.7, 1.1, 1.7, 1.2), places=(0.0, 0.25, 0.5, 0.75, 1.0))
    for each, own in ((body, law), (body, even), (half(body), even)):
        angle, found = tangential(own, each)
        known = np.interp(angle, np.pi * np.array(own.places), own.cortex)
        assert found == pytest.approx(known, abs=2e-3)
    with pytest.raises(ValueError, match=r"1\.2 at the share 0\.25 and 1\.8 at 0\.75, its image"):
        tangential(law, half(body))


def test_half_a_body_needs_places():
    """Evenly spaced over the whole surface, the last of five factors has no influence on the half."""
    body = half(semicircle(radius=1.0, thickness=0.2, size=0.1))
    five = (1.1, 1.2, 1.3, 1.4, 1.5)
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    scene = Scene(body=body, terms=(solid,), processes=(GrowthMap(cortex=five),))
    with pytest.raises(
        ValueError, match=r"beyond the mirror and .* places=\(0, 0\.125, 0\.25, 0\.375, 0\.5\)"
    ):
        simulate(scene)
    placed = GrowthMap(cortex=five, places=(0, 0.125, 0.25, 0.375, 0.5))
    assert placed.on(body).start(State(1.0), 0)["growth"][0].max() == pytest.approx(1.5, abs=0.01)


def test_every_part_of_a_surface_has_the_values_of_its_own_places():
    body = outline([CIRCLE, CIRCLE + np.array([[3.0], [0.0]])], thickness=0.2, size=0.1)
    both = at_places((1.0, -1.0)) + at_places((1.0, -1.0), 3.0)
    law = GrowthMap(cortex=(1.1, 1.1, 1.7, 1.7), places=both)
    left = body.quadrature.points[0][:, body.in_cortex] < 1.5
    found = law.factors(body, State(1.0), 1.0)[0][:, body.in_cortex]
    assert (found[left] == 1.1).all()
    assert (found[~left] == 1.7).all()
    only = GrowthMap(cortex=(1.1, 1.3), places=at_places((0.0, np.pi)))  # none on the right one
    assert (only.factors(body, State(1.0), 1.0)[0][:, body.in_cortex][~left] == 1.1).all()


def test_tables_by_week_grow_as_the_table_and_areas_as_squares(disc, tmp_path):
    file = tmp_path / "growth.csv"
    file.write_text("name,x [mm],y [mm],week 26,week 30,38\nright,1000,0,1,2,4\nleft,-1000,0,3,3,6\n")
    weeks = Weeks(start=28.0, end=36.0)
    law = GrowthTable.read(file, ages=weeks, between="nearest")
    angle, found = tangential(law, disc, weeks.time(34.0))
    assert found[np.abs(angle) < 1.5] == pytest.approx(3.0 / 1.5)  # 3 at week 34, 1.5 at week 28
    assert found[np.abs(angle) > 1.6] == pytest.approx(4.5 / 3.0)
    assert tangential(law, disc, 0.0)[1] == pytest.approx(1.0)
    areas = GrowthTable.read(file, ages=weeks, between="nearest", of="area")
    assert tangential(areas, disc, weeks.time(34.0))[1] ** 2 == pytest.approx(found)
    assert law.at == (26.0, 30.0, 38.0)
    late = GrowthTable(at=(28.0, 30.0), cortex=((1.0,), (1.2,)), places=((1.0, 0.0),))
    with pytest.raises(InadmissibleStateError, match="week 34, but the table ends at 30"):
        late.factors(disc, State(0.5), 0.5)


def test_a_run_by_a_table_is_stored_with_it(disc, tmp_path):
    law = GrowthTable(at=(0.0, 8.0, 32.0), cortex=((1.0,), (1.02,), (1.05,)), places=(0.0,), ages=Days())
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    stops = Stepping(first=0.5, largest=0.5, stops=Days().times(8))
    scene = Scene(body=disc, terms=(solid,), processes=(law,), stepping=stops)
    result = simulate(scene, out=tmp_path / "run")
    assert result.at(day=8).time == pytest.approx(Days().time(8))
    assert load(tmp_path / "run").scene.processes == (law,)


def test_a_table_of_thickness_puts_the_interface_where_it_says(tmp_path):
    file = tmp_path / "thickness.csv"
    thick = 0.2 + 0.05 * np.cos(AT)
    rows = [f"{1e3 * x},{1e3 * y},{1e3 * t}" for x, y, t in zip(*CIRCLE, thick, strict=True)]
    file.write_text("\n".join(["x [mm],y [mm],thickness [mm]", *rows]))
    given = SurfaceTable.read(file).along("thickness", np.roll(CIRCLE[:, ::-1], 7, axis=1))
    assert given == pytest.approx(np.roll(thick[::-1], 7))
    body = outline(np.roll(CIRCLE[:, ::-1], 7, axis=1), thickness=given, size=0.1)
    x, y = body.nodes[:, body.interface]
    assert 1 - np.hypot(x, y) == pytest.approx(0.2 + 0.05 * np.cos(np.arctan2(y, x)), abs=3e-3)


@pytest.mark.parametrize(
    ("unit", "metres"),
    [
        (" [in]", 0.0254),
        (" [MM]", 1e-3),
        (" (µm)", 1e-6),
        ("_mm", 1e-3),
        (" in cm", 1e-2),
        ("_px", 0),
        ("", 1.0),
        (" [1]", 1.0),
        (" [-]", 1.0),
        (" (left)", 1.0),
        ("_in", 1.0),
        (" in", 1.0),
        (" / in", 0.0254),
        (" [furlong]", 0),
        (" [kPa]", 0),
        (" [1/mm]", 0),
        (" [%]", 0),
    ],
)
def test_values_of_a_table_have_the_unit_of_their_column(tmp_path, unit, metres):
    file = tmp_path / "thickness.csv"
    file.write_text(f"s,thickness{unit}\n0.0,0.1\n0.5,0.1\n")
    table = SurfaceTable.read(file)
    (column,) = table.columns
    if metres:
        assert table.along(column, CIRCLE) == pytest.approx(0.1 * metres)
    else:
        with pytest.raises(ValueError, match=r"column='thickness.*' has the unit '.*'; .* lengths \(m, cm"):
            table.along(column, CIRCLE)


@pytest.mark.parametrize(
    ("kind", "change", "message"),
    [
        (GrowthMap, {"places": (0.1, 0.2, 0.3)}, "places has 3 and cortex 2 entries"),
        (GrowthMap, {"places": (0.1, 1.2)}, r"places holds 1\.2"),
        (
            GrowthTable,
            {"cortex": ((1.0, 1.0), (1.2, 5.2))},
            r"at place 1 lengths grow by 5\.2 from week 28 to ",
        ),
        (
            GrowthTable,
            {"cortex": ((1.0, 1.0), (0.2, 1.0))},
            r"place 0 .* by 0\.2 .* between 0\.3 and 5.* area",
        ),
        (GrowthTable, {"cortex": ((1.0, 1.0), (26.0, 1.0)), "of": "area"}, r"place 0 lengths grow by 5\.099"),
        (GrowthMap, {"between": "spline"}, "between='spline'"),
        (GrowthTable, {"at": (30.0, 28.0)}, r"at=\(30\.0, 28\.0\)"),
        (GrowthTable, {"at": (30.0, 40.0)}, "from week 30 to 40, and the scene begins at 28"),
        (GrowthTable, {"cortex": ((1.0, 1.0), (0.0, 1.0))}, "cortex holds 0"),
        (GrowthTable, {"of": "volume"}, "of='volume'"),
    ],
)
def test_wrong_tables_are_refused_by_name(kind, change, message):
    options = {"cortex": (1.1, 1.2), "places": (0.1, 0.2)}
    if kind is GrowthTable:
        options |= {"at": (28.0, 40.0), "cortex": ((1.0, 1.0), (1.2, 1.3))}
    with pytest.raises(ValueError, match=message):
        kind(**(options | change))


def test_areas_grow_by_squares_and_ages_before_the_scene_do_not_count():
    at, growth = (22.0, 28.0, 40.0), ((0.1,), (1.0,), (24.0,))
    GrowthTable(at=at, cortex=growth, places=(0.0,), of="area")
    with pytest.raises(ValueError, match="lengths grow by 24 from week 28 to week 40"):
        GrowthTable(at=at, cortex=growth, places=(0.0,))


def test_places_off_the_surface_are_refused(disc):
    law = GrowthMap(cortex=(1.1, 1.2), places=((1e-3, 0.0), (0.0, 1e-3)))
    with pytest.raises(ValueError, match=r"place 0, \(0\.001, 0\) m, is 0\.999 m from the pial surface"):
        law.factors(disc, State(1.0), 1.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y,28\n0,1,1\n", "column x has the unit None"),
        ("x [mm],y [mm]\n0,1\n", "must name the columns"),
        ("s,early,late\n0,1,2\n", "named by its age"),
        ("s,28,30\n0,1\n", r"line 2: '0,1' is not 3 numbers"),
    ],
)
def test_wrong_files_are_refused_by_name(tmp_path, text, message):
    file = tmp_path / "growth.csv"
    file.write_text(text)
    with pytest.raises(ValueError, match=message):
        GrowthTable.read(file, ages=Weeks())
