"""Quadratic triangles that fold over themselves, against the smallest Jacobian on a fine grid."""

import numpy as np
import pytest
from skfem import MeshTri1, MeshTri2

from turingfold.geometry.triangles import folded_over

GRID = np.array([(i, j) for i in range(61) for j in range(61 - i)]).T / 60.0


def one_triangle(offsets):
    """Return a triangle of unit size whose six nodes are moved by offsets (2, 6)."""
    corners = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    straight = MeshTri2.from_mesh(MeshTri1(corners, np.array([[0], [1], [2]])))
    return MeshTri2(straight.doflocs + offsets, straight.t, validate=False, sort_t=False)


def test_a_triangle_is_folded_over_where_its_jacobian_is_not_positive():
    chance = np.random.default_rng(0)
    found = {True: 0, False: 0}
    only_inside = 0
    for _ in range(600):
        mesh = one_triangle(chance.normal(scale=0.17, size=(2, 6)))
        jacobian = mesh.mapping().detDF(GRID)[0]
        if abs(jacobian.min()) < 2e-3:  # the grid cannot tell
            continue
        folded = bool(jacobian.min() <= 0)
        assert folded_over(mesh, mesh.doflocs).size == folded
        found[folded] += 1
        at_nodes = mesh.mapping().detDF(np.array([[0, 1, 0, 0.5, 0.5, 0], [0, 0, 1, 0, 0.5, 0.5]]))[0]
        only_inside += folded and at_nodes.min() > 0
    assert min(found.values()) > 100
    assert only_inside > 3  # six samples would have passed them


@pytest.mark.parametrize("fraction", [0.26, 0.24])
def test_a_middle_node_may_come_as_near_to_a_corner_as_a_quarter_of_the_edge(fraction):
    mesh = one_triangle(np.zeros((2, 6)))
    nodes = mesh.doflocs.copy()
    bottom = int(np.flatnonzero((nodes == [[0.5], [0.0]]).all(0))[0])
    nodes[0, bottom] = fraction
    assert folded_over(mesh, nodes).size == (fraction < 0.25)
