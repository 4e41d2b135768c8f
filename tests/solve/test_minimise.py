"""Newton's method: minima of known potentials, unstable starts, step bounds, and every way to fail."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from checks import message_names

from turingfold.errors import NotConvergedError
from turingfold.geometry.shapes import semicircle
from turingfold.growth.laws import TangentialGrowth
from turingfold.parts import Entries, Hessian, TimeStep
from turingfold.solve.newton import Minimiser
from turingfold.state import State
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic
from turingfold.testing import advanced

ENTRIES = Entries(np.array([0, 1, 1]), np.array([0, 0, 1]))


@dataclass
class Surface:
    """A potential of two unknowns from functions for its energy, slope and curvature (2, 2)."""

    energy: object
    slope: object
    curvature: object
    bound: float = 1.0
    visits: list = field(default_factory=list)

    def evaluate(self, x):
        self.visits.append(x.copy())
        energy = self.energy(*x)
        return None if energy is None else _Point(self, x, energy)


@dataclass
class _Point:
    surface: Surface
    x: np.ndarray
    energy: float
    has_hessian = True
    round_off = 1e-15

    def gradient(self):
        slope = np.array(self.surface.slope(*self.x), dtype=float)
        return slope, 1.0

    def hessian(self, convexity):
        H = np.array(self.surface.curvature(*self.x), dtype=float)
        values, vectors = np.linalg.eigh(H)
        values = values - convexity * np.minimum(values, 0.0) + 1e-9 * convexity
        H = vectors @ np.diag(values) @ vectors.T
        return Hessian(ENTRIES, np.array([H[0, 0], H[1, 0], H[1, 1]]))

    def largest_step(self, direction):
        return self.surface.bound


def bowl(**options):
    """E = 3x² + xy + 2y² - x, minimum at (4, -1)/23."""
    return Surface(
        lambda x, y: 3 * x**2 + x * y + 2 * y**2 - x,
        lambda x, y: (6 * x + y - 1, x + 4 * y),
        lambda x, y: ((6.0, 1.0), (1.0, 4.0)),
        **options,
    )


def two_wells():
    """E = x⁴/4 - x²/2 + y²: minima at (±1, 0), a saddle at the origin."""
    return Surface(
        lambda x, y: x**4 / 4 - x**2 / 2 + y**2,
        lambda x, y: (x**3 - x, 2 * y),
        lambda x, y: ((3 * x**2 - 1, 0.0), (0.0, 2.0)),
    )


def valley():
    """Rosenbrock's function, minimum at (1, 1)."""
    return Surface(
        lambda x, y: (1 - x) ** 2 + 100 * (y - x**2) ** 2,
        lambda x, y: (-2 * (1 - x) - 400 * x * (y - x**2), 200 * (y - x**2)),
        lambda x, y: ((2 - 400 * y + 1200 * x**2, -400 * x), (-400 * x, 200.0)),
    )


def minimiser(fixed=(), iterations=60, tolerance=1e-10):
    return Minimiser(2, np.array(fixed, dtype=np.int64), tolerance, iterations)


def test_a_quadratic_takes_one_iteration():
    solver = minimiser()
    found = solver.minimise([bowl()], np.array([5.0, -3.0]))
    np.testing.assert_allclose(found.x, (4 / 23, -1 / 23), atol=1e-14)
    assert solver.effort.iterations == 1
    assert found.stable
    assert found.residual <= 1e-10
    assert found.energy == pytest.approx(-2 / 23, rel=1e-12)  # half of -x at the minimum


def test_potentials_add_up():
    found = minimiser().minimise([bowl(), bowl(), two_wells()], np.array([0.5, 0.1]))
    x, y = found.x
    assert 2 * (6 * x + y - 1) + x**3 - x == pytest.approx(0.0, abs=1e-9)
    assert 2 * (x + 4 * y) + 2 * y == pytest.approx(0.0, abs=1e-9)


def test_fixed_unknowns_stay_where_they_start():
    found = minimiser(fixed=[1]).minimise([bowl()], np.array([5.0, -3.0]))
    assert found.x[1] == -3.0
    assert found.x[0] == pytest.approx((1 + 3) / 6, rel=1e-14)


@pytest.mark.parametrize("start", [(0.1, 0.5), (-0.01, 0.0), (0.55, 2.0)])
def test_an_indefinite_start_goes_down_to_a_minimum(start):
    found = minimiser().minimise([two_wells()], np.array(start))
    np.testing.assert_allclose(found.x, (np.sign(start[0]), 0.0), atol=1e-9)
    assert found.stable
    assert found.energy == pytest.approx(-0.25, rel=1e-12)


def test_a_saddle_is_reported_as_unstable():
    found = minimiser().minimise([two_wells()], np.array([0.0, 0.5]))
    np.testing.assert_allclose(found.x, 0.0, atol=1e-9)
    assert found.negative_pivots == 1


def test_the_energy_never_rises_along_a_curved_valley():
    surface, solver = valley(), minimiser()
    energies = []
    found = solver.minimise([surface], np.array([-1.2, 1.0]))
    for x in surface.visits:
        energies.append(surface.energy(*x))
    np.testing.assert_allclose(found.x, 1.0, atol=1e-9)
    # trials may be refused, but the accepted ones, each the lowest so far, end at the minimum
    assert energies[-1] == min(energies) < 1e-18
    assert solver.effort.iterations < 40


def test_newton_converges_quadratically():
    # from x = 1 + e the next error is (3/2) e²
    for start in (1.1, 1.01):
        with pytest.raises(NotConvergedError) as failure:
            minimiser(iterations=1, tolerance=1e-12).minimise([two_wells()], np.array([start, 0.0]))
        expected = 2 * 1.5 * (start - 1) ** 2  # the slope is twice the error
        assert failure.value.residual == pytest.approx(expected, rel=0.2)


def test_a_step_bound_is_kept():
    surface = bowl(bound=0.25)
    solver = minimiser(iterations=100)
    found = solver.minimise([surface], np.array([5.0, -3.0]))
    first = surface.visits[1] - np.array([5.0, -3.0])
    np.testing.assert_allclose(first, 0.25 * (np.array([4, -1]) / 23 - np.array([5.0, -3.0])), rtol=1e-12)
    np.testing.assert_allclose(found.x, (4 / 23, -1 / 23), atol=1e-9)


def test_what_is_not_admissible_is_stepped_back_from():
    # the full step leads to x = 4/23, but beyond x = 1 there is nothing until the next iteration
    def energy(x, y):
        return None if x < 2 * 4 / 23 and y < -0.5 else 3 * x**2 + x * y + 2 * y**2 - x

    surface = bowl()
    surface.energy = energy
    found = minimiser().minimise([surface], np.array([5.0, -3.0]))
    np.testing.assert_allclose(found.x, (4 / 23, -1 / 23), atol=1e-9)


def test_an_inadmissible_start_is_an_error():
    surface = bowl()
    surface.energy = lambda x, y: None
    with pytest.raises(NotConvergedError, match="not admissible"):
        minimiser().minimise([surface], np.zeros(2))


def test_too_few_iterations_are_an_error():
    with pytest.raises(NotConvergedError) as failure:
        minimiser(iterations=2).minimise([valley()], np.array([-1.2, 1.0]))
    message_names(failure.value, "2 Newton iterations")
    assert failure.value.residual > 1e-3


def test_forces_that_are_not_finite_are_an_error():
    surface = bowl()
    surface.slope = lambda x, y: (np.nan, 0.0)
    with pytest.raises(NotConvergedError, match="not finite"):
        minimiser().minimise([surface], np.zeros(2))


def test_an_energy_that_is_not_finite_counts_as_inadmissible():
    surface = bowl()
    surface.energy = lambda x, y: np.nan
    with pytest.raises(NotConvergedError, match="not admissible"):
        minimiser().minimise([surface], np.zeros(2))


def test_a_slope_that_belongs_to_another_energy_is_an_error():
    # the direction leads down by the slope, but the energy only rises
    surface = bowl()
    surface.slope = lambda x, y: (-6 * x - y + 1, -x - 4 * y)
    with pytest.raises(NotConvergedError, match="lowers the energy"):
        minimiser().minimise([surface], np.array([5.0, -3.0]))


def test_an_energy_without_lower_bound_is_an_error():
    surface = Surface(
        lambda x, y: -x - x**2 + y**2,
        lambda x, y: (-1 - 2 * x, 2 * y),
        lambda x, y: ((-2.0, 0.0), (0.0, 2.0)),
    )
    with pytest.raises(NotConvergedError, match="5 Newton iterations"):
        minimiser(iterations=5).minimise([surface], np.array([0.0, 1.0]))


def test_the_memory_of_one_minimiser_goes_on_in_another():
    one = minimiser()
    one.minimise([two_wells()], np.array([0.1, 0.5]))
    memory = one.memory
    assert memory.convexity == 0
    other = Minimiser(2, np.zeros(0, dtype=np.int64), 1e-10, 60, memory)
    assert other.memory.point is None
    other.remember([two_wells()], memory.point)
    assert np.array_equal(other.memory.point, memory.point)
    assert memory.point == pytest.approx([1.0, 0.0], abs=1e-3)


def test_a_grown_body_reaches_the_tolerance_and_is_certified():
    body = semicircle(radius=1.0, thickness=0.3, size=0.15, base="roller")
    state = State(0.0, {"displacement": np.zeros_like(body.nodes)})
    state = state.updated(**advanced(TangentialGrowth(cortex=1.5), body, state, 1.0))
    potential = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)).on(body).during(state, TimeStep(1.0))
    solver = Minimiser(2 * body.nodes.shape[1], body.fixed, 1e-9, 60)
    start = np.zeros(2 * body.nodes.shape[1])
    found = solver.minimise([potential], start)
    assert found.residual <= 1e-9
    assert found.stable
    assert found.energy < potential.evaluate(start).energy
    assert not found.x[body.fixed].any()
    # all fields of the body are free to move away: the minimum is one in random directions
    rng = np.random.default_rng(0)
    for _ in range(5):
        d = rng.standard_normal(len(start))
        d[body.fixed] = 0.0
        assert potential.evaluate(found.x + 1e-4 * d).energy > found.energy


def hardening(load):
    """E = x² + x⁴/4 + y² - load x."""
    return Surface(
        lambda x, y: x**2 + x**4 / 4 + y**2 - load * x,
        lambda x, y: (2 * x + x**3 - load, 2 * y),
        lambda x, y: ((2 + 3 * x**2, 0.0), (0.0, 2.0)),
    )


def place(load):
    """Where hardening(load) is at rest."""
    return np.array([np.roots([1, 0, 2, -load]).real[-1], 0.0])


def test_a_good_guess_is_factorised_at_once_and_speaks_for_the_equilibrium():
    solver = minimiser()
    x = solver.minimise([hardening(1.0)], np.zeros(2)).x
    x = solver.minimise([hardening(1.1)], x, place(1.1 + 1e-5)).x  # misses by 1e-4 of the way
    assert solver.memory.missed == pytest.approx(1e-4, rel=0.1)
    before, surface = solver.effort.factorizations, hardening(1.2)
    found = solver.minimise([surface], x, place(1.2 + 1e-5))
    assert found.stable
    assert found.residual <= 1e-10
    assert solver.effort.factorizations == before + 1
    assert np.array_equal(solver.memory.point, place(1.2 + 1e-5))


def test_a_guess_that_misses_after_a_good_one_is_certified_anew():
    solver = minimiser()
    x = solver.minimise([hardening(1.0)], np.zeros(2)).x
    x = solver.minimise([hardening(1.1)], x, place(1.1 + 1e-5)).x
    before = solver.effort.factorizations
    found = solver.minimise([hardening(1.2)], x, place(1.25))
    assert found.x == pytest.approx(place(1.2), abs=1e-9)
    assert solver.effort.factorizations > before + 1
    assert solver.memory.missed == pytest.approx(0.5, rel=0.05)
    assert solver.memory.point == pytest.approx(found.x, abs=1e-9)


def test_a_worse_guess_than_the_start_is_left_also_after_a_good_one():
    solver = minimiser()
    x = solver.minimise([hardening(1.0)], np.zeros(2)).x
    x = solver.minimise([hardening(1.1)], x, place(1.1 + 1e-5)).x
    found = solver.minimise([hardening(1.1)], x, np.array([3.0, 0.0]))  # nothing changed
    assert np.array_equal(found.x, x)


def test_a_guess_that_is_not_admissible_is_left():
    solver = minimiser()
    x = solver.minimise([hardening(1.0)], np.zeros(2)).x
    x = solver.minimise([hardening(1.1)], x, place(1.1 + 1e-5)).x
    surface = hardening(1.2)
    energy, surface.energy = surface.energy, lambda x, y: None if x > 0.6 else energy(x, y)
    assert solver.minimise([surface], x, np.array([0.7, 0.0])).x == pytest.approx(place(1.2), abs=1e-9)
