"""Half of a mirror-symmetric body gives the numbers of the whole at half the cost."""

from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshTri1

from turingfold.geometry.body import Body
from turingfold.geometry.mirror import half
from turingfold.geometry.roughness import geometric_imperfection
from turingfold.geometry.shapes import semicircle, semiellipse
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.laws import TangentialGrowth
from turingfold.morphometry.walls import self_intersections
from turingfold.results.simulate import simulate
from turingfold.scene import Scene
from turingfold.stepping import Stepping
from turingfold.terms.contact import SelfContact
from turingfold.terms.dynamics import Inertia
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic
from turingfold.terms.tension import AxonalTension
from turingfold.turing.kinetics.chemical import Schnakenberg
from turingfold.turing.process import Turing

T = 2.5e-3
SOLID = Elastic(gray=NeoHookean.from_young(1389.0, 0.4583), white=NeoHookean.from_young(1895.0, 0.4583))


def both(body, terms, processes, **options):
    """Return the results on the whole body and on its half."""
    terms = (SOLID, *terms)
    return [simulate(Scene(body=b, terms=terms, processes=processes, **options)) for b in (body, half(body))]


def check_alike(whole, right, rel, until=1.0):
    size, last = whole.scene.body.length, None
    for step, (one, other) in enumerate(zip(whole.history, right.history, strict=True)):
        assert one["time"] == other["time"]
        if one["time"] <= until * (1 + 1e-9):
            assert 2 * other["energy"] == pytest.approx(one["energy"], rel=rel)
            last = step + 1
    assert right.pial(last) == pytest.approx(whole.pial(last), abs=rel * size)


@pytest.mark.slow
def test_figure_3_folds_alike():
    """24 half waves of the pattern are 12 on the half; contact across the mirror line included."""
    body = semicircle(radius=0.0404, thickness=T, size=T / 2)
    whole, right = both(
        body,
        (AxonalTension(strength=0.5), SelfContact()),
        (Turing(Schnakenberg(), half_waves=24, symmetric=True), TangentialGrowth(cortex=1.9)),
    )
    check_alike(whole, right, 1e-6)
    numbers, expected = right.summary(), whole.summary()
    assert numbers["mirror_error"] == 0.0
    assert numbers["folds"] == expected["folds"]
    assert 2 * numbers["energy"] == pytest.approx(expected["energy"], rel=1e-3)
    assert numbers["registration"] == pytest.approx(expected["registration"], abs=0.01)
    assert numbers["gyrification_index"] == pytest.approx(expected["gyrification_index"], rel=1e-2)


def test_a_sulcus_on_the_mirror_line_closes_on_it():
    """With 22 half waves the apex is between two peaks: its walls meet on the mirror line."""
    body = semicircle(radius=0.0404, thickness=T, size=T / 2)
    pull, growth = AxonalTension(strength=0.5, patches=11), TangentialGrowth(cortex=1.9)
    scene = Scene(body=half(body), terms=(SOLID, pull, SelfContact()), processes=(growth,))
    result = simulate(scene)
    x = (scene.body.nodes + result.last["displacement"])[0, scene.body.pial]
    assert x.min() == 0.0  # the apex itself
    assert np.sum(x < 3e-4) >= 3  # walls as close to the line as the barrier lets them
    assert self_intersections(result.pial(), closed=False) == 0
    # between the nodes, within half an edge of the crease's tip, the curve may pass the line, by little
    start, middle, end = (x[k : x.size - 2 + k : 2, None] for k in range(3))
    s = np.linspace(0, 1, 51)
    curve = (1 - s) * (1 - 2 * s) * start + 4 * s * (1 - s) * middle + s * (2 * s - 1) * end
    assert curve.min() > -0.004 * T


def test_ellipse_with_imperfection_and_inertia():
    body = semiellipse(width=0.0808, height=0.03, thickness=T, size=T / 2, base="roller")
    whole, right = both(
        body,
        (Inertia(density=1100.0),),
        (TangentialGrowth(cortex=1.5), Imperfection(amplitude=0.05, symmetric=True)),
        stepping=Stepping(first=0.05, tolerance=1e-10),
    )
    check_alike(whole, right, 1e-8)


def area(body):
    return body.quadrature.weights.sum()


def changed(body, **parts):
    return replace(body, mesh=replace(body.mesh, **parts))


def sheared(body):
    x, y = body.nodes
    return changed(body, doflocs=np.stack([x, y * (1 + 0.2 * x)]))


def cortex_on_the_right(body):
    kept = np.flatnonzero(body.in_cortex & (body.mesh.p[0][body.mesh.t].mean(0) > 0))
    return changed(body, _subdomains={"cortex": kept})


CROOKED = {
    "shifted": lambda body: changed(body, doflocs=body.nodes + np.array([[0.03], [0.0]])),
    "sheared": sheared,
    "rough": lambda body: geometric_imperfection(body, 0.005, modes=20, seed=0),
    "one node": lambda body: changed(body, doflocs=body.nodes + 1e-6 * (np.arange(body.nodes.shape[1]) == 9)),
    "cortex": cortex_on_the_right,
}


@pytest.mark.parametrize("way", CROOKED)
def test_only_symmetric_meshes_can_be_halved(way):
    body = CROOKED[way](semicircle(radius=1.0, thickness=0.2, size=0.1))
    with pytest.raises(ValueError, match="mirror-symmetric"):
        half(body)


def test_a_symmetric_mesh_with_triangles_across_the_line_cannot_be_halved():
    points = np.array([[-1.0, 1.0, -1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0, 0.5]])
    mesh = MeshTri1(points, np.array([[0, 1, 4], [1, 3, 4], [3, 2, 4], [2, 0, 4]]).T)
    sides = {"pial": lambda x: x[1] == 1.0, "base": lambda x: x[1] == 0.0}
    body = Body(mesh.with_boundaries(sides).with_subdomains({"cortex": [2]}), 0.5)
    with pytest.raises(ValueError, match="triangles across x = 0"):
        half(body)


@pytest.mark.parametrize("base", ["clamped", "roller"])
@pytest.mark.parametrize("of", ["shape", "thickness"])
def test_a_symmetric_roughness_can_be_halved(base, of):
    smooth = semiellipse(width=2.0, height=0.8, thickness=0.1, size=0.05, base=base)
    for seed in range(3):
        rough = geometric_imperfection(smooth, 0.005, of=of, modes=20, seed=seed, symmetric=True)
        right = half(rough)
        assert 2 * area(right) == pytest.approx(area(rough), rel=1e-12)
        assert 1e-4 < np.abs(rough.nodes - smooth.nodes).max() < 0.03
        mirrored = rough.nodes * [[-1.0], [1.0]]
        assert set(map(tuple, mirrored.T.tolist())) == set(map(tuple, rough.nodes.T.tolist()))
