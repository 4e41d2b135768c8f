"""Swelling: free discs, diffusion against Bessel's series, sources, zones, and what is refused."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import j0, j1, jn_zeros

from turingfold import (
    Elastic,
    Ellipse,
    NeoHookean,
    Scene,
    Stepping,
    Swelling,
    half,
    human,
    outline,
    semicircle,
    simulate,
)
from turingfold.geometry.body import Body
from turingfold.geometry.layers import cortex_indicator
from turingfold.geometry.refinement import refined
from turingfold.growth.diffusion import Diffusion
from turingfold.growth.histories import Exponential
from turingfold.state import State
from turingfold.testing import advanced, check_process

MU, KAPPA = 1.0, 3.0
REGION = Ellipse(centre=(0.0, 0.3), semi_axes=(0.3, 0.2), edge=0.1)


@pytest.fixture(scope="module")
def body():
    return semicircle(radius=1.0, thickness=0.2, size=0.1, base="roller")


@pytest.fixture(scope="module")
def disc():
    at = 2 * np.pi * np.arange(100) / 100
    return outline(np.stack([np.cos(at), np.sin(at)]), thickness=0.2, size=0.1, base="free")


def at(swelling, body, time):
    start = State(0.0, swelling.on(body).start(State(0.0), 0))
    return advanced(swelling, body, start, time)


@pytest.mark.parametrize(
    "swelling",
    [
        Swelling(coefficient=0.4),
        Swelling(coefficient=-0.5, zone=REGION, history=Exponential(), out_of_plane="fixed"),
        Swelling(coefficient=1.5, zone="cortex", diffusivity=0.02, source="pial"),
    ],
)
def test_swelling_passes_the_examination(body, swelling):
    check_process(swelling, body, State(0.0), 0.3)
    earlier = State(0.0, {"growth": np.full((3, *body.quadrature.weights.shape), 1.5)})
    growth = check_process(swelling, body, earlier, 0.3)["growth"]
    assert growth == pytest.approx(1.5 * at(swelling, body, 0.3)["growth"], rel=1e-14)


@pytest.mark.parametrize("out_of_plane", ["tangential", "fixed"])
def test_a_free_disc_swells_as_one_that_is_held_in_z_only(disc, out_of_plane):
    g = 1.3
    swell = Swelling(coefficient=g - 1, zone="all", out_of_plane=out_of_plane)
    scene = Scene(body=disc, terms=(Elastic(gray=NeoHookean(mu=MU, kappa=KAPPA)),), processes=(swell,),
                  stepping=Stepping(first=0.2, largest=0.2))  # fmt: skip
    result = simulate(scene)
    gz = g if out_of_plane == "tangential" else 1.0

    def pressure(stretch):  # dW/dstretch of F* = diag(stretch/g, stretch/g, 1/g_z), by hand
        a, z = stretch / g, 1 / gz
        J = a * a * z
        return MU * (2 * a * J ** (-2 / 3) - (2 / 3) * (2 * a * a + z * z) * J ** (-2 / 3) / a) + (
            2 * KAPPA * (J - 1) * a * z
        )

    stretch = brentq(pressure, 1.0, 2.0, xtol=1e-14)
    assert (stretch == pytest.approx(g, rel=1e-12)) == (out_of_plane == "fixed")
    moved, still = disc.nodes + result.last["displacement"], disc.nodes - disc.nodes.mean(1, keepdims=True)
    size = np.hypot(*(moved - moved.mean(1, keepdims=True)))  # it may have turned
    assert size == pytest.approx(stretch * np.hypot(*still), abs=1e-7)
    stress = result.observe()["von_mises"]
    if out_of_plane == "fixed":
        assert stress.max() < 1e-6 * MU
    else:  # in z alone: |σ_zz| of the same F*
        a, z = stretch / g, 1 / g
        J = a * a * z
        assert stress == pytest.approx(MU * J ** (-5 / 3) * abs(z * z - a * a), rel=1e-6)


def exact(r, time):
    """Return the concentration in a disc of radius 1 whose edge is at 1, by Bessel's series."""
    zeros = jn_zeros(0, 60)
    return 1 - sum(2 * np.exp(-k * k * time) * j0(k * r) / (k * j1(k)) for k in zeros)


def test_diffusion_follows_the_series_of_bessel(disc):
    r, errors = np.hypot(*disc.nodes), {}
    found = Diffusion(disc, disc.pial, 0.5)
    for time in (0.02, 0.1, 0.4, 2.0):
        errors[time] = np.abs(found.at(time) - exact(r, 0.5 * time)).max()
    assert max(errors.values()) < 3e-3
    assert errors[2.0] < 1e-5
    finer = semicircle(radius=1.0, thickness=0.3, size=0.05, base="roller", coarsening=1.0)
    coarse = semicircle(radius=1.0, thickness=0.3, size=0.1, base="roller", coarsening=1.0)
    off = [np.abs(Diffusion(b, b.pial, 1.0).at(0.1) - exact(np.hypot(*b.nodes), 0.1)).max()
           for b in (coarse, finer)]  # fmt: skip
    assert off[1] < off[0] / 6  # order 3 of quadratic elements would be 8


def test_the_contour_is_exact_in_time(body):
    # the modes of M ẇ + K w = 0 themselves decay by exp(-λ t)
    from scipy.linalg import eigh
    from skfem import Basis, BilinearForm, ElementTriP2
    from skfem.helpers import dot, grad

    basis = Basis(body.mesh, ElementTriP2(), intorder=4)
    mass = BilinearForm(lambda u, v, _: u * v).assemble(basis).toarray()
    flux = BilinearForm(lambda u, v, _: dot(grad(u), grad(v))).assemble(basis).toarray()
    free = np.setdiff1d(np.arange(basis.N), body.pial)
    values, modes = eigh(flux[np.ix_(free, free)], mass[np.ix_(free, free)])
    start = -modes.T @ mass[free].sum(1)
    diffusion = Diffusion(body, body.pial, 1.0)
    for time in (1e-4, 1 / 16 - 1e-9, 1 / 16, 1 / 16 + 1e-9, 0.3, 1.0):
        c = 1 + modes @ (np.exp(-values * time) * start)
        assert diffusion.at(time)[free] == pytest.approx(c, abs=3e-6)


def test_concentration_does_not_depend_on_the_steps(body):
    swelling = Swelling(coefficient=0.2, diffusivity=0.1, source="interface")
    start = State(0.0, swelling.on(body).start(State(0.0), 0))
    halfway = State(0.5, advanced(swelling, body, start, 0.5))
    one, two = advanced(swelling, body, start, 1.0), advanced(swelling, body, halfway, 0.5)
    assert np.array_equal(one["concentration"], two["concentration"])


def test_a_swelling_zone_is_the_core_the_cortex_or_a_region(body):
    theta = cortex_indicator(body)
    for zone, share in (("core", 1 - theta), ("cortex", theta), ("all", 1.0), (REGION, REGION.share(body))):
        assert at(Swelling(coefficient=0.5, zone=zone), body, 0.4)["growth"][2] == pytest.approx(
            1 + 0.2 * share, rel=1e-14
        )


def test_a_solvent_comes_from_a_ventricle_and_clips_to_its_range(body):
    mesh = body.mesh.with_boundaries({"hole left": lambda x: x[1] == 0})
    wet = Body(mesh, body.thickness, base="free")
    late = at(Swelling(coefficient=0.5, diffusivity=1.0, source="hole"), wet, 20.0)["concentration"]
    assert late == pytest.approx(1.0, abs=1e-5)
    start = Swelling(coefficient=0.5, diffusivity=1.0, source="hole").on(wet).start(State(0.0), 0)
    assert (start["concentration"] == 0).all()
    assert (start["growth"] == 1).all()  # at rest, as the body is
    early = at(Swelling(coefficient=0.5, diffusivity=1e-4, source="hole"), wet, 0.01)["concentration"]
    assert early.min() == 0.0
    assert early.max() <= 1.0
    raw = Diffusion(wet, np.flatnonzero(wet.nodes[1] == 0), 1e-4).at(0.01)
    assert raw.min() < -1e-3  # what is put back


def test_bad_swelling_is_refused_by_name(body):
    for options, message in (
        ({"coefficient": -1.0}, "coefficient=-1 must be more than -1"),
        ({"coefficient": 0.1, "diffusivity": -2.0, "source": "pial"}, "diffusivity=-2 must be positive"),
        ({"coefficient": 0.1, "diffusivity": 1.0}, "belong together"),
        ({"coefficient": 0.1, "diffusivity": 1.0, "source": "sky"}, "source='sky'"),
        ({"coefficient": 0.1, "zone": "white"}, "zone='white'"),
        ({"coefficient": 0.1, "zone": 3}, "zone=3 must be a Region"),
        ({"coefficient": 0.1, "out_of_plane": "free"}, "out_of_plane='free'"),
        ({"coefficient": 0.1, "history": 2}, "history=2"),
        (
            {"coefficient": 0.1, "history": Exponential(), "diffusivity": 1.0, "source": "pial"},
            "both say how",
        ),
    ):
        with pytest.raises(ValueError, match=message):
            Swelling(**options)
    with pytest.raises(ValueError, match="no such boundary"):
        Swelling(coefficient=0.1, diffusivity=1.0, source="hole").on(body)
    far = Ellipse(centre=(5.0, 0.0), semi_axes=(1.0, 1.0), edge=0.1)
    with pytest.raises(ValueError, match="lies outside the body"):
        Swelling(coefficient=0.1, zone=far).on(body)


def test_the_core_of_a_brain_is_fine_enough_for_where_its_swelling_sets_in():
    """Over an eighth of the radius: elements of a fifth of it left 4 per cent of the energy."""
    body = half(semicircle(radius=0.0404, thickness=2.5e-3, elements=6))

    def energy(on):
        grow = human.growth(body, cortex=1.0)
        return simulate(Scene(body=on, terms=(human.tissue(),), processes=grow)).summary()["energy"]

    assert energy(body) == pytest.approx(energy(refined(body, 2)), rel=0.01)
