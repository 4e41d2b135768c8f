"""The negative part of the elastic tangent, in closed form.

Split F into its conformal and anticonformal parts, F = (P, R) in an orthonormal basis of 2x2 matrices. Then
cof F = (P, -R), and the tangent a 1 + c₁(F⊗C + C⊗F) + c₂ C⊗C + b ∂C/∂F, C = F_zz cof F, has the eigenvalues
a + b F_zz (along P⊥), a - b F_zz (along R⊥) and those of a 2x2 matrix on (P, R) directions.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array, Integers


def negative_part(
    F: Array, out: Array, a: Array, b: Array, c1: Array, c2: Array
) -> tuple[Integers, Array, Array]:
    """Return the points where the tangent is indefinite, and what to add there to make it semi-definite.

    F: in-plane part (2, 2, q, e); out: F_zz and the tangent's coefficients, each (q, e).
    Returns flat indices (p,), weights (4, p) = max(0, -eigenvalue) and unit eigenmatrices (4, 2, 2, p).
    """
    P, R = _split(F)
    p2, r2 = (P**2).sum(0), (R**2).sum(0)
    turn = b * out
    first = a + turn + (2 * c1 * out + c2 * out**2) * p2
    second = a - turn + (c2 * out**2 - 2 * c1 * out) * r2
    coupling2 = (c2 * out**2) ** 2 * p2 * r2
    indefinite = (a + turn < 0) | (a - turn < 0) | (first < 0) | (second < 0) | (first * second < coupling2)
    where = np.flatnonzero(indefinite)
    P, R = P.reshape(2, -1)[:, where], R.reshape(2, -1)[:, where]
    a, turn, first, second = (v.ravel()[where] for v in (a, turn, first, second))
    coupling = -np.sqrt(coupling2.ravel()[where])
    lowest, highest, cosine, sine = _symmetric_pair(first, second, coupling)
    P, R = _unit(P), _unit(R)
    none = np.zeros_like(P)
    pair = [(cosine * P, sine * R), (-sine * P, cosine * R)]
    vectors = np.stack(
        [_join(_quarter_turn(P), none), _join(none, _quarter_turn(R)), *(_join(p, r) for p, r in pair)]
    )
    eigenvalues = np.stack([a + turn, a - turn, lowest, highest])
    return where, np.maximum(0.0, -eigenvalues), vectors


def _split(F: Array) -> tuple[Array, Array]:
    s = np.sqrt(0.5)
    return (
        s * np.stack([F[0, 0] + F[1, 1], F[1, 0] - F[0, 1]]),
        s * np.stack([F[0, 0] - F[1, 1], F[1, 0] + F[0, 1]]),
    )


def _join(P: Array, R: Array) -> Array:
    s = np.sqrt(0.5)
    parts = np.stack([np.stack([P[0] + R[0], R[1] - P[1]]), np.stack([P[1] + R[1], P[0] - R[0]])])
    return np.asarray(s * parts)


def _quarter_turn(v: Array) -> Array:
    return np.stack([-v[1], v[0]])


def _unit(v: Array) -> Array:
    length = np.hypot(*v)
    fallback = np.zeros_like(v)
    fallback[0] = 1.0
    return np.where(length > 0, v / np.where(length > 0, length, 1.0), fallback)


def _symmetric_pair(first: Array, second: Array, coupling: Array) -> tuple[Array, Array, Array, Array]:
    """Return the eigenvalues of [[first, coupling], [coupling, second]] and the lower one's direction."""
    mean, half = 0.5 * (first + second), 0.5 * (first - second)
    spread = np.hypot(half, coupling)
    angle = 0.5 * np.arctan2(-coupling, -half)
    return mean - spread, mean + spread, np.cos(angle), np.sin(angle)
