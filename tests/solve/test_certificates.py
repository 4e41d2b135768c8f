"""Tangents of places nearby speak for equilibria: against a factorisation at each of them."""

import numpy as np
import pytest

from turingfold import (
    Elastic,
    NeoHookean,
    Scene,
    Stepping,
    TangentialGrowth,
    geometric_imperfection,
    semiellipse,
)
from turingfold.solve.inertia import negative_pivots
from turingfold.solve.march import begin, march
from turingfold.solve.problem import Problem
from turingfold.solve.sparsity import Assembler

GRAY, WHITE = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)


def scene(seed):
    """Return a random body that grows past its first instabilities."""
    rng = np.random.default_rng(seed)
    thickness, steps = rng.choice([2e-3, 2.5e-3, 4e-3]), int(rng.choice([15, 20, 30, 50]))
    body = semiellipse(
        width=0.04 * rng.uniform(0.7, 1.4),
        height=0.04,
        thickness=thickness,
        size=thickness / 2,
        base=str(rng.choice(["clamped", "roller"])),
    )
    return Scene(
        body=geometric_imperfection(body, 0.01 * thickness, seed=seed),
        terms=(Elastic(gray=GRAY, white=WHITE),),
        processes=(TangentialGrowth(cortex=rng.uniform(1.4, 2.2)),),
        stepping=Stepping(first=1 / steps, largest=1 / steps),
    )


@pytest.mark.slow
def test_tangents_nearby_tell_stability():
    answers = []
    for seed in range(8):
        made = scene(seed)
        problem = Problem(made)
        assembler = Assembler(problem.n_dofs, problem.held)
        for step, progress in march(made, begin(made), problem):
            kept = progress.memory.point
            if kept is not None and not np.array_equal(kept, step.x):  # its tangent was not factorised here
                here = negative_pivots(*assembler.assemble(step.at.hessians(0.0)))
                answers.append((step.numbers["negative_pivots"] == 0) == (here == 0))
    assert len(answers) > 60
    assert all(answers)
