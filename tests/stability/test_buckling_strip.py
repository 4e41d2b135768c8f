"""The onset of buckling of a growing strip on a deep core, from its tangent at the exact homogeneous state.

The threshold is found twice: by the program's tangent, and by the exact incremental equations, whose
solutions in each homogeneous layer are e^{ikx} e^{sy} with s from a polynomial of degree 4.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import brentq
from skfem import MeshTri1

from turingfold.geometry.body import Body
from turingfold.parts import TimeStep
from turingfold.solve.linear import NotPositiveDefinite, solver_for
from turingfold.solve.sparsity import Assembler
from turingfold.state import State
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic

DEPTH = 12.0  # of cortex and core together, in thicknesses of the cortex


@dataclass(frozen=True)
class Strip:
    """A core and a cortex of thickness 1 that grows along x, one wave length long."""

    core: NeoHookean
    cortex: NeoHookean
    length: float


STRIPS = {
    "kappa 5 mu": (Strip(NeoHookean(mu=1.0, kappa=5.0), NeoHookean(mu=1.0, kappa=5.0), 4.10), 1.6297),
    "document 1": (
        Strip(NeoHookean.from_young(1895.0, 0.4583), NeoHookean.from_young(1389.0, 0.4583), 3.61),
        1.7324,
    ),
    "stiff cortex": (Strip(NeoHookean(mu=1.0, kappa=5.0), NeoHookean(mu=10.0, kappa=50.0), 9.61), 1.1286),
}


def stress(m, F):
    """First Piola stress of a 2x2 deformation gradient in plane strain."""
    J, I1 = np.linalg.det(F), (F**2).sum() + 1.0
    cofactor = J * np.linalg.inv(F).T
    return m.mu * J ** (-2 / 3) * (F - I1 / (3 * J) * cofactor) + m.kappa * (J - 1) * cofactor


def rise(m, growth):
    """Return λ_y of a cortex that is held in x and free in y, F* = diag(1/g, λ_y)."""
    return brentq(lambda l: stress(m, np.diag([1 / growth, l]))[1, 1], 0.5, 3.0, xtol=1e-15)


# the exact threshold


def tangent(m, F, growth):
    """∂P_ij/∂F_kl of a grown layer at F = F* G, per reference area, by central differences of order 4."""
    shrink, found, h = np.diag([1 / growth, 1.0]), np.empty((2, 2, 2, 2)), 1e-3

    def nominal(F):
        return growth * stress(m, F @ shrink) @ shrink

    for k in (0, 1):
        for l in (0, 1):
            d = np.zeros((2, 2))
            d[k, l] = h
            one, two = (nominal(F + s * d) - nominal(F - s * d) for s in (1, 2))
            found[:, :, k, l] = (8 * one - two) / (12 * h)
    return found


def waves(A, k):
    """Return s (4,) and amplitudes (2, 4) of the solutions u e^{ikx} e^{sy} of A_ijkl u_k,lj = 0."""
    # (s² M + s C + K) u = 0 with M = A_i2k2, C = ik (A_i1k2 + A_i2k1), K = -k² A_i1k1
    M, K = A[:, 1, :, 1], -(k**2) * A[:, 0, :, 0]
    C = 1j * k * (A[:, 0, :, 1] + A[:, 1, :, 0])
    inverse = np.linalg.inv(M)
    companion = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ K, -inverse @ C]])
    values, vectors = np.linalg.eig(companion)
    return values, vectors[:2]


def traction(A, k, values, vectors):
    """Nominal traction on y = const of each wave: A_i2kl u_k (ik, s)_l; (2, 4)."""
    slopes = np.stack([np.full(4, 1j * k), values])
    return np.einsum("ikl,kw,lw->iw", A[:, 1], vectors, slopes)


def dependence(strip, growth):
    """Return the smallest singular value of the strip's boundary conditions; zero at a threshold.

    They are: u = 0 at the bottom, u and traction continuous at the interface, no traction on top.
    """
    k, bottom = 2 * np.pi / strip.length, 1.0 - DEPTH
    core = tangent(strip.core, np.eye(2), 1.0)
    cortex = tangent(strip.cortex, np.diag([1.0, rise(strip.cortex, growth)]), growth)
    (s0, u0), (s1, u1) = waves(core, k), waves(cortex, k)
    t0, t1 = traction(core, k, s0, u0), traction(cortex, k, s1, u1)
    base = np.exp(s0 * (bottom - np.where(s0.real < 0, bottom, 0.0)))  # scaled so that nothing overflows
    at_interface = np.exp(-s0 * np.where(s0.real < 0, bottom, 0.0))
    top = np.exp(s1 * 1.0)
    rows = [
        np.concatenate([u0 * base, np.zeros((2, 4))], axis=1),
        np.concatenate([u0 * at_interface, -u1], axis=1),
        np.concatenate([t0 * at_interface, -t1], axis=1),
        np.concatenate([np.zeros((2, 4)), t1 * top], axis=1),
    ]
    matrix = np.concatenate(rows)
    matrix /= np.abs(matrix).max(1, keepdims=True)
    return np.linalg.svd(matrix, compute_uv=False)[-1]


def exact_threshold(strip, near):
    """Return the growth at which the boundary conditions become dependent, by golden section."""
    grid = np.linspace(near * 0.97, near * 1.03, 61)
    low = int(np.argmin([dependence(strip, g) for g in grid]))
    a, b = grid[max(low - 1, 0)], grid[min(low + 1, 60)]
    golden = (np.sqrt(5) - 1) / 2
    for _ in range(60):
        c, d = b - golden * (b - a), a + golden * (b - a)
        a, b = (a, d) if dependence(strip, c) < dependence(strip, d) else (c, b)
    return 0.5 * (a + b)


# the program's threshold


def mesh(strip, layers, around):
    """Return the strip, with `layers` elements through the cortex, and its fixed unknowns."""
    rows, step = [1.0], 1.0 / layers
    rows += [1.0 - step * (i + 1) for i in range(layers)]
    while rows[-1] > 1.0 - DEPTH + 1.2 * step:
        step = min(1.25 * step, 1.5)
        rows.append(rows[-1] - step)
    rows[-1] = 1.0 - DEPTH
    x = np.linspace(0.0, strip.length, around + 1)
    grid = MeshTri1.init_tensor(x, np.array(rows[::-1]))
    centre = grid.p[1][grid.t].mean(0)
    named = grid.with_boundaries({"pial": lambda p: p[1] == 1.0, "base": lambda p: p[1] == 1.0 - DEPTH})
    body = Body(named.with_subdomains({"cortex": np.flatnonzero(centre > 0)}), 1.0)
    sides = np.flatnonzero((body.nodes[0] == 0) | (body.nodes[0] == strip.length))
    bottom = np.flatnonzero(body.nodes[1] == 1.0 - DEPTH)
    return body, np.unique(np.concatenate([2 * sides, 2 * bottom, 2 * bottom + 1]))


class Tangents:
    """The program's tangent at the homogeneous state of each growth."""

    def __init__(self, strip, layers, around):
        self.strip = strip
        self.body, fixed = mesh(strip, layers, around)
        self.operator = Elastic(gray=strip.cortex, white=strip.core).on(self.body)
        self.assembler = Assembler(2 * self.body.nodes.shape[1], fixed)
        self.solver = None

    def at(self, growth):
        """Return potential and displacement of the homogeneous state."""
        body = self.body
        factors = np.ones((3, *body.quadrature.weights.shape))
        factors[0, :, body.in_cortex] = growth
        y = body.nodes[1]
        up = np.where(y > 0, (rise(self.strip.cortex, growth) - 1) * y, 0.0)
        potential = self.operator.during(State(1.0, {"growth": factors}), TimeStep(1.0))
        return potential, np.stack([np.zeros_like(up), up]).T.ravel()

    def stable(self, growth):
        """Return whether the tangent is positive definite."""
        potential, x = self.at(growth)
        pattern, values = self.assembler.assemble([potential.evaluate(x).hessian(0.0)])
        self.solver = self.solver or solver_for(pattern)
        try:
            self.solver.factorize(values)
        except NotPositiveDefinite:
            return False
        return True

    def threshold(self, low, high):
        """Return the growth at which the tangent first loses positivity, by bisection."""
        assert self.stable(low)
        assert not self.stable(high)
        while high - low > 1e-5:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.stable(middle) else (low, middle)
        return 0.5 * (low + high)


@pytest.mark.parametrize("name", STRIPS)
def test_the_homogeneous_state_is_an_equilibrium(name):
    tangents = Tangents(STRIPS[name][0], 2, 8)
    potential, x = tangents.at(1.4)
    forces, scale = potential.evaluate(x).gradient()
    assert np.linalg.norm(forces[tangents.assembler.free]) < 1e-12 * np.sqrt(scale)


@pytest.mark.parametrize("name", STRIPS)
def test_the_exact_threshold_is_the_printed_one(name):
    strip, known = STRIPS[name]
    assert exact_threshold(strip, known) == pytest.approx(known, abs=1e-4)


@pytest.mark.parametrize("name", STRIPS)
def test_the_strip_buckles_within_half_a_percent(name):
    strip, known = STRIPS[name]
    found = Tangents(strip, 4, 4 * round(strip.length)).threshold(0.9 * known, 1.1 * known)
    assert found == pytest.approx(known, rel=5e-3)


def test_the_onset_converges_from_above():
    # the trial functions are a subspace: no mesh can buckle before the exact solution
    strip, known = STRIPS["kappa 5 mu"]
    exact = exact_threshold(strip, known)
    found = [Tangents(strip, n, 4 * n).threshold(0.999 * exact, 1.2 * known) for n in (1, 2, 4)]
    errors = np.array(found) - exact
    assert 0 < errors[2] < errors[1] < errors[0]
    assert np.log2(errors[0] / errors[2]) / 2 > 2.5
    assert errors[0] < 0.05 * exact  # the resolution of the quickest figures


def test_the_wave_length_is_the_critical_one():
    strip, known = STRIPS["kappa 5 mu"]
    found = [
        exact_threshold(Strip(strip.core, strip.cortex, strip.length * s), known) for s in (0.85, 1.0, 1.15)
    ]
    assert found[1] < min(found[0], found[2])
