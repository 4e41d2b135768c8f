"""Sections of triangle surfaces, against exact shapes, and surfaces that cannot be used."""

import sys

import numpy as np
import pytest
from planar import area

from turingfold import surface_section


def torus(wide=40.0, tube=15.0, count=96):
    """Return a torus around the superior axis, in mm: vertices (n, 3), triangles (m, 3)."""
    u, v = (2 * np.pi * np.arange(count) / count for _ in range(2))
    r = wide + tube * np.cos(v)
    points = np.stack([r * np.cos(u)[:, None], r * np.sin(u)[:, None], np.tile(tube * np.sin(v), (count, 1))])
    number = np.arange(count**2).reshape(count, count)
    a, b = number, np.roll(number, -1, axis=0)
    c, d = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    triangles = np.concatenate([np.stack([a, b, d], axis=-1), np.stack([a, d, c], axis=-1)]).reshape(-1, 3)
    return points.reshape(3, -1).T, triangles


def test_a_plane_across_a_torus_gives_two_circles():
    section = surface_section(torus(), torus(tube=12.0), plane="coronal", at=0.0)
    for loops, radius in ((section.pial, 15.0), (section.white, 12.0)):
        assert [abs(area(loop)) for loop in loops] == pytest.approx([np.pi * radius**2 * 1e-6] * 2, rel=2e-3)
        for loop in loops:
            assert np.hypot(np.abs(loop[0]) - 0.04, loop[1]) == pytest.approx(1e-3 * radius, rel=2e-3)
    assert (section.plane, section.position) == ("coronal", 0.0)


@pytest.mark.parametrize("at", [0.0, 3e-3])
def test_a_plane_along_a_torus_gives_a_ring(at):
    """Vertices lie on the plane at 0, whose curves must still close."""
    section = surface_section(torus(), plane="axial", at=at)
    half = np.sqrt(15.0**2 - (1e3 * at) ** 2)
    expected = [np.pi * (40 + half) ** 2 * 1e-6, np.pi * (40 - half) ** 2 * 1e-6]
    assert [abs(area(loop)) for loop in section.pial] == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize(("plane", "kept"), [("sagittal", (1, 2)), ("coronal", (0, 2)), ("axial", (0, 1))])
def test_places_in_the_plane_are_those_of_the_axes(plane, kept):
    points, triangles = torus()
    points = points @ np.diag([1.0, 1.2, 0.8]) + (3.0, -5.0, 7.0)
    across = ({0, 1, 2} - set(kept)).pop()
    at = points[:, across].mean()
    section = surface_section((points, triangles), plane=plane, at=1e-3 * at)
    found = np.concatenate(section.pial, axis=1)
    near = points[np.abs(points[:, across] - at) < 2.0][:, kept]
    assert found.min(1) == pytest.approx(1e-3 * near.min(0), abs=0.1e-3)
    assert found.max(1) == pytest.approx(1e-3 * near.max(0), abs=0.1e-3)


def test_triangles_turned_over_and_shuffled_do_not_matter():
    points, triangles = torus()
    rng = np.random.default_rng(0)
    mixed = rng.permutation(triangles)
    mixed[::2] = mixed[::2, ::-1]
    one, other = (surface_section((points, t), at=2e-3) for t in (triangles, mixed))
    assert [abs(area(loop)) for loop in other.pial] == pytest.approx([abs(area(loop)) for loop in one.pial])


def test_both_hemispheres_make_one_section():
    points, triangles = torus(wide=20.0, tube=8.0)
    pair = [(points + np.array([side, 0, 0]), triangles) for side in (-40.0, 40.0)]
    assert len(surface_section(pair, at=0.0).pial) == 4


@pytest.mark.parametrize("kind", ["gifti", "gzipped", "freesurfer"])
def test_surfaces_are_read_from_files(tmp_path, kind):
    nibabel = pytest.importorskip("nibabel")
    points, triangles = torus()
    if kind != "freesurfer":
        file = tmp_path / ("lh.pial.surf.gii" if kind == "gifti" else "lh.pial.gii.gz")
        arrays = [(points.astype("f4"), "POINTSET"), (triangles.astype("i4"), "TRIANGLE")]
        parts = [nibabel.gifti.GiftiDataArray(a, f"NIFTI_INTENT_{name}") for a, name in arrays]
        nibabel.save(nibabel.gifti.GiftiImage(darrays=parts), file)
    else:
        file = tmp_path / "lh.pial"
        nibabel.freesurfer.write_geometry(file, points, triangles)
    expected, found = surface_section((points, triangles), at=2e-3), surface_section(file, at=2e-3)
    assert found.source == file.name
    assert [abs(area(a)) for a in found.pial] == pytest.approx(
        [abs(area(a)) for a in expected.pial], rel=1e-6
    )


def test_an_open_surface_is_closed_with_a_word():
    points, triangles = torus()
    middle = points[triangles].mean(axis=1)
    hole = (middle[:, 0] > 0) & (middle[:, 2] > 14.5)
    with pytest.warns(UserWarning, match=r"the pial surface is open; its curve is closed by a line of 0\.00"):
        section = surface_section((points, triangles[~hole]), at=0.0)
    assert abs(area(section.pial[0])) == pytest.approx(np.pi * 15.0**2 * 1e-6, rel=0.02)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"at": 40}, r"at=40 m: the coronal planes .* from -0\.055 to 0\.055 m\. 40 mm would be at=0\.04"),
        ({"plane": "frontal"}, "plane='frontal'"),
        ({"unit": "furlong"}, "unit='furlong'"),
        ({"pial": "lh.pial"}, r"no file lh\.pial"),
        ({"pial": (torus()[0], torus()[1] + 1)}, "name vertices beyond"),
        ({"pial": (torus()[0][:, :2], torus()[1])}, r"shape .*; it must be \(n, 3\)"),
        ({"pial": (torus()[0], torus()[1] * 1.0)}, "give vertex numbers"),
        ({"pial": (torus()[0], np.repeat(torus()[1], 2, axis=0))}, "belongs to 4 triangles"),
    ],
)
def test_wrong_surfaces_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        surface_section(**({"pial": torus(), "at": 0.0} | change))


def test_files_that_are_no_surface_are_refused(tmp_path, monkeypatch):
    pytest.importorskip("nibabel")
    for name in ("a.gii", "lh.pial"):
        (tmp_path / name).write_text("no surface")
        with pytest.raises(ValueError, match=f"{name} is no surface"):
            surface_section(tmp_path / name, at=0.0)
    monkeypatch.setitem(sys.modules, "nibabel", None)
    with pytest.raises(ValueError, match=r"turingfold\[images\]"):
        surface_section(tmp_path / "lh.pial", at=0.0)
