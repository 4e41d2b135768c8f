"""Snaps: the gradient flow ends at a minimum of less energy, from beyond a limit point and from a saddle."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import eye_array
from small import GRAY, elastic_scene
from test_minimise import two_wells

from turingfold import Elastic
from turingfold.parts import TimeStep
from turingfold.solve.newton import Minimiser
from turingfold.solve.problem import Problem
from turingfold.solve.snap import Creep
from turingfold.terms.dynamics import mass
from turingfold.terms.quadratic_energy import SymmetricMatrix
from turingfold.testing import dense


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


@pytest.mark.parametrize("scale", [1e-3, 1e-6])
def test_too_little_viscosity_at_first_finds_the_way_from_a_saddle_all_the_same(scale):
    minimiser = Minimiser(2, np.zeros(0, dtype=np.int64), 1e-10, 60)
    creep = Creep(SymmetricMatrix.of(eye_array(2)), scale, 1.0)
    assert creep.to_minimum(minimiser, (two_wells(),), np.zeros(2)).energy == pytest.approx(-0.25, rel=1e-12)


def test_the_flow_stays_in_the_valley_it_starts_in():
    # E falls along the flow, so from x < 0 it cannot cross the ridge x = 0
    found = flow([-0.05, 3.0])
    assert found.x[0] == pytest.approx(-1.0, abs=1e-9)


@pytest.mark.parametrize("element", ["quadratic", "mixed"])
def test_the_softest_mode_is_the_lowest_eigenvector_of_tangent_and_mass(element):
    scene = elastic_scene()
    scene = replace(scene, terms=(Elastic(gray=GRAY, element=element),))
    problem = Problem(scene)
    state = problem.processed(problem.start(), 0.5)
    potentials = problem.potentials(state, TimeStep(0.5))
    minimiser = Minimiser(problem.n_dofs, problem.held, 1e-10, 60)
    found = minimiser.minimise(potentials, np.zeros(problem.n_dofs))
    M = mass(scene.body, 1.0).whole
    free = np.setdiff1d(np.arange(problem.n_dofs), problem.held)
    K = dense(found.at.hessians(0.0)[0], problem.n_dofs)[np.ix_(free, free)]
    values, vectors = eigh(K, M.toarray()[np.ix_(free, free)])
    mode = minimiser.softest_mode(M, 40)
    assert values[1] > 1.2 * values[0]
    exact = vectors[:, 0] / np.abs(vectors[:, 0]).max()
    assert min(np.abs(mode[free] - exact).max(), np.abs(mode[free] + exact).max()) < 1e-2
    assert not mode[problem.held].any()
