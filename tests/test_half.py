"""Half of a mirror-symmetric body gives the numbers of the whole at half the cost."""
import numpy as np
import pytest

from turingfold.geometry import half, semicircle, semiellipse
from turingfold.growth import TangentialGrowth
from turingfold.imperfection import Imperfection
from turingfold.mechanics.contact import SelfContact
from turingfold.mechanics.dynamics import Inertia
from turingfold.mechanics.elastic import Elastic
from turingfold.mechanics.material import NeoHookean
from turingfold.run import simulate
from turingfold.scene import Scene, Stepping
from turingfold.tension import AxonalTension
from turingfold.turing.concentrations import Schnakenberg
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


def test_figure_3_folds_alike():
    """24 half waves of the pattern are 12 on the half; contact across the mirror line included.

    At t = 0.85 both snap. On its way the whole body could also fall to either side, so that its steps are
    made convex in other ways; from then on the two are near, not the same.
    """
    body = semicircle(radius=0.0404, thickness=T, size=T / 2)
    whole, right = both(
        body,
        (AxonalTension(strength=0.5), SelfContact()),
        (Turing(Schnakenberg(), half_waves=24, symmetric=True), TangentialGrowth(cortex=1.9)),
    )
    check_alike(whole, right, 1e-6, until=0.8)
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
    assert result.summary()["self_intersections"] == 0


def test_ellipse_with_imperfection_and_inertia():
    body = semiellipse(width=0.0808, height=0.03, thickness=T, size=T / 2, base="roller")
    whole, right = both(
        body,
        (Inertia(density=1100.0),),
        (TangentialGrowth(cortex=1.5), Imperfection(amplitude=0.05, symmetric=True)),
        stepping=Stepping(first=0.05, tolerance=1e-10),
    )
    check_alike(whole, right, 1e-8)


def test_only_symmetric_meshes_can_be_halved():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    crooked = type(body)(body.mesh.translated((0.03, 0.0)), 0.2, body.base)
    with pytest.raises(ValueError, match="mirror-symmetric"):
        half(crooked)
