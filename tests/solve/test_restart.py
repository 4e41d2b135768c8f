"""A march that goes on from a checkpoint takes the same steps to the last bit, whatever acts in it."""

import numpy as np
import pytest

from turingfold import (
    Drag,
    Elastic,
    Inertia,
    NeoHookean,
    Scene,
    SelfContact,
    Stepping,
    StiffnessDamping,
    TangentialGrowth,
    semicircle,
)
from turingfold.results.checkpoint import Checkpoint, from_arrays, to_arrays
from turingfold.results.files import arrays_content, read_arrays, write_whole
from turingfold.solve.march import begin, march
from turingfold.solve.newton import NEAR

SOLID = Elastic(gray=NeoHookean.from_young(1.0, 0.4))
MIXED = Elastic(gray=NeoHookean.from_young(1.0, 0.4), element="mixed")
WALLS = SelfContact()
SCENES = {
    "contact": (SOLID, WALLS),
    "drag": (SOLID, WALLS, Drag(coefficient=0.5)),
    "damping": (SOLID, StiffnessDamping(elastic=SOLID, time=0.05)),
    "inertia": (SOLID, Inertia(density=0.05)),
    "within an error": (SOLID, Inertia(density=0.05)),
    "midpoint": (SOLID, Inertia(density=0.05), Drag(coefficient=0.5)),
    "mixed": (MIXED, Drag(coefficient=0.5)),
}
SLOW = ("within an error", "midpoint", "mixed")


def stored(progress, file):
    write_whole(file, arrays_content(to_arrays(Checkpoint(progress, 1, 0.0, {}))))
    return from_arrays(read_arrays(file)).progress


def numbers(step):
    return {name: value for name, value in step.numbers.items() if name != "seconds"}


@pytest.mark.parametrize(
    ("name", "solver"),
    [
        *(pytest.param(name, "auto", marks=pytest.mark.slow if name in SLOW else ()) for name in SCENES),
        ("contact", "superlu"),  # one scene of them here, the others are slow
        *(pytest.param(name, "superlu", marks=pytest.mark.slow) for name in SCENES if name != "contact"),
    ],
)
def test_a_restart_repeats_every_bit(name, solver, tmp_path):
    body = semicircle(radius=1.0, thickness=0.25, size=0.2)
    # steps of lengths that time's round-off does not give back
    scheme = "midpoint" if name == "midpoint" else "euler"
    error = 0.02 if name == "within an error" else None
    steps = Stepping(first=0.03, largest=0.083, solver=solver, scheme=scheme, local_error=error)
    grow = TangentialGrowth(cortex=2.2)
    scene = Scene(body=body, terms=SCENES[name], processes=(grow,), until=1.7, stepping=steps)
    path = list(march(scene, begin(scene)))
    for (_, progress), (expected, _) in zip(path[:-1:4], path[1::4], strict=False):
        again, _ = next(march(scene, stored(progress, tmp_path / "checkpoint.npz")))
        assert numbers(again) == pytest.approx(numbers(expected), rel=0, abs=0, nan_ok=True)
        for field, values in expected.state.fields.items():
            assert np.array_equal(again.state[field], values), field


def test_a_restart_before_a_tangent_made_at_the_guess_repeats_every_bit(tmp_path):
    body = semicircle(radius=1.0, thickness=0.25, size=0.2)
    steps = Stepping(first=1 / 60, largest=1 / 60)
    scene = Scene(body=body, terms=(SOLID,), processes=(TangentialGrowth(cortex=1.6),), stepping=steps)
    path = list(march(scene, begin(scene)))
    good = [k for k, (_, progress) in enumerate(path[:-1]) if progress.memory.missed < NEAR]
    assert len(good) > 20
    for k in good[::5]:
        again, _ = next(march(scene, stored(path[k][1], tmp_path / "checkpoint.npz")))
        expected = path[k + 1][0]
        assert numbers(again) == pytest.approx(numbers(expected), rel=0, abs=0, nan_ok=True)
        assert np.array_equal(again.state["displacement"], expected.state["displacement"])


def test_a_checkpoint_without_word_of_the_last_guess_is_gone_on_with(tmp_path):
    body = semicircle(radius=1.0, thickness=0.25, size=0.2)
    scene = Scene(body=body, terms=(SOLID,), processes=(TangentialGrowth(cortex=1.2),))
    *_, (_, progress) = march(scene, begin(scene))
    arrays = to_arrays(Checkpoint(progress, 1, 0.0, {}))
    del arrays["memory.missed"]
    write_whole(tmp_path / "checkpoint.npz", arrays_content(arrays))
    assert from_arrays(read_arrays(tmp_path / "checkpoint.npz")).progress.memory.missed == np.inf
