"""Sections as closed curves: the thickness of the cortex against exact shapes, and what is refused."""

import os
from pathlib import Path

import numpy as np
import pytest

from turingfold import Section, read_outline

BESIDE = Path(__file__).parents[3] / "shared" / "reference" / "sections"
REAL = Path(os.environ.get("BRAIN_SECTIONS", BESIDE))


def circle(radius, count=720, centre=(0.0, 0.0)):
    at = 2 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(at), np.sin(at)]) + np.array(centre)[:, None]


def test_rings_have_the_difference_of_their_radii():
    section = Section(pial=[circle(0.03), circle(0.01, centre=(0.1, 0))], white=[circle(0.027)])
    thick, apart = section.thickness()
    assert thick == pytest.approx(3e-3, rel=1e-3)
    assert np.isnan(apart).all()  # no white matter in that part


def test_an_offset_curve_is_as_deep_as_it_was_offset():
    at = 2 * np.pi * np.arange(2000) / 2000
    pial = np.stack([0.04 * np.cos(at), 0.03 * np.sin(at)])
    normal = np.stack([0.03 * np.cos(at), 0.04 * np.sin(at)])
    white = pial - 2.5e-3 * normal / np.hypot(*normal)
    assert Section([pial], [white]).thickness()[0] == pytest.approx(2.5e-3, rel=1e-3)


def test_eccentric_circles_have_the_mean_of_both_nearest_distances():
    """With centres e apart, |p - w| = |p - c| - r and |w - q| = R - |w|, as both ways follow radii."""
    R, r, e = 0.03, 0.02, 4e-3
    pial = circle(R, 4000)
    to_white = np.hypot(pial[0] - e, pial[1])
    w = np.array([[e], [0]]) + r * (pial - np.array([[e], [0]])) / to_white
    exact = 0.5 * (to_white - r + R - np.hypot(*w))
    found = Section([pial], [circle(r, 4000, (e, 0))]).thickness()[0]
    assert found == pytest.approx(exact, rel=1e-4)


def test_walls_of_a_sulcus_see_their_own_white_matter():
    """Two squares of tissue 1 mm apart, each with white matter 3 mm below its surface but one thin."""

    def box(left, right, low, high, count=40):
        t = np.arange(count) / count
        x = np.concatenate(
            [left + (right - left) * t, right + 0 * t, right - (right - left) * t, left + 0 * t]
        )
        y = np.concatenate([low + 0 * t, low + (high - low) * t, high + 0 * t, high - (high - low) * t])
        return 1e-3 * np.stack([x, y])

    section = Section(
        [box(-20, -0.5, 0, 20), box(0.5, 20, 0, 20)], [box(-17, -7.5, 3, 17), box(1.5, 17, 3, 17)]
    )
    left, right = section.thickness()
    wall = np.isclose(section.pial[0][0], -0.5e-3) & (np.abs(section.pial[0][1] - 0.01) < 4e-3)
    assert np.isnan(left[wall]).all()  # 2 mm away is white matter, but that of the other wall
    wall = np.isclose(section.pial[1][0], 0.5e-3) & (np.abs(section.pial[1][1] - 0.01) < 4e-3)
    assert right[wall] == pytest.approx(1e-3)


@pytest.mark.skipif(not REAL.is_dir(), reason="the folder BRAIN_SECTIONS of real sections is not here")
@pytest.mark.parametrize("stem", ["s1_coronal_+50_lh", "s1_axial_+50_rh", "s1_sagittal_+22_rh"])
def test_real_cortex_is_two_to_four_millimetres_thick(stem):
    """In sections it looks thicker than it is (2.5 mm on average), where the plane cuts it at a slant."""
    curves = [
        [read_outline(file, unit="mm").single() for file in sorted(REAL.glob(f"{stem}_{name}_*.csv"))]
        for name in ("pial", "white")
    ]
    found = np.concatenate(Section(*curves).thickness())
    assert np.isnan(found).mean() < 0.2
    assert 2e-3 < np.nanmedian(found) < 4e-3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pial": []}, "pial holds no curve"),
        ({"pial": circle(1.0)}, "put the one curve in a list"),
        ({"pial": [circle(1.0)[:, :2]]}, r"pial\[0\] has 2 points"),
        ({"pial": [circle(1.0)], "white": [circle(1.0).T]}, r"white\[0\] has shape \(720, 2\)"),
        ({"pial": [circle(1.0)], "holes": [circle(np.nan)]}, r"holes\[0\] is nan at index"),
    ],
)
def test_wrong_curves_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        Section(**options)


def test_a_section_without_white_matter_has_no_thickness():
    with pytest.raises(ValueError, match="no white surface"):
        Section([circle(0.03)]).thickness()


def test_millimetres_are_pointed_out():
    with pytest.warns(UserWarning, match=r"the section is 60 by 60 large.*if they are mm") as told:
        section = Section([circle(30.0)])
    assert len(told) == 1
    np.testing.assert_array_equal(section.pial[0], circle(30.0))  # as it was given
