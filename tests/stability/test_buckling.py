"""Buckling against independent thresholds: half discs, strips; half bodies, limit points, branches."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from checks import message_names
from scipy.sparse import csc_matrix
from skfem import MeshTri1

from turingfold.cli.case import find_case
from turingfold.errors import NotConvergedError
from turingfold.geometry.body import Body
from turingfold.geometry.mirror import half
from turingfold.geometry.shapes import semicircle
from turingfold.growth.histories import Table
from turingfold.growth.laws import TangentialGrowth
from turingfold.scene import Scene
from turingfold.solve.inertia import Indefinite, negative_pivots
from turingfold.solve.march import begin, march
from turingfold.solve.sparsity import Sparsity
from turingfold.stability.buckling import buckling
from turingfold.stability.fundamental_path import FundamentalPath
from turingfold.stability.waves import extent_of, half_waves
from turingfold.stepping import Stepping
from turingfold.terms.dynamics import Drag
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic

CORE = NeoHookean(mu=1.0, kappa=5.0)
Mixed = partial(Elastic, element="mixed")
COARSE = Stepping(first=0.1, largest=0.1)
DOCUMENT_1 = {"gray": NeoHookean.from_young(1389.0, 0.4583), "white": NeoHookean.from_young(1895.0, 0.4583)}
REFERENCE = {  # thickness over radius, ratio of moduli, layers, out of plane: growth and half waves
    (0.1, 1.0, "sigmoid", "fixed"): (1.7195, 15),
    (0.1, 1.0, "sharp", "fixed"): (1.6881, 14),
    (0.2, 1.0, "sigmoid", "fixed"): (1.7846, 7),
    (0.1, 1.0, "sharp", "tangential"): (1.3852, 12),
    (0.1, 3.0, "sharp", "fixed"): (1.3445, 9),
    (0.1, 10.0, "sharp", "fixed"): (1.1716, 6),
}


def grown(body, *, cortex=2.0, ratio=1.0, out_of_plane="fixed", stepping=COARSE, term=None):
    """Return a growing scene whose cortex is `ratio` times as stiff as its core."""
    gray = NeoHookean(mu=ratio * CORE.mu, kappa=ratio * CORE.kappa)
    return Scene(
        body=body,
        terms=(term or Elastic(gray=gray, white=CORE),),
        processes=(TangentialGrowth(cortex=cortex, out_of_plane=out_of_plane),),
        stepping=stepping,
    )


def disc(thickness, layers_of_elements, base="roller", radius=1.0, layers="sharp"):
    size = thickness / layers_of_elements
    return semicircle(
        radius=radius, thickness=thickness * radius, size=size * radius, base=base, layers=layers
    )


# eigenvalues and waves


def lower(matrix):
    """Return the sparsity and the lower-triangle values of a dense symmetric matrix."""
    n = len(matrix)
    columns, rows = np.nonzero(np.triu(matrix))
    return Sparsity(n, columns.astype(np.int64) * n + rows), matrix[rows, columns]


@pytest.mark.parametrize("shift", [-3.0, 0.0, 0.7, 3.0])
def test_negative_pivots_are_negative_eigenvalues(shift):
    rng = np.random.default_rng(3)
    matrix = np.where(rng.random((60, 60)) < 0.1, rng.standard_normal((60, 60)), 0.0)
    matrix = matrix + matrix.T + np.diag(rng.standard_normal(60) + shift)
    assert negative_pivots(*lower(matrix)) == np.sum(np.linalg.eigvalsh(matrix) < 0)


def test_an_indefinite_system_is_solved_again_and_again():
    matrix = np.array([[2.0, 1.0, 0.0], [1.0, -1.0, 3.0], [0.0, 3.0, 1.0]])
    pattern, values = lower(matrix)
    solver, b = Indefinite(pattern), np.array([1.0, 2.0, 3.0])
    for factor in (1.0, -2.0, 3.0):
        x = solver.factorize(factor * values).solve(b)
        assert np.abs(factor * matrix @ x - b).max() < 1e-13
    assert csc_matrix(pattern.lower(values)).nnz == 5


def test_a_singular_matrix_is_refused():
    with pytest.raises(NotConvergedError, match="singular"):
        negative_pivots(*lower(np.ones((2, 2))))


def wave(body, function):
    """Return the radial displacement function(θ) of a disc."""
    angle = np.arctan2(body.nodes[1], body.nodes[0])
    return function(angle) * np.stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("n", [1, 6, 15])
def test_half_waves_of_a_disc_are_its_mode_number(n):
    roller, clamped = disc(0.1, 2), disc(0.1, 2, "clamped")
    assert half_waves(roller, wave(roller, lambda a: np.cos(n * a))) == n
    assert half_waves(clamped, wave(clamped, lambda a: np.sin(n * a))) == n
    noise = wave(roller, lambda a: np.cos(n * a) + 0.01 * np.cos(40 * a))
    assert half_waves(roller, noise) == n


def test_half_waves_of_half_a_body_are_those_of_the_whole():
    roller, clamped = half(disc(0.1, 2)), half(disc(0.1, 2, "clamped"))
    assert half_waves(roller, wave(roller, lambda a: np.cos(8 * a))) == 8
    assert half_waves(clamped, wave(clamped, lambda a: np.sin(7 * a))) == 7


@pytest.mark.parametrize("sign", [1, -1, 0])
def test_a_mode_at_the_ends_counts_alike_whether_they_move_alike_or_one_alone_or_half_is_computed(sign):
    """Reference: sin²(5a) sin(20a) on a < π/5, two waves: L/π √(∫u'²/∫u²) = √(400 + 100/3)."""
    whole = disc(0.1, 4, "clamped")

    def ends(a):
        bump = np.sin(20 * a) * np.sin(5 * a) ** 2 * (a < np.pi / 5)
        other = np.pi - a
        return bump + sign * np.sin(20 * other) * np.sin(5 * other) ** 2 * (other < np.pi / 5)

    found = half_waves(whole, wave(whole, ends))
    assert found == pytest.approx(np.sqrt(400 + 100 / 3), abs=0.6)
    if sign == 1:
        assert half_waves(half(whole), wave(half(whole), ends)) == found


def test_the_extent_of_a_mode_is_the_share_of_waves_that_are_there():
    whole = disc(0.1, 4)
    assert extent_of(whole, wave(whole, lambda a: np.cos(12 * a))) == pytest.approx(1.0, abs=0.01)
    some = wave(whole, lambda a: np.sin(12 * a) * (a < np.pi / 4))
    assert extent_of(whole, some) == pytest.approx(3 / 12, abs=0.01)


# thresholds


def threshold(case, elements):
    thickness, ratio, layers, out = case
    cortex = 1.3 if ratio == 10 else 2.0
    body = disc(thickness, elements, layers=layers)
    return buckling(grown(body, cortex=cortex, ratio=ratio, out_of_plane=out))


@pytest.mark.parametrize("case", REFERENCE)
def test_the_half_disc_on_rollers_buckles_as_computed_independently(case):
    found, (growth, mode) = threshold(case, 2), REFERENCE[case]
    assert found.growth == pytest.approx(growth, rel=0.004)
    assert abs(found.mode - mode) <= 1
    assert abs(found.remaining_stiffness) < 1e-3
    assert not found.limit


@pytest.mark.slow
@pytest.mark.parametrize("case", REFERENCE)
def test_the_threshold_converges_from_above(case):
    coarse, fine, (growth, mode) = threshold(case, 2), threshold(case, 4), REFERENCE[case]
    assert growth < fine.growth < growth + 0.5 * (coarse.growth - growth)
    assert fine.growth == pytest.approx(growth, rel=0.001)
    assert abs(fine.mode - mode) <= 1


@pytest.mark.slow
def test_a_quarter_of_the_thickness_buckles_into_four_times_the_waves():
    found = buckling(grown(disc(0.025, 3, layers="sigmoid")))
    assert found.growth == pytest.approx(1.6668, rel=0.005)
    assert abs(found.mode - 61) <= 1


@pytest.mark.slow
def test_the_body_of_document_1_buckles_as_computed_independently():
    body = semicircle(radius=0.0404, thickness=2.5e-3, size=2.5e-3 / 4, base="roller")
    found = buckling(grown(body, term=Elastic(**DOCUMENT_1)))
    assert found.growth == pytest.approx(1.782, rel=0.005)
    assert abs(found.mode - 26) <= 1


def strip(length, layers):
    """Return half a wave length of a strip, 12 cortex thicknesses deep, between two rollers."""
    depths, size = [k / layers for k in range(layers + 1)], 1 / layers
    while depths[-1] < 12:
        size = min(1.3 * size, 1.5)
        depths.append(depths[-1] + size)
    across = np.linspace(0, length / 2, round(length / 2 * layers) + 1)
    mesh = MeshTri1.init_tensor(across, -np.array(depths[::-1]))
    right = length / 2 - 1e-9
    sides = {"pial": lambda x: x[1] == 0, "mirror": lambda x: x[0] == 0, "base": lambda x: x[0] > right}
    return Body(mesh.with_boundaries(sides), 1.0, "roller")


NEARLY = NeoHookean.from_young(3.0, 0.4999)
STRIPS = {
    "kappa 5 mu": (Elastic(gray=CORE), 4.10, 1.6297),
    "kappa 5 mu, mixed": (Mixed(gray=CORE), 4.10, 1.6297),
    "document 1": (Elastic(**DOCUMENT_1), 3.61, 1.7324),
    "stiff cortex": (Elastic(gray=NeoHookean(mu=10.0, kappa=50.0), white=CORE), 9.61, 1.1286),
    "nearly incompressible": (Mixed(gray=NEARLY), 4.90, 1.5969),
}


@pytest.mark.parametrize("case", STRIPS)
def test_the_growing_strip_buckles_as_computed_independently(case):
    term, length, growth = STRIPS[case]
    found = buckling(grown(strip(length, 4), term=term))
    assert found.growth == pytest.approx(growth, rel=0.0015 if case == "document 1" else 0.0005)


def test_the_threshold_depends_neither_on_the_steps_nor_on_the_units():
    fine = buckling(grown(disc(0.2, 2), stepping=Stepping(first=0.05, largest=0.05)))
    scaled = buckling(grown(disc(0.2, 2, radius=0.04), term=Elastic(gray=NeoHookean(mu=476.0, kappa=2380.0))))
    coarse = buckling(grown(disc(0.2, 2)))
    assert fine.growth == pytest.approx(coarse.growth, rel=1e-4)
    assert scaled.growth == pytest.approx(coarse.growth, rel=1e-8)
    assert np.abs(np.abs(scaled.shape) - np.abs(coarse.shape)).max() < 1e-4


def test_half_a_body_buckles_into_the_even_modes():
    body = disc(0.2, 2)
    whole, part = buckling(grown(body)), buckling(grown(half(body)))
    assert part.mode % 2 == 0
    if whole.mode % 2 == 0:
        assert part.growth == pytest.approx(whole.growth, rel=1e-4)
    else:
        assert whole.growth < part.growth < 1.02 * whole.growth


# branches


def final(scene, progress, until):
    """Return the last step of a march from `progress` to the time `until`, and where to go on."""
    scene = replace(scene, until=until, stepping=Stepping(first=0.05, largest=0.05))
    return list(march(scene, progress))[-1]


def test_the_branch_of_a_stiff_cortex_is_a_pitchfork():
    """Reference: beyond a pitchfork, amplitudes grow as √(t - t_c) and the energy gained as (t - t_c)²."""
    scene = grown(disc(0.1, 2), cortex=1.3, ratio=10.0)
    found, path, pial = buckling(scene), FundamentalPath(scene), scene.body.pial
    amplitudes, gains = [], []
    for dt in (0.01, 0.02):
        straight = path.step(found.state, dt, None)
        potentials = path.potentials(straight.state, dt)
        energy = sum(potential.evaluate(straight.x).energy for potential in potentials)
        assert straight.negative > 0
        for sign in (1, -1):
            last, _ = final(scene, found.switched(sign * 0.02, dt), found.time + dt)
            assert last.numbers["negative_pivots"] == 0
            moved = last.state["displacement"] - straight.state["displacement"]
            along = (moved * found.shape)[:, pial].sum() / (found.shape[:, pial] ** 2).sum()
            assert half_waves(scene.body, moved) == found.mode
            amplitudes.append(sign * along)
            gains.append(energy - last.numbers["energy"])
    assert np.array(amplitudes[2:]) / amplitudes[:2] == pytest.approx(np.sqrt(2), rel=0.02)
    assert np.array(gains[2:]) / gains[:2] == pytest.approx(4.0, rel=0.02)


@pytest.mark.slow
def test_half_a_clamped_disc_ends_at_a_limit_point_from_which_it_snaps():
    scene = grown(half(disc(0.2, 2, "clamped")))
    found = buckling(scene)
    assert found.limit
    assert 0 < found.remaining_stiffness < 0.02
    jumps, progress = [], begin(scene)
    for time in (found.time - 0.005, found.time + 0.005):
        last, progress = final(scene, progress, time)
        assert last.numbers["negative_pivots"] == 0
        jumps.append(np.abs(last.state["displacement"] - found.state["displacement"]).max())
    assert jumps[1] > 4 * jumps[0]


PACES = {
    "late start": Table(times=(0.3, 1.0), shares=(0.0, 1.0)),
    "pause": Table(times=(0.0, 0.3, 0.5, 1.0), shares=(0.0, 0.3, 0.3, 1.0)),
    "nine times faster": Table(times=(0.0, 0.5, 1.0), shares=(0.0, 0.1, 1.0)),
}


@pytest.mark.parametrize("pace", PACES)
def test_the_pace_of_growth_changes_not_how_much_of_it_buckles(pace):
    scene = grown(disc(0.2, 1))
    uneven = replace(scene, processes=(replace(scene.processes[0], history=PACES[pace]),))
    steady, found = buckling(scene), buckling(uneven)
    assert not found.limit
    assert found.growth == pytest.approx(steady.growth, rel=1e-3)
    assert found.mode == steady.mode
    assert found.growth == pytest.approx(PACES[pace].factor(2.0, found.time), rel=1e-12)


# failures


def test_a_scene_without_growth_stays_stable():
    with pytest.raises(NotConvergedError) as caught:
        buckling(replace(grown(disc(0.2, 1)), processes=()))
    message_names(caught.value, "No loss of stability until t = 1")


def test_a_scene_that_stays_stable_says_how_far_it_grew():
    with pytest.raises(NotConvergedError) as caught:
        buckling(grown(disc(0.2, 1), cortex=1.2))
    message_names(caught.value, "1.2", "grow more")
    assert caught.value.time == 1.0


def test_a_path_that_cannot_be_followed_says_where():
    with pytest.raises(NotConvergedError) as caught:
        buckling(grown(disc(0.2, 1), stepping=Stepping(tolerance=1e-30)))  # below round-off
    message_names(caught.value, "t = 0,", "growth 1,", "Stepping(largest=...)")


def test_no_amplitude_is_no_branch():
    found = buckling(grown(disc(0.2, 1)))
    for amplitude, dt in ((0.0, 0.1), (np.nan, 0.1), (0.1, 0.0)):
        with pytest.raises(ValueError, match=r"amplitude|dt"):
            found.switched(amplitude, dt)


def test_terms_that_resist_motion_are_refused():
    body = semicircle(radius=1.0, thickness=0.2, size=0.2, base="roller")
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), Drag(coefficient=1.0))
    with pytest.raises(ValueError, match="Drag"):
        buckling(Scene(body=body, terms=terms, processes=(TangentialGrowth(cortex=1.9),)))


@pytest.mark.slow
@pytest.mark.parametrize("step", [0.1, 0.05, 0.02])
def test_a_limit_point_is_not_stepped_over(step):
    """Figure 3, small and halved: its march in steps of 0.0016 jumps at t = 0.6016, index 1.01 to 1.05."""
    scene = find_case("figure3").scenes({"halved": True}, quick=True)["three hypotheses"]
    found = buckling(replace(scene, stepping=Stepping(first=step, largest=step)))
    assert found.limit
    assert 0.6001 < found.time <= 0.6016
    assert found.growth == pytest.approx(1.7813, abs=2e-4)
