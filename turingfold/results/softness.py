"""How near an equilibrium is to losing its stability, as a share that needs no scale.

K is the tangent of the equilibrium and K⁺ the same with the negative parts of each element taken away. Along
a displacement d, what presses takes away the share 1 - d·K d / d·K⁺ d of the stiffness. The softest d keeps

    softness = min d·K d / d·K⁺ d:

1 where nothing presses, 0 at a limit point or a bifurcation. Near 0 a finer mesh, shorter steps or rounding
may lead to other folds, which no estimate at this equilibrium knows of.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from ..arrays import Array
from ..solve.problem import Problem
from ..solve.sparsity import Assembler
from ..state import State
from .carried import NoEstimateError, at_rest, refuse_motion, solution

# chosen after seeing 0.015 to 0.046 on four meshes that end before a snap which finer ones are past (0.05 to
# 0.14 on others), 0.051 or more past it, and 0.08 to 0.12 of folded bodies of Figure 3 and of document 2
SOFT = 0.05
CLOSE = 1e-2  # relative error of the softness


def softness(problem: Problem, state: State) -> float:
    """Return the share of its stiffness that the softest displacement keeps; negative at a saddle.

    It takes one factorisation. Raises NoEstimateError where terms resist motion, and where the softest
    displacement is not found.
    """
    refuse_motion(problem.scene)
    at, assembler = at_rest(problem, state), Assembler(problem.n_dofs, problem.held)
    true, convex = (assembler.assemble(at.hessians(convexity)) for convexity in (0.0, 1.0))
    shape = 2 * (len(assembler.free),)
    products = true[0].product(true[1]), convex[0].product(convex[1]), solution(*true, problem.scene)
    tangent, positive, inverse = (LinearOperator(shape, matvec=each, dtype=np.float64) for each in products)
    start: Array = np.random.default_rng(0).standard_normal(shape[0])
    try:
        # both ends of the inverse's: the negative and the positive eigenvalue that are nearest to zero
        found = eigsh(tangent, 2, positive, sigma=0.0, which="BE", OPinv=inverse, v0=start, tol=CLOSE,
                      return_eigenvectors=False)  # fmt: skip
    except ArpackError as error:
        raise NoEstimateError(f"the softest displacement is not found: {error}") from error
    return float(found.min())


def soft_words(share: float | None) -> str:
    """Return what to say of an equilibrium that is nearly unstable, or nothing."""
    if share is None or share >= SOFT:
        return ""
    if share < 0:
        return "the last state is past a limit of stability: it is no minimum of the energy"
    return (
        f"the last state is near a limit of stability (the softest displacement keeps {100 * share:.1f} % of "
        "its stiffness): with a finer mesh it may fold otherwise, which no estimated error includes"
    )
