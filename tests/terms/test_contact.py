"""Self-contact: derivatives, balance, collision-free steps, obstacles, and the size of the barrier."""

import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import ipctk
import numpy as np
import pytest
from checks import message_names
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from skfem import MeshTri1
from small import folding_scene

from turingfold.geometry.body import Body, by_node
from turingfold.geometry.mirror import half
from turingfold.geometry.shapes import semicircle
from turingfold.growth.laws import TangentialGrowth
from turingfold.morphometry.walls import self_intersections
from turingfold.outlines import outline
from turingfold.parts import TimeStep
from turingfold.results.holding import HoldingForceWarning
from turingfold.results.simulate import simulate
from turingfold.scene import Scene
from turingfold.solve.march import begin, march
from turingfold.solve.problem import Problem, configuration
from turingfold.state import State
from turingfold.stepping import Stepping
from turingfold.terms.contact import SelfContact
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic
from turingfold.testing import check_semidefinite, check_term

STEP = TimeStep(0.1)
SLOT = 0.3


def slotted(base="free", size=0.25, slot=SLOT):
    """Return a block of two columns with a slot of depth 1 and this width between them, from x = 1 on."""
    x = np.concatenate([np.arange(0, 1 + 1e-9, size), np.arange(0, 1 + 1e-9, size) + 1 + slot])
    y = np.arange(0, 1.5 + 1e-9, size)
    mesh = MeshTri1.init_tensor(x, y)
    centre = mesh.p[:, mesh.t].mean(1)
    inside = (centre[0] > 1) & (centre[0] < 1 + slot) & (centre[1] > 0.5)
    mesh = mesh.remove_elements(np.flatnonzero(inside))
    return Body(mesh.with_boundaries({"pial": lambda p: p[1] > 0, "base": lambda p: p[1] == 0}), 0.2, base)


def state_of(body, scale=1.0):
    return State(1.0, {"displacement": np.zeros_like(body.nodes), "stress_scale": np.array(scale)})


def closed(body, gap, slot=SLOT):
    """Return the displacement that moves the right column until the slot has this width from y = 1 up."""
    shift = np.where(body.nodes[0] > 1, (gap - slot) * np.clip(2 * body.nodes[1] - 1, 0.0, 1.0), 0.0)
    return np.stack([shift, np.zeros_like(shift)]).T.ravel()


def test_contact_passes_the_examination():
    body = slotted()
    dhat = 0.4 * 0.125
    rng = np.random.default_rng(0)
    noise = 0.05 * dhat * rng.standard_normal((2, 2 * body.nodes.shape[1]))
    samples = list(closed(body, 0.5 * dhat) + noise)
    term, state, step = SelfContact(), state_of(body), 0.003 * dhat
    check_term(term, body, state, samples, step=step, other=SelfContact(stiffness=2.0))
    check_term(SelfContact(gap=0.8), body, state, samples, step=step, other=SelfContact(gap=0.7))


def test_the_clamped_hessian_has_no_negative_eigenvalue():
    body = slotted(size=0.5)
    noise = 0.004 * np.random.default_rng(0).standard_normal(2 * body.nodes.shape[1])
    potential = SelfContact().on(body).during(state_of(body), STEP)
    true, _ = check_semidefinite(potential, closed(body, 0.04) + noise)
    assert true < 0


def test_without_contact_there_is_no_energy():
    body = slotted()
    potential = SelfContact().on(body).during(state_of(body), STEP)
    here = potential.evaluate(np.zeros(2 * body.nodes.shape[1]))
    assert here.energy == 0.0
    assert not here.has_hessian
    assert not here.gradient()[0].any()


def test_the_traction_is_uniform_and_grows_with_stiffness_and_stress():
    # a uniform traction p on edges of length L, carried to the vertices of four chords by the trapezoidal
    # rule and from them by the quadratic shape functions: 3 p L/8 at corners, 5 p L/8 at middles
    body = slotted(size=0.125)
    found = []
    for stiffness, scale in ((1.0, 1.0), (0.5, 7.0)):
        potential = SelfContact(stiffness=stiffness).on(body).during(state_of(body, scale), STEP)
        force = -potential.evaluate(closed(body, 0.0125)).gradient()[0].reshape(-1, 2)
        wall = np.isin(np.arange(len(force)), body.pial) & (body.nodes[0] == 1 + SLOT)
        corners = force[wall & np.isin(body.nodes[1], (1.125, 1.25))]
        middles = force[wall & np.isin(body.nodes[1], (1.1875, 1.3125))]
        assert len(corners) == len(middles) == 2
        np.testing.assert_allclose(corners[:, 0], corners[0, 0], rtol=1e-9)
        np.testing.assert_allclose(middles[:, 0], middles[0, 0], rtol=1e-9)
        assert middles[0, 0] / corners[0, 0] == pytest.approx(5 / 3, rel=1e-9)
        assert np.abs(np.append(corners[:, 1], middles[:, 1])).max() < 1e-9 * corners[0, 0]
        found.append(middles[0, 0])
    assert found[0] > 0
    assert found[1] == pytest.approx(3.5 * found[0], rel=1e-9)


@pytest.mark.parametrize(("gap", "about"), [(0.4, 0.02), (0.2, 0.2), (0.8, 0.3)])
def test_the_traction_at_half_of_dhat_is_the_stiffness_on_every_mesh(gap, about):
    # what a corner and the middle beside it carry, per length of flat wall
    found = []
    for size in (0.25, 0.125, 0.0625):
        body = slotted(size=size)
        operator = SelfContact(gap=gap, stiffness=3.0).on(body)
        x = closed(body, (0.5 * operator.dhat + operator.apart) * operator.unit)
        force = -operator.during(state_of(body, 7.0), STEP).evaluate(x).gradient()[0].reshape(-1, 2)
        wall = np.isin(np.arange(len(force)), body.pial) & (body.nodes[0] == 1 + SLOT)
        found.append(force[wall & np.isin(body.nodes[1], (1.25, 1.25 - size / 2)), 0].sum() / size)
    assert found[0] == pytest.approx(21.0, rel=about)
    np.testing.assert_allclose(found, found[0], rtol=1e-3)


def bulged(body, by):
    """Return a displacement that closes the slot to 0.03 and then bends both walls towards each other."""
    moved = closed(body, 0.03).reshape(-1, 2)
    on = (np.abs(body.nodes[0] - 1 - SLOT / 2) < 0.51 * SLOT) & np.isclose(body.nodes[1], 1.125)
    moved[on, 0] += by * np.sign(1 + SLOT / 2 - body.nodes[0, on])
    return moved.ravel()


@pytest.mark.parametrize("by", [0.002, 0.005, 0.01])
def test_the_smallest_gap_is_that_of_the_curves(by):
    # both walls' middles at y = 1.125 come nearer; a fine sample of both parabolas gives the distance
    body, xi = slotted(), np.linspace(0, 1, 4001)
    left, right = (side + by * sign * 4 * xi * (1 - xi) for side, sign in ((1.0, 1), (1.03, -1)))
    gap = SelfContact().on(body).during(state_of(body), STEP).evaluate(bulged(body, by)).measure()["min_gap"]
    assert gap == pytest.approx((right - left).min(), abs=1e-9)


def test_no_step_makes_curved_walls_overlap():
    # walls 0.03 apart whose middles move by 0.02 each meet at 3/4 of the way
    body = slotted()
    x, d = closed(body, 0.03), bulged(body, 0.02) - closed(body, 0.03)
    bound = SelfContact().on(body).during(state_of(body), STEP).evaluate(x).largest_step(d)
    assert 0.6 < bound < 0.75


def bowed(at):
    """A wall bows by h = 0.29 from x = 1 towards a corner opposite, which comes to x = `at`, ξ = 3/8.

    The wall, x = 1 + 4 h ξ (1 - ξ), is at 1.272 there, its chord from 1/4 to 1/2 at 1.254 only.
    """
    body = slotted()
    moved = body.nodes.copy()

    def put(start, end):
        moved[:, np.flatnonzero(np.hypot(*(body.nodes - np.array(start)[:, None])) < 1e-9)[0]] = end

    put((1.0, 1.125), (1.29, 1.125))
    corner, below, above = np.array([at, 1.09375]), np.array([2.0, 0.75]), np.array([2.0, 1.25])
    put((1.3, 0.75), below)
    put((1.3, 1.25), above)
    put((1.3, 1.0), corner)
    put((1.3, 0.875), 0.5 * (below + corner))
    put((1.3, 1.125), 0.5 * (above + corner))
    put((0.0, 1.125), (-0.29, 1.125))  # a wall that bows as far, with nothing in the way
    return body, moved - body.nodes


def test_a_step_after_which_curves_cross_is_taken_again_with_more_chords():
    body, shift = bowed(at=1.263)
    potential = SelfContact().on(body).during(state_of(body), STEP)
    assert potential.evaluate(np.zeros(body.nodes.size)).finer() is None
    assert potential.evaluate(by_node(0.5 * shift)).finer() is None
    pial = (body.nodes + shift)[:, body.pial]
    assert self_intersections(pial, closed=False, quadratic=True) > 0
    seen = potential.evaluate(by_node(shift))
    assert not seen.walls.cross(seen.positions)
    assert not seen.is_valid()
    assert potential.evaluate(by_node(0.5 * shift)).is_valid()
    finer = seen.finer()
    assert finer.walls.counts.max() > potential.walls.counts.max()
    assert finer.evaluate(np.zeros(body.nodes.size)).largest_step(by_node(shift)) < 1.0


def bowed_towards_each_other(overlap):
    """Return the slotted body with two walls that bow most between vertices of their chords, and where.

    x = 1 + 4 h ξ (1 - ξ) - h ξ/2 and its mirror image are nearest at ξ = 7/16, the middle of a chord of 1/8.
    """
    body, h = slotted(), 0.158  # whose eight chords miss 0.98 of what they keep apart
    middle = 1 + h * (63 / 64 - 7 / 32) - 0.5 * overlap
    moved = body.nodes.copy()
    for y, wall in ((1.0, 1.0), (1.125, 1 + 0.75 * h), (1.25, 1 - 0.5 * h)):
        for x, to in ((1.0, wall), (1 + SLOT, 2 * middle - wall)):
            moved[:, np.flatnonzero(np.hypot(*(body.nodes - [[x], [y]])) < 1e-9)[0]] = to, y
    return body, moved - body.nodes


def test_chords_of_walls_that_bow_towards_each_other_are_made_finer_too():
    body, shift = bowed_towards_each_other(overlap=0.001)
    potential = SelfContact().on(body).during(state_of(body), STEP)
    pial = (body.nodes + shift)[:, body.pial]
    assert self_intersections(pial, closed=False, quadratic=True) == 2
    seen = potential.evaluate(by_node(shift))
    needed = seen.operator.made_of(np.maximum(seen.walls.counts, seen.operator.needed(seen.points)))
    assert not needed.cross(needed.positions(seen.points))  # twice of what one edge's chords miss is between
    finer = seen.finer()
    assert finer.walls.counts.max() > needed.counts.max()
    assert finer.evaluate(np.zeros(body.nodes.size)).largest_step(by_node(shift)) < 1.0
    body, shift = bowed_towards_each_other(overlap=-0.001)
    assert SelfContact().on(body).during(state_of(body), STEP).evaluate(by_node(shift)).finer() is None


def test_only_edges_without_room_keep_their_chords():
    body, shift = bowed(at=1.2725)  # nearer than chords keep apart
    state = state_of(body).updated(displacement=shift)
    operator = SelfContact().on(body)
    counts = operator.during(state, STEP).walls.counts
    middles = body.nodes[:, operator.nodes[operator.edges[1]]]
    inner, outer = (int(np.argmin(np.hypot(middles[0] - x, middles[1] - 1.125))) for x in (1.0, 0.0))
    assert counts[inner] == operator.counts[inner]
    assert counts[outer] > operator.counts[outer]


def test_the_smallest_gap_is_the_one_between_the_walls():
    body = slotted()
    potential = SelfContact().on(body).during(state_of(body), STEP)
    assert potential.evaluate(closed(body, 0.021)).measure()["min_gap"] == pytest.approx(0.021, rel=1e-9)


@pytest.fixture(scope="module")
def slot():
    """A slotted body and its contact, at rest."""
    body = slotted()
    return body, SelfContact().on(body).during(state_of(body), STEP)


def towards_the_other_wall(body, rng):
    """Return displacements that close or open the slot, (2, n_nodes), and roughen its walls a little."""
    side = np.sign(body.nodes[0] - 1 - SLOT / 2) * np.clip(2 * body.nodes[1] - 1, 0.0, 1.0)
    return [[1.0], [0.2]] * rng.standard_normal((2, 1)) * side + 0.002 * rng.standard_normal(body.nodes.shape)


@settings(derandomize=True, max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), size=st.floats(0.01, 10.0))
def test_no_step_within_the_bound_makes_walls_cross(slot, seed, size):
    body, potential = slot
    rng = np.random.default_rng(seed)
    d = size * towards_the_other_wall(body, rng)
    bound = potential.evaluate(np.zeros(d.size)).largest_step(d.T.ravel())
    assert 0 < bound <= 1
    for share in (0.25, 0.5, 0.75, 1.0):
        walls = (body.nodes + share * bound * d)[:, body.pial]
        assert self_intersections(walls, closed=False, quadratic=True) == 0


@pytest.mark.parametrize("times", [1.5, 7.0, 40.0, 300.0])
def test_long_ways_have_the_bound_that_ipctk_finds_on_the_whole_of_them(times):
    """To ipctk's own accuracy: on 55 ways that end at a wall both differ by 2.4e-6 at most."""
    body = slotted()
    operator, rng = SelfContact().on(body), np.random.default_rng(0)
    walls, bounds = operator.walls, []
    for _ in range(10):
        d = by_node(towards_the_other_wall(body, rng))
        start, end = (walls.positions(operator.moved(x)) for x in (np.zeros_like(d), d))
        end = start + times * walls.far / np.abs(end - start).max() * (end - start)
        pairs = ipctk.Candidates()
        pairs.build(walls.mesh, start, end, 0.5 * walls.apart, ipctk.SweepAndPrune())
        whole = pairs.compute_collision_free_stepsize(walls.mesh, start, end, walls.apart)
        bounds.append(walls.largest_step(start, end))
        assert bounds[-1] == pytest.approx(0.9 * whole if whole < 1.0 else 1.0, rel=1e-5)
        for share in np.linspace(0.05, 1.0, 20):
            assert not walls.cross(start + share * bounds[-1] * (end - start))
    assert min(bounds) < 1.0


def test_a_full_step_through_the_other_wall_is_refused():
    body = slotted()
    operator = SelfContact().on(body)
    potential = operator.during(state_of(body), STEP)
    through = closed(body, -0.9)
    assert not operator.walls.cross(operator.walls.positions(operator.moved(closed(body, 0.1))))
    bound = potential.evaluate(np.zeros_like(through)).largest_step(through)
    # the walls meet after 0.3 of 1.2; nine tenths of a conservative bound
    assert 0.2 < bound < SLOT / 1.2


def test_a_step_that_is_not_finite_is_refused():
    body = slotted()
    potential = SelfContact().on(body).during(state_of(body), STEP)
    d = np.zeros(2 * body.nodes.shape[1])
    assert potential.evaluate(d).largest_step(d) == 1.0
    d[2 * body.pial[3]] = np.nan
    assert potential.evaluate(np.zeros_like(d)).largest_step(d) == 0.0


@pytest.mark.parametrize("outward", [0.4, 8.0])
@pytest.mark.parametrize("base", ["clamped", "roller", "free"])
def test_the_base_line_goes_on_outside_the_body(base, outward):
    body = semicircle(radius=1.0, thickness=0.3, size=0.15, base=base)
    operator = SelfContact().on(body)
    d = np.zeros((body.nodes.shape[1], 2))
    node = body.pial[1] if body.nodes[0, body.pial[0]] > 0 else body.pial[-2]
    d[node] = outward, -0.3  # outward and under the base line, past no wall of the body
    start, end = (operator.walls.positions(operator.moved(x)) for x in (np.zeros(d.size), d.ravel()))
    bound = operator.walls.largest_step(start, end)  # of walls: triangles turn over sooner
    if base == "free":
        assert bound == 1.0
    else:
        height = body.nodes[1, node]  # the curve through it bends under the line at half of the way
        assert 0.3 * height / 0.3 < bound < height / 0.3


def test_the_mirror_line_is_an_obstacle_of_half_a_body():
    body = half(semicircle(radius=1.0, thickness=0.3, size=0.15))
    potential = SelfContact().on(body).during(state_of(body), STEP)
    d = np.zeros((body.nodes.shape[1], 2))
    near = [k for k in body.pial if 0 < body.nodes[0, k] < 0.2]
    d[near] = -0.5, 0.4
    bound = potential.evaluate(np.zeros(d.size)).largest_step(d.ravel())
    after = body.nodes[0, near] + bound * d[near, 0]
    assert bound < 1
    assert after.min() > 0


def test_the_hessian_has_room_for_contacts_to_come():
    # also for those of walls that slide along each other by an edge
    body = slotted()
    dhat = 0.05
    slid = np.where(body.nodes[0] > 1, 0.2 * np.clip(2 * body.nodes[1] - 1, 0.0, 1.0), 0.0)
    slid = np.stack([np.zeros_like(slid), slid]).T.ravel()
    potential = SelfContact().on(body).during(state_of(body), STEP)
    early = potential.evaluate(closed(body, 0.9 * dhat)).hessian(0.0).expected()
    places = set(zip(early.rows.ravel().tolist(), early.columns.ravel().tolist(), strict=True))
    later = potential.evaluate(closed(body, 0.3 * dhat) + slid).hessian(0.0).entries
    assert set(zip(later.rows.tolist(), later.columns.tolist(), strict=True)) <= places


def test_energy_scales_with_the_body_and_its_stress():
    # the same body in mm with the same stresses: energy per depth 1e6 times as large, forces 1e3 times
    body = slotted()
    mesh = MeshTri1(1e3 * body.mesh.p, body.mesh.t).with_boundaries(body.mesh.boundaries)
    large = Body(mesh, 200.0, "free")
    x = closed(body, 0.02)
    one = SelfContact().on(body).during(state_of(body, 3.0), STEP).evaluate(x)
    other = SelfContact().on(large).during(state_of(large, 3.0), STEP).evaluate(1e3 * x)
    assert other.energy == pytest.approx(1e6 * one.energy, rel=1e-9)
    forces = 1e3 * one.gradient()[0]
    np.testing.assert_allclose(other.gradient()[0], forces, atol=1e-9 * forces.max())


def test_the_scene_gives_the_scale_of_stress():
    body = slotted()
    gray, white = NeoHookean(mu=476.0, kappa=5551.0), NeoHookean(mu=650.0, kappa=7574.0)
    terms = (Elastic(gray=gray, white=white), SelfContact())
    state = begin(Scene(body=body, terms=terms)).state
    dhat = 0.05
    operator, x = SelfContact().on(body), closed(body, 0.5 * dhat)
    found = operator.during(state, STEP).evaluate(x).energy
    assert found == operator.during(state_of(body, 650.0), STEP).evaluate(x).energy > 0


def folded(gap):
    """Return the length of the folded surface; check on the way that no accepted step crosses a wall."""
    body = semicircle(radius=1.0, thickness=0.2, size=0.05)
    contact = SelfContact(gap=gap)
    operator = contact.on(body)
    scene = Scene(
        body=body,
        terms=(Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), contact),
        until=0.7,
        processes=(TangentialGrowth(cortex=2.6),),
        stepping=Stepping(first=0.05, largest=0.05),
    )
    for step, _ in march(scene, begin(scene)):
        assert not operator.walls.cross(operator.walls.positions(operator.moved(step.x)))
    assert step.numbers["min_gap"] < operator.dhat * operator.unit
    at = (body.nodes + step.state["displacement"])[:, body.pial]
    return float(np.hypot(*np.diff(at)).sum())


@pytest.mark.slow
def test_the_folded_surface_hardly_depends_on_the_barrier():
    """0.2 % with four elements through the cortex; 2.9 % with two, where creases are an element wide."""
    wide, narrow = folded(0.4), folded(0.2)
    assert wide > 1.2 * np.pi  # it has folded
    assert abs(wide / narrow - 1) < 0.01


def test_curves_do_not_cross_where_coarse_walls_fold():
    """With contact of corners and middles alone, 2 of these states overlap."""
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), SelfContact())
    scene = Scene(body=body, terms=terms, processes=(TangentialGrowth(cortex=2.6),), until=0.7)
    gaps = []
    for step, _ in march(scene, begin(scene)):
        pial = (body.nodes + step.state["displacement"])[:, body.pial]
        assert self_intersections(pial, closed=False, quadratic=True) == 0
        gaps.append(step.numbers["min_gap"])
    assert 0 < np.nanmin(gaps) < 0.02


def stem():
    """A section whose cut through the stem lies above the lobes beside it: the base line would cross them."""
    x = [0, 12, 28, 40, 43, 41, 36, 28, 20, 16, 13, 9]
    y = [42, 44, 38, 24, 8, -8, -20, -25, -21, -12, -4, -2]
    half = CubicSpline(range(12), np.stack([x, y], axis=1))(np.linspace(0, 11, 160))
    half = np.concatenate([half, [[9.0, -8.2]]])
    points = 1e-3 * np.concatenate([half, half[::-1][:-1] * [-1, 1]]).T
    return outline(
        points, thickness=2.5e-3, size=1e-3, base="clamped", base_ends=((-9e-3, -8.2e-3), (9e-3, -8.2e-3))
    )


@pytest.mark.parametrize("base_line", [True, False])
def test_the_base_line_ends_before_the_lobes_beside_it(base_line):
    body = stem()
    operator = SelfContact(base_line=base_line).on(body)
    assert not operator.walls.cross(operator.walls.positions(operator.moved(np.zeros(body.nodes.size))))
    assert (len(operator.names) > operator.names.count("body")) is base_line
    at = operator.during(state_of(body), STEP).evaluate(np.zeros(body.nodes.size))
    assert at.energy == 0.0


def test_contact_does_not_depend_on_where_the_body_is():
    body = slotted()
    far = Body(body.mesh.translated((150.0, -80.0)), 0.2, "free")
    x = closed(body, 0.02)
    one, other = (SelfContact().on(b).during(state_of(b), STEP).evaluate(x) for b in (body, far))
    assert other.energy == pytest.approx(one.energy, rel=1e-9)
    forces = one.gradient()[0]
    np.testing.assert_allclose(other.gradient()[0], forces, atol=1e-9 * np.abs(forces).max())


def test_a_skull_that_is_too_close_is_named():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)  # dhat 0.4 of 0.05
    with pytest.raises(ValueError, match=r"closer to the skull than dhat = 0\.0196 m, near \(") as failure:
        SelfContact(skull=arch(1.018, 0.03, np.pi - 0.03)).on(body)
    message_names(failure.value, "wider")


def test_importing_contact_changes_no_setting_of_ipctk():
    lines = ("import ipctk", "ipctk.set_num_threads(2)", "import turingfold.terms.contact")
    code = "\n".join((*lines, "print(ipctk.get_num_threads())"))
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "2"


def test_a_body_that_touches_itself_at_rest_is_refused():
    # at the tips of a rhombus, of 11 degrees, the walls are sin 11° = 0.2 edges apart
    points = np.array([[0.0, 1.0, 2.0, 1.0], [0.0, -0.1, 0.0, 0.1]])
    mesh = MeshTri1(points, np.array([[0, 1], [1, 2], [3, 3]])).refined(2)
    with pytest.raises(ValueError, match="dhat") as failure:
        SelfContact(gap=0.4).on(Body(mesh.with_boundaries({"pial": mesh.boundary_facets()}), 0.02, "free"))
    message_names(failure.value, "gap", "m;")


@pytest.mark.parametrize(
    ("name", "bad"),
    [
        ("base_line", 1),
        ("gap", 0.0),
        ("gap", 0.95),
        ("gap", float("nan")),
        ("stiffness", -1.0),
        ("stiffness", None),
    ],
)
def test_bad_input_is_refused(name, bad):
    with pytest.raises(ValueError, match=name):
        SelfContact(**{name: bad})


def test_skull_confines_the_folding_brain():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    angle = np.linspace(0.02, np.pi - 0.02, 200)
    radius = 1.05
    skull = radius * np.stack([np.cos(angle), np.sin(angle)])
    solid, growth = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), TangentialGrowth(cortex=1.9)
    outside = {}
    for name, contact in (("free", SelfContact()), ("skull", SelfContact(skull=skull))):
        scene = Scene(body=body, terms=(solid, contact), processes=(growth,))
        for step, _ in march(scene, begin(scene)):
            pial = (body.nodes + step.state["displacement"])[:, body.pial]
        above = pial[:, pial[1] > 0.1]
        outside[name] = np.hypot(*above).max()
    assert outside["free"] > 1.1
    assert outside["skull"] < radius


def test_the_contact_pressure_carries_what_the_stress_does():
    # a growing half disc under a flat lid: what the lid presses is what passes through each level below it
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    lid = np.array([[-2.0, 2.0], [1.03, 1.03]])
    processes = (TangentialGrowth(cortex=1.3, core=1.3, radial_core=1.3),)
    scene = Scene(
        body=body, terms=(Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), SelfContact(skull=lid)),
        processes=processes,
    )  # fmt: skip
    fields = (result := simulate(scene)).observe()
    pressure = fields["contact_pressure"]
    assert pressure.min() == 0.0
    np.testing.assert_array_equal(pressure, np.broadcast_to(pressure[0], pressure.shape))
    x, y = body.nodes + result.last["displacement"]
    facets = body.mesh.boundary_facets()
    start, end = body.mesh.facets[:, facets]
    middle, triangle = body.mesh.nvertices + facets, body.mesh.f2t[0, facets]
    length = sum(np.hypot(x[b] - x[a], y[b] - y[a]) for a, b in ((start, middle), (middle, end)))
    above = y[middle] > 0.95  # at its foot the body presses on the base line too
    pressed = float(pressure[0, triangle[above]] @ length[above])
    # where the lid presses, the forces of the stress balance it; elsewhere they vanish
    scene = result.scene
    elastic = scene.terms[0].on(body).during(result.last, TimeStep(1.0, over=True))
    forces = elastic.evaluate(by_node(result.last["displacement"])).gradient()[0].reshape(-1, 2)
    assert pressed > 0.5
    assert np.hypot(*forces[y > 0.95].T).sum() == pytest.approx(pressed, rel=1e-3)
    assert -forces[y > 0.95, 1].sum() == pytest.approx(pressed, rel=0.01)  # across a flat lid
    assert "contact_pressure" in result.observe(0)
    assert not result.observe(0)["contact_pressure"].any()


def test_the_contact_pressure_of_corners_is_over_both_their_edges():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1, base="free")
    corners = 1.03 * np.array([[-1, -0.03], [1, -0.03], [1, 1], [-1, 1], [-1, -0.03]])
    sides = [np.linspace(a, b, 20, endpoint=False) for a, b in pairwise(corners)]
    box = np.concatenate([*sides, corners[-1:]]).T
    scene = Scene(
        body=body, terms=(Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)), SelfContact(skull=box)),
        processes=(TangentialGrowth(cortex=1.15, core=1.15, radial_core=1.15),),
    )  # fmt: skip
    with pytest.warns(HoldingForceWarning):  # the body is not in the middle of the box
        result = simulate(scene)
    pressure = result.observe()["contact_pressure"][0]
    points, facets = body.nodes + result.last["displacement"], body.mesh.boundary_facets()
    ends, middle = body.mesh.facets[:, facets], body.mesh.nvertices + facets
    length = sum(np.hypot(*(points[:, end] - points[:, middle])) for end in ends)
    triangle = body.mesh.f2t[0, facets]
    with_two = np.bincount(triangle, minlength=len(pressure)) == 2
    assert with_two.sum() == 2
    assert (pressure[with_two] > 0.3).all()
    contact = scene.terms[1].on(body).during(result.last, TimeStep(1.0, over=True))
    forces = contact.evaluate(by_node(result.last["displacement"])).gradient()[0].reshape(-1, 2)
    assert pressure[triangle] @ length == pytest.approx(np.hypot(*forces.T).sum(), rel=1e-9)


def test_skull_too_close():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    with pytest.raises(ValueError, match="skull"):
        SelfContact(skull=body.nodes[:, body.pial] * 1.0001).on(body)
    with pytest.raises(ValueError, match="skull has shape"):
        SelfContact(skull=np.zeros((3, 5)))


def arch(radius, low=0.02, high=np.pi - 0.02, centre=0.0):
    angle = np.linspace(low, high, 200)
    return np.stack([centre + radius * np.cos(angle), radius * np.sin(angle)])


@pytest.mark.parametrize(
    ("skull", "message"),
    [
        (arch(1.2)[:, 60:], r"skull does not go round .* the point \(0\.9\d+, 0\.[01]"),
        (arch(0.5), r"the point \(0\.9\d+, 0\.0\d+\) m of the pial surface lies outside"),
        (arch(1.2, centre=4.0), "lies outside"),
        (arch(1.2, centre=0.5), r"skull crosses the body near \(-0\.\d+, 0\.\d+\)"),
        (np.array([[1.2, 0.0, -1.2], [0.1, 0.99, 0.1]]), r"crosses the body near \(0\.96\d*, 0\.2[78]"),
    ],
    ids=["too short", "inside", "elsewhere", "shifted", "dented"],
)
@pytest.mark.parametrize("step", [1, -1], ids=["counter-clockwise", "clockwise"])
def test_a_skull_that_does_not_enclose_the_body_is_refused(skull, message, step):
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    skull = skull[:, ::step]
    if step < 0:
        message = "skull (crosses|does not go round) the body"
    with pytest.raises(ValueError, match=message):
        SelfContact(skull=skull).on(body)


def test_a_skull_around_half_a_body_ends_before_its_mirror():
    body = half(semicircle(radius=1.0, thickness=0.2, size=0.1))
    assert SelfContact(skull=arch(1.2, high=0.5 * np.pi - 0.02)).on(body).walls.chords.moving > 0
    with pytest.raises(ValueError, match=r"the point \(0\.5\d+, 0\.8\d+\)"):
        # from (0.97, 0.71) straight to (0, 1): what lies beyond x = 0.557, y = 0.831 is left out
        SelfContact(skull=arch(1.2, high=0.2 * np.pi)).on(body)


ENDS = r"skull reaches, near \({}, {}\) m, the line .* base \(or mirror\) continues .* clear of that line"


@pytest.mark.parametrize(
    ("low", "high", "where"),
    [
        (0.0, np.pi, (r"1\.2", "0")),
        (0.01, np.pi - 0.03, (r"1\.2", r"0\.012")),
        (0.03, np.pi, (r"-1\.2", r"0\.018\d*")),
        (-0.1, np.pi + 0.1, (r"1\.2", r"-0\.0\d+")),
        (-np.pi, np.pi, (r"-1\.2", r"-1\.5\d*e-16|-1\.4\d*e-16")),
    ],
    ids=["on the line", "near it", "one end", "beyond it", "all round"],
)
def test_a_skull_ends_clear_of_the_base_line(low, high, where):
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)  # dhat 0.4 of 0.05
    with pytest.raises(ValueError, match=ENDS.format(*where)):
        SelfContact(skull=arch(1.2, low, high)).on(body)
    clear = np.arcsin(0.021 / 1.2)
    assert SelfContact(skull=arch(1.2, clear, np.pi - clear)).on(body).walls.chords.moving > 0


def test_a_skull_ends_clear_of_the_line_of_the_mirror():
    body = half(semicircle(radius=1.0, thickness=0.2, size=0.1))
    with pytest.raises(ValueError, match=ENDS.format(r"0\.018\d*", r"1\.2")):
        SelfContact(skull=arch(1.2, high=0.5 * np.pi)).on(body)


def test_a_skull_around_a_closed_surface_is_closed():
    disc = outline(arch(1.0, 0.0, 2 * np.pi), thickness=0.2, size=0.1)
    around = arch(1.2, 0.0, 2 * np.pi)
    assert SelfContact(skull=around).on(disc).walls.chords.moving > 0
    with pytest.raises(ValueError, match=r"skull ends at \(1\.\d+, -0\.\d+\) m, not where it begins"):
        SelfContact(skull=around[:, :-1]).on(disc)
    with pytest.raises(ValueError, match="does not go round"):
        SelfContact(skull=around * 0.5).on(disc)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_state_is_an_equilibrium_as_it_was_found():
    made = folding_scene()
    grown = (*made.processes[:-1], replace(made.processes[-1], cortex=2.6))
    found = simulate(replace(made, processes=grown))
    problem = Problem(found.scene)
    free = np.setdiff1d(np.arange(problem.n_dofs), problem.held)
    for state, row in zip(found.states[1:], found.history, strict=True):
        step = TimeStep(row["step"], over=True)
        at = configuration(problem.potentials(state, step), by_node(state["displacement"]))
        assert at.forces(free)[1] == pytest.approx(row["residual"], rel=0.1, abs=1e-11)
        assert at.energy == pytest.approx(row["energy"], rel=1e-12)
    assert (found.last["contact_chords"] > found.states[0]["contact_chords"]).any(), "edges are to bend far"
