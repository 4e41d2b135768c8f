"""How sure fitted parameters are, and which of their combinations the targets do not tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array

DISTINCT = 1e-4  # singular values below this share of the largest belong to what the targets do not tell
LOST = 0.1  # share of a parameter in such combinations beyond which it is not told itself


@dataclass(frozen=True, eq=False)
class Told:
    """Standard errors, (p,), infinite where the targets do not tell a parameter; and what they tell at all.

    distinct, singular_values, flat: as in `Fit`.
    """

    deviations: Array
    distinct: int
    singular_values: Array
    flat: Array


def smoothed_away(jacobian: Array, roughness: Array, values: Array) -> Array:
    """Return how far weighted second differences took fitted values from those of the data alone, (p,).

    At the least of |r|² + |R β|² it is Jᵀr + RᵀR β = 0; a Gauss-Newton step to Jᵀr = 0 is (JᵀJ)⁺ RᵀR β.
    jacobian: of the data, (rows, p).  roughness: R, (rows, p).
    """
    if not len(roughness):
        return np.zeros(len(values))
    inverse = np.linalg.pinv(jacobian.T @ jacobian, rcond=DISTINCT**2, hermitian=True)
    return np.asarray(inverse @ (roughness.T @ (roughness @ values)))


def told(jacobian: Array, spread: Array) -> Told:
    """Return what residuals tell of the parameters that make them.

    β errs by A ε with A the pseudo-inverse of the Jacobian (rows, p); spread: standard deviation of the
    residuals' errors ε, (rows,), taken as independent.
    """
    sizes = np.linalg.norm(jacobian, axis=0)
    scale = np.where(sizes > 0, sizes, 1.0)  # of a parameter without any effect
    left, singular, modes = np.linalg.svd(jacobian / scale, full_matrices=False)
    known = singular > DISTINCT * singular[0]
    inverse = (modes[known].T / singular[known]) @ left[:, known].T
    deviations = np.sqrt(inverse**2 @ spread**2) / scale
    lost = (modes[~known] ** 2).sum(0) > LOST
    flat = modes[~known] / scale
    return Told(
        deviations=np.where(lost, np.inf, deviations), distinct=int(known.sum()), singular_values=singular,
        flat=flat / np.linalg.norm(flat, axis=1, keepdims=True),
    )  # fmt: skip
