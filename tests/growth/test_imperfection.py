"""Seeded noise: the same on every mesh, of unit variance, symmetric on request."""

import numpy as np
import pytest

from turingfold.errors import MissingFieldError
from turingfold.geometry.mirror import half
from turingfold.geometry.roughness import geometric_imperfection, noise
from turingfold.geometry.shapes import semicircle
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.laws import TangentialGrowth
from turingfold.outlines import outline
from turingfold.scene import Scene
from turingfold.solve.march import begin
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic
from turingfold.testing import advanced


def scene(body, *processes):
    return Scene(body=body, terms=(Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),), processes=processes, seed=3)


def body(size=0.05, **options):
    return semicircle(radius=1.0, thickness=0.1, size=size, **options)


def test_noise_has_unit_variance():
    share = np.linspace(0.0, 1.0, 2001)
    variances = [noise(share, 80, seed).var() for seed in range(200)]
    # the mean of 200 variances, each over about 80 independent modes, scatters by 0.011
    assert np.mean(variances) == pytest.approx(1.0, abs=0.05)


def test_noise_is_seeded_and_symmetric_on_request():
    share = np.linspace(0.0, 1.0, 301)
    assert np.array_equal(noise(share, 40, 7), noise(share, 40, 7))
    assert not np.allclose(noise(share, 40, 7), noise(share, 40, 8))
    even = noise(share, 40, 7, symmetric=True)
    assert even == pytest.approx(even[::-1], abs=1e-12)
    plain = noise(share, 40, 7)
    assert not np.allclose(plain, plain[::-1])


@pytest.mark.parametrize("of", ["growth", "moduli"])
def test_same_noise_on_two_meshes(of):
    growth = TangentialGrowth(cortex=1.9)
    values = []
    for size in (0.1, 0.025):
        made = begin(scene(body(size), growth, Imperfection(amplitude=0.05, of=of, modes=20))).state
        arc, depth = body(size).arc, body(size).depth
        near = depth < 0.1
        order = np.argsort(arc[near])
        found = made["noise"] if of == "growth" else (made["modulus_factor"] - 1.0) / 0.05
        values.append(np.interp(np.linspace(0.2, 2.9, 200), arc[near][order], found[near][order]))
    assert values[0] == pytest.approx(
        values[1], abs=0.12
    )  # of functions of unit variance, linearly interpolated


def test_growth_is_multiplied_in_the_cortex_only():
    growth = TangentialGrowth(cortex=1.9)
    rough = Imperfection(amplitude=0.1)
    start = begin(scene(body(), growth, rough)).state
    plain = advanced(growth, body(), start, 1.0)["growth"]
    grown = rough.on(body()).advance(start, start.updated(growth=plain), 1.0)["growth"]
    assert grown[0] - 1.0 == pytest.approx((plain[0] - 1.0) * (1.0 + 0.1 * start["noise"]), rel=1e-12)
    assert np.array_equal(grown[1:], plain[1:])


def test_half_body_gets_the_symmetric_noise_of_the_whole():
    whole = body()
    right = half(whole)
    growth = TangentialGrowth(cortex=1.9)
    left = begin(scene(right, growth, Imperfection(amplitude=0.1))).state["noise"]
    all_of_it = begin(scene(whole, growth, Imperfection(amplitude=0.1, symmetric=True))).state["noise"]
    keep = whole.mesh.p[0][whole.mesh.t].mean(0) > 0
    assert left == pytest.approx(all_of_it[:, keep], abs=1e-10)


def test_roughened_body_keeps_base_and_moves_the_pial_surface_by_the_noise():
    smooth = body(0.025)
    rough = geometric_imperfection(smooth, 0.004, modes=20, seed=5)
    shift = rough.nodes - smooth.nodes
    x, y = smooth.nodes[:, smooth.pial]
    share = np.arctan2(y, x) / np.pi
    inner = (share > 0.1) & (share < 0.9)
    radial = (shift[:, smooth.pial] * np.stack([x, y])).sum(0)
    assert radial[inner] == pytest.approx(0.004 * noise(share, 20, 5)[inner], abs=1e-6)
    assert shift[:, smooth.boundary_path("base")[0]] == pytest.approx(0.0, abs=1e-15)


def test_needs_growth_before_it():
    with pytest.raises(MissingFieldError, match="growth"):
        scene(body(), Imperfection(amplitude=0.1))


@pytest.mark.parametrize("amplitude", [-0.1, 0.5, float("nan")])
def test_bad_amplitude(amplitude):
    with pytest.raises(ValueError, match="amplitude"):
        Imperfection(amplitude=amplitude)
    with pytest.raises(ValueError, match="amplitude"):
        geometric_imperfection(body(), amplitude)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"modes": 0}, "modes=0 must be a whole number of at least 1"),
        ({"modes": 2.5}, r"modes=2\.5 must be a whole number"),
        ({"seed": -1}, "seed=-1 must be a whole number of at least 0"),
        ({"seed": None}, "seed=None must be a whole number"),
    ],
)
def test_bad_modes_and_seeds_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        geometric_imperfection(body(0.2), 0.01, **options)


def test_a_roughness_that_turns_triangles_over_is_refused_with_its_remedy():
    with pytest.raises(ValueError, match=r"amplitude=0\.15 m with modes=80 .* smaller amplitude or fewer"):
        geometric_imperfection(semicircle(radius=1.0, thickness=0.2, size=0.1), 0.15)


def test_rough_thickness_leaves_the_interface():
    smooth = body(0.025)
    rough = geometric_imperfection(smooth, 0.004, of="thickness", modes=20, seed=5)
    shift = rough.nodes - smooth.nodes
    assert shift[:, smooth.interface] == pytest.approx(0.0, abs=1e-9)
    assert np.hypot(*shift[:, smooth.pial]).max() > 0.004
    with pytest.raises(ValueError, match="'shape', 'thickness'"):
        geometric_imperfection(smooth, 0.004, of="colour")


def test_noise_on_a_closed_surface_has_no_seam():
    share = np.array([0.0, 1.0])
    for seed in range(5):
        start, end = noise(share, 20, seed, closed=True)
        assert start == pytest.approx(end, abs=1e-12)
        assert abs(np.subtract(*noise(share, 20, seed))) > 1e-3  # which an open one has no need of
    values = np.concatenate([noise(np.linspace(0, 1, 500), 40, seed, closed=True) for seed in range(100)])
    assert values.std() == pytest.approx(1.0, rel=0.05)
    # the shortest wave is as long as on an open surface with as many modes
    spectrum = np.abs(np.fft.rfft(noise(np.arange(512) / 512, 20, 0, closed=True)))
    assert spectrum[11:].max() < 1e-10 * spectrum.max()
    assert spectrum[10] > 1e-3 * spectrum.max()


def test_a_closed_body_is_rough_all_round():
    angle = 2 * np.pi * np.arange(60) / 60
    body = outline(np.stack([np.cos(angle), np.sin(angle)]), thickness=0.2, size=0.1)
    rough = geometric_imperfection(body, 0.01, modes=10)
    radius = np.hypot(*rough.nodes[:, rough.pial]) - np.hypot(*body.nodes[:, body.pial])
    near = np.abs(np.arctan2(*body.nodes[::-1, body.pial])) < 0.3  # where the curve begins
    assert np.abs(radius[near]).max() > 1e-3
    around = radius[np.argsort(np.arctan2(*body.nodes[::-1, body.pial]))]
    assert np.abs(np.diff(around, append=around[0])).max() < 5e-3
