"""Points in polygons and segments that meet, also where there are very many."""

import tracemalloc

import numpy as np
import pytest

from turingfold.geometry.polygon import enclosed, inside, intersections


def circle(count, radius=1.0):
    """Return the segments of a circle, shuffled: (2, 2, count)."""
    angle = 2 * np.pi * np.arange(count) / count
    loop = radius * np.stack([np.cos(angle), np.sin(angle)])
    order = np.random.default_rng(0).permutation(count)
    return np.stack([loop, np.roll(loop, -1, axis=1)])[:, :, order]


def peak(function, *arguments):
    """Return what a function returns, and the memory it takes meanwhile, in MB."""
    tracemalloc.start()
    try:
        return function(*arguments), tracemalloc.get_traced_memory()[1] / 1e6
    finally:
        tracemalloc.stop()


def test_many_points_in_a_dense_curve_take_little_memory():
    rng = np.random.default_rng(1)
    radius, angle = rng.uniform(0.0, 2.0, 400), rng.uniform(0.0, 2 * np.pi, 400)
    found, memory = peak(enclosed, radius * np.stack([np.cos(angle), np.sin(angle)]), circle(100_000))
    assert np.array_equal(found, radius < 1)  # none is within 1e-9 of the circle
    assert memory < 100  # 4e7 pairs of doubles are 320 MB


def test_many_segments_that_meet_take_little_memory():
    rays = np.linspace(0.1, 1.4, 100)
    outward = np.stack([np.cos(rays), np.sin(rays)]) * np.array([0.5, 1.5])[:, None, None]
    (i, _, s, _), memory = peak(intersections, outward, circle(100_000))
    assert np.array_equal(np.sort(i), np.arange(100))
    assert s == pytest.approx(np.full(100, 0.5), abs=1e-9)
    assert memory < 300  # 1e7 pairs at once take 560 MB


@pytest.mark.parametrize("reverse", [False, True])
def test_levels_of_corners_and_edges_are_crossed_once(reverse):
    # at y = 0 and 1 rays pass corners, at y = 0.5 they run along a level edge
    loop = np.array([[0.0, 2.0, 2.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0, 0.5, 0.5]])
    loop = loop[:, ::-1] if reverse else loop
    within = np.array([[0.5, 1.5, 1.5], [0.25, 0.25, 0.5]])
    beyond = np.array([[0.5, -1.0, -1.0, -1.0, 3.0], [0.75, 0.5, 0.0, 1.0, 0.5]])
    assert inside(within, loop).all()
    assert not inside(beyond, loop).any()


def test_no_points_and_no_segments():
    assert enclosed(np.zeros((2, 0)), circle(5)).shape == (0,)
    assert enclosed(np.zeros((2, 3)), np.zeros((2, 2, 0))).tolist() == [False] * 3
