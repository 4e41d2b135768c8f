"""The adjoint of an equilibrium: one solve for each measure, whatever the number of parameters.

A measure m of an equilibrium g(x, p) = 0 changes with a parameter by dm/dp = -λ·∂g/∂p, where K λ = ∂m/∂x and
K = ∂g/∂x is symmetric. λ is what a force at each node changes in m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..results.result import Result
from .measures import MEASURES, Measure, gradient_of, measures_of, pial_at
from .parameters import number_of
from .tangent import Equilibrium


@dataclass(frozen=True, eq=False)
class AdjointSensitivity:
    """Derivatives of m measures with respect to p parameters, and to forces.

    derivatives: (m, p).  forces: by how much each measure changes with a force at each node, (m, 2, n_nodes);
    per N for each m of depth; 0 where nodes are held.  errors: of ∂g/∂p, relative, (p,).
    negative_pivots: of the tangent; 0 at a minimum.
    """

    parameters: tuple[str, ...]
    values: Array
    measures: tuple[str, ...]
    numbers: Array
    derivatives: Array
    forces: Array
    errors: Array
    negative_pivots: int


def adjoint_sensitivity(
    result: Result, *, to: Sequence[str] = (), of: Sequence[str | Measure] = MEASURES, step: int = -1
) -> AdjointSensitivity:
    """Return the derivatives of measures with respect to parameters, and to forces at the nodes.

    dm/dp = ∂m/∂p - λ·∂g/∂p, K λ = ∂m/∂x; of the energy ∂E/∂p, its λ being 0. Cheaper than `sensitivity` where
    there are more parameters than measures, as with a map of growth; it does not say how far they hold.
    to, of: as in `sensitivity`; without `to` only the effect of forces is computed.
    Raises ValueError and NotConvergedError as `sensitivity` does.
    """
    here = Equilibrium.of(result, step)
    values = np.array([number_of(result.scene, parameter) for parameter in to])
    measures = measures_of(result, of)
    points = pial_at(result, here.x)
    still = np.zeros(len(here.x))
    adjoints = np.stack(
        [
            still if measure is None else here.tangent.solve(gradient_of(result, measure, here.x))
            for measure in measures.values()
        ]
    )
    derivatives, errors = np.zeros((len(measures), len(to))), np.zeros(len(to))
    own = np.array([measure is None for measure in measures.values()], dtype=float)
    for k, parameter in enumerate(to):
        found = here.change(parameter)
        derivatives[:, k] = own * found.energy - adjoints @ found.gradient
        errors[k] = found.error
    return AdjointSensitivity(
        parameters=tuple(to), values=values, measures=tuple(measures),
        numbers=np.array([here.at.energy if m is None else m(points) for m in measures.values()]),
        derivatives=derivatives, forces=adjoints.reshape(len(measures), -1, 2).swapaxes(1, 2), errors=errors,
        negative_pivots=here.tangent.factors.negative,
    )  # fmt: skip
