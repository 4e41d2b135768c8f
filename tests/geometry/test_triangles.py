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


def test_a_triangle_with_a_bubble_is_folded_over_where_the_bubble_turns_it():
    """Against the determinant of the deformation, by differences of places on a fine grid."""
    chance, step, found, by_bubble = np.random.default_rng(1), 1e-6, {True: 0, False: 0}, 0

    def places(mesh, bubble, x, y):
        return mesh.mapping().F(np.stack([x, y]))[:, 0] + 27 * x * y * (1 - x - y) * bubble

    for _ in range(400):
        mesh = one_triangle(chance.normal(scale=0.1, size=(2, 6)))
        bubble = chance.normal(scale=0.1, size=(2, 1))
        x, y = GRID
        u = (places(mesh, bubble, x + step, y) - places(mesh, bubble, x - step, y)) / (2 * step)
        v = (places(mesh, bubble, x, y + step) - places(mesh, bubble, x, y - step)) / (2 * step)
        least = (u[0] * v[1] - u[1] * v[0]).min()
        if abs(least) < 5e-3:  # the grid cannot tell
            continue
        folded = bool(least < 0)
        assert folded_over(mesh, mesh.doflocs, bubble).size == folded
        found[folded] += 1
        by_bubble += folded and not folded_over(mesh, mesh.doflocs).size
    assert min(found.values()) > 80
    assert by_bubble > 30
