"""The closing by a disc: exact on slots, bent strips and arcs; the index that follows from it."""

import numpy as np
import pytest
from morphometry_shapes import banana, comb, ellipse, moved, mushrooms

from turingfold.morphometry.closing import morphological_closing
from turingfold.morphometry.folds import find_folds, fold_count
from turingfold.morphometry.polyline import perimeter
from turingfold.morphometry.shape import gyrification_index


@pytest.mark.parametrize(
    ("radius", "arc"),
    [
        (0.01, 2 * np.pi),
        (0.9, 2 * np.pi),
        (0.01, np.pi),
        (0.9, np.pi),
        (0.02, 5 * np.pi / 3),
    ],
)
@pytest.mark.parametrize("step", [1, -1])
def test_a_convex_body_is_its_own_closing(radius, arc, step):
    points = ellipse(1, 1, 901, arc)[:, ::step]
    assert gyrification_index(points, closing=radius) == pytest.approx(1, abs=1e-4)


def test_a_disc_wider_than_a_slot_bridges_it_by_its_own_arc():
    """Through the mouth, w wide, bulges an arc of the disc: 2 r asin(w / 2r) long."""
    fingers, width, slot, depth, radius = 5, 0.3, 0.1, 0.8, 0.07
    hull = 2 * (fingers * width + (fingers - 1) * slot + depth + 1.0)
    outer = hull + (fingers - 1) * (2 * radius * np.arcsin(slot / (2 * radius)) - slot)
    length = hull + (fingers - 1) * 2 * depth
    found = gyrification_index(comb(fingers, width, slot, depth), closing=radius)
    assert found == pytest.approx(length / outer, rel=1e-4)


def test_a_disc_narrower_than_a_slot_rounds_its_floor():
    """In each of the floor's two corners a quarter of the disc's circle stands for two radii."""
    radius, slot, depth = 0.04, 0.1, 0.8
    points = comb(5, 0.3, slot, depth)
    outer = perimeter(points) - 4 * 2 * (2 - np.pi / 2) * radius
    assert gyrification_index(points, closing=radius) == pytest.approx(perimeter(points) / outer, rel=1e-4)


@pytest.mark.parametrize("radius", [0.5, 1.9])
def test_a_bent_strip_without_folds_has_index_one_against_its_closing(radius):
    points = banana(3.0, 1.0)
    closing = morphological_closing(points, radius)
    length = np.pi * (4 + 2) + 2 * np.pi  # outer and inner half circle, two round ends
    hull = np.pi * 4 + np.pi + 6  # outer half circle, a quarter of each end, the straight way between them
    assert gyrification_index(points) == pytest.approx(length / hull, rel=1e-3)
    assert gyrification_index(points, closing=radius) == pytest.approx(1, abs=2e-3)
    assert fold_count(points) == 1
    assert fold_count(points, reference=closing) == 0


def test_folds_on_a_bent_strip_are_counted_against_its_closing():
    """12 sulci on the outer and 12 on the inner side of a bent strip; the hull hides the inner ones."""
    base = banana(3.0, 1.0, step=0.005)
    radius, turn = np.hypot(*base), np.arctan2(base[1], base[0])
    along = (np.minimum(np.abs(radius - 2), np.abs(radius - 4)) < 1e-6) & (turn > 0)
    share = (turn - np.pi / 2 + 1.3) / 2.6  # sulci 0.3 deep from 0 to 1, none near the ends of the strip
    swing = np.where(along & (share > 0) & (share < 1), 0.3 * np.sin(12 * np.pi * share) ** 2, 0.0)
    outwards = np.where(radius > 3, 1, -1) * base / radius
    points = base - outwards * swing
    closing = morphological_closing(points, 1.5)
    assert find_folds(points, reference=closing, prominence=0.1).count == 24


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi])
@pytest.mark.parametrize("scale", [1e-3, 40.0])
def test_closing_is_invariant(arc, scale):
    points = mushrooms(12, 0.15, arc=arc)
    other = moved(points, 1.0, scale, (3.0, -2.0))[:, ::-1]
    found = gyrification_index(points, closing=0.2)
    assert gyrification_index(other, closing=0.2 * scale) == pytest.approx(found, rel=1e-6)
    assert found > 1.5


def test_a_disc_larger_than_the_body_is_refused():
    with pytest.raises(ValueError, match=r"radius=1\.5 must be positive and at most 0\.99.*convex hull"):
        gyrification_index(ellipse(1, 1, 100), closing=1.5)
    with pytest.raises(ValueError, match="give one of them"):
        gyrification_index(ellipse(1, 1), closing=0.1, initial=ellipse(1, 1))
