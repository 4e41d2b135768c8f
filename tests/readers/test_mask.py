"""Sections of images: exact areas and places however stored, tissues, and images that cannot be used."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pictures
from planar import area, inside

from turingfold import mask_outline, outline, sections
from turingfold.geometry.changes import OutlineWarning

nibabel = pytest.importorskip("nibabel")

BESIDE = Path(__file__).parents[3] / "shared" / "reference" / "sections"
REAL = Path(os.environ.get("BRAIN_SECTIONS", BESIDE))
EDGES = np.array([0.05, 0.3, 0.08])  # mm
HALF = np.array([4.0, 3.0])  # half axes of the ellipsoid in a coronal section, mm
START = np.array([-3.0, 11.0, 20.0])  # of its centre, mm
NOTCH = 0.6 * 0.45  # mm²
COUNT = (200, 9, 100)
PLACED = np.diag([*EDGES, 1.0])
PLACED[:3, 3] = START - (np.array(COUNT) - 1) / 2 * EDGES


def brain():
    """Return an ellipsoid, thickest in coronal plane 4, with a notch on the right, as voxels in RAS."""
    x, y, z = ((np.arange(k) - (k - 1) / 2) * edge for k, edge in zip(COUNT, EDGES, strict=True))
    found = (x[:, None, None] / HALF[0]) ** 2 + y[:, None] ** 2 / 9 + (z / HALF[1]) ** 2 <= 1
    found &= ~((x[:, None, None] > 3.5) & (y[:, None] > -99) & (np.abs(z) < 0.3))
    return found.astype(np.uint8)


def image(voxels, affine=PLACED, units="mm"):
    found = nibabel.Nifti1Image(voxels, affine)
    found.header.set_xyzt_units(units)
    return found


def written(path, voxels=None, **options):
    nibabel.save(image(brain() if voxels is None else voxels, **options), path)
    return path


def square(edge, width=80.0):
    """Return x, z of the voxels of a square coronal plane round the origin, and its affine, in mm."""
    at = np.arange(-width / 2, width / 2, edge) + 0.3 * edge
    affine = np.diag([edge, 1.0, edge, 1.0])
    affine[[0, 2], 3] = at[0]
    return at[:, None, None], at, affine


def disc(radius, edge, width=80.0):
    """Return a disc in a coronal plane, and its affine, in mm."""
    x, z, affine = square(edge, width)
    return np.hypot(x, z) <= radius, affine


def enclosed(loops):
    """Return the area that an odd number of the loops encloses; they do not cross."""
    around = [sum(inside(one[:, :1], other)[0] for other in loops if other is not one) for one in loops]
    return sum((-1) ** n * abs(area(loop)) for n, loop in zip(around, loops, strict=True))


# curves


@pytest.mark.parametrize("value", [1, 42, 255])
@pytest.mark.parametrize("radius", [10.0, 30.0])
def test_a_disc_has_its_area_whatever_its_value(value, radius):
    voxels, affine = disc(radius, 0.25)
    points = mask_outline(image((value * voxels).astype(np.uint8), affine))
    assert abs(area(points)) == pytest.approx(np.pi * radius**2 * 1e-6, rel=5e-3)
    assert abs(area(points)) == pytest.approx(voxels.sum() * 0.25**2 * 1e-6, rel=1e-4)  # of the voxels
    assert np.hypot(*points) == pytest.approx(1e-3 * radius, abs=0.25e-3)


def test_a_map_of_probability_is_followed_between_voxels():
    """Shares that fall linearly across an ellipse's edge give the ellipse to second order of the voxel."""
    a, b = 30.0, 20.0
    errors = []
    for edge in (2.0, 1.0):
        x, z, affine = square(edge)
        share = np.clip(0.5 + 2 * (1 - np.hypot(x / a, z / b)), 0, 1)
        points = mask_outline(image(share.astype(np.float32), affine))
        errors.append(np.abs(np.hypot(points[0] / a, points[1] / b) * 1e3 - 1).max())
    assert errors[0] < 2e-3
    assert errors[0] / errors[1] > 3


def test_the_outline_encloses_most_and_not_the_longest_curve():
    x, z, affine = square(0.5, 100.0)
    r, t = np.hypot(x, z), np.arctan2(z, x)
    mask = image(((r < 40) & (r > 30 + 6 * np.cos(16 * t))).astype(np.uint8), affine)
    assert np.hypot(*mask_outline(mask)).max() == pytest.approx(0.040, abs=0.5e-3)
    (section,) = sections(mask)
    assert len(section.pial) == 2
    assert enclosed(section.pial) == pytest.approx(np.pi * (40**2 - 30**2 - 6**2 / 2) * 1e-6, rel=5e-3)


def test_all_parts_are_returned_and_one_not_without_a_word():
    voxels = np.zeros((40, 3, 40), dtype=np.uint8)
    voxels[2:10, 1, 2:10] = 1
    voxels[20:38, 1, 20:38] = 1
    mask = image(voxels, np.eye(4))
    (section,) = sections(mask)
    assert [abs(area(loop)) for loop in section.pial] == pytest.approx([18**2 * 1e-6, 8**2 * 1e-6], rel=0.01)
    with pytest.warns(UserWarning, match=r"parts of 63\.5 mm² lie outside the outline.*323"):
        points = mask_outline(mask)
    assert points.min() > 19e-3


def test_a_mask_that_touches_the_edge_of_the_image_is_closed():
    voxels = np.repeat(np.uint8([0, 1, 1]), 100).reshape(3, 10, 10).swapaxes(0, 1)
    with pytest.warns(OutlineWarning, match="the image's edge cuts the tissue off") as told:
        points = mask_outline(image(voxels))
    assert len(told) == 4
    assert np.ptp(points, axis=1) == pytest.approx(
        1e-2 * EDGES[::2], rel=1e-6
    )  # NIfTI keeps them in single precision


def cropped(mask):
    """Return a mask without rows and columns that have no tissue."""
    rows, columns = (np.flatnonzero(mask.any(axis)) for axis in (1, 0))
    return mask[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]


@pytest.mark.parametrize("size", [12, 41, 100, 301])
@pytest.mark.parametrize("aspect", [1.0, 1.4, 2.3])
@pytest.mark.parametrize("angle", [0.0, 0.6])
def test_a_closely_cropped_shape_is_not_cut_off_by_the_edge_that_it_touches(size, aspect, angle):
    x = np.arange(size) - 0.5 * (size - 1) + 0.2
    x, y = np.meshgrid(x, x)
    along, across = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    (section,) = sections(cropped(np.hypot(along, aspect * across) <= 0.49 * size), pixel_mm=1.0, gray=1)
    assert section.cuts == ()


@pytest.mark.parametrize("side", ["bottom", "right", "top", "left"])
def test_what_the_edge_of_an_image_cuts_off_is_told_by_its_ends_and_may_be_a_base(side):
    turns = ("bottom", "right", "top", "left").index(side)
    x = np.arange(121) - 60.0
    mask = np.rot90(np.pad(np.hypot(*np.meshgrid(x, x)) <= 50, 5)[:90], turns)
    (section,) = sections(mask, pixel_mm=1.0, gray=1)
    ((first, last),) = section.cuts
    length = 1e-3 * np.rot90(mask, -turns)[-1].sum()
    turn = np.exp(0.5j * np.pi * turns)
    assert complex(*last) - complex(*first) == pytest.approx((length - 1e-3) * turn)  # counter-clockwise
    with pytest.warns(
        OutlineWarning, match="edge cuts the tissue off along .* base_ends=section.cuts"
    ) as told:
        body = outline(section, thickness=5e-3, size=2.5e-3)
    assert len(told) == 1
    assert any("the image's edge cuts" in remark for remark in body.changes.remarks())
    held = outline(section, thickness=5e-3, size=2.5e-3, base="clamped", base_ends=section.cuts)  # no warning
    (line,) = held.boundary_paths("base")
    assert np.ptp(held.nodes[:, line.nodes], axis=1).max() == pytest.approx(length, abs=2e-3)


# places


def test_places_are_those_of_the_affine():
    points = mask_outline(image(brain()))
    assert (points.min(1) + points.max(1))[1] / 2 == pytest.approx(1e-3 * START[2])
    assert points[0].min() == pytest.approx(1e-3 * (START[0] - HALF[0]), abs=1e-3 * EDGES[0])
    assert abs(area(points)) == pytest.approx((np.pi * HALF.prod() - NOTCH) * 1e-6, rel=0.01)
    middle = points[0, np.abs(points[1] - 1e-3 * START[2]) < 0.2e-3]
    assert middle.max() < points[0].max() - 0.3e-3  # the notch is on the right


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 2, 0), (2, 1, 0)])
@pytest.mark.parametrize("signs", [(1, 1, 1), (-1, 1, 1), (1, -1, -1)])
@pytest.mark.parametrize("plane", ["coronal", "axial", "sagittal"])
def test_an_image_stored_otherwise_has_the_same_sections(order, signs, plane):
    voxels, affine = brain(), PLACED.copy()
    for axis, sign in enumerate(signs):
        if sign < 0:
            voxels = np.flip(voxels, axis)
            affine[:, 3] += affine[:, axis] * (voxels.shape[axis] - 1)
            affine[:, axis] *= -1
    stored = image(np.ascontiguousarray(voxels.transpose(order)), affine[:, [*order, 3]])
    stored.header.set_zooms((1.0, 1.0, 1.0))  # pixdim, which says otherwise
    assert stored.affine == pytest.approx(affine[:, [*order, 3]])
    expected, found = sections(image(brain()), plane=plane)[0], sections(stored, plane=plane)[0]
    assert found.position == pytest.approx(expected.position, abs=1e-9)
    assert found.pial[0] == pytest.approx(expected.pial[0], abs=1e-9)


def test_an_oblique_image_has_sections_of_true_size():
    """The voxels' axes are turned about the superior axis and sheared by 0.2 in the coronal plane."""
    voxels, _ = disc(10.0, 0.25, 40.0)
    turn = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
    affine = np.eye(4)
    affine[:3, :3] = turn @ np.array([[0.25, 0, 0.05], [0, 1, 0], [0, 0, 0.25]])
    points = mask_outline(image(voxels.astype(np.uint8), affine))
    at = points - (points.max(1) + points.min(1))[:, None] / 2
    sheared = np.hypot(at[0] - 0.2 * at[1], at[1])
    assert sheared == pytest.approx(10e-3, abs=0.3e-3)


@pytest.mark.parametrize(("units", "metres"), [("meter", 1.0), ("micron", 1e-6), ("unknown", 1e-3)])
def test_lengths_are_in_the_units_of_the_file(tmp_path, units, metres):
    points = mask_outline(written(tmp_path / "brain.nii", units=units))
    assert np.ptp(points[0]) == pytest.approx(8.0 * metres, rel=0.02)


def test_millimetres_taken_for_metres_are_pointed_out(tmp_path):
    voxels, affine = disc(30.0, 1.0)
    file = written(tmp_path / "brain.nii", voxels.astype(np.uint8), affine=affine, units="meter")
    with pytest.warns(UserWarning, match=r"brain\.nii.* 60 by 60 large, read as metres; if they are mm"):
        points = mask_outline(file)
    assert np.ptp(points, axis=1) == pytest.approx([60, 60], abs=1)  # m, as the file says


@pytest.mark.parametrize(
    ("plane", "index", "size", "edges"),
    [
        ("axial", 30, (8.0 * (1 - 0.52**2) ** 0.5, 2.7), (0.05, 0.3)),  # 1.56 mm below; nine of 0.3 mm
        ("sagittal", 100, (2.7, 6.0), (0.3, 0.08)),  # the middle
        ("coronal", 0, (8.0 * 0.84**0.5, 6.0 * 0.84**0.5), (0.05, 0.08)),  # 1.2 mm behind the middle
    ],
)
def test_planes_are_chosen_by_number_and_by_place(plane, index, size, edges):
    across = ("sagittal", "coronal", "axial").index(plane)
    at = PLACED[across, 3] + index * EDGES[across]
    ways = {"index": index}, {"at_mm": at}
    one, other = (sections(image(brain()), plane=plane, **way)[0] for way in ways)
    assert np.all(np.abs(np.ptp(one.pial[0], axis=1) - 1e-3 * np.array(size)) <= 1.001e-3 * np.array(edges))
    assert np.array_equal(one.pial[0], other.pial[0])
    assert one.position == other.position == pytest.approx(1e-3 * at)
    near = sections(image(brain()), plane=plane, at_mm=(at + 0.4 * EDGES[across], at + 0.6 * EDGES[across]))
    assert [s.position for s in near] == pytest.approx([1e-3 * at, 1e-3 * (at + EDGES[across])])


# tissues


def shells():
    """Return labels of a disc: ventricle (4) to 6 mm, white (2, 41) to 20 mm, gray (3, 42) to 30 mm."""
    x, z, affine = square(0.5)
    r, right = np.hypot(x, z), x > 0
    labels = np.where(right, 41, 2) * (r < 20) + np.where(right, 42, 3) * ((r >= 20) & (r < 30))
    return np.where(r < 6, 4, labels).astype(np.int16), affine


def check_shells(section):
    for loops, radius in ((section.pial, 30), (section.white, 20), (section.holes, 6)):
        assert [abs(area(loop)) for loop in loops] == pytest.approx([np.pi * radius**2 * 1e-6], rel=0.01)


def test_labels_make_pial_white_and_hole():
    voxels, affine = shells()
    check_shells(sections(image(voxels, affine), gray=(3, 42), white=(2, 41), hole=4)[0])
    check_shells(sections((voxels, affine), gray=(3, 42), white=(2, 41), hole=4)[0])
    floats = image(voxels.astype(np.float64), affine)
    check_shells(sections(floats, gray=[3, 42], white=[2, 41], hole=[4])[0])


def test_maps_of_probability_make_pial_white_and_hole():
    voxels, affine = shells()
    maps = [np.isin(voxels, labels) * 0.98 + 0.005 for labels in ((3, 42), (2, 41), (4,))]
    check_shells(sections(image(np.stack(maps, axis=3), affine), gray=0, white=1, hole=2)[0])
    each = dict(zip(("gray", "white", "hole"), [image(m, affine) for m in maps], strict=True))
    check_shells(sections(each)[0])


def test_pictures_have_rows_from_top_to_bottom(tmp_path):
    voxels, _ = shells()
    voxels[100:, 0, 140:] = 0
    pixels = np.uint8(voxels[:, 0, ::-1].T)
    for name in ("a.png", "a.tif"):
        Pictures.fromarray(pixels).save(tmp_path / name)
        (section,) = sections(tmp_path / name, gray=(3, 42), white=(2, 41), hole=4, pixel_mm=0.5)
        check_shells(section)
        assert section.position is None
    black_and_white = Pictures.fromarray(np.where(pixels, 255, 0).astype(np.uint8)).convert("RGB")
    black_and_white.save(tmp_path / "mask.png")
    (section,) = sections(tmp_path / "mask.png", pixel_mm=0.5)
    assert abs(area(section.pial[0])) == pytest.approx(np.pi * 30**2 * 1e-6, rel=0.01)


def black_on_white(kind):
    """Return a disc of radius 30 mm in pixels of 0.5 mm, whose value is lower than that round it."""
    inside = np.hypot(*np.meshgrid(np.arange(-70, 71), np.arange(-65, 66))) <= 60
    if kind == "int8":
        return np.where(inside, -1, 0).astype(np.int8)
    if kind != "palette":
        return np.where(inside, 0, 255).astype(np.uint8)
    picture = Pictures.fromarray(np.where(inside, 0, 1).astype(np.uint8), "P")
    picture.putpalette([200, 100, 100, 255, 255, 255])
    return picture


@pytest.mark.parametrize(
    ("kind", "words"),
    [("uint8", "value 255 .* 0 is"), ("int8", "value 0 .* -1 is"), ("palette", "value 1 .* 0 is")],
)
def test_a_black_brain_on_white_is_a_brain(tmp_path, kind, words):
    pixels = black_on_white(kind)
    if kind == "palette":
        pixels.save(tmp_path / "mask.png")
        pixels = tmp_path / "mask.png"
    with pytest.warns(UserWarning, match=f"the {words} taken as tissue; if .* is, give .*gray="):
        (section,) = sections(pixels, pixel_mm=0.5)
    assert [area(loop) for loop in section.pial] == pytest.approx([np.pi * 30**2 * 1e-6], rel=0.01)


@pytest.mark.parametrize("white", [1, 255, 0.98])
def test_of_several_maps_none_is_turned_round(white):
    """Of 131 by 141 pixels of a quarter mm² all but a disc of 30 mm is gray; the disc is a hole."""
    hole = np.where(black_on_white("uint8") == 0, white, 0)
    with pytest.warns(
        UserWarning, match=f"so that the outline follows them.* give {np.ceil(white):g} minus it as gray"
    ):
        (section,) = sections({"gray": white - hole, "hole": hole}, pixel_mm=0.5)
    assert enclosed(section.holes) == pytest.approx(np.pi * 30**2 * 1e-6, rel=0.01)
    assert enclosed(section.pial) == pytest.approx(131 * 141 * 0.25e-6, rel=0.01)


def test_the_values_of_tissue_can_be_given():
    pixels = black_on_white("uint8")
    (brain_,) = sections(pixels, gray=0, pixel_mm=0.5)
    (round_it,) = sections(pixels, gray=255, pixel_mm=0.5)
    assert enclosed(brain_.pial) == pytest.approx(np.pi * 30**2 * 1e-6, rel=0.01)
    assert enclosed(brain_.pial) + enclosed(round_it.pial) == pytest.approx(131 * 141 * 0.25e-6, rel=1e-4)


def test_a_level_above_which_lies_the_edge_of_the_picture_is_pointed_out():
    shades = np.where(black_on_white("uint8") == 0, 40, 230) + np.arange(141) % 7
    with pytest.warns(
        UserWarning, match=r"above the level 128 fill 100% of the image's edges, .* its negative"
    ):
        sections(shades, level=128, pixel_mm=0.5)
    (section,) = sections(-shades, level=-128, pixel_mm=0.5)
    assert area(section.pial[0]) == pytest.approx(np.pi * 30**2 * 1e-6, rel=0.01)


def test_a_brain_that_is_cut_out_closely_stays_a_brain():
    """It touches all four edges, but with little of them."""
    pixels = 255 - black_on_white("uint8")[5:-5, 10:-10]
    assert all(edge.any() for edge in (pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]))
    (section,) = sections(pixels, pixel_mm=0.5)
    assert enclosed(section.pial) == pytest.approx(np.pi * 30**2 * 1e-6, rel=0.01)


@pytest.mark.parametrize("name", ["a.png", "a.tif"])
@pytest.mark.parametrize(
    ("orientation", "stored"),
    [
        (1, lambda seen: seen),
        (2, lambda seen: seen[:, ::-1]),  # the first column is the right side
        (3, lambda seen: seen[::-1, ::-1]),
        (6, lambda seen: seen.T[::-1]),  # the first row is the right side, the first column the top
        (8, lambda seen: seen.T[:, ::-1]),  # the first row is the left side, the first column the bottom
    ],
)
def test_pictures_are_upright_as_their_camera_says(tmp_path, name, orientation, stored):
    """By the specification of EXIF, tag Orientation; as seen, 20 by 10 pixels are at the top left."""
    seen = np.zeros((60, 90), dtype=np.uint8)
    seen[5:15, 10:30] = 255
    exif = Pictures.Exif()
    exif[0x0112] = orientation
    Pictures.fromarray(np.ascontiguousarray(stored(seen))).save(tmp_path / name, exif=exif)
    (section,) = sections(tmp_path / name, pixel_mm=1.0)
    (left, low), (right, high) = 1e3 * section.pial[0].min(1), 1e3 * section.pial[0].max(1)
    assert [left, right, low, high] == pytest.approx([9.5, 29.5, 44.5, 54.5])


@pytest.mark.skipif(not REAL.is_dir(), reason="the folder BRAIN_SECTIONS of real sections is not here")
def test_labels_of_a_real_brain_agree_with_the_surfaces_they_were_made_from():
    shapely = pytest.importorskip("shapely")
    from turingfold import read_outline

    file = REAL / "s1_labels_coronal_+50_1mm.nii.gz"
    (section,) = sections(file, at_mm=50, gray=1, white=2)
    left = shapely.box(-1, -1, -0.004, 1)  # the surfaces are those of the left hemisphere, up to the fissure

    def region(loops):
        found = shapely.Polygon()
        for loop in loops:
            found = found.symmetric_difference(shapely.make_valid(shapely.Polygon(loop.T)))
        return found.intersection(left)

    for name, loops in (("pial", section.pial), ("white", section.white)):
        files = sorted(REAL.glob(f"s1_coronal_+50_lh_{name}_*.csv"))
        exact = region([read_outline(file, unit="mm").single() for file in files])
        found = region(loops)
        assert found.area == pytest.approx(exact.area, rel=0.02)
        assert found.symmetric_difference(exact).area < 0.15 * exact.area


# what cannot be used


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_planes_with_values_that_are_not_finite_are_refused(value):
    voxels = brain().astype(np.float32)
    voxels[20, 4, 50] = value  # on the outline, which would be left open there
    with pytest.raises(ValueError, match=r"1 voxels of coronal plane 4 are not finite"):
        mask_outline(image(voxels), index=4)
    assert mask_outline(image(voxels), index=3).shape[1] > 100  # the others can be used


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"plane": "frontal"}, "plane='frontal'"),
        ({"index": 9}, "planes 0 to 8"),
        ({"index": -1}, "planes 0 to 8"),
        ({"index": 4.5}, r"index=4\.5 must be a whole number.*planes 0 to 8"),
        ({"index": True}, "index=True must be a whole number"),
        ({"at_mm": 0.011}, r"at_mm=0\.011: .* coronal planes 0 to 8, at 9\.8 to 12\.2 mm"),
        ({"at_mm": 11, "index": 4}, "give one of them"),
        ({"level": 1.5}, r"level=1\.5: .*values from 0 to 1"),
        ({"level": float("nan")}, "level"),
        ({"gray": 7}, r"gray=7: the image holds the labels 0, 1"),
        ({"gray": "cortex"}, "gray='cortex' must be a whole number"),
        ({"gray": ()}, "gray is an empty list"),
        ({"white": 1}, "gray is missing beside white"),
        ({"gray": 1, "white": 1}, "share a label"),
        ({"gray": 1, "level": 0.5}, "labels are inside or outside"),
    ],
)
def test_wrong_options_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        sections(image(brain()), **options)


def test_images_of_several_values_need_a_name_for_them():
    voxels, affine = shells()
    with pytest.raises(ValueError, match="the image holds the labels 0, 2, 3, 4, 41, 42; name those of gray"):
        sections(image(voxels, affine))
    above = sections(image(voxels, affine), level=1)[0]
    assert abs(area(above.pial[0])) == pytest.approx(np.pi * 30**2 * 1e-6, rel=0.01)
    with pytest.raises(ValueError, match="neither labels nor probabilities; give a level"):
        sections(image(voxels * 0.37, affine))


def test_headers_that_are_wrong_are_refused_in_words(tmp_path):
    odd = image(brain())
    odd.header["xyzt_units"] = 5
    with pytest.raises(ValueError, match="code 5 for lengths"):
        mask_outline(odd)
    for entry in (0.0, np.nan):
        affine = np.diag([1.0, entry, 1.0, 1.0])
        flat = image(brain())
        flat.header.set_sform(affine, code=1)
        nibabel.Nifti1Image(flat.dataobj, None, flat.header).to_filename(tmp_path / "flat.nii")
        with pytest.raises(ValueError, match=r"affine does not place the voxels .* sform"):
            mask_outline(tmp_path / "flat.nii")
    colours = np.zeros((4, 4, 4), dtype=[("R", "u1"), ("G", "u1"), ("B", "u1")])
    with pytest.raises(ValueError, match="holds colours"):
        mask_outline(written(tmp_path / "rgb.nii", colours))
    with pytest.raises(ValueError, match=r"shape \(4, 4, 4, 2\); say which map"):
        mask_outline(written(tmp_path / "series.nii", np.ones((4, 4, 4, 2), dtype=np.uint8)))
    with pytest.raises(ValueError, match="other voxels; bring them to one grid"):
        sections({"gray": image(brain()), "white": image(brain()[:-1])})


def test_pictures_that_cannot_be_used_are_refused(tmp_path):
    Pictures.new("RGB", (9, 9), (200, 10, 10)).save(tmp_path / "red.png")
    with pytest.raises(ValueError, match=r"red\.png holds colours"):
        sections(tmp_path / "red.png", pixel_mm=1.0)
    with pytest.raises(ValueError, match=r"pixel_mm: red\.png has no size|holds colours"):
        sections(tmp_path / "red.png")
    with pytest.raises(ValueError, match="pixel_mm: the array has no size"):
        sections(np.eye(9))
    with pytest.raises(ValueError, match="pictures have no position"):
        sections(np.eye(9), pixel_mm=1.0, at_mm=3)
    Pictures.new("1", (10_000, 9_000)).save(tmp_path / "huge.png")
    with pytest.raises(ValueError, match=r"huge\.png is no picture that can be read.*90000000 pixels"):
        sections(tmp_path / "huge.png", pixel_mm=1.0)
    (tmp_path / "a.png").write_bytes(b"no picture")
    with pytest.raises(ValueError, match=r"a\.png is no picture"):
        sections(tmp_path / "a.png", pixel_mm=1.0)


@pytest.mark.parametrize("kept", [40, 0.5, 0.9])
@pytest.mark.parametrize("name", ["brain.nii", "brain.nii.gz"])
def test_files_cut_short_are_refused(tmp_path, name, kept):
    file = written(tmp_path / name)
    content = file.read_bytes()
    file.write_bytes(content[: kept if kept > 1 else int(kept * len(content))])
    with pytest.raises(ValueError, match=name.replace(".", r"\.")):
        mask_outline(file)


def test_files_that_are_no_mask_are_refused(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match="no file"):
        mask_outline(tmp_path / "none.nii")
    (tmp_path / "text.nii").write_text("no image")
    with pytest.raises(ValueError, match=r"text\.nii is no image"):
        mask_outline(tmp_path / "text.nii")
    for path in (None, 3):
        with pytest.raises(ValueError, match=f"image={path} must be a path, a nibabel image, or a pair"):
            mask_outline(path)
    file = written(tmp_path / "brain.nii")
    monkeypatch.setitem(sys.modules, "nibabel", None)
    with pytest.raises(ValueError, match="turingfold\\[images\\]"):
        mask_outline(file)
