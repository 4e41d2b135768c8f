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
from ..solve.threads import one_thread
from .change import warn_of_rough
from .measures import MEASURES, Measure, gradient_of, measures_of, numbers_at
from .parameters import counted, values_in
from .tangent import Equilibrium
from .validity import is_kinked


@dataclass(frozen=True, eq=False)
class AdjointSensitivity:
    """Derivatives of m measures with respect to p parameters, and to forces.

    derivatives: (m, p).  forces: by how much each measure changes with a force at each node, (m, 2, n_nodes);
    per N for each m of depth; 0 where nodes are held.  errors: of ∂g/∂p, relative, (p,).
    jumps: of ∂m/∂x, relative, where a measure jumps or has a kink, (m,).
    negative_pivots: of the tangent; 0 at a minimum.
    """

    parameters: tuple[str, ...]
    values: Array
    measures: tuple[str, ...]
    numbers: Array
    derivatives: Array
    forces: Array
    errors: Array
    jumps: Array
    negative_pivots: int

    def __repr__(self) -> str:
        """Return it in a line; the arrays would fill pages."""
        to = f"{counted(self.parameters)} and to forces" if self.parameters else "forces"
        return f"AdjointSensitivity(of {', '.join(self.measures)} to {to})"


@one_thread
def adjoint_sensitivity(
    result: Result, *, to: Sequence[str] = (), of: Sequence[str | Measure] = MEASURES, step: int = -1
) -> AdjointSensitivity:
    """Return the derivatives of measures with respect to parameters, and to forces at the nodes.

    dm/dp = ∂m/∂p - λ·∂g/∂p, K λ = ∂m/∂x; of the energy ∂E/∂p, its λ being 0. One solve a measure, where
    `sensitivity` has one a parameter, as with a map of growth; it does not say how far they hold. Depths and
    functions of one's own are taken apart by differences, four evaluations for each pial displacement.
    to, of: as in `sensitivity`; without `to` only the effect of forces is computed.
    Raises and warns as `sensitivity` does.
    """
    here = Equilibrium.of(result, step)
    values = values_in(result.scene, to)
    measures = measures_of(result, of)
    still = np.zeros(len(here.x))
    free = here.tangent.assembler.free
    gradients = [
        (still, 0.0) if measure is None else gradient_of(result, measure, here.x, free)
        for measure in measures.values()
    ]
    adjoints = np.stack([here.tangent.solve(each) if each.any() else still for each, _ in gradients])
    derivatives, errors = np.zeros((len(measures), len(to))), np.zeros(len(to))
    numbers = numbers_at(result, measures, here.x, here.at.energy)
    own = np.array([measure is None for measure in measures.values()], dtype=float)
    for k, parameter in enumerate(to):
        found = here.change(parameter)
        derivatives[:, k] = own * found.energy - adjoints @ found.gradient
        errors[k] = found.error
        lost = own * found.lost_energy + np.abs(adjoints @ found.lost)
        if is_kinked(lost, derivatives[:, k], values[k], numbers).any():
            warn_of_rough([parameter], errors[[k]])
    return AdjointSensitivity(
        parameters=tuple(to), values=values, measures=tuple(measures),
        numbers=numbers,
        derivatives=derivatives, forces=adjoints.reshape(len(measures), -1, 2).swapaxes(1, 2), errors=errors,
        jumps=np.array([jump for _, jump in gradients]), negative_pivots=here.tangent.factors.negative,
    )  # fmt: skip
