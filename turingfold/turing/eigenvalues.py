"""Rightmost eigenvalues of a steady pattern, complex pairs included: whether it is linearly stable.

Perturbations z of a steady state evolve as M ∂z/∂t = J z and modes as exp(λ t) with J z = λ M z. Every λ lies
in the numerical range of the pencil, so an unstable one lies in the box 0 ≤ Re λ ≤ r, |Im λ| ≤ h that
`unstable_box` returns. For a real σ > 0 the function

    g(λ) = σ/(σ − λ) · ((σ + λ)/(σ − λ))^POWER,

a Cayley transform damped at −∞, satisfies |g| ≥ σ/√(max(σ, r − σ)² + h²) on that box and is small for
strongly damped modes. Arnoldi's method finds the eigenvalues of g(M⁻¹J) of largest modulus; once the smallest
of them is below that bound, no unstable eigenvalue is missing. One real factorisation of σM − J serves all.
Cayley transforms for stability: Meerbergen, Spence, Roose (1994) BIT 34:409.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigvals, orth
from scipy.sparse import csc_array
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs, splu

from ..arrays import Array, Complexes
from ..errors import NotConvergedError
from .reaction_diffusion import ReactionDiffusion

POWER = 8
FIRST, MOST = 8, 256  # eigenvalues asked for at first, and at most
DENSE = 200  # unknowns up to which all eigenvalues are computed at once
ALLOWANCE = 1.1  # interpolating the reaction within elements widens the numerical range: at most 4 % measured


def unstable_box(system: ReactionDiffusion, state: Array) -> tuple[float, float]:
    """Return r ≥ 0 and h > 0 such that an eigenvalue with Re λ ≥ 0 has Re λ ≤ r and |Im λ| ≤ h.

    With the species scaled by (1, s), r and h bound the symmetric and the skew part of the reaction's 2 × 2
    Jacobians at the nodes; diffusion only shifts eigenvalues to the left.
    """
    p_u, p_v, q_u, q_v = system.kinetics.derivatives(*state)
    sizes = float(np.abs(p_v).max()), float(np.abs(q_u).max())
    s = np.sqrt(sizes[0] / sizes[1]) if min(sizes) > 0 else 1.0
    uv, vu = p_v / s, q_u * s
    right = 0.5 * (p_u + q_v) + np.hypot(0.5 * (p_u - q_v), 0.5 * (uv + vu))
    fastest = max(float(np.abs(values).max()) for values in (p_u, q_v, uv, vu))
    high = max(0.5 * float(np.abs(vu - uv).max()), 1e-3 * fastest)
    return ALLOWANCE * max(float(right.max()), 0.0), ALLOWANCE * high


def rightmost_eigenvalues(
    system: ReactionDiffusion, state: Array, tolerated: float = 0.0, heed: Callable[[], object] = lambda: None
) -> Complexes:
    """Return eigenvalues at a state by descending real part: every one with Re λ ≥ 0, and those next to it.

    Where one exceeds `tolerated`, the rate up to which a perturbation may grow, others of that kind may be
    missing.
    heed: is called by and by, and may raise to end the search.
    Raises NotConvergedError if stability cannot be decided with MOST eigenvalues.
    """
    n = 2 * system.space.size
    if n <= DENSE:
        jacobian = -system.matrix(state).toarray()
        mass = np.kron(system.space.mass.toarray(), np.eye(2))
        return _ordered(eigvals(jacobian, mass))
    right, high = unstable_box(system, state)
    sigma = max(high, right)
    least = sigma / float(np.hypot(max(sigma, right - sigma), high))
    solve = system.solver(state, sigma)

    def inverse(x: Array) -> Array:  # (σM − J)⁻¹ M
        return solve(system.times_mass(x.reshape(2, -1))).ravel()

    def damped_cayley(x: Array) -> Array:
        heed()
        y = sigma * inverse(x)
        for _ in range(POWER):
            y = 2 * sigma * inverse(y) - y
        return y

    operator = LinearOperator((n, n), matvec=damped_cayley, dtype=float)
    start = 1 + np.cos(np.arange(n))  # a fixed start: the same eigenvalues, to the last bit, in every run
    count = FIRST
    while count <= min(MOST, n // 3):
        try:
            values, vectors = eigs(operator, count, ncv=2 * count + 4, v0=start, tol=1e-6)
        except ArpackNoConvergence:
            break
        space = orth(np.hstack([vectors.real, vectors.imag]), rcond=1e-8)
        images = np.stack([inverse(column) for column in space.T], axis=1)
        found = _ordered(sigma - 1 / eigvals(space.T @ images))
        if np.abs(values).min() < least or found[0].real > tolerated:
            return found
        count *= 2
    raise NotConvergedError(
        f"whether a steady pattern is stable could not be decided from the {count // 2} eigenvalues of its "
        "slowest perturbations; use a shorter band or fewer half waves."
    )


def eigenvalue_near(
    system: ReactionDiffusion, state: Array, guess: complex, heed: Callable[[], object] = lambda: None
) -> complex:
    """Return the eigenvalue nearest to a guess that is not real; heed: as of `rightmost_eigenvalues`."""
    n = 2 * system.space.size
    matrix = system.matrix(state)
    mass = system.matrix(state, 1.0) - matrix
    factors = splu(csc_array(matrix + guess * mass), permc_spec="MMD_AT_PLUS_A")

    def apply(x: Array) -> Array:
        heed()
        return np.asarray(factors.solve(mass @ x))

    inverse = LinearOperator((n, n), matvec=apply, dtype=complex)
    return _nearest(inverse, guess, 1)


def eigenvalue_right(
    system: ReactionDiffusion, state: Array, heed: Callable[[], object] = lambda: None
) -> complex:
    """Return the one with the largest real part of the four eigenvalues nearest to a point right of zero.

    The point is 0.03 times the size of the reaction's own rates.  heed: as of `rightmost_eigenvalues`.
    """
    p_u, _, _, q_v = system.kinetics.derivatives(*state)
    point = 0.03 * float(max(np.abs(p_u).max(), np.abs(q_v).max()))
    solve = system.solver(state, point)
    n = 2 * system.space.size

    def apply(x: Array) -> Array:
        heed()
        return solve(system.times_mass(x.reshape(2, -1))).ravel()

    return _nearest(LinearOperator((n, n), matvec=apply, dtype=float), point, 4)


def _nearest(inverse: LinearOperator, point: complex, count: int) -> complex:
    # (point·M − J)⁻¹ M has the eigenvalues 1 / (point − λ); a small basis, as few of its vectors are wanted:
    # ARPACK's usual one takes a third more solves
    n = inverse.shape[0]
    start = (1 + np.cos(np.arange(n))).astype(inverse.dtype)
    values = eigs(inverse, count, ncv=max(3 * count, 8), v0=start, return_eigenvectors=False, tol=1e-6)
    return complex(_ordered(point - 1 / values)[0])


def _ordered(values: ArrayLike) -> Complexes:
    found = np.asarray(values, dtype=np.complex128)
    return found[np.argsort(-found.real, kind="stable")]
