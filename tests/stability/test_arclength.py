"""Paths of equilibria through limit points: a truss with an exact answer, growing bodies, failures."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from checks import message_names
from small import elastic_scene

from turingfold.errors import NotConvergedError
from turingfold.geometry.mirror import half
from turingfold.geometry.shapes import semicircle
from turingfold.geometry.triangles import folded_over
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.laws import TangentialGrowth
from turingfold.parts import Entries, Evaluation, Evolution, Hessian, Operator, Potential, Process, Term
from turingfold.results.simulate import simulate
from turingfold.scene import Scene
from turingfold.solve.march import Progress, march
from turingfold.stability import arc_length as arclength
from turingfold.stability.arc_length import EquilibriumPath, PathPoint, PathStoppedError, equilibria
from turingfold.stability.buckling import buckling
from turingfold.stability.corrector import Corrector, Direction, Place
from turingfold.stability.path_dependence import at_rest
from turingfold.state import State
from turingfold.stepping import Stepping
from turingfold.terms.contact import SelfContact
from turingfold.terms.damping import StiffnessDamping
from turingfold.terms.dynamics import Drag, Inertia
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic
from turingfold.terms.tension import AxonalTension

SPAN, HEIGHT = 1.0, 0.3  # of half a shallow von Mises truss
LENGTH = np.hypot(SPAN, HEIGHT)  # of its bars at rest
CRITICAL = (LENGTH * SPAN**2) ** (1 / 3)  # of its bars at the limit points
LIMIT = 2 * (LENGTH / CRITICAL - 1) * np.sqrt(CRITICAL**2 - SPAN**2)  # largest load on bars of stiffness 1
LOADS = -1.5 * LIMIT, 1.5 * LIMIT  # at t = 0 and t = 1


class OfTheEnd(Term):
    """An energy of the last two unknowns, `end`; springs of stiffness 1 hold the others."""

    def on(self, body):
        own = np.arange(body.nodes.size)
        return EndOperator(self, Entries(np.append(own, own[-1]), np.append(own, own[-2])))


@dataclass(frozen=True)
class EndOperator(Operator):
    term: OfTheEnd
    entries: Entries
    resists_rigid_motions = True

    def during(self, state, step):
        return EndPotential(self, state.time)


@dataclass(frozen=True)
class EndPotential(Potential):
    operator: EndOperator
    time: float

    def evaluate(self, x):
        return EndEvaluation(self, x)


class EndEvaluation(Evaluation):
    def __init__(self, potential, x):
        self.x, self.entries = x, potential.operator.entries
        energy, self.force, self.block = potential.operator.term.end(x[-2:], potential.time)
        self.scale = potential.operator.term.scale
        self.energy = 0.5 * float(x[:-2] @ x[:-2]) + float(energy)

    def gradient(self):
        return np.append(self.x[:-2], self.force), self.scale

    def hessian(self, convexity):
        (first, _), (across, last) = self.block
        return Hessian(self.entries, np.append(np.ones(len(self.x) - 2), [first, last, across]))


@dataclass(frozen=True)
class Truss(OfTheEnd):
    """Two bars of stiffness 1 meet at the last node, which a load pushes down.

    Energy Σ ½ (l - l₀)² + p w, with p from LOADS[0] at t = 0 to LOADS[1] at t = 1, and constant outside.
    """

    scale = LIMIT**2

    def end(self, x, time):
        load = np.array([0.0, np.interp(time, [0, 1], LOADS)])
        bars = x - np.array([[-SPAN, -HEIGHT], [SPAN, -HEIGHT]])
        lengths = np.hypot(*bars.T)
        share = LENGTH / lengths
        parts = zip(share, bars / lengths[:, None], strict=True)
        block = sum((1 - s) * np.eye(2) + s * np.outer(u, u) for s, u in parts)
        force = ((1 - share)[:, None] * bars).sum(0) + load
        return 0.5 * ((lengths - LENGTH) ** 2).sum() + load @ x, force, block


BODY = semicircle(radius=1.0, thickness=0.3, size=0.5)


def truss():
    # the last node is on no base: it is the middle of an edge
    assert BODY.nodes.shape[1] * 2 - 1 not in BODY.fixed
    return Scene(body=BODY, terms=(Truss(),))


def load(w):
    """Return the exact load that pushes the truss down by w."""
    y = HEIGHT - w
    return 2 * (LENGTH / np.hypot(SPAN, y) - 1) * y


def times(loads):
    return (np.asarray(loads) - LOADS[0]) / (LOADS[1] - LOADS[0])


def depth(path):
    return np.array([-point.state["displacement"][1, -1] for point in path.points])


# the truss


@pytest.fixture(scope="module")
def path():
    return equilibria(truss())


def test_a_truss_snaps_through_as_in_theory(path):
    w, time = depth(path), path.of("time")
    assert time[0] == 0.0
    assert time[-1] == 1.0
    assert (np.diff(w) > 0).all()  # up to the first limit point, back to the second, and on
    assert times(load(w)) == pytest.approx(time, abs=1e-7)
    assert (path.of("residual") <= 1e-8).all()
    assert path.limit_points == pytest.approx(times([LIMIT, -LIMIT]), abs=1e-5)
    y = np.sqrt(CRITICAL**2 - SPAN**2)
    between = (w > HEIGHT - y) & (w < HEIGHT + y)
    assert path.of("negative_pivots").tolist() == between.astype(int).tolist()
    assert path.stable.tolist() == (~between).tolist()
    assert between.sum() > 5
    bars = np.hypot(SPAN, HEIGHT - w) - LENGTH
    assert path.of("energy") == pytest.approx(bars**2 - load(w) * w, abs=1e-9)


def test_the_rate_is_the_slope_of_time_along_the_path(path):
    """ds² = dw²/(n thickness²) + dt², n nodes, as only one of them moves."""
    w = depth(path)
    slope = (load(w + 1e-5) - load(w - 1e-5)) / 2e-5 / (LOADS[1] - LOADS[0])
    size = BODY.thickness * np.sqrt(BODY.nodes.shape[1])
    assert path.of("rate") == pytest.approx(slope / np.hypot(slope, 1 / size), abs=1e-4)
    chords = np.hypot(np.diff(w) / size, np.diff(path.of("time")))
    assert np.diff(path.of("arc")) == pytest.approx(chords, rel=1e-9)


def test_the_way_back_leads_to_the_start():
    there = equilibria(truss(), steps=40)
    assert there.limit_points.size > 0
    back = equilibria(truss(), start=there.points[-1], backward=True)
    assert back.points[-1].time == 0.0
    assert depth(back)[-1] == pytest.approx(depth(there)[0], abs=1e-8)
    assert back.limit_points == pytest.approx(there.limit_points[::-1], abs=1e-5)


def test_a_path_goes_on_from_any_of_its_points(path):
    first = equilibria(truss(), steps=15)
    second = equilibria(truss(), start=first.points[-1], arc=0.02)
    assert second.points[0].arc == first.points[-1].arc
    found = [*first.limit_points, *second.limit_points]
    assert found == pytest.approx(path.limit_points, abs=1e-5)
    assert second.points[-1].time == 1.0


def test_a_path_ends_where_it_is_told():
    path = equilibria(truss(), until=0.5)
    assert path.points[-1].time == 0.5
    assert depth(path)[-1] == pytest.approx(0.0, abs=1e-8)  # no load there
    assert len(equilibria(truss(), steps=3).points) == 4


@dataclass(frozen=True)
class Bent(OfTheEnd):
    """A force at the last node that is piecewise linear in its displacement u, against a load of 3 t.

    Its slope is `stiffness` below u = 1/stiffness and above u = 1.5/stiffness, and the opposite in between:
    t = 1/3 and 1/6 are limit points, at corners of the path.
    """

    stiffness: float
    scale = 1.0

    def end(self, x, time):
        k, load = self.stiffness, 3 * time
        u = x[1] * k
        one, other = np.clip(u - 1, 0, None), np.clip(u - 1.5, 0, None)
        energy = (0.5 * u**2 - one**2 + other**2) / k - load * x[1] + 0.5 * x[0] ** 2
        slope = -k if 1 < u < 1.5 else k
        return energy, np.array([x[0], u - 2 * one + 2 * other - load]), np.diag([1.0, slope])


@pytest.mark.parametrize("stiffness", [0.3, 3.0, 100.0])
def test_a_path_with_corners_is_followed_around_them(stiffness):
    """In arc lengths, u = 1/stiffness is 0.28/stiffness: the corners are turns by 0.7 to nearly π."""
    path = equilibria(Scene(body=BODY, terms=(Bent(stiffness),)))
    u = stiffness * np.array([point.state["displacement"][1, -1] for point in path.points])
    force = u - 2 * np.clip(u - 1, 0, None) + 2 * np.clip(u - 1.5, 0, None)
    assert (np.diff(u) > 0).all()
    assert path.points[-1].time == 1.0
    assert path.of("time") == pytest.approx(force / 3, abs=1e-8)
    assert path.of("negative_pivots").tolist() == ((u > 1) & (u < 1.5)).astype(int).tolist()
    assert path.limit_points == pytest.approx([1 / 3, 1 / 6], abs=1e-4)


@pytest.mark.parametrize(("start", "goes_on"), [(0.32, -1.0), (0.18, 1.0)], ids=["back", "on"])
def test_processes_are_asked_only_for_times_of_the_scene(monkeypatch, start, goes_on):
    """A guess beyond a corner is eight arcs away: here before the start, or after the end.

    From the first corner the path leads back to t = 1/6 only.
    """
    corrector = Corrector(Scene(body=BODY, terms=(Bent(3.0),)), 0.4)
    u = 3 * start if goes_on < 0 else 2 - 3 * start
    place = Place(np.append(np.zeros(2 * BODY.nodes.shape[1] - 1), u / 3.0), start, {})
    last = corrector.correct(place, Direction(np.zeros_like(place.x), -goes_on))
    asked, problem = [], corrector.path.problem
    processed = problem.processed
    monkeypatch.setattr(
        problem, "processed", lambda before, dt: asked.append(before.time + dt) or processed(before, dt)
    )
    if goes_on > 0:
        assert corrector.around(last, 0.06).tangent.time > 0
    else:
        with pytest.raises(NotConvergedError, match="no corner"):
            corrector.around(last, 0.06)
    assert min(asked) >= 0.0
    assert max(asked) <= 0.4 + 1e-7  # the difference by which forces are derived


def test_a_corrector_that_fails_has_moved_no_more_often_than_it_may(monkeypatch):
    corrector = Corrector(replace(truss(), stepping=Stepping(tolerance=1e-30)), 1.0)
    asked, problem = [], corrector.path.problem
    processed = problem.processed
    monkeypatch.setattr(problem, "processed", lambda *when: asked.append(when) or processed(*when))
    with pytest.raises(NotConvergedError, match="10 iterations"):
        corrector.correct(corrector.start, Direction(np.zeros_like(corrector.start.x), 1.0))
    assert len(asked) == 2 * 11  # at the start and after each of ten moves, there and a little later


def test_limit_points_and_what_is_there_are_interpolated():
    """t = 3 s - 4 s³ turns at s = ±1/2, where the cubics of s are exact."""
    arc = np.array([-0.9, -0.6, -0.3, 0.1, 0.4, 0.8])
    points = [
        PathPoint(
            state=State(3 * s - 4 * s**3, {}),
            arc=s,
            rate=3 - 12 * s**2,
            growth=1.0,
            energy=0.0,
            residual=0.0,
            negative_pivots=0,
        )
        for s in arc
    ]
    path = EquilibriumPath(tuple(points))
    assert path.limit_points == pytest.approx([-1.0, 1.0], rel=1e-12)
    assert path.at_limit_points(arc**3 + arc) == pytest.approx([-0.625, 0.625], rel=1e-12)
    assert EquilibriumPath(path.points[:2]).at_limit_points(arc[:2]).size == 0


RADIUS = 0.3


@dataclass(frozen=True)
class Ring(OfTheEnd):
    """A force (u + 2)² + (t - ½)² - r² at the last node: its equilibria are a circle, not seen from t = 0."""

    scale = 1.0

    def end(self, x, time):
        u, c = x[1] + 2, (time - 0.5) ** 2 - RADIUS**2
        return u**3 / 3 + c * u + 0.5 * x[0] ** 2, np.array([x[0], u**2 + c]), np.diag([1.0, 2 * u])


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("largest", [1.0, 2.0])
def test_a_closed_path_is_followed_once(backward, largest):
    displacement = np.zeros_like(BODY.nodes)
    displacement[1, -1] = RADIUS - 2
    start = PathPoint(
        state=State(0.5, {"displacement": displacement}),
        arc=0.0,
        rate=1.0,
        growth=1.0,
        energy=0.0,
        residual=0.0,
        negative_pivots=0,
    )
    with pytest.raises(PathStoppedError, match="come back to its point at arc") as caught:
        equilibria(
            Scene(body=BODY, terms=(Ring(),)), start=start, arc=0.02, largest=largest, backward=backward
        )
    path = caught.value.path
    message_names(caught.value, "closed loop", "imperfection")
    size = BODY.thickness * np.sqrt(BODY.nodes.shape[1])
    width = RADIUS / size  # of the ellipse, in arc lengths; its height is RADIUS
    share = ((RADIUS - width) / (RADIUS + width)) ** 2
    around = np.pi * (RADIUS + width) * (1 + 3 * share / (10 + np.sqrt(4 - 3 * share)))  # Ramanujan 1914
    *before, last = path.points
    apart = [np.abs(p.state["displacement"] - last.state["displacement"]).max() for p in before]
    met = before[int(np.argmin(apart))]
    assert min(apart) < 1e-4 * RADIUS
    assert met.time == pytest.approx(last.time, abs=1e-5)
    assert 0.98 * around < last.arc - met.arc < around  # of chords
    assert met.arc <= 0.02 * largest  # no point but the first ones is passed again
    assert sorted(path.limit_points[:2]) == pytest.approx([0.5 - RADIUS, 0.5 + RADIUS], abs=1e-5)


# growing bodies


def growing(*terms, element="auto", largest=0.1):
    """Return half a clamped disc that creases at its ends, without an exact solution."""
    body = half(semicircle(radius=1.0, thickness=0.2, size=0.1, base="clamped"))
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0), element=element)
    return Scene(
        body=body,
        terms=(solid, *terms),
        processes=(TangentialGrowth(cortex=2.0),),
        stepping=Stepping(first=0.1, largest=largest),
    )


def test_the_limit_point_of_a_clamped_disc_is_where_its_base_path_ends():
    scene = growing()
    path, found = equilibria(scene, steps=20), buckling(scene)
    assert found.limit
    # which brackets it to 1e-4 of the scene's time from below
    assert found.time <= path.limit_points[0] <= found.time + 1e-4
    assert path.points[-1].time < path.limit_points[0]
    beyond = np.flatnonzero(path.of("rate") < 0)[0]
    assert path.of("negative_pivots").tolist() == [0] * beyond + [1] * (21 - beyond)
    assert (path.of("residual") <= 1e-8).all()


@pytest.mark.slow
def test_a_path_does_not_depend_on_the_arc():
    """Its second turn is so local that a step too far ahead misses it, and with it the rest of the path."""
    fine, coarse = equilibria(growing(), steps=50), equilibria(growing(), arc=0.2, largest=4.0, steps=50)
    assert len(fine.limit_points) >= 2
    assert fine.limit_points[:2] == pytest.approx(coarse.limit_points[:2], abs=1e-5)


@pytest.mark.slow
def test_contact_turns_the_path_forward_again():
    """Without contact the crease closes at ever less growth; with it the body snaps to touching walls.

    On this coarse mesh the crease deepens node by node: between the first turn and the last are others.
    """
    scene = growing(SelfContact())
    path = equilibria(scene)
    turns = path.limit_points
    assert len(turns) % 2 == 0
    assert turns[1] < turns[0] - 0.05
    assert turns[1:].max() < turns[0]
    assert path.points[-1].time == 1.0
    assert path.stable[-1]
    assert path.of("negative_pivots").max() == 1
    body = scene.body
    assert not any(folded_over(body.mesh, body.nodes + p.state["displacement"]).size for p in path.points)
    on = path.points[np.flatnonzero(path.of("rate") < 0)[-1] + 3]
    assert on.time < turns[0]
    *_, (last, _) = march(scene, Progress(on.state, 0.05))  # on the branch that the path has come to
    assert last.numbers["negative_pivots"] == 0
    # bounds set after seeing 1.5e-3 and 1e-5: how many chords an edge has depends on the step before
    assert np.abs(last.state["displacement"] - path.points[-1].state["displacement"]).max() < 3e-3
    assert last.numbers["energy"] == pytest.approx(path.points[-1].energy, rel=1e-4)


@pytest.mark.parametrize("element", ["quadratic", "mixed"])
def test_without_a_limit_point_the_states_are_those_of_a_march(element):
    scene = elastic_scene(stepping=Stepping(first=0.1, largest=0.2, tolerance=1e-11))
    pull = AxonalTension(strength=0.02, patches=6)
    scene = replace(scene, terms=(replace(scene.terms[0], element=element), pull))
    path = equilibria(scene)
    assert path.limit_points.size == 0
    assert path.stable.all()
    for point in (path.points[len(path.points) // 2], path.points[-1]):
        marched = simulate(replace(scene, until=point.time))
        moved = marched.last["displacement"]
        assert np.abs(point.state["displacement"] - moved).max() < 1e-8 * np.abs(moved).max()
        assert point.energy == pytest.approx(marched.history[-1]["energy"], rel=1e-8)
        assert point.growth == pytest.approx(marched.history[-1]["growth"], rel=1e-12)


# what it refuses, and where it stops


@dataclass(frozen=True)
class Compounding(Process):
    """Growth that multiplies what is there at every step."""

    writes = ("growth",)

    def on(self, body):
        return Compounded(self, np.ones((3, *body.quadrature.weights.shape)))

    def factor(self, before, now):
        return 1 + now - before


@dataclass(frozen=True)
class Compounded(Evolution):
    law: Compounding
    none: np.ndarray

    def start(self, state, seed):
        return {"growth": self.none}

    def advance(self, before, now, dt):
        return {"growth": before["growth"] * self.law.factor(before.time, now.time)}


@dataclass(frozen=True)
class Waiting(Compounding):
    """Growth that is read off the last equilibrium, so that it changes with nothing but the displacement."""

    reads: tuple[str, ...] = ("displacement",)

    def factor(self, before, now):
        return 1.0


SOLID = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
RESISTING = (Drag(coefficient=1e-9), Inertia(density=1.0), StiffnessDamping(elastic=SOLID, time=1.0))


@pytest.mark.parametrize("term", RESISTING, ids=lambda term: type(term).__name__)
def test_terms_that_resist_motion_are_refused(term):
    with pytest.raises(ValueError, match=type(term).__name__):
        equilibria(growing(term))
    assert at_rest(growing(term)).terms == growing().terms


@pytest.mark.parametrize(
    "process", [Compounding(), Waiting(), Waiting(("cauchy_stress",))], ids=["steps", "place", "stress"]
)
def test_processes_that_remember_are_refused(process):
    with pytest.raises(ValueError, match=type(process).__name__):
        equilibria(replace(growing(), processes=(process,)))


@dataclass(frozen=True)
class Late(Compounding):
    """Growth that remembers its steps from t = 0.7 on, by when they begin or by when they end."""

    share: float = 1.0

    def factor(self, before, now):
        late = before + self.share * (now - before) > 0.7
        return 1 + now - before if late else 1.0


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_processes_that_remember_only_late_are_refused(share):
    with pytest.raises(ValueError, match="Late"):
        equilibria(replace(growing(), processes=(Late(share),)))


@dataclass(frozen=True)
class Tabled(Compounding):
    """Growth after a table that may read the last equilibrium."""

    table: np.ndarray
    reads: tuple[str, ...] = ()


def test_processes_with_arrays_are_told_apart():
    processes = Tabled(np.ones(3)), Tabled(np.zeros(3), ("displacement", "growth"))
    with pytest.raises(ValueError, match="processes holds Tabled"):
        equilibria(replace(growing(), processes=processes))


def test_nothing_is_made_for_a_scene_that_is_refused(monkeypatch):
    def made(self, body):
        raise AssertionError

    monkeypatch.setattr(TangentialGrowth, "on", made)
    with pytest.raises(ValueError, match="Drag"):
        equilibria(growing(RESISTING[0]))
    with pytest.raises(ValueError, match="Drag"):
        buckling(growing(RESISTING[0]))


def test_processes_that_act_on_one_another_are_not_refused():
    noise = Imperfection(of="growth", amplitude=0.01)
    scene = growing()
    assert len(equilibria(replace(scene, processes=(*scene.processes, noise)), steps=2).points) == 3


def test_a_path_that_cannot_go_on_keeps_what_it_has():
    with pytest.raises(PathStoppedError) as caught:
        equilibria(growing(), arc=2.0, smallest=1.0, largest=1.0)
    message_names(caught.value, "after 1 points", "t = 0", "smallest")
    assert caught.value.time == 0.0
    assert len(caught.value.path.points) == 1


def test_a_path_stops_at_the_time_limit():
    scene = replace(growing(), stepping=Stepping(seconds=1e-6))
    with pytest.raises(PathStoppedError, match="time limit"):
        equilibria(scene)


def test_a_step_that_ends_after_the_time_limit_is_kept(monkeypatch):
    clock = iter([0.0, 0.0, 10.0, 20.0])  # looked at when the path begins and before each step
    monkeypatch.setattr(arclength, "perf_counter", lambda: next(clock))
    with pytest.raises(PathStoppedError, match="after 3 points") as caught:
        equilibria(replace(truss(), stepping=Stepping(seconds=15.0)))
    message_names(caught.value, "15 s", "Stepping(seconds=...)", "start")
    assert "smallest" not in str(caught.value)
    assert "nan" not in str(caught.value)
    assert len(caught.value.path.points) == 3
    assert caught.value.residual == caught.value.path.points[-1].residual


@pytest.mark.parametrize(
    ("scene", "why"),
    [
        (replace(growing(), stepping=Stepping(tolerance=1e-30)), "iterations"),  # below round-off
        (Scene(body=BODY, terms=(Bent(-1.0),)), "unstable"),
    ],
    ids=["not balanced", "unstable"],
)
def test_a_start_that_is_no_stable_equilibrium_is_an_error(scene, why):
    with pytest.raises(PathStoppedError) as caught:
        equilibria(scene)
    message_names(caught.value, "after 0 points", why)
    assert caught.value.path.points == ()


@pytest.mark.parametrize(
    "options",
    [
        {"arc": 0.0}, {"smallest": 2.0}, {"largest": -1.0}, {"largest": 0.5}, {"steps": 0}, {"until": 2.0},
        {"backward": True},
    ],
    ids=str,
)  # fmt: skip
def test_bad_options(options):
    with pytest.raises(ValueError, match=next(iter(options))):
        equilibria(truss(), **options)


def test_bad_start():
    path = equilibria(truss(), steps=3)
    with pytest.raises(ValueError, match="PathPoint"):
        equilibria(truss(), start=path)
    with pytest.raises(ValueError, match="beyond until"):
        equilibria(truss(), start=path.points[-1], until=0.5 * path.points[-1].time)


def test_a_start_that_leads_nowhere():
    still = replace(equilibria(truss(), steps=3).points[-1], rate=0.0)
    with pytest.raises(PathStoppedError, match="does not cross the plane") as caught:
        equilibria(truss(), start=still)
    assert caught.value.path.points == ()


def test_a_start_on_another_mesh():
    with pytest.raises(ValueError, match="start holds a displacement of shape") as caught:
        equilibria(growing(), start=equilibria(truss(), steps=1).points[-1])
    message_names(caught.value, str(BODY.nodes.shape), str(growing().body.nodes.shape), "same mesh")
