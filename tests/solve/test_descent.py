"""Directions where the tangent is not positive definite: what conjugate gradients make of it."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from test_extreme import cleft_between_three_lobes
from test_minimise import Surface, _Point, minimiser, two_wells

from turingfold.parts import Abrupt
from turingfold.results.simulate import simulate
from turingfold.solve.descent import DOUBLINGS, MOST, descent, lengthened
from turingfold.solve.problem import configuration


def matrix(values, seed=0):
    """Return a symmetric matrix with these eigenvalues, and its eigenvectors in columns."""
    vectors = np.linalg.qr(np.random.default_rng(seed).standard_normal(2 * (len(values),)))[0]
    return vectors @ np.diag(values) @ vectors.T, vectors


def test_a_positive_definite_tangent_gives_newtons_direction():
    K, _ = matrix([1.0, 2.0, 5.0, 5.0, 9.0, 20.0])
    force = np.random.default_rng(1).standard_normal(6)
    found = descent(lambda r: r, lambda d: K @ d, force, residual=1e-20)
    assert found.direction == pytest.approx(np.linalg.solve(K, force), rel=1e-8)
    assert (found.iterations, found.curved) == (5, False)  # as many as there are different eigenvalues


def test_a_good_preconditioner_needs_one_iteration():
    K, _ = matrix(np.linspace(1.0, 1e3, 40))
    force = np.ones(40)
    found = descent(lambda r: np.linalg.solve(K, r), lambda d: K @ d, force, residual=1e-3)
    assert found.direction == pytest.approx(np.linalg.solve(K, force))
    assert found.iterations == 1


def test_iterations_far_from_the_equilibrium_are_few_and_never_without_end():
    K, _ = matrix(np.geomspace(1.0, 30.0, 200))
    force = np.ones(200)
    near, far = (descent(lambda r: r, lambda d: K @ d, force, residual=size) for size in (1e-12, 1.0))
    assert far.iterations < near.iterations == MOST
    assert force @ near.direction > 0 < force @ far.direction


@pytest.mark.parametrize(("curvature", "down", "beside"), [
    (-2.0, 0.828261, 1.260870), (-1e-6, 3.312, 1.04), (1e-6, 3.312, 1.04),
])  # fmt: skip
def test_along_negative_or_no_curvature_the_step_has_a_length_and_goes_down(curvature, down, beside):
    """With the convex K̃, 1 in place of the lowest eigenvalue: the way to the saddle would be up.

    Two steps by hand, c the curvature and q = (1, -1, 0.5), q² = 2.25: f = (0.3, q), α = 2.34/(2.25 +
    0.09 c); r = f - α K f, β = r²/2.34, d = r + β f; the end is α f + r²/max(|d K d|, d²/10) d, here along
    the lowest mode and beside it, in q.
    """
    K, vectors = matrix([curvature, 1.0, 1.0, 1.0])
    force = vectors @ np.array([0.3, 1.0, -1.0, 0.5])
    found = descent(lambda r: r, lambda d: K @ d, force, residual=1e-12)
    assert (found.iterations, found.curved) == (2, True)
    assert force @ found.direction > 0
    along = vectors.T @ found.direction
    assert along == pytest.approx([down, beside, -beside, 0.5 * beside], rel=1e-4)


def onward(surface, start, end):
    """Return where the step between two x of a surface is lengthened to, at y = 0."""
    at, there = (configuration((surface,), np.array([x, 0.0])) for x in (start, end))
    return lengthened(at, there).x[0]


def test_a_step_is_doubled_as_long_as_the_energy_falls():
    """E = x⁴/4 - x²/2: from 0.05 on by 0.05, 0.1, 0.2, 0.4 and 0.8 it falls, at 1.65 it is 0.49."""
    assert onward(two_wells(), 0.05, 0.1) == pytest.approx(0.85)
    assert onward(two_wells(), 0.05, 1.0) == 1.0  # the minimum
    assert onward(two_wells(), 0.05, 0.7) == 0.7  # 1.35 is lower than the start, but higher than 0.7


def test_a_step_is_doubled_no_farther_than_is_admissible():
    tight = two_wells()
    tight.bound = 0.99
    assert onward(tight, 0.05, 0.1) == 0.1
    well = two_wells()
    ends = replace(well, energy=lambda x, y: well.energy(x, y) if x < 0.5 else None)
    assert onward(ends, 0.05, 0.1) == pytest.approx(0.45)


def test_a_step_down_without_end_is_doubled_a_few_times():
    slope = Surface(lambda x, y: -x, lambda x, y: (-1.0, 0.0), lambda x, y: ((0.0, 0.0), (0.0, 0.0)))
    assert onward(slope, 0.0, 1.0) == 2.0**DOUBLINGS


@dataclass
class Asked(Surface):
    """A surface that notes the convexities it is asked for; one that is a wall's, or not."""

    kind: type = _Point
    asked: list = field(default_factory=list)

    def evaluate(self, x):
        return self.kind(self, x, self.energy(*x))


class Solid(_Point):
    """The surface at a point."""

    def hessian(self, convexity):
        self.surface.asked.append(convexity)
        return super().hessian(convexity)


class Wall(Solid, Abrupt):
    """The surface of a wall at a point."""


def test_walls_are_made_convex_before_the_solid_is():
    """E = 2x² + 2y² of the solid and x⁴ - 3x² of the wall: a saddle at 0, minima at x = ±1/√2."""
    solid = Asked(
        lambda x, y: 2 * x * x + 2 * y * y, lambda x, y: (4 * x, 4 * y),
        lambda x, y: ((4.0, 0.0), (0.0, 4.0)), kind=Solid,
    )  # fmt: skip
    wall = Asked(
        lambda x, y: x**4 - 3 * x * x, lambda x, y: (4 * x**3 - 6 * x, 0.0),
        lambda x, y: ((12 * x * x - 6, 0.0), (0.0, 0.0)), kind=Wall,
    )  # fmt: skip
    found = minimiser().minimise([solid, wall], np.array([0.05, 0.5]))
    assert found.x == pytest.approx([np.sqrt(0.5), 0.0], abs=1e-9)
    assert found.stable
    assert set(wall.asked) == {0.0, 1.0}
    assert set(solid.asked) == {0.0}


@pytest.mark.filterwarnings("ignore::turingfold.HoldingForceWarning")  # the skull pushes
def test_walls_that_slide_cost_no_second_factorisation():
    """Three lobes pressed together: 304 factorisations for 248 iterations when each was tried anew."""
    scene, _ = cleft_between_three_lobes(1.25)
    result = simulate(scene)
    told = result.summary()
    assert told["min_gap"] > 0 == told["self_intersections"]
    assert told["factorizations"] < told["newton_iterations"]
