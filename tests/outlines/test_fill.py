"""Filling an outline with triangles: what it costs, and what is said where it cannot be done."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import shapely

from turingfold.outlines import outline
from turingfold.outlines.domain import Given, Thickness, domain
from turingfold.outlines.mesh import meshed


def test_memory_is_that_of_the_triangles_and_not_of_all_pairs_of_points():
    """All pairs of points within the largest edge, as once asked for, took 5500 bytes a triangle here."""
    at = 2 * np.pi * np.arange(160) / 160
    points = np.stack([0.03 * np.cos(at), 0.022 * np.sin(at)])
    tracemalloc.start()
    try:
        body = outline(points, thickness=2.5e-3, elements=10)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 3e3 * body.mesh.nelements  # bytes


def test_lines_that_cross_are_named_with_their_place():
    """Two holes 0.5 wide that cross at (±0.1, 0), in units of 2 m around (3, 4)."""
    at = 2 * np.pi * np.arange(160) / 160
    circle = np.stack([np.cos(at), np.sin(at)])
    made, _ = domain(Given([circle], [], None, []), Thickness(0.1, None), 0.05, 0.0125, 0.0, unit=2.0)
    discs = [shapely.Point(0, y).buffer(0.25, quad_segs=32) for y in (-0.23, 0.23)]
    crossing = replace(made, holes=shapely.MultiPolygon(discs))
    with pytest.raises(ValueError, match=r"cannot keep \d+ edges of holes, first near .* m, where") as told:
        meshed(crossing, lambda x: np.full(x.shape[1], 0.05), 0.35, np.array([[3.0], [4.0]]), 2.0)
    x, y = np.array(str(told.value).split("(")[1].split(")")[0].split(","), dtype=float)
    assert abs(x - 3.0) < 0.35
    assert y == pytest.approx(4.0, abs=0.1)
