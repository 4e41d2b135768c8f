"""Algebra at the integration points that all elastic elements share; `elastic` says what the letters mean."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import Array
from ...geometry.quadrature import Quadrature
from ...parts import STRESS_FIELDS
from .projection import negative_parts


@dataclass(frozen=True)
class Metric:
    """What growth does to the pull-back.

    D: (2, 2, q, e).  B: its components xx, xy and yy, (3, q, e).  delta, out2, weights: δ, F*_zz² and J_G dA,
    each (q, e).
    """

    D: Array
    B: Array
    delta: Array
    out2: Array
    weights: Array


def metric(quadrature: Quadrature, tangent: Array | None, growth: Array | None) -> Metric:
    """Return the pull-back for growth factors (3, q, e) along tangent, normal and z, or for none.

    tangent: of the nearest pial point, (2, q, e); only growth needs it.
    """
    if growth is None or tangent is None:
        D, out, weights = quadrature.inverse, np.ones_like(quadrature.weights), quadrature.weights
    else:
        tx, ty = tangent
        along, across, gz = growth
        xx, yy = tx * tx / along + ty * ty / across, ty * ty / along + tx * tx / across
        xy = tx * ty * (1 / along - 1 / across)
        inverse = quadrature.inverse
        D = np.stack(
            [inverse[:, 0] * xx + inverse[:, 1] * xy, inverse[:, 0] * xy + inverse[:, 1] * yy], axis=1
        )
        out, weights = 1 / gz, quadrature.weights * along * across * gz
    B = np.stack(
        [D[0, 0] ** 2 + D[0, 1] ** 2, D[0, 0] * D[1, 0] + D[0, 1] * D[1, 1], D[1, 0] ** 2 + D[1, 1] ** 2]
    )
    return Metric(D, B, out * determinant(D), out**2, weights)


def determinant(H: Array) -> Array:
    """Return det H, (q, e), of (2, 2, q, e)."""
    return np.asarray(H[0, 0] * H[1, 1] - H[0, 1] * H[1, 0])


def cofactor(H: Array, delta: Array) -> Array:
    """Return C = ∂J*/∂H = δ cof H, (2, 2, q, e)."""
    C = H[::-1, ::-1] * delta
    for entry in (C[0, 1], C[1, 0]):
        np.negative(entry, out=entry)
    return C


def times_symmetric(H: Array, B: Array) -> Array:
    """Return H B, (2, 2, q, e), for B given by its components xx, xy and yy."""
    return np.asarray(H[:, :1] * B[:2] + H[:, 1:] * B[1:])


def first_invariant(H: Array, HB: Array, out2: Array) -> Array:
    """Return I₁ = H : H B + F*_zz², (q, e)."""
    return np.asarray(np.einsum("ijqe,ijqe->qe", H, HB) + out2)


def deformation(H: Array, D: Array) -> Array:
    """Return the in-plane part of F* = H D, (2, 2, q, e)."""
    return np.asarray(H[:, :1] * D[0] + H[:, 1:] * D[1])


def von_mises(mu: Array, F: Array, out2: Array, I1: Array, J: Array) -> Array:
    """Return the von Mises stress of F*, (2, 2, q, e) in the plane and F*_zz² = out2 across it; Pa."""
    mean = I1 / 3
    xx, yy = F[0, 0] ** 2 + F[0, 1] ** 2 - mean, F[1, 0] ** 2 + F[1, 1] ** 2 - mean
    xy, zz = F[0, 0] * F[1, 0] + F[0, 1] * F[1, 1], out2 - mean
    return np.asarray(mu * J ** (-5.0 / 3.0) * np.sqrt(1.5 * (xx**2 + yy**2 + zz**2 + 2 * xy**2)))


def cauchy(mu: Array, mean: Array, F: Array, out2: Array, I1: Array, J: Array) -> Array:
    """Return the Cauchy stress μ J^{-5/3} dev(F*F*ᵀ) + mean 1: components xx, yy, xy and zz, (4, q, e); Pa.

    F: the in-plane part of F*, (2, 2, q, e).  out2: F*_zz².  mean: mean stress.
    """
    a = mu * J ** (-5.0 / 3.0)
    xx, yy = F[0, 0] ** 2 + F[0, 1] ** 2, F[1, 0] ** 2 + F[1, 1] ** 2
    level = mean - a * I1 / 3
    xy = a * (F[0, 0] * F[1, 0] + F[0, 1] * F[1, 1])
    return np.stack([a * xx + level, a * yy + level, xy, a * out2 + level])


def stress_fields(stress: Array) -> dict[str, Array]:
    """Return the components of `cauchy` as fields by name."""
    return dict(zip(STRESS_FIELDS, stress, strict=True))


def tangents(
    metric: Metric, H: Array, HB: Array, C: Array, law: tuple[Array, Array, Array, Array], convexity: float
) -> tuple[Array, Array]:
    """Return the weighted tangent at the points, with the share `convexity` of its negative part taken away.

    law: a, b of P = a H B + b C and c₁, c₂ of its derivative, each (q, e).
    For equal components i: (2, 3, q, e), the xx, xy and yy coefficients of gradients; for components 0 and 1:
    (2, 2, q, e).
    """
    (a, b, c1, c2), w = law, metric.weights
    # c₁(S⊗C + C⊗S) + c₂ C⊗C = K⊗C + C⊗K with K = c₁ S + ½ c₂ C
    K = (w * c1) * HB + (0.5 * w * c2) * C
    same = np.empty((2, 3, *a.shape))
    np.multiply(K + K, C, out=same[:, ::2])
    np.multiply(K[:, 0], C[:, 1], out=same[:, 1])
    same[:, 1] += K[:, 1] * C[:, 0]
    same += (w * a) * metric.B
    mixed = K[0][:, None] * C[1][None] + C[0][:, None] * K[1][None]  # (m, n, q, e)
    turn = w * b * metric.delta
    mixed[0, 1] += turn
    mixed[1, 0] -= turn
    if convexity > 0:
        _add_negative_part(convexity, same, mixed, metric, deformation(H, metric.D), law)
    return same, mixed


def _add_negative_part(
    share: float, same: Array, mixed: Array, metric: Metric, F: Array, law: tuple[Array, Array, Array, Array]
) -> None:
    D, areas = metric.D, metric.weights.ravel()
    for where, weights, vectors in negative_parts(F, np.sqrt(metric.out2), *law):
        V = np.zeros_like(F)
        V.reshape(2, 2, -1)[:, :, where] = np.sqrt(share * areas[where] * weights) * vectors
        V = V[:, :1] * D[:, 0] + V[:, 1:] * D[:, 1]
        same[:, ::2] += V * V
        same[:, 1] += V[:, 0] * V[:, 1]
        mixed += V[0][:, None] * V[1]


def determinant_along(H: Array, dH: Array) -> tuple[Array, Array, Array]:
    """Return c, l and q of det(H + s dH) = c + l s + q s², each (q, e)."""
    linear = H[0, 0] * dH[1, 1] + dH[0, 0] * H[1, 1] - H[0, 1] * dH[1, 0] - dH[0, 1] * H[1, 0]
    return determinant(H), linear, determinant(dH)


def first_loss(constant: Array, linear: Array, square: Array) -> float:
    """Return the smallest s in (0, 1] with c + l s + q s² = 0 for any entry, or 1; c > 0 everywhere."""
    bad = np.flatnonzero((constant + linear + square <= 0) | ((linear < 0) & (square > 0)))
    if not len(bad):
        return 1.0
    c, l, q = constant.ravel()[bad], linear.ravel()[bad], square.ravel()[bad]
    inside = l * l - 4 * q * c
    bottom = np.sqrt(np.maximum(inside, 0.0)) - l
    root = np.where((inside >= 0) & (bottom > 0), 2 * c / np.where(bottom > 0, bottom, 1.0), np.inf)
    return float(min(1.0, root.min()))
