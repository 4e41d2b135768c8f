"""Stiff films on closed discs and rings that grow inward snap, and still reach a certified end."""

import numpy as np
import pytest
from skfem import MeshTri1

from turingfold import (
    Body,
    Elastic,
    NeoHookean,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    outline,
    simulate,
)

YOUNG = 1e3


def disc():
    """A disc of ten cortical thicknesses that nothing holds, three elements through the cortex."""
    angle = 2 * np.pi * np.arange(240) / 240
    points = 0.025 * np.stack([np.cos(angle), np.sin(angle)])
    return outline(points, thickness=0.0025, size=0.0025 / 3, base="free")


def ring(inner=0.01, outer=0.02, around=94, across=12):
    """A ring held at its outer side, whose cortex lines the hole."""
    mesh = MeshTri1.init_tensor(np.linspace(0, 2 * np.pi, around + 1), np.linspace(inner, outer, across + 1))
    angle, radius = mesh.p
    columns = np.round(angle / (2 * np.pi) * around).astype(int) % around
    number = columns * (across + 1) + np.round((radius - inner) / (outer - inner) * across).astype(int)
    points = np.empty((2, number.max() + 1))
    points[:, number] = radius * np.stack([np.cos(angle), np.sin(angle)])
    found = MeshTri1(points, number[mesh.t])
    sides = {
        name: (lambda x, at=at: np.abs(np.hypot(*x) - at) < 1e-2 * inner)
        for name, at in (("pial", inner), ("base", outer))
    }
    return Body(found.with_boundaries(sides), thickness=0.002)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "ratio"), [(disc, 1.0), (disc, 3.0), (ring, 1.0), (ring, 3.0), (ring, 10.0)]
)
def test_stiff_cortices_reach_a_certified_end(shape, ratio):
    gray, white = NeoHookean.from_young(ratio * YOUNG, 0.4583), NeoHookean.from_young(YOUNG, 0.4583)
    scene = Scene(
        body=shape(), terms=(Elastic(gray=gray, white=white), SelfContact()),
        processes=(TangentialGrowth(cortex=1.8),), stepping=Stepping(seconds=1800.0),
    )  # fmt: skip
    result = simulate(scene)
    assert result.converged, result.message
    assert result.history[-1]["negative_pivots"] == 0
    summary = result.summary()
    assert summary["self_intersections"] == 0
    assert summary["folds"] >= 4
