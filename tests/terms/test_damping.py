"""Damping proportional to stiffness: exact decay of vibrations, energy, momentum, what it does not resist."""

from dataclasses import dataclass

import numpy as np
import pytest
from checks import message_names
from scipy.linalg import eigh

from turingfold.cli.main import main
from turingfold.geometry.shapes import semicircle
from turingfold.growth.laws import TangentialGrowth
from turingfold.parts import Evolution, Process, TimeStep
from turingfold.scene import Scene
from turingfold.solve import newton
from turingfold.solve.march import Progress, begin, march
from turingfold.state import State
from turingfold.stepping import Stepping
from turingfold.terms.damping import StiffnessDamping
from turingfold.terms.dynamics import Drag, Inertia, mass
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic
from turingfold.testing import check_balanced, check_derivatives, check_semidefinite, dense

GRAY = NeoHookean(mu=1.0, kappa=5.0)
STEP = TimeStep(0.1)
SOLID = Elastic(gray=GRAY)
SMALL = 1e-5  # amplitude of a vibration: it is linear to this share


@dataclass(frozen=True)
class Softening(Process):
    """A stiffness that falls from 1 to 1/2, more at some points than at others."""

    writes = ("modulus_factor",)

    def on(self, body):
        return SofteningOnBody(body.quadrature.points[1] > 0.5)


@dataclass(frozen=True)
class SofteningOnBody(Evolution):
    upper: np.ndarray

    def start(self, state, seed):
        return self.advance(state, state, 0.0)

    def advance(self, before, now, dt):
        return {"modulus_factor": 1.0 - 0.5 * now.time * self.upper}


def disc(base="free"):
    return semicircle(radius=1.0, thickness=0.3, size=0.3, base=base)


def at_rest(body, *, time=0.2, step=STEP, elastic=SOLID, **fields):
    """Return the potential of a step from rest."""
    state = State(step.length, {"displacement": np.zeros_like(body.nodes), **fields})
    return StiffnessDamping(elastic=elastic, time=time).on(body).during(state, step)


def mode(body, number):
    """Return frequency and shape (2 n_nodes,) of a mode of K₀ φ = ω² M φ, φᵀ M φ = 1."""
    n = body.nodes.size
    free = np.setdiff1d(np.arange(n), body.supported)
    none = State(0.0, {})
    K = dense(SOLID.on(body).during(none, TimeStep(1.0)).evaluate(np.zeros(n)).hessian(0.0), n)
    rest = State(0.0, {"displacement": np.zeros((2, n // 2))})
    potential = Inertia(density=1.0).on(body).during(rest, TimeStep(1.0))
    M = dense(potential.evaluate(np.zeros(n)).hessian(0.0), n)
    values, vectors = eigh(K[np.ix_(free, free)], M[np.ix_(free, free)])
    shape = np.zeros(n)
    shape[free] = vectors[:, number]
    return np.sqrt(values[number]), shape


def marched(body, terms, scheme, dt, steps, *, displacement=None, velocity=None):
    """Return the states after the start of so many equal steps."""
    zero = np.zeros_like(body.nodes)
    stepping = Stepping(first=1 / steps, largest=1 / steps, tolerance=1e-13, scheme=scheme)
    scene = Scene(body=body, terms=terms, until=dt * steps, stepping=stepping)
    start = begin(scene)
    fields = {
        "displacement": zero if displacement is None else displacement,
        "velocity": zero if velocity is None else velocity,
    }
    found = [step for step, _ in march(scene, Progress(start.state.updated(**fields), start.dt))]
    assert len(found) == steps
    return found


def vibration(scheme, base, number, dt, steps, *, alpha=0.0, beta=0.0):
    """Return a mode's frequency and its amplitudes, from 1, while it vibrates freely."""
    body = disc(base)
    omega, shape = mode(body, number)
    terms = [SOLID, Inertia(density=1.0)]
    if alpha:
        terms.append(Drag(coefficient=alpha))
    if beta:
        terms.append(StiffnessDamping(elastic=SOLID, time=beta))
    start = SMALL * shape.reshape(-1, 2).T
    weights = mass(body, 1.0).whole @ shape
    found = marched(body, tuple(terms), scheme, dt / omega, steps, displacement=start)
    return omega, np.array([1.0, *(weights @ step.x / SMALL for step in found)])


def exact(scheme, s, dt, count):
    """Return a scheme's amplitudes for u'' - 2 Re(s) u' + |s|² u = 0 from u = 1, u' = 0.

    The two solutions e^{st} become λⁿ, λ = 1/(1 - s dt) by backward Euler, (1 + s dt/2)/(1 - s dt/2) by the
    midpoint rule: both rules make a first-order system's exact eigenvectors go on as such.
    """
    factor = 1 / (1 - s * dt) if scheme == "euler" else (1 + s * dt / 2) / (1 - s * dt / 2)
    weight = np.conj(s) / (np.conj(s) - s)  # u = a λⁿ + conj, with a + conj = 1 and s a + conj = 0
    return 2 * (weight * factor ** np.arange(count)).real


def root(omega, alpha, beta):
    """Return s = ω (-ζ + i √(1 - ζ²)) with Rayleigh's ratio ζ = (α/ω + β ω)/2."""
    ratio = 0.5 * (alpha / omega + beta * omega)
    assert 0 < ratio < 1
    return omega * complex(-ratio, np.sqrt(1 - ratio**2))


@pytest.mark.parametrize("scheme", ["euler", "midpoint"])
@pytest.mark.parametrize(("base", "number"), [("clamped", 0), ("free", 3)])
def test_a_mode_decays_as_the_scheme_says(scheme, base, number):
    omega, _ = mode(disc(base), number)
    beta, dt = 0.3 / omega, 0.3
    _, found = vibration(scheme, base, number, dt, 12, beta=beta)
    expected = exact(scheme, root(omega, 0.0, beta), dt / omega, 13)
    assert np.abs(found - expected).max() < 10 * SMALL


@pytest.mark.parametrize("scheme", ["euler", "midpoint"])
def test_rayleigh_adds_mass_and_stiffness(scheme):
    omega, _ = mode(disc("clamped"), 0)
    alpha, beta = 0.2 * omega, 0.3 / omega
    _, found = vibration(scheme, "clamped", 0, 0.3, 12, alpha=alpha, beta=beta)
    expected = exact(scheme, root(omega, alpha, beta), 0.3 / omega, 13)
    assert np.abs(found - expected).max() < 10 * SMALL


def test_midpoint_tends_to_the_modal_damping_with_order_two():
    omega, _ = mode(disc("clamped"), 0)
    beta, errors = 0.3 / omega, []
    s = root(omega, 0.0, beta)
    for steps in (8, 16, 32):
        dt = 4.0 / steps
        _, found = vibration("midpoint", "clamped", 0, dt, steps, beta=beta)
        times = np.arange(steps + 1) * dt / omega
        true = np.exp(s.real * times) * (np.cos(s.imag * times) - s.real / s.imag * np.sin(s.imag * times))
        errors.append(np.abs(found - true).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(2.0, abs=0.15)


# energy and momentum


def motion(scheme):
    """Return the steps of a free body that spins, moves and stretches at first, its mass and velocity."""
    body = disc()
    x, y = body.nodes
    velocity = np.stack([0.3 * x - 0.2 * y, 0.2 * x - 0.3 * y + 0.1])
    terms = (SOLID, Inertia(density=1.0), StiffnessDamping(elastic=SOLID, time=0.2))
    return marched(body, terms, scheme, 0.1, 20, velocity=velocity), mass(body, 1.0).whole, velocity


@pytest.mark.parametrize("scheme", ["euler", "midpoint"])
def test_energy_is_lost_and_momentum_kept_in_free_flight(scheme):
    steps, M, velocity = motion(scheme)
    first = velocity.T.ravel()
    energies = [0.5 * first @ (M @ first)]
    for step in steps:
        energies.append(step.at.evaluations[0].energy + step.numbers["kinetic_energy"])
        now = step.state["velocity"].T.ravel()
        change = (M @ (now - first)).reshape(-1, 2).sum(0)
        assert np.abs(change).max() < 1e-12 * np.abs(M @ first).sum()
    assert (np.diff(energies) < 0).all()


@pytest.mark.parametrize("scheme", ["euler", "midpoint"])
def test_the_work_of_a_step_is_the_energy_that_the_damping_takes(scheme):
    """Forces f over the step do the work f·(end - start) = dt v·β K₀ v, v the mean velocity."""
    body, dt, beta = disc("clamped"), 0.1, 0.2
    potential = at_rest(body, time=beta, step=TimeStep(dt, Stepping(scheme=scheme).balance))
    end = 0.01 * np.random.default_rng(2).standard_normal(body.nodes.size)
    there = end if scheme == "euler" else 0.5 * end
    force, _ = potential.evaluate(there).gradient()
    K = SOLID.on(body).during(State(0.0, {}), TimeStep(1.0)).evaluate(np.zeros(len(end))).hessian(0.0)
    velocity = end / dt
    assert force @ end == pytest.approx(dt * beta * velocity @ dense(K, len(end)) @ velocity, rel=1e-12)


# what it is


@pytest.mark.parametrize("element", ["quadratic", "mixed"])
def test_derivatives_balance_and_no_negative_eigenvalue(element):
    body = disc()
    potential = at_rest(body, elastic=Elastic(gray=GRAY, element=element))
    x = 0.01 * np.random.default_rng(1).standard_normal(body.nodes.size)
    check_derivatives(potential, x, 0.01)
    check_balanced(body, np.zeros_like(x), potential.evaluate(x).gradient()[0])  # no moment on the start
    check_semidefinite(potential, x)
    values = np.linalg.eigvalsh(dense(potential.evaluate(x).hessian(0.0), len(x)))
    assert (np.abs(values[:3]) < 1e-12 * values[-1]).all()  # two translations and the first of a rotation
    assert values[3] > 1e-5 * values[-1]


def test_rotation_is_resisted_in_proportion_to_the_sine_of_the_angle():
    body = disc()

    def forces(angle, turn):
        """Forces against turning by `turn` more, over the length of the step's way."""

        def turned(by):
            R = np.array([[np.cos(by), -np.sin(by)], [np.sin(by), np.cos(by)]])
            return R @ body.nodes - body.nodes

        potential = at_rest(body, displacement=turned(angle))
        force, _ = potential.evaluate(turned(angle + turn).T.ravel()).gradient()
        return force / turn

    radial = at_rest(body).evaluate(body.nodes.T.ravel()).gradient()[0]  # β K₀ X / dt
    turn = 1e-6
    for angle in (0.0, 0.1, 0.7):
        expected = -np.sin(angle) * radial
        assert np.abs(forces(angle, turn) - expected).max() < 2 * turn * np.abs(radial).max()
    moved = np.tile([0.3, -0.2], len(body.nodes.T))
    assert np.abs(at_rest(body).evaluate(moved).gradient()[0]).max() < 1e-12 * np.abs(radial).max()


def test_stiffer_tissue_is_damped_more():
    body = disc()
    x = 0.01 * np.random.default_rng(3).standard_normal(body.nodes.size)
    plain = at_rest(body).evaluate(x).gradient()[0]
    double = np.full(body.quadrature.weights.shape, 2.0)
    twice = at_rest(body, modulus_factor=double).evaluate(x).gradient()[0]
    slower = at_rest(body, time=0.4).evaluate(x).gradient()[0]
    assert twice == pytest.approx(2 * plain, rel=1e-12)
    assert slower == pytest.approx(2 * plain, rel=1e-12)


@pytest.mark.parametrize("time", [0.0, -1.0, float("nan"), "long", None])
def test_bad_time(time):
    with pytest.raises(ValueError, match="time"):
        StiffnessDamping(elastic=SOLID, time=time)


def test_bad_solid():
    with pytest.raises(ValueError, match="elastic"):
        StiffnessDamping(elastic=GRAY, time=1.0)


DAMPED = Drag(coefficient=1.0), StiffnessDamping(elastic=SOLID, time=1.0)


@pytest.mark.parametrize("terms", [DAMPED[:1], DAMPED[1:], (Inertia(density=1.0),)])
def test_a_middle_of_the_step_needs_a_term_that_resists_motion(terms):
    middle = Stepping(scheme="midpoint")
    with pytest.raises(ValueError, match="middle of each step") as failure:
        Scene(body=disc(), terms=(SOLID,), stepping=middle)
    message_names(failure.value, "scheme='midpoint'", "no term resists motion", "Inertia(...) or Drag(...)")
    Scene(body=disc(), terms=(SOLID, *terms), stepping=middle)


def test_a_sweep_without_inertia_says_why_it_cannot_be(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rod.py").write_text(
        "from turingfold import Elastic, Inertia, NeoHookean, Scene, Stepping, semicircle\n"
        "def scenes(quick=False):\n"
        "    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), Inertia(density=1.0))\n"
        "    body, middle = semicircle(radius=1.0, thickness=0.3, size=0.5), Stepping(scheme='midpoint')\n"
        "    return {'one': Scene(body=body, terms=terms, stepping=middle)}\n"
    )
    assert main(["sweep", "rod.py", "--vary", "Inertia=on,off"]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert "Stepping(scheme='midpoint')" in told
    assert "no term resists motion" in told


@pytest.mark.parametrize("scheme", ["euler", "midpoint"])
def test_the_energy_told_is_that_of_the_vibrating_mode(scheme):
    """½ ω² a² of the amplitude a is stored; with motion and heat it is all, but for Euler's loss."""
    omega, shape = mode(disc("clamped"), 0)
    alpha, beta, dt = 0.2 * omega, 0.3 / omega, 0.3 / omega
    terms = (
        SOLID, Inertia(density=1.0), Drag(coefficient=alpha), StiffnessDamping(elastic=SOLID, time=beta),
    )  # fmt: skip
    start = SMALL * shape.reshape(-1, 2).T
    found = marched(disc("clamped"), terms, scheme, dt, 12, displacement=start)
    weights, all_there_was = mass(disc("clamped"), 1.0).whole @ shape, 0.5 * (omega * SMALL) ** 2
    before, moved, heat = SMALL, 0.0, 0.0
    for step in found:
        numbers, now = step.numbers, float(weights @ step.x)
        velocity = (now - before) / dt
        assert numbers["energy"] == pytest.approx(0.5 * (omega * now) ** 2, abs=1e-4 * all_there_was)
        assert numbers["drag_work"] == pytest.approx(dt * alpha * velocity**2, rel=1e-3)
        assert numbers["damping_work"] == pytest.approx(dt * beta * (omega * velocity) ** 2, rel=1e-3)
        heat += numbers["drag_work"] + numbers["damping_work"]
        if scheme == "euler":  # what the rule itself loses
            heat += 0.5 * (omega * (now - before)) ** 2 + 0.5 * (velocity - moved) ** 2
        total = numbers["energy"] + numbers["kinetic_energy"] + heat
        assert total == pytest.approx(all_there_was, rel=1e-4)
        before, moved = now, velocity


def test_a_stiffness_that_is_written_anew_needs_no_new_places(monkeypatch):
    """Symbolic factorisations of a scene whose stiffness softens in time: one, as without damping."""
    made, original = [], newton.solver_for
    monkeypatch.setattr(newton, "solver_for", lambda *given: made.append(given) or original(*given))
    body = disc("clamped")
    terms = (SOLID, StiffnessDamping(elastic=SOLID, time=0.2))
    scene = Scene(body=body, terms=terms, processes=(Softening(), TangentialGrowth(cortex=1.2)))
    steps = [step for step, _ in march(scene, begin(scene))]
    assert len(steps) == 20
    assert len(made) == 1
