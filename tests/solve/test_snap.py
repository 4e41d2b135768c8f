"""Snaps: the gradient flow ends at a minimum of less energy, from beyond a limit point and from a saddle."""

import numpy as np
import pytest
from scipy.sparse import eye_array
from test_minimise import two_wells

from turingfold.solve.newton import Minimiser
from turingfold.solve.snap import Creep
from turingfold.terms.quadratic_energy import SymmetricMatrix


def flow(start):
    minimiser = Minimiser(2, np.zeros(0, dtype=np.int64), 1e-10, 60)
    creep = Creep(SymmetricMatrix.of(eye_array(2)), 1.0, 1.0)
    return creep.to_minimum(minimiser, (two_wells(),), np.array(start))


@pytest.mark.parametrize("start", [(0.0, 0.5), (0.0, 0.0), (0.3, -1.0), (3.0, 2.0)])
def test_the_flow_ends_at_a_minimum(start):
    # E = x⁴/4 - x²/2 + y²: minima at (±1, 0) of energy -1/4; on x = 0 every force points to the saddle
    found = flow(start)
    assert found.stable
    assert abs(found.x[0]) == pytest.approx(1.0, abs=1e-9)
    assert found.x[1] == pytest.approx(0.0, abs=1e-9)
    assert found.energy == pytest.approx(-0.25, rel=1e-12)


def test_the_flow_stays_in_the_valley_it_starts_in():
    # E falls along the flow, so from x < 0 it cannot cross the ridge x = 0
    found = flow([-0.05, 3.0])
    assert found.x[0] == pytest.approx(-1.0, abs=1e-9)
