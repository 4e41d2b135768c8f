"""Estimated errors against those that a reference on finer meshes shows: between a third and three times."""

import json
import time
from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshTri1
from small import GRAY, elastic_scene, folding_scene

from turingfold import (
    Body,
    Drag,
    Elastic,
    NeoHookean,
    Scene,
    Stepping,
    StoppedError,
    StressGrowth,
    TangentialGrowth,
    UnfinishedWarning,
    load,
    semicircle,
    simulate,
)
from turingfold.extend import Load
from turingfold.geometry.refinement import at_finer_points, prolongation, refined
from turingfold.parts import Operator
from turingfold.results.measures import shape_numbers
from turingfold.results.units import with_error
from turingfold.terms.line import DeadLoad

ROLLING = semicircle(radius=1.0, thickness=0.25, size=0.25, base="roller")


def numbers(result):
    return shape_numbers(result.scene.body, result.last["displacement"]) | {
        "energy": result.history[-1]["energy"]
    }


def effectivities(scene, times):
    """Return estimated over true errors; the truth is that of two mesh sizes, extrapolated by their order."""
    result = simulate(scene, errors=True)
    assert not result.no_errors
    found = [numbers(result)]
    found += [numbers(simulate(replace(scene, body=refined(scene.body, k)))) for k in times]
    shares = {}
    for name, off in result.errors.items():
        values = [one[name] for one in found]
        if (name == "gyrification_index" and values[-1] < 1.0001) or not any(values):  # it does not fold
            assert off < 1e-4
            continue
        *_, last, finest = values
        ratio = abs((finest - last) / (last - values[0])) if len(times) > 1 else 0.0
        truth = finest + (finest - last) * ratio / (1 - ratio) if 0 < ratio < 0.8 else finest
        shares[name] = off / abs(truth - values[0])
    return shares


class Pull(Load):
    """A dead traction upwards on the right side, as on Cook's membrane."""

    def on(self, body):
        class Pulled(Operator):
            def during(self, state, step):
                nodes, forces = body.boundary_path("right")[0], np.zeros((body.nodes.shape[1], 2))
                for a, b, c in zip(nodes[:-2:2], nodes[1::2], nodes[2::2], strict=True):
                    length = abs(body.nodes[1, c] - body.nodes[1, a])
                    forces[[a, b, c], 1] += state.time * length / 16 * np.array([1, 4, 1]) / 6
                return DeadLoad(forces.ravel())

        return Pulled()


def cook(n=4):
    s, t = (grid := MeshTri1.init_tensor(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))).p
    sides = {
        "pial": lambda x: np.isclose(x[1], 44 + x[0] / 3), "base": lambda x: x[0] == 0,
        "right": lambda x: x[0] == 48,
    }  # fmt: skip
    mesh = MeshTri1(np.stack([48 * s, 44 * s + t * (44 - 28 * s)]), grid.t).with_boundaries(sides)
    soft = NeoHookean.from_young(1.0985, 0.3)
    return Scene(body=Body(mesh, 8.0, "clamped"), terms=(Elastic(gray=soft), Pull()))


def bent_strip():
    sides = {"pial": lambda x: x[1] == 1, "base": lambda x: x[0] == 0}
    mesh = MeshTri1.init_tensor(np.linspace(0, 4, 9), np.linspace(0, 1, 3)).with_boundaries(sides)
    return elastic_scene(TangentialGrowth(cortex=1.4), body=Body(mesh, 0.5, "clamped"))


SCENES = {
    "disc": lambda: elastic_scene(body=ROLLING),
    "clamped disc": elastic_scene,
    "Cook's membrane": cook,
    "bent strip": bent_strip,
    "growth by stress": lambda: elastic_scene(TangentialGrowth(cortex=1.3), StressGrowth(rate=1.0)),
    "incompressible disc": lambda: incompressible(ROLLING),
    "growth at a clamp": lambda: growing_at_a_clamp(),  # its energy is of order 0.7
    "clamped incompressible disc": lambda: incompressible(None),  # its length converges as h^0.6, at its ends
}


def growing_at_a_clamp():
    gray, white = NeoHookean.from_young(1.0, 0.48), NeoHookean.from_young(2.0, 0.48)
    body = semicircle(radius=1.0, thickness=0.25, elements=3)
    return Scene(
        body=body, terms=(Elastic(gray=gray, white=white),), processes=(TangentialGrowth(cortex=1.3),)
    )


def incompressible(body):
    return replace(elastic_scene(body=body), terms=(Elastic(gray=NeoHookean.from_young(3.0, 0.4999)),))


@pytest.mark.parametrize("name", SCENES)
def test_estimates_are_within_a_factor_of_three(name):
    shares = effectivities(SCENES[name](), (1, 2))
    assert {"perimeter", "energy"} <= set(shares)
    assert all(1 / 3 < share < 3 for share in shares.values()), shares


@pytest.mark.slow
def test_estimates_of_a_folded_body_with_touching_walls_are_within_a_factor_of_three():
    shares = effectivities(folding_scene(), (1, 2))
    assert set(shares) == {"perimeter", "gyrification_index", "sulcal_depth", "energy"}
    assert all(1 / 3 < share < 3 for share in shares.values()), shares


def test_the_finer_mesh_has_the_same_fields():
    finer = refined(ROLLING)
    x, y = ROLLING.nodes
    along = prolongation(ROLLING, finer) @ (x * y - x**2)
    straight = np.abs(finer.nodes[1]) < 0.5  # curved elements are no polynomials in x and y
    straight &= np.hypot(*finer.nodes) < 0.6
    X, Y = finer.nodes
    np.testing.assert_allclose(along[straight], (X * Y - X**2)[straight], atol=1e-14)
    places = at_finer_points(ROLLING, ROLLING.quadrature.points)  # the map of an element is quadratic
    np.testing.assert_allclose(places, finer.quadrature.points, atol=1e-14)


def test_errors_fall_with_the_mesh():
    coarse, fine = (
        simulate(elastic_scene(body=body), errors=True).errors for body in (ROLLING, refined(ROLLING))
    )
    assert all(fine[name] < 0.3 * coarse[name] for name in ("perimeter", "energy"))


def test_errors_are_kept_in_the_folder_and_absent_when_off(tmp_path):
    scene = elastic_scene()
    made = simulate(scene, tmp_path / "on")
    assert made.errors["energy"] > 0
    assert load(tmp_path / "on").errors == made.errors
    assert json.loads((tmp_path / "on" / "summary.json").read_text())["errors"] == made.errors
    assert "error estimate" in made.seconds_by_part
    off = simulate(scene, tmp_path / "off", errors=False)
    assert off.errors == simulate(scene).errors == {}
    assert "error estimate" not in off.seconds_by_part


def test_a_time_limit_leaves_no_time_for_estimates(tmp_path, monkeypatch):
    late, rows = [0.0], []
    for module in ("solve.newton", "results.simulate"):
        monkeypatch.setattr(f"turingfold.{module}.perf_counter", lambda: time.perf_counter() + late[0])

    def stall(row):
        rows.append(row)
        late[0] = 200.0 if len(rows) == 2 else 0.0

    scene = elastic_scene(stepping=Stepping(first=0.1, largest=0.1, seconds=100.0))
    with pytest.raises(StoppedError, match="time limit of 100 s"):
        simulate(scene, tmp_path / "out", progress=stall)
    late[0] = 0.0
    with pytest.warns(UnfinishedWarning):
        found = load(tmp_path / "out")
    assert len(found.history) == 2
    assert found.errors == found.quadrature_errors == {}
    assert found.no_errors == found.no_step_errors == "The time limit was reached."
    assert "error estimate" not in found.seconds_by_part
    whole = simulate(scene, tmp_path / "out", resume=True)
    assert whole.errors["energy"] > 0


def test_a_motion_says_why_it_has_none():
    result = simulate(
        Scene(
            body=ROLLING, terms=(Elastic(gray=GRAY), Drag(coefficient=1.0)),
            processes=(TangentialGrowth(cortex=1.2),),
        ), errors=True,
    )  # fmt: skip
    assert result.errors == {}
    assert "turingfold accuracy" in result.no_errors


@pytest.mark.parametrize(("number", "error", "words"), [
    (1.4371, 0.0261, "1.44 ± 0.03"), (1.4371, 0.0032, "1.437 ± 0.003"), (12.3, 3.2, "12 ± 3"),
    (1.4371, None, "1.44 ± ?"), (1.4371, float("nan"), "1.44 ± ?"), (1.4371, 0.0, "1.44"),
    (1.4371, 3e-6, "1.4371 ± 0.0001"), (0.5, 0.0098, "0.50 ± 0.01"), (1.4371, 12.0, "1 ± 12"),
])  # fmt: skip
def test_numbers_are_told_with_their_error(number, error, words):
    assert with_error(number, error) == words
