"""Patterns from local disturbances, where no small one grows."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from turingfold import (
    AxonalTension,
    GrayScott,
    Scene,
    Schnakenberg,
    SeededPattern,
    Turing,
    half,
    semicircle,
    simulate,
)
from turingfold.errors import NotConvergedError
from turingfold.growth.laws import TangentialGrowth
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic

MODEL = GrayScott(F=0.04, k=0.06)  # its only steady state, (1, 0), is stable
D = 0.012**2
BODY = semicircle(radius=0.5, thickness=0.06, size=0.03)


def seeded(**changes):
    given = {"d_u": 2 * D, "d_v": D, "disturbed": (0.5, 0.25), "places": (0.5,), "width": 0.3}
    return SeededPattern(MODEL, **(given | changes))


def on_a_line(length, count=200):
    """Return v of Gray and Scott's model on a line, by finite differences and scipy's LSODA, (count,)."""
    x = (np.arange(count) + 0.5) / count
    strength = (np.abs(x - 0.5) * length < 0.15) * (1 + 0.01 * x)
    start = np.stack([1 - 0.5 * strength, 0.25 * strength], axis=1)

    def rate(_, w):
        w = w.reshape(count, 2)
        ends = np.pad(w, [(1, 1), (0, 0)], mode="edge")  # no flux
        spread = (ends[2:] - 2 * w + ends[:-2]) * (count / length) ** 2
        u, v = w.T
        p = -u * v**2 + MODEL.F * (1 - u) + 2 * D * spread[:, 0]
        q = u * v**2 - (MODEL.F + MODEL.k) * v + D * spread[:, 1]
        return np.stack([p, q], axis=1).ravel()

    run = solve_ivp(
        rate, (0.0, 2e4), start.ravel(), method="LSODA", rtol=1e-6, atol=1e-9, lband=2, uband=2, t_eval=[2e4]
    )
    return run.y[1::2, -1]


def peaks(v):
    return int(((v[1:-1] > v[:-2]) & (v[1:-1] >= v[2:])).sum() + (v[0] > v[1]) + (v[-1] > v[-2]))


def test_seeds_grow_into_the_pattern_that_a_line_has():
    fields = seeded().on(BODY).start(None, 0)
    line = on_a_line(np.pi * 0.47)  # the middle of the band
    band = BODY.cortex
    place = np.full(BODY.nodes.shape[1], -1)
    place[band.nodes] = np.arange(len(band.nodes))
    along = fields["activator"][place[BODY.pial]]
    assert peaks(along) == peaks(line) >= 2
    assert along.max() == pytest.approx(line.max(), rel=0.02)
    assert fields["pattern"].min() == 0.0
    assert fields["pattern"].max() == 1.0


def test_a_small_disturbance_dies_and_the_error_says_so():
    with pytest.raises(NotConvergedError, match="nothing is left of the disturbance"):
        seeded(disturbed=(0.99, 0.01)).on(BODY).start(None, 0)
    with pytest.raises(ValueError, match="only a large, local disturbance starts"):
        Turing(MODEL)


def test_axons_pull_where_the_spots_are():
    gray = NeoHookean(mu=1.0, kappa=5.0)
    terms = (Elastic(gray=gray), AxonalTension(strength=1e-3, ramp=0.1))
    growth = TangentialGrowth(cortex=1.05)
    result = simulate(Scene(body=BODY, processes=(seeded(), growth), terms=terms, until=0.1))
    assert result.status == "converged"
    assert np.ptp(result.last["pattern"]) == 1.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"places": (1.2,)}, r"places=.*from 0 to 1"),
        ({"places": ()}, "places"),
        ({"d_u": -1.0}, "d_u"),
        ({"uniform": (0.5, 0.5)}, "is not steady"),
        ({"activator": "w"}, "activator"),
        ({"disturbed": (np.nan, 0.0)}, "disturbed"),
    ],
)
def test_bad_input_is_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        seeded(**changes)


def test_places_are_shares_of_the_whole_surface_on_half_a_body_too():
    right, law = half(BODY), seeded(places=(0.1, 0.3), width=0.2)
    every = [law.on(body) for body in (BODY, right)]
    at = [one.linear.space.nodes[:, one.seeds.any(axis=1)].T.round(12) for one in every]
    assert sorted(map(tuple, at[0])) == sorted(map(tuple, at[1]))
    with pytest.raises(ValueError, match="half a body has the shares"):
        seeded(places=(0.3, 0.7)).on(right)


def test_seeds_narrower_than_elements_are_refused():
    with pytest.raises(ValueError, match="no node of the band lies in a seed so narrow"):
        seeded(width=1e-6, places=(0.503,)).on(BODY)
    with pytest.raises(ValueError, match="kinetics"):
        SeededPattern(3, d_u=1.0, d_v=1.0, disturbed=(0, 0), places=(0.5,), width=0.1)
    assert SeededPattern(
        Schnakenberg(), d_u=1e-3, d_v=1e-2, disturbed=(2.0, 0.5), places=(0.5,), width=0.1, activator="u"
    )
