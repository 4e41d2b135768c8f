"""Sections of a real adult brain and of ferrets, as delivered; skipped where they are not here."""

import os
import warnings
from pathlib import Path

import numpy as np
import pytest
import shapely

from turingfold import outline, read_outline, read_section
from turingfold.outlines.fill import angles

BESIDE = Path(__file__).parents[3] / "shared" / "reference"
SECTIONS = Path(os.environ.get("BRAIN_SECTIONS", BESIDE / "sections"))
FERRET = Path(os.environ.get("FERRET_OUTLINES", BESIDE / "ferret"))
HUMAN = ("s1_axial_+50_rh", "s1_coronal_+50_lh", "s1_sagittal_+22_rh")
SINGLE = [
    *sorted(SECTIONS.glob("smooth*.csv")),
    *sorted(FERRET.glob("*.csv")),
    *(SECTIONS / f"{name}_pial_1.csv" for name in HUMAN),
]
needed = pytest.mark.skipif(not SINGLE[0].is_file(), reason=f"the sections are not in {SECTIONS}")
T = 2.5e-3
pytestmark = pytest.mark.filterwarnings(
    "ignore:outline. .*(lie|crosses):turingfold.geometry.changes.OutlineWarning"
)


def loops(name, surface):
    files = sorted(SECTIONS.glob(f"{name}_{surface}_*.csv"))
    return [read_outline(file, unit="mm").single() for file in files]


def examined(body, given, size):
    """Examine triangles, and how far the pial surface is from the given curves where no walls touch."""
    assert angles(body.mesh.p, body.mesh.t).min() >= 20
    curves = [shapely.LinearRing(loop.T) for loop in given]
    pial = np.concatenate([body.nodes[:, path.nodes] for path in body.pial_paths], axis=1)
    at = shapely.points(pial.T)
    distance = shapely.distance(at, shapely.union_all(curves))
    tissue = shapely.make_valid(shapely.Polygon(given[0].T))
    for loop in given[1:]:
        tissue = tissue ^ shapely.make_valid(shapely.Polygon(loop.T))
    gaps = tissue.buffer(size / 4).buffer(-size / 4) - tissue.buffer(0.01 * size)  # walls that touch
    away = np.nan_to_num(shapely.distance(at, gaps), nan=np.inf) > size / 2
    assert distance[away].max() < size / 3
    assert distance.max() < size / 2
    assert body.changes.lost + body.changes.added < 0.05


@needed
@pytest.mark.slow
@pytest.mark.parametrize("file", SINGLE, ids=lambda file: file.stem)
def test_a_single_outline_is_meshed_as_it_is(file):
    human = file.parent == SECTIONS
    points = read_outline(file, unit="mm" if human else 1.0).single()
    thickness = T if human else 0.1
    body = outline(points, thickness=thickness, elements=3)
    examined(body, [points], thickness / 3)
    # where walls of a real sulcus touch for less than an element, its inside is closed off
    assert human or len(body.pial_paths) == 1


@needed
@pytest.mark.slow
@pytest.mark.parametrize("name", HUMAN)
def test_a_whole_section_is_meshed_with_its_own_white_surface(name):
    pial, white = loops(name, "pial"), loops(name, "white")
    body = outline(pial, interface=white, size=T / 3)
    examined(body, pial, T / 3)
    assert body.changes.cortex == pytest.approx(0.0, abs=0.03)
    assert len(body.pial_paths) > 1
    constant = outline(pial, thickness=T, elements=3)
    examined(constant, pial, T / 3)


@needed
@pytest.mark.slow
@pytest.mark.parametrize("smooth", [None, 0.0])
@pytest.mark.parametrize("name", ["coronal_+50_1mm", "axial_+32_2mm"])
def test_labels_are_meshed_with_steps_of_voxels_and_without(name, smooth):
    pytest.importorskip("nibabel")
    plane = name.split("_")[0]
    section = read_section(SECTIONS / f"s1_labels_{name}.nii.gz", gray="1", white="2", plane=plane)
    for elements in (1.5, 2, 2.3):
        body = outline(section, size=T / elements, smooth=smooth)
        assert angles(body.mesh.p, body.mesh.t).min() >= 20


@needed
def test_units_that_do_not_agree_are_refused_at_once():
    pial = loops(HUMAN[1], "pial")
    with pytest.raises(ValueError, match="same unit"):
        outline(pial, thickness=2.5, elements=3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(ValueError, match="same unit"):
            outline([1e3 * loop for loop in pial], thickness=2.5e-3, elements=3)
