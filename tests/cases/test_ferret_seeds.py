"""The ferret family's statements do not hang on the seed of the imperfection."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import eigsh
from test_ferret import CASES, folds, index

from turingfold import Stepping, simulate
from turingfold.cli.case import load_case
from turingfold.geometry.body import by_node
from turingfold.parts import TimeStep
from turingfold.terms.dynamics import mass
from turingfold.terms.quadratic_energy import SymmetricMatrix


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
def test_folds_depend_neither_on_the_mesh_nor_on_the_steps_which_resolve_the_motion():
    scenes = load_case(CASES / "ferret_mesh.py").scenes({"seed": 1}, quick=False)
    coarse, fine = (simulate(scenes[f"{finer} x"]) for finer in (1, 4))  # 8 x and 12 x take minutes
    halved = simulate(replace(coarse.scene, stepping=Stepping(first=1 / 80, largest=1 / 80)))
    for other, within in ((fine, 0.02), (halved, 0.005)):
        assert folds(coarse).count == folds(other).count >= 8
        assert places(coarse) == pytest.approx(places(other), abs=0.02)  # a fifth of their distance
        assert index(coarse) == pytest.approx(index(other), rel=within)
    drag, lowest = coarse.scene.terms[2].coefficient, []
    for state, row in list(zip(coarse.states[1:], coarse.history, strict=True))[19::2]:
        lowest.append(least_eigenvalue(coarse.scene, state))
        assert lowest[-1] > -drag / row["step"]  # a minimum with the drag of its own step
    assert min(lowest) < -10.0  # unstable without
    assert max(row["negative_pivots"] for row in coarse.history) == 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1])
def test_local_changes_act_in_their_zone_for_any_seed(seed):
    # four elements through the cortex take half a minute, the case's nine ten
    every = load_case(CASES / "ferret_local.py").scenes({"seed": seed, "elements": 4.0}, quick=False)
    scenes = {name: every[name] for name in ("normal", "2 g", "0.25 T")}
    middle, apart = {}, {}
    for name, scene in scenes.items():
        result = simulate(scene)
        assert result.converged
        at, depths = places(result), folds(result).depths
        zone = np.abs(at - 0.5) < 0.15
        middle[name] = zone.sum(), depths[zone].mean()
        # sulci beyond the zone's half width and smooth edge, on either side: how far apart
        apart[name] = np.concatenate([np.diff(at[at < 0.28]), np.diff(at[at > 0.72])])
    assert middle["2 g"][1] > 1.2 * middle["normal"][1]
    assert middle["0.25 T"][0] >= 2 * middle["normal"][0]
    assert apart["0.25 T"].min() > 0.6 * apart["normal"].mean()  # fine folds would be 0.25 as far apart
