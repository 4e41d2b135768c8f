"""Sections from files of every kind, by one function: areas of discs and rings, in m."""

from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image as Pictures

from turingfold import read_section
from turingfold.cli.case import load_case

nibabel = pytest.importorskip("nibabel")
CASE = Path(__file__).parents[2] / "cases" / "section.py"
RING = '<circle id="edge" cx="50" cy="50" r="30"/><g id="white"><circle cx="50" cy="50" r="25"/></g>'
HOLE = '<circle id="ventricle" cx="50" cy="50" r="5"/>'


def areas(section):
    """Return the areas of all curves in mm²."""
    return {
        name: [1e6 * shapely.Polygon(curve.T).area for curve in getattr(section, name)]
        for name in ("pial", "white", "holes")
    }


def disc(radius, size=101):
    x = np.arange(size) - size // 2
    return np.hypot(*np.meshgrid(x, x)) <= radius


def test_a_drawing_names_its_white_surface_and_its_ventricles(tmp_path):
    file = tmp_path / "slice.svg"
    file.write_text(f'<svg xmlns="http://www.w3.org/2000/svg">{RING}{HOLE}</svg>')
    found = areas(read_section(file, white="white", holes="ventricle", unit="mm"))
    for name, radius in (("pial", 30), ("white", 25), ("holes", 5)):
        assert found[name] == pytest.approx([np.pi * radius**2], rel=2e-3)
    wide = read_section(str(file), white="white", width=0.12)
    assert np.ptp(wide.pial[0][0]) == pytest.approx(0.12)
    assert areas(wide)["white"] == pytest.approx([np.pi * 50**2], rel=2e-3)


def test_points_have_their_white_surface_in_a_file_of_its_own(tmp_path):
    at = 2 * np.pi * np.arange(200) / 200
    for name, radius in (("pial.csv", 30), ("white.csv", 20)):
        rows = [f"{radius * np.cos(a)},{radius * np.sin(a)}" for a in at]
        (tmp_path / name).write_text("\n".join(["x (mm),y (mm)", *rows]))
    found = areas(read_section(tmp_path / "pial.csv", white=str(tmp_path / "white.csv")))
    assert found["pial"] == pytest.approx([np.pi * 900], rel=1e-3)
    assert found["white"] == pytest.approx([np.pi * 400], rel=1e-3)
    with pytest.warns(UserWarning, match="unit='cm' is taken instead") as told:
        read_section(tmp_path / "pial.csv", white=str(tmp_path / "white.csv"), unit="cm")
    assert {str(one.message).split()[0] for one in told} == {"pial.csv", "white.csv"}


def test_pictures_have_the_size_of_a_pixel_or_a_width(tmp_path):
    file = tmp_path / "mask.png"
    Pictures.fromarray(np.uint8(255 * disc(40))).save(file)
    assert areas(read_section(file, unit="0.0005"))["pial"] == pytest.approx([np.pi * 400], rel=0.01)
    assert areas(read_section(file, width=0.04))["pial"] == pytest.approx([np.pi * 400], rel=0.03)
    with pytest.raises(ValueError, match=r"mask\.png does not say how large it is"):
        read_section(file)


def test_volumes_have_labels_and_planes(tmp_path):
    file = tmp_path / "labels.nii.gz"
    voxels = np.where(disc(20), 2, 3 * disc(40))[:, None, :] * np.ones((1, 3, 1), dtype=int)
    nibabel.save(nibabel.Nifti1Image(np.uint8(voxels), np.diag([0.5, 2.0, 0.5, 1.0])), file)
    found = areas(read_section(file, gray="3", white="2", at=0.002))
    assert found["pial"] == pytest.approx([np.pi * 400], rel=0.01)
    assert found["white"] == pytest.approx([np.pi * 100], rel=0.01)
    with pytest.raises(ValueError, match=r"unit=cm: labels\.nii\.gz states the size of its voxels; "):
        read_section(file, gray="3", white="2", unit="cm")
    with pytest.raises(ValueError, match="gray=cortex: give labels"):
        read_section(file, gray="cortex")


@pytest.mark.parametrize("count", [1, 7])
def test_a_slab_is_not_cut_edge_on(tmp_path, count):
    file = tmp_path / "slab.nii.gz"
    voxels = np.where(disc(20), 2, 3 * disc(40))[:, :, None] * np.ones((1, 1, count), dtype=int)
    affine = np.diag([0.5, 0.5, 2.0, 1.0])
    affine[2, 3] = 10.0
    nibabel.save(nibabel.Nifti1Image(np.uint8(voxels), affine), file)
    words = (
        rf"plane='coronal': slab.nii.gz has {count} axial planes of 101 by 101 .* plane='axial'.* at 10 to "
    )
    with pytest.raises(ValueError, match=words + f"{10 + 2 * (count - 1)} mm"):
        read_section(file, gray="3", white="2")
    found = areas(read_section(file, gray="3", white="2", plane="axial", at=0.01))
    assert found["pial"] == pytest.approx([np.pi * 400], rel=0.01)
    assert found["white"] == pytest.approx([np.pi * 100], rel=0.01)


def test_surfaces_are_cut_by_a_plane(tmp_path):
    cube = np.array([[x, y, z] for x in (0, 10) for y in (0, 10) for z in (0, 10)], dtype="f4")
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))], dtype="i4")
    for name, side in (("lh.pial.surf.gii", 0), ("rh.pial.surf.gii", 30)):
        parts = [(cube + np.float32([side, 0, 0]), "POINTSET"), (triangles, "TRIANGLE")]
        arrays = [nibabel.gifti.GiftiDataArray(each, f"NIFTI_INTENT_{kind}") for each, kind in parts]
        nibabel.save(nibabel.gifti.GiftiImage(darrays=arrays), tmp_path / name)
    both = f"{tmp_path / 'lh.pial.surf.gii'},{tmp_path / 'rh.pial.surf.gii'}"
    assert areas(read_section(both, at=0.004))["pial"] == pytest.approx([100, 100])
    with pytest.raises(ValueError, match="at is missing"):
        read_section(both)


def test_the_case_takes_a_file_and_says_what_is_missing(tmp_path):
    file = tmp_path / "slice.svg"
    file.write_text(f'<svg xmlns="http://www.w3.org/2000/svg">{RING}{HOLE}</svg>')
    case = load_case(CASE)
    given = {"outline": str(file), "white": "white", "holes": "ventricle", "unit": "mm"}
    body = case.scenes(given, quick=True)["section"].body
    assert body.quadrature.weights.sum() == pytest.approx(np.pi * (30**2 - 5**2) * 1e-6, rel=5e-3)
    assert body.quadrature.weights[:, body.in_cortex].sum() == pytest.approx(np.pi * 275e-6, rel=0.01)
    with pytest.raises(ValueError, match=r"nowhere\.svg"):
        case.scenes({"outline": "nowhere.svg"}, quick=True)
