"""What filling an outline with triangles costs."""

import tracemalloc

import numpy as np

from turingfold.outlines import outline


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
