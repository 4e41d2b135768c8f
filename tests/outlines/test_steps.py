"""Steps of voxels: discs, ellipses and waves, of known length and area, drawn in voxels and read again."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from planar import area
from skfem import Basis, ElementTriP2

from turingfold import Section, find_folds, gyrification_index, outline, perimeter, sections
from turingfold.cli.case import load_case

CASE = Path(__file__).parents[2] / "cases" / "section.py"
T = 2.5e-3
ANGLE = np.linspace(0.0, 2 * np.pi, 100_000, endpoint=False)


def disc(angle):
    return 25e-3 + 0 * angle


def ellipse(angle):
    return 1 / np.hypot(np.cos(angle) / 30e-3, np.sin(angle) / 20e-3)


def wavy(angle):
    """13 waves of 12 mm along a circle, 4 mm high."""
    return 25e-3 + 2e-3 * np.cos(13 * angle)


def curve(radius):
    return radius(ANGLE) * np.stack([np.cos(ANGLE), np.sin(ANGLE)])


def imaged(radius, edge):
    """Return the section of a mask of a shape, in voxels of an edge in m, aside of their middles."""
    x = (np.arange(round(80e-3 / edge)) + 0.5) * edge - 40e-3
    x, y = np.meshgrid(x + 0.13 * edge, x + 0.37 * edge, indexing="ij")
    voxels = np.hypot(x, y) < radius(np.arctan2(y, x))
    (found,) = sections((np.uint8(voxels)[:, None], np.diag([1e3 * edge] * 3 + [1.0])), plane="coronal")
    return found


def pial(section, **options):
    body = outline(section, thickness=T, elements=4, **options)
    return body.nodes[:, body.pial], body.changes


@pytest.mark.parametrize("edge", [0.5e-3, 1e-3])
@pytest.mark.parametrize("shape", [disc, ellipse])
def test_convex_shapes_in_voxels_have_no_folds_and_their_own_length(shape, edge):
    exact = curve(shape)
    found, _ = pial(imaged(shape, edge))
    assert find_folds(found, thickness=T, closed=True).count == 0
    assert gyrification_index(found, closed=True) == pytest.approx(1.0, abs=2e-3)
    assert perimeter(found) == pytest.approx(perimeter(exact), rel=5e-3)
    assert abs(area(found)) == pytest.approx(abs(area(exact)), rel=1e-3)
    stepped, _ = pial(imaged(shape, edge), smooth=0)
    assert perimeter(stepped) > 1.05 * perimeter(exact)  # as has been: the default is what helps


@pytest.mark.parametrize("edge", [0.5e-3, 1e-3])
def test_gyri_of_twelve_voxels_and_more_stay(edge):
    exact = curve(wavy)
    found, _ = pial(imaged(wavy, edge))
    assert find_folds(found, thickness=T, closed=True).count == 13
    assert gyrification_index(found, closed=True) == pytest.approx(
        gyrification_index(exact[:, ::50], closed=True), rel=0.02
    )
    assert abs(area(found)) == pytest.approx(abs(area(exact)), rel=5e-3)


def test_the_length_is_said_and_the_users_own_wins():
    section = imaged(disc, 0.5e-3)
    assert section.voxel == pytest.approx(0.5e-3)
    (words,) = pial(section)[1].remarks()
    assert words == "steps of voxels smoothed away over 0.00075 m, 1.5 voxels (smooth=0 keeps them)"
    same, changes = pial(section, smooth=0.75e-3)
    assert not any("voxels" in note for note in changes.notes)
    np.testing.assert_array_equal(same, pial(section)[0])
    drawn, changes = pial(Section([curve(disc)[:, ::100]]))  # of no image
    assert changes.remarks() == ()
    assert perimeter(drawn) == pytest.approx(2 * np.pi * 25e-3, rel=1e-3)


def test_a_section_scaled_to_a_width_has_voxels_as_large(tmp_path):
    from PIL import Image as Pictures

    from turingfold import read_section

    x = np.arange(101) - 50
    Pictures.fromarray(np.uint8(255 * (np.hypot(*np.meshgrid(x, x)) <= 40))).save(tmp_path / "mask.png")
    read = read_section(tmp_path / "mask.png", width=0.081)  # 81 pixels across
    assert read.voxel == pytest.approx(1e-3)
    body = load_case(CASE).scenes({"outline": str(tmp_path / "mask.png"), "width": 0.081}, quick=True)
    assert "smoothed away over 0.0015 m" in str(body["section"].body.changes)


def test_specks_of_single_voxels_do_not_stop_an_image():
    section = imaged(disc, 0.5e-3)
    speck = 0.25e-3 * np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]]) + 0.035
    _, changes = pial(replace(section, pial=[*section.pial, speck]))
    area = 0.5e-3**2  # of one voxel
    assert f"1 curves of points smaller than 1.5 voxels left out, {area:.2g} m²" in changes.remarks()


def folded(edge):
    """Return labels of a disc with twelve sulci, 3 mm wide, whose cortex is 3 mm thick; voxels of an edge."""
    x = (np.arange(round(80e-3 / edge)) + 0.5) * edge - 40e-3
    x, y = np.meshgrid(x + 0.13 * edge, x + 0.37 * edge, indexing="ij")
    sulci = [
        shapely.LineString(np.outer([16e-3, 40e-3], [np.cos(a), np.sin(a)]))
        for a in (np.arange(12) + 0.5) / 6 * np.pi
    ]
    tissue = shapely.Point(0, 0).buffer(30e-3) - shapely.union_all(sulci).buffer(1.5e-3)
    inside = [shapely.contains_xy(area, x, y) for area in (tissue, tissue.buffer(-3e-3))]
    return np.uint8(inside[0]) + np.uint8(inside[1])


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize("edge", [1e-3, 2e-3])
def test_each_tissue_has_the_area_of_its_voxels(edge, cut):
    """Else smoothing fills sulci more than it wears off gyri: gray matter +1.3 % and, at 2 mm, +7.3 %."""
    labels = folded(edge)
    labels = labels[:, len(labels) // 2 :] if cut else labels
    (section,) = sections((labels[:, None], np.diag([1e3 * edge] * 3 + [1.0])), gray=1, white=2)
    for curves, voxels in ((section.pial, labels > 0), (section.white, labels > 1)):
        enclosed = sum(abs(area(curve)) + section.lacking for curve in curves)
        assert enclosed == pytest.approx(voxels.sum() * edge**2, rel=1e-9)
    body = outline(section, size=T / 2, base_ends=section.cuts if cut else None)
    areas = Basis(body.mesh, ElementTriP2(), intorder=4).dx.sum(axis=1)
    gray = areas[body.mesh.subdomains["cortex"]].sum()
    assert areas.sum() == pytest.approx((labels > 0).sum() * edge**2, rel=5e-3)
    assert gray == pytest.approx((labels == 1).sum() * edge**2, rel=0.03)
    # islands of one voxel, which are told apart, are gray
    specks = [curve for curve in section.white if np.ptp(curve, axis=1).max() < 1.5 * edge]
    gray -= sum(abs(area(curve)) + section.lacking for curve in specks)
    assert body.changes.cortex == pytest.approx(gray / ((labels == 1).sum() * edge**2) - 1, abs=5e-3)
