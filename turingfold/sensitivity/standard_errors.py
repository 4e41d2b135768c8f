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
    """Return about how much weighted second differences change fitted values, (p,).

    Minimising |r|² + |R β|² moves β by (JᵀJ + RᵀR)⁻¹ RᵀR β; of the true β, for which the fitted one stands.
    jacobian: of all residuals, those of the roughness R (rows, p) among them.
    """
    if not len(roughness):
        return np.zeros(len(values))
    return np.asarray(
        np.linalg.pinv(jacobian.T @ jacobian, hermitian=True) @ (roughness.T @ (roughness @ values))
    )


def told(jacobian: Array, spread: Array) -> Told:
    """Return what residuals tell of the parameters that make them.

    β errs by A ε with A the pseudo-inverse of the Jacobian (rows, p); spread: standard deviation of the
    residuals' errors ε, (rows,), taken as independent.
    """
    scale = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
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
