"""Loads too small for a residual relative to the moduli are followed all the same."""

import numpy as np
import pytest
from small import elastic_scene

from turingfold import Stepping, TangentialGrowth, simulate
from turingfold.errors import NotConvergedError
from turingfold.solve.inertia import Indefinite
from turingfold.solve.sparsity import Sparsity


def displacement(excess):
    growth = TangentialGrowth(cortex=1.0 + excess)
    scene = elastic_scene(growth, stepping=Stepping(first=0.25, largest=0.25))
    return simulate(scene).last["displacement"]


@pytest.mark.parametrize("excess", [1e-7, 1e-9, 1e-11])
def test_a_small_growth_moves_the_body_in_proportion(excess):
    # linear elasticity: displacement per growth is that of a growth ten times as small as would bend the line
    line = (displacement(1e-4) - displacement(-1e-4)) / 2e-4
    found = displacement(excess) / excess
    assert np.abs(found - line).max() < 1e-3 * np.abs(line).max()


def test_a_pivot_that_vanishes_by_chance_does_not_stop_a_factorisation():
    # eigenvalues of [[0, 1], [1, 0]] are ±1 and its first pivot is 0; beside it a block with one negative one
    matrix = np.array([[0.0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 2, 3], [0, 0, 3, 2]])
    columns, rows = np.nonzero(np.triu(matrix + np.eye(4)))
    sparsity = Sparsity(4, columns.astype(np.int64) * 4 + rows)
    factors = Indefinite(sparsity).factorize(matrix[rows, columns])
    assert factors.negative == 2
    b = np.arange(1.0, 5.0)
    x = factors.solve(b)
    x += factors.solve(b - matrix @ x)  # as its users do
    np.testing.assert_allclose(matrix @ x, b, atol=1e-10)


def test_a_singular_matrix_is_still_refused():
    columns, rows = np.nonzero(np.triu(np.ones((2, 2))))
    sparsity = Sparsity(2, columns.astype(np.int64) * 2 + rows)
    with pytest.raises(NotConvergedError):
        Indefinite(sparsity).factorize(np.zeros(3))
