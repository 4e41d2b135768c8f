"""Tangents of places nearby speak for equilibria: against a factorisation at each of them."""
import numpy as np
import pytest

from turingfold import (
    Elastic,
    NeoHookean,
    Scene,
    Stepping,
    TangentialGrowth,
    roughened,
    semiellipse,
    simulate,
)
from turingfold.solve.newton import Minimiser

GRAY, WHITE = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)


def scene(seed):
    """Return a random body that grows past its first instabilities."""
    rng = np.random.default_rng(seed)
    thickness, steps = rng.choice([2e-3, 2.5e-3, 4e-3]), int(rng.choice([15, 20, 30, 50]))
    body = semiellipse(
        width=0.04 * rng.uniform(0.7, 1.4), height=0.04, thickness=thickness, size=thickness / 2,
        base=str(rng.choice(["clamped", "roller"])),
    )
    return Scene(
        body=roughened(body, 0.01 * thickness, seed=seed),
        terms=(Elastic(gray=GRAY, white=WHITE),),
        processes=(TangentialGrowth(cortex=rng.uniform(1.4, 2.2)),),
        stepping=Stepping(first=1 / steps, largest=1 / steps),
    )


@pytest.mark.slow
def test_tangents_nearby_tell_stability(monkeypatch):
    answers = []
    certified = Minimiser._certified

    def compared(self, at, x, guess, origin, last):
        negative, factorizations = certified(self, at, x, guess, origin, last), self.effort.factorizations
        if last is not None and self._tangent is last:  # it was not factorised here
            answers.append((negative == 0) == (self._factorized(at, x, 0.0) is not None))
            self.effort.factorizations = factorizations
            last.solver.factorize(last.values)
        return negative

    monkeypatch.setattr(Minimiser, "_certified", compared)
    for seed in range(8):
        simulate(scene(seed))
    assert len(answers) > 60
    assert all(answers)
