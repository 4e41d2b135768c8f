"""Outlines of masks in NIfTI images: place, size and orientation, and files that cannot be used."""
import sys

import numpy as np
import pytest

from turingfold import mask_outline, outline
from turingfold.geometry.polygon import area

nibabel = pytest.importorskip("nibabel")

EDGES = (0.05, 0.3, 0.08)  # mm
HALF = (4.0, 3.0)  # half axes of the ellipse in a coronal section, mm


def brain(signs=(1, 1, 1)):
    """Return an ellipsoid, thickest in coronal section 4, with a notch on the right, as voxels in RAS."""
    n = (200, 9, 100)
    x, y, z = ((np.arange(k) - (k - 1) / 2) * edge for k, edge in zip(n, EDGES, strict=True))
    inside = (x[:, None, None] / HALF[0]) ** 2 + y[:, None] ** 2 / 9 + (z / HALF[1]) ** 2 <= 1
    inside &= ~((x[:, None, None] > 3.5) & (y[:, None] > -99) & (np.abs(z) < 0.3))
    flips = tuple(slice(None, None, sign) for sign in signs)
    return inside[flips].astype(np.uint8)


def written(path, voxels, signs=(1, 1, 1), units="mm"):
    image = nibabel.Nifti1Image(voxels, np.diag([*(np.array(EDGES) * signs), 1.0]))
    image.header.set_xyzt_units(units)
    nibabel.save(image, path)
    return path


@pytest.mark.parametrize("signs", [(1, 1, 1), (-1, 1, 1), (1, -1, -1)])
def test_the_outline_is_that_of_the_brain_however_it_is_stored(tmp_path, signs):
    points = mask_outline(written(tmp_path / "brain.nii.gz", brain(signs), signs))
    expected = np.pi * HALF[0] * HALF[1] - 0.6 * 0.45  # without the notch, which is 0.45 mm deep
    assert abs(area(points)) == pytest.approx(expected * 1e-6, rel=0.01)
    assert np.ptp(points, axis=1) == pytest.approx(2e-3 * np.array(HALF), rel=0.02)
    middle = points.mean(axis=1)
    notch = points[:, np.abs(points[1] - np.mean([points[1].min(), points[1].max()])) < 2e-4]
    right = notch[0, notch[0] > middle[0]]
    assert right.max() < points[0].max() - 0.3e-3  # it is on the right


@pytest.mark.parametrize(("units", "metres"), [("meter", 1.0), ("micron", 1e-6), ("unknown", 1e-3)])
def test_lengths_are_in_the_units_of_the_file(tmp_path, units, metres):
    points = mask_outline(written(tmp_path / "brain.nii", brain(), units=units))
    assert np.ptp(points[0]) == pytest.approx(8.0 * metres, rel=0.02)


@pytest.mark.parametrize(
    ("section", "index", "size", "edges"),
    [
        ("axial", 30, (8.0 * (1 - 0.52**2) ** 0.5, 2.7), (0.05, 0.3)),  # 1.56 mm below it; nine of 0.3 mm
        ("sagittal", 100, (2.7, 6.0), (0.3, 0.08)),  # the middle
        ("coronal", 0, (8.0 * 0.84**0.5, 6.0 * 0.84**0.5), (0.05, 0.08)),  # 1.2 mm behind the middle
    ],
)
def test_sections_across_each_axis(tmp_path, section, index, size, edges):
    points = mask_outline(written(tmp_path / "brain.nii", brain()), section=section, index=index)
    assert np.all(np.abs(np.ptp(points, axis=1) - 1e-3 * np.array(size)) <= 1.001e-3 * np.array(edges))


def test_a_smoothed_mask_becomes_a_body(tmp_path):
    points = mask_outline(written(tmp_path / "brain.nii", brain()))
    body = outline(points, thickness=0.4e-3, size=0.2e-3, smooth=1.0e-3)
    inside = body.quadrature.weights.sum()
    assert inside == pytest.approx(abs(area(points)), rel=0.01)


def test_a_mask_that_touches_the_edge_of_the_image_is_closed(tmp_path):
    points = mask_outline(written(tmp_path / "full.nii", np.ones((10, 3, 10), dtype=np.uint8)))
    edges = [10 * 0.05e-3, 10 * 0.08e-3]  # NIfTI keeps them in single precision
    assert np.ptp(points, axis=1) == pytest.approx(edges, rel=1e-6)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_sections_with_values_that_are_not_finite_are_refused(tmp_path, value):
    voxels = brain().astype(np.float32)
    voxels[20, 4, 50] = value  # on the outline, which would be left open there
    file = written(tmp_path / "brain.nii", voxels)
    with pytest.raises(ValueError, match=r"1 voxels of coronal section 4 are not finite"):
        mask_outline(file)
    assert mask_outline(file, index=3).shape[1] > 100  # the others can be used


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"section": "frontal"}, "section='frontal'"),
        ({"index": 9}, "sections 0 to 8"),
        ({"index": -1}, "sections 0 to 8"),
        ({"index": 4.5}, r"index=4\.5 must be a whole number.*sections 0 to 8"),
        ({"index": True}, "index=True must be a whole number"),
        ({"level": 1.5}, "values from 0 to 1"),
        ({"level": float("nan")}, "level"),
    ],
)
def test_wrong_options_are_named(tmp_path, options, message):
    with pytest.raises(ValueError, match=message):
        mask_outline(written(tmp_path / "brain.nii", brain()), **options)


@pytest.mark.parametrize("kept", [40, 0.5, 0.9])
@pytest.mark.parametrize("name", ["brain.nii", "brain.nii.gz"])
def test_files_cut_short_are_refused(tmp_path, name, kept):
    file = written(tmp_path / name, brain())
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
    with pytest.raises(ValueError, match=r"shape \(4, 4, 4, 2\)"):
        mask_outline(written(tmp_path / "series.nii", np.ones((4, 4, 4, 2), dtype=np.uint8)))
    for path in (None, 3):
        with pytest.raises(ValueError, match=f"path={path} must be the path of an image"):
            mask_outline(path)
    monkeypatch.setitem(sys.modules, "nibabel", None)
    with pytest.raises(ValueError, match="turingfold\\[images\\]"):
        mask_outline(written(tmp_path / "brain.nii", brain()))
