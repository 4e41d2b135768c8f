"""Fitting: hidden parameters are found again from outlines alone, with honest errors; what is refused."""

import json
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from turingfold import (
    Elastic,
    GrowthMap,
    NeoHookean,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    half,
    outline,
    semicircle,
    simulate,
)  # fmt: skip
from turingfold.morphometry.distance import Polygon
from turingfold.results.surface import along_pial
from turingfold.sensitivity.fit import fit
from turingfold.sensitivity.smoothing import corner
from turingfold.sensitivity.targets import checked_targets

HIDDEN = (1.3, 1.15, 1.25, 1.1, 1.2)
NAMES = tuple(f"GrowthMap.cortex.{k}" for k in range(len(HIDDEN)))
AGES = (0.5, 1.0)
BODY = semicircle(radius=1.0, thickness=0.2, elements=2)


def scene(cortex, core=1.0):
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0), white=NeoHookean(mu=core, kappa=5.0)), SelfContact())
    steps = Stepping(first=0.25, largest=0.25)
    return Scene(body=BODY, terms=terms, processes=(GrowthMap(cortex=cortex),), stepping=steps)


def outlines(made):
    result = simulate(made)
    return {age: result.pial([s.time for s in result.states].index(age)) for age in AGES}


@pytest.fixture(scope="module")
def targets():
    return outlines(scene(HIDDEN))


def test_a_hidden_map_is_found_from_outlines_alone(targets, tmp_path):
    misfits = []
    found = fit(scene((1.1,) * 5), targets, NAMES, out=tmp_path, progress=misfits.append)
    # the outlines are points only: what lies between them is a spline here, and quadratic edges in the body
    np.testing.assert_allclose(found.values, HIDDEN, rtol=1e-3)
    assert found.distinct == 5
    assert max(found.misfits.values()) < 1e-3 * BODY.thickness
    assert found.solves < 60
    assert misfits[0] > 1e-2 * BODY.thickness
    stored = json.loads((tmp_path / "fit.json").read_text())["parameters"]
    np.testing.assert_allclose([stored[name] for name in NAMES], HIDDEN, rtol=1e-3)
    assert found.scene.processes[0].cortex == tuple(found.values.tolist())


def test_outlines_resampled_from_another_start_do_as_well(targets):
    def resampled(points, count):
        s = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=1))))
        return CubicSpline(s, points, axis=1)(np.linspace(0.0, s[-1], count))

    fine = {age: resampled(points, 90) for age, points in targets.items()}
    found = fit(scene((1.1,) * 5), fine, NAMES)
    np.testing.assert_allclose(found.values, HIDDEN, rtol=2e-3)


@pytest.mark.slow
def test_noise_moves_the_map_by_as_much_as_it_says(targets):
    noise, inside = 5e-3 * BODY.thickness, []
    for seed in range(6):
        random = np.random.default_rng(seed)
        noisy = {age: p + noise * random.standard_normal(p.shape) for age, p in targets.items()}
        found = fit(scene((1.1,) * 5), noisy, NAMES)
        inside.extend(np.abs(found.values - HIDDEN) < 2 * found.deviations)
        assert (found.deviations < 0.05).all()
    assert np.mean(inside) >= 0.9


def test_what_the_outline_does_not_tell_is_said(targets):
    # all moduli scaled by one factor leave every shape of a body without loads as it is
    names = ("Elastic.gray.mu", "Elastic.gray.kappa", "Elastic.white.mu", "Elastic.white.kappa")
    found = fit(scene(HIDDEN), targets, names, bounds=(0.2, 20.0))
    assert found.distinct < 4
    assert np.isinf(found.deviations).any()
    common = found.values / np.linalg.norm(found.values)
    weights = np.linalg.lstsq(found.flat.T, common, rcond=None)[0]
    np.testing.assert_allclose(weights @ found.flat, common, atol=1e-3)


def test_a_free_body_is_laid_on_its_target_first():
    a = 2 * np.pi * np.arange(80) / 80
    body = outline(np.stack([1.2 * np.cos(a), 0.9 * np.sin(a)]), thickness=0.2, elements=2)
    hidden = (1.3, 1.15, 1.25, 1.1, 1.2, 1.05)

    def free(cortex):
        terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),)
        steps = Stepping(first=0.5, largest=0.5)
        return Scene(body=body, terms=terms, processes=(GrowthMap(cortex=cortex),), stepping=steps)

    turn = np.array([[np.cos(0.2), -np.sin(0.2)], [np.sin(0.2), np.cos(0.2)]])
    target = turn @ simulate(free(hidden)).pial() + np.array([[0.3], [-0.2]])
    names = [f"GrowthMap.cortex.{k}" for k in range(6)]
    found = fit(free((1.15,) * 6), {1.0: target}, names)
    np.testing.assert_allclose(found.values, hidden, rtol=3e-3)
    assert found.misfits[1.0] < 1e-3 * body.thickness


def test_the_corner_of_a_curve_is_found():
    x = np.array([0.0, 0.1, 0.2, 0.3, 1.0, 2.0])
    y = np.array([5.0, 4.0, 3.0, 0.1, 0.05, 0.0])
    assert corner(x, y) == 3


@pytest.mark.slow
def test_smoothness_joins_neighbours(targets):
    stiff = fit(scene((1.2,) * 5), targets, NAMES, smoothness=10.0)
    assert np.abs(np.diff(stiff.values, 2)).max() < 0.2 * np.abs(np.diff(HIDDEN, 2)).max()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: {}, "targets is empty"),
        (lambda t: {1.5: t[1.0]}, "age=1.5"),
        (lambda t: {1.0: 1e3 * t[1.0]}, "both in m"),
        (lambda t: {1.0: t[1.0][:, [*range(9), *range(20, 8, -1), *range(21, 33)]]}, "crosses itself"),
        (lambda t: {1.0: t[1.0][:, :3] * np.nan}, "finite"),
    ],
)
def test_bad_targets_are_refused(targets, change, words):
    with pytest.raises(ValueError, match=words):
        fit(scene((1.1,) * 5), change(targets), NAMES)


def test_distances_from_a_square_are_exact():
    square = np.array([[0.0, 2, 2, 0], [0, 0, 2, 2]])
    points = np.array([[1.0, 1.0, 1.0, 3.0, -1.0, 1.0], [0.5, -0.5, 1.9, 3.0, 1.0, 0.0]])
    distance, gradient = Polygon(square, True).distances(points)  # counter-clockwise: the inside is left
    np.testing.assert_allclose(distance, [0.5, -0.5, 0.1, -np.sqrt(2), -1.0, 0.0], atol=1e-14)
    r = np.sqrt(0.5)
    expected = np.array([[0, 0, 0, -r, 1, 0], [1, 1, -1, -r, 0, 1]])
    np.testing.assert_allclose(gradient, expected, atol=1e-14)


def test_maps_are_checked_and_joined_round_closed_curves():
    for bad in ((1.2,), (1.2, -1.0), (1.2, float("nan"))):
        with pytest.raises(ValueError, match="cortex"):
            GrowthMap(cortex=bad)


@pytest.mark.parametrize("part", [slice(None, 1), slice(-1, None)])
def test_half_an_outline_is_refused(targets, part):
    """A body would be stretched towards a half as if there were nothing of the other."""
    points = targets[1.0]
    middle = points.shape[1] // 2
    one = points[:, : middle + 1] if part.stop else points[:, middle:]
    with pytest.raises(ValueError, match=r"an end of targets\[1\] is .* from where the pial surface ends"):
        fit(scene((1.1,) * 5), {1.0: one}, NAMES)
    halved = replace(scene((1.1,) * 5), body=half(BODY), processes=(GrowthMap(cortex=(1.1,) * 3),))
    with pytest.raises(ValueError, match=r"targets\[1\] reaches .* whole outline"):
        fit(halved, {1.0: one}, NAMES[:3])


def test_half_a_body_on_rollers_may_grow_beyond_its_base():
    """Its ends slide along the base by several thicknesses; those of the target lie there, too."""
    body = semicircle(radius=1.0, thickness=0.1, elements=1, base="roller")
    grow = TangentialGrowth(cortex=1.4, core=1.4)
    made = Scene(body=half(body), terms=(Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),), processes=(grow,))
    target = 1.4 * along_pial(made.body, made.body.nodes[:, made.body.pial])
    assert list(checked_targets(made, {1.0: target})) == [1.0]
    with pytest.raises(ValueError, match="from where the pial surface ends"):
        checked_targets(made, {1.0: target + np.array([[0.0], [0.3]])})


def test_distances_of_many_points_are_exact_in_little_memory():
    """Of 5000 points from a polygon of 5000 corners inside a circle; a table of all pairs takes 400 MB."""
    n, rng = 5000, np.random.default_rng(0)
    angle = 2 * np.pi * np.arange(n) / n
    circle = np.stack([np.cos(angle), np.sin(angle)])
    edge = rng.integers(n, size=n)  # off the middle of an edge, within its strip: that edge is the nearest
    sagitta, off = np.cos(np.pi / n), rng.uniform(-0.5, 0.5, n)
    normal = np.stack([np.cos(angle + np.pi / n), np.sin(angle + np.pi / n)])[:, edge]
    tracemalloc.start()
    distance, gradient = Polygon(circle, True).distances((sagitta + off) * normal)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    np.testing.assert_allclose(distance, -off, atol=1e-13)
    np.testing.assert_allclose(gradient, -normal, atol=1e-9)
    assert peak < 20e6
