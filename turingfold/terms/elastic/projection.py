"""The negative part of the elastic tangent, in closed form.

Split F into its conformal and anticonformal parts, F = (P, R) in an orthonormal basis of 2x2 matrices. Then
cof F = (P, -R), and the tangent a 1 + c₁(F⊗C + C⊗F) + c₂ C⊗C + b ∂C/∂F, C = F_zz cof F, has the eigenvalues
a + b F_zz (along P⊥), a - b F_zz (along R⊥) and those of a 2x2 matrix on (P, R) directions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Integers


class Negative(NamedTuple):
    """Points where an eigenvalue is negative, flat indices (p,), its amount (p,), eigenmatrices (2, 2, p)."""

    where: Integers
    weights: Array
    vectors: Array


def negative_parts(F: Array, out: Array, a: Array, b: Array, c1: Array, c2: Array) -> list[Negative]:
    """Return the negative eigenvalues of the tangent with their unit eigenmatrices, if there are any.

    F: in-plane part (2, 2, q, e); out: F_zz and the tangent's coefficients, each (q, e).
    """
    P, R = _split(F)
    p2, r2 = (P**2).sum(0), (R**2).sum(0)
    turn, rise, bulk = b * out, 2 * c1 * out, c2 * out**2
    across, along = a + turn, a - turn
    first, second = across + (rise + bulk) * p2, along + (bulk - rise) * r2
    coupling2 = bulk**2 * p2 * r2
    in_pair = np.flatnonzero((first < 0) | (second < 0) | (first * second < coupling2))
    found = [
        *_turned(across, P, lambda turned: _join(turned, np.zeros_like(turned))),
        *_turned(along, R, lambda turned: _join(np.zeros_like(turned), turned)),
    ]
    if len(in_pair):
        P, R = (_unit(v.reshape(2, -1)[:, in_pair]) for v in (P, R))
        first, second, coupling2 = (v.ravel()[in_pair] for v in (first, second, coupling2))
        lowest, highest, cosine, sine = _symmetric_pair(first, second, -np.sqrt(coupling2))
        found.append(Negative(in_pair, np.maximum(0.0, -lowest), _join(cosine * P, sine * R)))
        both = np.flatnonzero(highest < 0)
        if len(both):
            vectors = _join(-sine * P, cosine * R)[:, :, both]
            found.append(Negative(in_pair[both], -highest[both], vectors))
    return found


def _turned(eigenvalues: Array, v: Array, matrix: Callable[[Array], Array]) -> Iterator[Negative]:
    """Yield where the eigenvalues that belong to a quarter turn of v are negative, if they are anywhere."""
    where = np.flatnonzero(eigenvalues < 0)
    if len(where):
        x, y = _unit(v.reshape(2, -1)[:, where])
        yield Negative(where, -eigenvalues.ravel()[where], matrix(np.stack([-y, x])))


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
