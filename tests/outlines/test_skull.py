"""A skull around sections: its area against formulas, and growth that it holds back."""

import numpy as np
import pytest
import shapely

from turingfold import (
    Elastic,
    NeoHookean,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    outline,
    semicircle,
    simulate,
    skull_around,
)

AT = 2 * np.pi * np.arange(160) / 160
CIRCLE = np.stack([np.cos(AT), np.sin(AT)])
GAP = 0.03


@pytest.fixture(scope="module")
def pair():
    """Two discs of radius 1, their centres 2.4 apart."""
    return outline([CIRCLE, CIRCLE + np.array([[2.4], [0.0]])], thickness=0.25, size=0.125)


def test_the_hull_of_two_discs_is_a_stadium_enlarged_by_the_gap(pair):
    skull = skull_around(pair, gap=GAP)
    assert (skull[:, 0] == skull[:, -1]).all()
    ring = shapely.Polygon(skull.T)
    assert ring.area == pytest.approx(np.pi * (1 + GAP) ** 2 + 2.4 * 2 * (1 + GAP), rel=1e-3)
    nodes = np.concatenate([pair.nodes[:, path.nodes] for path in pair.pial_paths], axis=1)
    least = shapely.distance(shapely.points(nodes.T), ring.exterior).min()
    assert least == pytest.approx(GAP, rel=2e-3)
    x, y = skull_around(pair, gap=GAP, closing=0.4)  # a disc of 0.4 fills the neck, but follows the waist
    waist = np.abs(y[np.abs(x - 1.2) < 0.2]).min()
    # the disc that touches both has its centre above the middle, √(1.4² - 1.2²) high
    assert waist == pytest.approx(np.sqrt(1.4**2 - 1.2**2) - 0.4 + GAP, abs=0.01)


@pytest.mark.filterwarnings("ignore::turingfold.HoldingForceWarning")  # the skull pushes
def test_growth_stays_inside_the_skull(pair):
    skull = skull_around(pair, gap=GAP)
    inside = shapely.Polygon(skull.T)

    def grown(contact):
        solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
        grow = TangentialGrowth(cortex=1.2, core=1.06, radial_core=1.06)
        steps = Stepping(first=0.1, largest=0.25)
        result = simulate(Scene(body=pair, terms=(solid, contact), processes=(grow,), stepping=steps))
        return np.concatenate(result.pial_parts(), axis=1)

    assert shapely.contains_xy(inside, *grown(SelfContact(skull=skull))).all()
    assert not shapely.contains_xy(inside, *grown(SelfContact())).all()


def test_what_is_not_closed_or_in_pieces_is_refused(pair):
    with pytest.raises(ValueError, match="for closed sections"):
        skull_around(semicircle(radius=1.0, thickness=0.2, size=0.2), gap=GAP)
    with pytest.raises(ValueError, match=r"closing=0\.1 m leaves 2 pieces"):
        skull_around(pair, gap=GAP, closing=0.1)
    with pytest.raises(ValueError, match="gap=0"):
        skull_around(pair, gap=0.0)
