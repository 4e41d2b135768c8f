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


def check_alike(whole, right, rel):
    assert 2 * right.history[-1]["energy"] == pytest.approx(whole.history[-1]["energy"], rel=rel)
    size = whole.scene.body.length
    assert right.pial() == pytest.approx(whole.pial(), abs=rel * size)
    for one, other in zip(whole.history, right.history, strict=True):
        assert one["time"] == other["time"]


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
    assert numbers["registration"] == pytest.approx(expected["registration"], abs=1e-4)
    assert numbers["gyrification_index"] == pytest.approx(expected["gyrification_index"], rel=1e-6)


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
