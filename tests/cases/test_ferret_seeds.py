"""The ferret family's statements do not hang on the seed of the imperfection."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.sparse.linalg import eigsh
from test_ferret import CASES, folds, index

from turingfold import Stepping, simulate
from turingfold.cli.case import load_case
from turingfold.geometry.body import by_node
from turingfold.morphometry.walls import self_intersections
from turingfold.parts import TimeStep
from turingfold.terms.dynamics import mass
from turingfold.terms.quadratic_energy import SymmetricMatrix

SEEDS = (1, 2)  # test_ferret has 0


@pytest.fixture(scope="module")
def grown():
    """Return a function (finer, seed) -> result of a brain of ferret_mesh; each is run once."""

    @cache
    def result(finer, seed):
        return simulate(load_case(CASES / "ferret_mesh.py").scenes({"seed": seed}, quick=False)[f"{finer} x"])

    return result


def places(result):
    """Return the sulci's places as shares of the surface, of the whole brain where half is computed."""
    return folds(result).sulci / (result.pial().shape[1] - 1)


def least_eigenvalue(scene, state):
    """Return the least eigenvalue of the energy's Hessian without drag, per mass of density 1."""
    body, x = scene.body, by_node(state["displacement"])
    free = np.setdiff1d(np.arange(len(x)), body.supported)
    elastic, walls, _ = scene.terms
    parts = [term.on(body).during(state, TimeStep(1.0)).evaluate(x) for term in (elastic, walls)]
    total = sum(SymmetricMatrix.from_lower(at.hessian(0.0), len(x)).whole for at in parts if at.has_hessian)
    stiffness, weights = (matrix[free][:, free].tocsc() for matrix in (total, mass(body, 1.0).whole))
    return eigsh(stiffness, 1, weights, sigma=-400.0, return_eigenvectors=False)[0]


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS[:1])
def test_folds_do_not_depend_on_the_mesh_for_any_seed(grown, seed):
    coarse, fine = grown(1, seed), grown(4, seed)
    assert folds(coarse).count == folds(fine).count >= 8
    assert places(coarse) == pytest.approx(places(fine), abs=0.02)  # a fifth of their distance
    assert index(coarse) == pytest.approx(index(fine), rel=0.02)


@pytest.mark.slow
def test_folds_do_not_depend_on_the_time_step(grown):
    result = grown(1, 1)
    halved = replace(result.scene, stepping=Stepping(first=1 / 80, largest=1 / 80))
    results = [result, simulate(halved)]
    assert folds(results[0]).count == folds(results[1]).count
    assert places(results[0]) == pytest.approx(places(results[1]), abs=0.02)
    assert index(results[0]) == pytest.approx(index(results[1]), rel=0.005)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_steps_resolve_the_motion_past_the_onset(grown, seed):
    result = grown(1, seed)
    scene = result.scene
    drag, lowest = scene.terms[2].coefficient, []
    for state, row in list(zip(result.states[1:], result.history, strict=True))[19::2]:
        lowest.append(least_eigenvalue(scene, state))
        assert lowest[-1] > -drag / row["step"]  # a minimum with the drag of its own step
    assert min(lowest) < -10.0  # unstable without
    assert max(row["negative_pivots"] for row in result.history) == 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_local_changes_act_in_their_zone_for_any_seed(seed):
    every = load_case(CASES / "ferret_local.py").scenes({"seed": seed}, quick=False)
    scenes = {name: every[name] for name in ("normal", "2 g", "0.25 T")}
    middle, apart = {}, {}
    for name, scene in scenes.items():
        result = simulate(scene)
        at, depths = places(result), folds(result).depths
        zone = np.abs(at - 0.5) < 0.15
        middle[name] = zone.sum(), depths[zone].mean()
        # sulci beyond the zone's half width and smooth edge, on either side: how far apart
        apart[name] = np.concatenate([np.diff(at[at < 0.28]), np.diff(at[at > 0.72])])
    assert middle["2 g"][1] > 1.2 * middle["normal"][1]
    assert middle["0.25 T"][0] >= 2 * middle["normal"][0]
    assert apart["0.25 T"].min() > 0.6 * apart["normal"].mean()  # fine folds would be 0.25 as far apart


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1])
def test_stages_can_be_traced_and_deepen_for_any_seed(seed):
    stages = load_case(CASES / "ferret_stages.py").scenes({"seed": seed}, quick=False)
    results = [simulate(scene) for scene in stages.values()]
    assert (np.diff([index(result) for result in results]) > 0.05).all()
    for result in results:
        assert self_intersections(result.pial(), closed=True, quadratic=True) == 0
