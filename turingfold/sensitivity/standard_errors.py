"""How sure fitted parameters are, and which of their combinations the targets do not tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from .smoothing import SPLINE

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


def noise_of(outlines: Array, landmarks: Array, points: Array, marked: int, parameters: int) -> float:
    """Return the standard deviation of the targets' points that residuals show, in their unit.

    outlines, landmarks: sums of squares of each age, (ages,), in which all points of an outline count as
    one, and a landmark as one of them.  points: of each outline, (ages,).  marked: coordinates of landmarks.
    An outline is compared with a spline through its points, which holds SPLINE of their variance.
    """
    squares = float(points @ (outlines / SPLINE + landmarks))
    return float(np.sqrt(squares / max(int(points.sum()) + marked - parameters, 1)))
