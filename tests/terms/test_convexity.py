"""The closed form of the tangent's negative part, against numerical eigenvalues."""

import numpy as np
import pytest

from turingfold.terms.elastic import material
from turingfold.terms.elastic.projection import negative_parts


def tangents(F, out, a, b, c1, c2):
    """The 4x4 tangents on vec F in row order: a 1 + c₁(F⊗C + C⊗F) + c₂ C⊗C + b F_zz ∂cof/∂F; (n, 4, 4)."""
    n = F.shape[-1]
    f = F.reshape(4, n)
    C = out * np.stack([F[1, 1], -F[1, 0], -F[0, 1], F[0, 0]]).reshape(4, n)
    turn = np.zeros((4, 4))
    turn[0, 3] = turn[3, 0] = 1.0
    turn[1, 2] = turn[2, 1] = -1.0
    made = a[:, None, None] * np.eye(4) + (b * out)[:, None, None] * turn
    made += np.einsum("n,in,jn->nij", c1, f, C) + np.einsum("n,in,jn->nij", c1, C, f)
    return made + np.einsum("n,in,jn->nij", c2, C, C)


def sample(n, spread, seed=0):
    rng = np.random.default_rng(seed)
    F = np.eye(2)[:, :, None] + spread * rng.standard_normal((2, 2, n))
    det = F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0]
    F = F[:, :, det > 0.05]
    out = rng.uniform(0.5, 1.5, F.shape[-1])
    J = out * (F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0])
    mu, kappa = np.full_like(J, 1.0), rng.uniform(0.1, 50.0, J.shape)
    I1 = (F**2).sum((0, 1)) + out**2
    a, b = material.stress_coefficients(mu, kappa, I1, J)
    c1, c2 = material.tangent_coefficients(mu, kappa, I1, J)
    return F, out, a, b, c1, c2


def numerical(made):
    values, vectors = np.linalg.eigh(made)
    return np.einsum("nk,nik,njk->nij", np.maximum(0.0, -values), vectors, vectors), values


def closed(args):
    """Return the parts, and their sum at each point, (n, 4, 4)."""
    F, *rest = args
    parts = negative_parts(F[:, :, None], *(v[None] for v in rest))
    added = np.zeros((F.shape[-1], 4, 4))
    for where, weights, vectors in parts:
        flat = vectors.reshape(4, -1)
        added[where] += np.einsum("p,ip,jp->pij", weights, flat, flat)
    return parts, added


@pytest.mark.parametrize("spread", [0.05, 0.4, 1.5])
def test_negative_part_is_the_numerical_one(spread):
    args = sample(400, spread)
    made = tangents(*args)
    expected, values = numerical(made)
    parts, added = closed(args)
    size = np.abs(values).max(1)
    assert (np.abs(added - expected).max((1, 2)) < 1e-12 * size).all()
    # what is added makes every tangent semi-definite
    assert (np.linalg.eigvalsh(made + added)[:, 0] > -1e-12 * size).all()
    for _, weights, vectors in parts:
        assert (weights >= 0).all()
        assert (vectors**2).sum((0, 1)) == pytest.approx(1.0, abs=1e-13)


def test_the_samples_hold_definite_and_indefinite_tangents():
    values = numerical(tangents(*sample(400, 0.4)))[1]
    share = np.mean(values[:, 0] < 0)
    assert 0.05 < share < 0.95


def test_the_undeformed_tangent_needs_nothing():
    eye = np.eye(2)[:, :, None]
    one = np.ones(1)
    a, b = material.stress_coefficients(one, 5 * one, 3 * one, one)
    c1, c2 = material.tangent_coefficients(one, 5 * one, 3 * one, one)
    args = (eye, one, a, b, c1, c2)
    _, added = closed(args)  # one eigenvalue is zero by rotation
    assert np.abs(added).max() < 1e-14
    assert numerical(tangents(*args))[1][0] == pytest.approx([0.0, 2.0, 2.0, 2 * (5 + 1 / 3)], abs=1e-13)


def test_pure_dilation_has_no_anticonformal_part_to_normalise():
    # F = λ 1 makes the anticonformal part zero; its direction is arbitrary but must be a unit matrix
    eye = 0.3 * np.eye(2)[:, :, None]
    one = np.ones(1)
    I1, J = 2 * 0.09 * one + 1, 0.09 * one
    stress = material.stress_coefficients(one, 5 * one, I1, J)
    args = (eye, one, *stress, *material.tangent_coefficients(one, 5 * one, I1, J))
    expected, values = numerical(tangents(*args))
    assert values.min() < 0
    np.testing.assert_allclose(closed(args)[1], expected, atol=1e-13 * np.abs(values).max())
