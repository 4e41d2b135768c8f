"""Worked examples of parts of a user's own: short, from the public names alone, examined, and run."""

import ast
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from pulled_core import PulledCore
from selkov import Selkov
from springs import Springs

from turingfold import (
    Elastic,
    NeoHookean,
    Scene,
    Stepping,
    TangentialGrowth,
    Turing,
    conditions,
    outline,
    semicircle,
    simulate,
)
from turingfold.extend import State, TimeStep, cortex_indicator
from turingfold.testing import check_kinetics, check_process, check_term

EXAMPLES = sorted(path for path in Path(__file__).parent.glob("*.py") if not path.name.startswith("test_"))
SOLID = Elastic(gray=NeoHookean.from_young(1389.0, 0.4583), white=NeoHookean.from_young(1895.0, 0.4583))


@pytest.fixture(scope="module")
def body():
    return semicircle(radius=0.0404, thickness=0.006, elements=2)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_short_and_use_public_names_only(path):
    text = path.read_text()
    assert len(text.splitlines()) <= 25
    lines = [line for line in ast.parse(text).body if isinstance(line, ast.ImportFrom)]
    ours = {line.module for line in lines if line.module.startswith("turingfold")}
    assert ours <= {"turingfold", "turingfold.extend"}


def test_selkovs_kinetics():
    u, v = np.random.default_rng(0).uniform(0.1, 2.0, (2, 50))
    check_kinetics(Selkov(), u, v)
    # f_u = (b² - a)/(a + b²), det J = a + b²: √ratio solves f_u r² - 2 √det r - (a + b²) = 0
    f_u, det = 0.9 / 1.1, 1.1
    critical = ((np.sqrt(det) + np.sqrt(det + f_u * det)) / f_u) ** 2
    assert conditions(Selkov(), 1.0, 20.0).critical_ratio == pytest.approx(critical, rel=1e-9)


def test_selkovs_kinetics_make_the_half_waves_asked_for(body):
    pattern = Turing(Selkov(), half_waves=8).pattern(body)
    along = pattern.normalised[pattern.design.line]
    assert np.count_nonzero(np.diff(np.sign(along - 0.5))) == 8


def test_springs(body):
    rng = np.random.default_rng(1)
    state = State(0.5, {"displacement": np.zeros_like(body.nodes)})
    samples = 1e-3 * rng.standard_normal((2, body.nodes.size))
    check_term(
        Springs(3.0), body, state, samples, step=1e-3, balanced=False, objective=False, other=Springs(4.0)
    )  # fmt: skip
    angle = 2 * np.pi * np.arange(40) / 40
    closed = outline(0.04 * np.stack([np.cos(angle), np.sin(angle)]), thickness=0.006, size=0.004)
    for one in (body, closed):
        moved = np.tile([3e-3, -4e-3], one.nodes.shape[1])
        energy = Springs(3.0).on(one).during(state, TimeStep(0.1)).evaluate(moved).energy
        assert energy == pytest.approx(0.5 * 3.0 * one.pial_curve.length * 25e-6, rel=1e-12)


def test_stiff_springs_hold_the_surface(body):
    scene = Scene(
        body=body, terms=(SOLID, Springs(1e8)), processes=(TangentialGrowth(cortex=1.1),),
        stepping=Stepping(first=0.5, largest=0.5),
    )  # fmt: skip
    held = simulate(scene).last["displacement"]
    free = simulate(replace(scene, terms=(SOLID,))).last["displacement"]
    assert np.abs(held[:, body.pial]).max() < 1e-2 * np.abs(free[:, body.pial]).max()


def test_the_pulled_core(body):
    stress = 100 * np.random.default_rng(2).standard_normal((4, *body.quadrature.weights.shape))
    check_process(PulledCore(), body, State(0.0, {"cauchy_stress": stress}), 0.1)
    scene = Scene(
        body=body, terms=(SOLID,), processes=(PulledCore(cortex=1.4, rate=1e-3),), until=1.0,
        stepping=Stepping(first=0.1, largest=0.1),
    )  # fmt: skip
    states, gray = simulate(scene).states, cortex_indicator(body)
    core = np.ones_like(gray)
    for before, now in pairwise(states):
        stress = stress_of(body, before)
        pull = 0.5 * (stress[0, 0] + stress[1, 1])
        core = core * np.exp((1 - gray) * 1e-3 * (now.time - before.time) * pull)
        expected = np.stack([(1 + 0.4 * gray * now.time) * core, core, np.ones_like(core)])
        np.testing.assert_allclose(now["growth"], expected, rtol=1e-12)
    assert core[:, ~body.in_cortex].mean() > 1.02
    assert (core[:, body.in_cortex] == 1).all()


def stress_of(body, state):
    """Return the Cauchy stress, (3, 3, q, e), of a state's displacement and growth, by 3x3 matrices."""
    q = body.quadrature
    at = (body.nodes + state["displacement"])[:, body.triangles]
    F = np.zeros((*q.weights.shape, 3, 3))
    F[..., :2, :2] = np.einsum("iae,amq,mkqe->qeik", at, q.derivatives, q.inverse)
    F[..., 2, 2] = 1.0
    tx, ty = body.tangent
    frame = np.zeros_like(F)
    frame[..., 0, 0], frame[..., 1, 0], frame[..., 0, 1], frame[..., 1, 1] = tx, ty, -ty, tx
    frame[..., 2, 2] = 1.0
    inverse = np.moveaxis(1 / state["growth"], 0, -1)[..., None, :] * frame @ np.swapaxes(frame, -1, -2)
    E = F @ inverse
    mu, kappa = (value[..., None, None] for value in SOLID.moduli(body))
    b, J = E @ np.swapaxes(E, -1, -2), np.linalg.det(E)[..., None, None]
    mean = np.trace(b, axis1=-2, axis2=-1)[..., None, None] / 3
    sigma = mu * J ** (-5 / 3) * (b - mean * np.eye(3)) + kappa * (J - 1) * np.eye(3)
    return np.moveaxis(sigma, (-2, -1), (0, 1))
