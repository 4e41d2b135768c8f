"""The march: step sizes, halving and growth of steps, untouched retries, limits, and typed errors."""

import re
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from checks import message_names
from hypothesis import given, settings
from hypothesis import strategies as st
from skfem import MeshTri1

from turingfold.errors import InadmissibleStateError, MissingFieldError, NotConvergedError
from turingfold.geometry.body import Body
from turingfold.geometry.shapes import semicircle
from turingfold.growth.histories import Exponential
from turingfold.growth.laws import TangentialGrowth
from turingfold.parts import (
    Entries,
    Evaluation,
    Evolution,
    Hessian,
    Operator,
    Potential,
    Process,
    Term,
    TimeStep,
)
from turingfold.scene import Scene
from turingfold.solve.march import begin, march
from turingfold.solve.newton import Minimiser
from turingfold.solve.problem import Problem
from turingfold.solve.snap import Creep
from turingfold.state import State
from turingfold.stepping import Stepping
from turingfold.terms.contact import SelfContact
from turingfold.terms.dynamics import (
    Dissipation,
    DissipationEvaluation,
    Drag,
    DragOperator,
    Inertia,
    mass,
)
from turingfold.terms.elastic.material import NeoHookean
from turingfold.terms.elastic.term import Elastic
from turingfold.testing import check_process, check_term

SOLID = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))


@pytest.fixture(scope="module")
def body():
    mesh = MeshTri1.init_tensor(np.linspace(0, 2, 5), np.linspace(0, 1, 3))
    return Body(mesh.with_boundaries({"pial": lambda p: p[1] == 1, "base": lambda p: p[1] == 0}), 0.5)


@dataclass(frozen=True)
class Watcher(Process, Evolution):
    """A process that writes its time, and keeps a note of every call."""

    notes: list = field(default_factory=list)
    broken_from: float = np.inf
    writes = keeps = ("clock",)

    def on(self, body):
        return self

    def start(self, state, seed):
        return {"clock": np.array([0.0])}

    def advance(self, before, now, dt):
        self.notes.append((before.time, dt, before["clock"].copy(), before["displacement"].copy()))
        broken = now.time > self.broken_from
        return {"clock": np.array([np.nan if broken else now.time])}


@dataclass(frozen=True)
class Refuser(Term, Operator):
    """A term without energy that refuses steps longer than `longest`, or ending after `last`."""

    longest: float = np.inf
    last: float = np.inf

    def on(self, body):
        return self

    def during(self, state, step):
        if step.length > self.longest or state.time > self.last:
            raise NotConvergedError("refused", residual=0.25)


def scene(body, *terms, processes=(), **stepping):
    return Scene(body=body, terms=(SOLID, *terms), processes=processes, stepping=Stepping(**stepping))


def run(made):
    return list(march(made, begin(made)))


def test_steps_grow_by_1_3_up_to_the_largest_and_end_on_time(body):
    steps = run(scene(body, first=0.1, largest=0.2))
    sizes = [step.numbers["step"] for step, _ in steps]
    expected = [0.1, 0.13, 0.169, 0.2, 0.2]
    assert sizes[:5] == pytest.approx(expected, rel=1e-12)
    assert sum(sizes) == pytest.approx(1.0, rel=1e-12)
    assert steps[-1][0].state.time == pytest.approx(1.0, rel=1e-12)
    assert [step.numbers["time"] for step, _ in steps] == pytest.approx(np.cumsum(sizes), rel=1e-12)


def test_a_laborious_step_is_followed_by_a_shorter_one(body):
    grow = TangentialGrowth(cortex=1.3)
    steps = run(scene(body, processes=(grow,), first=0.1, largest=0.1, iterations=4))
    sizes = [step.numbers["step"] for step, _ in steps]
    efforts = [step.numbers["newton_iterations"] for step, _ in steps]
    assert 3 in efforts
    for size, after, effort in zip(sizes[:-2], sizes[1:], efforts, strict=False):
        factor = 1.3 if effort <= 1.6 else 1.0 if effort <= 2.4 else 1 / 1.3
        assert after == pytest.approx(min(factor * size, 0.1), rel=1e-12)


def test_sizes_are_shares_of_the_end(body):
    made = Scene(body=body, terms=(SOLID,), until=50.0, stepping=Stepping(first=0.1, largest=0.1))
    assert [step.numbers["step"] for step, _ in run(made)] == pytest.approx([5.0] * 10, rel=1e-9)


@settings(derandomize=True, max_examples=20, deadline=None)
@given(first=st.floats(0.02, 1.0), share=st.floats(0.02, 1.0), until=st.floats(1e-3, 1e3))
def test_no_march_overshoots_or_ends_with_a_sliver(body, first, share, until):
    largest = max(first, share)
    made = Scene(body=body, terms=(SOLID,), until=until, stepping=Stepping(first=first, largest=largest))
    sizes = [step.numbers["step"] / until for step, _ in run(made)]
    assert sum(sizes) == pytest.approx(1.0, abs=1e-9)
    assert max(sizes) <= largest * 1.0100001  # what would be left over is taken along
    if len(sizes) > 1:
        assert sizes[-1] > 0.0099 * sizes[-2]


def test_a_refused_step_is_halved_and_then_grows_again(body):
    watcher = Watcher()
    steps = run(scene(body, Refuser(longest=0.11), processes=(watcher,), first=0.4, largest=0.4))
    tried = [dt for _, dt, _, _ in watcher.notes]
    # 0.4, 0.2 are refused; 0.1 is taken; 0.13 is refused, 0.065 taken, then 0.0845, 0.10985, 0.142805, ...
    assert tried[:8] == pytest.approx([0.4, 0.2, 0.1, 0.13, 0.065, 0.0845, 0.10985, 0.142805], rel=1e-12)
    assert max(step.numbers["step"] for step, _ in steps) <= 0.11
    assert steps[-1][0].state.time == pytest.approx(1.0, rel=1e-12)


def test_a_retry_starts_from_the_untouched_state(body):
    watcher = Watcher()
    growing = (watcher, TangentialGrowth(cortex=1.3))
    run(scene(body, Refuser(longest=0.11), processes=growing, first=0.4, largest=0.4))
    by_time: dict[float, list] = {}
    for time, _, clock, displacement in watcher.notes:
        by_time.setdefault(time, []).append((clock, displacement))
        assert clock[0] == time
    assert max(len(tries) for tries in by_time.values()) >= 3
    for tries in by_time.values():
        for clock, displacement in tries[1:]:
            assert np.array_equal(clock, tries[0][0])
            assert np.array_equal(displacement, tries[0][1])


def test_a_march_that_cannot_go_on_says_when_and_what_to_try(body):
    made = scene(body, Refuser(last=0.5), first=0.1, largest=0.1, smallest=1e-3)
    steps = march(made, begin(made))
    good = []
    with pytest.raises(NotConvergedError) as failure:
        good.extend(step.state.time for step, _ in steps)
    error, reached = failure.value, good[-1]
    # steps down to 1e-3 were tried: the last good time is within two of them of the limit
    assert 0.5 - 2e-3 < reached <= 0.5
    assert error.time == reached
    assert error.residual == 0.25
    assert isinstance(error.__cause__, NotConvergedError)
    message_names(error, f"t = {reached:.6g} of 1", "refused", "0.25", "Stepping", "Drag", "last good state")


def test_a_field_that_is_not_finite_stops_the_march(body):
    made = scene(body, processes=(Watcher(broken_from=0.35),), first=0.1, largest=0.1, smallest=1e-2)
    with pytest.raises(NotConvergedError) as failure:
        run(made)
    assert isinstance(failure.value.__cause__, InadmissibleStateError)
    assert failure.value.time == pytest.approx(0.35, abs=0.011)
    message_names(failure.value, "'clock'", "not finite")


@dataclass(frozen=True)
class Marked(Drag):
    """Drag that leaves a field behind, which is broken after t = 0.35."""

    writes = ("mark",)

    def on(self, body):
        return MarkedOperator(mass(body, self.coefficient))


class MarkedOperator(DragOperator):
    def during(self, state, step):
        found = super().during(state, step)
        return MarkedPotential(found.matrix, found.rest, found.weight, step=step, name=str(state.time))


class MarkedPotential(Dissipation):
    def evaluate(self, x):
        return MarkedEvaluation(self, x)


class MarkedEvaluation(DissipationEvaluation):
    def finish(self, wanted):
        return {"mark": np.array([np.nan if float(self.potential.name) > 0.35 else 1.0])}


def test_no_state_with_a_field_of_a_term_that_is_not_finite_is_accepted(body):
    made = scene(body, Marked(coefficient=1.0), first=0.1, largest=0.1, smallest=1e-2)
    with pytest.raises(NotConvergedError) as failure:
        run(made)
    assert failure.value.time == pytest.approx(0.35, abs=0.011)
    message_names(failure.value, "'mark'", "not finite")


def test_the_time_limit_stops_between_steps(body):
    made = scene(body, first=0.1, largest=0.1, seconds=1e-9)
    with pytest.raises(NotConvergedError, match="time limit") as failure:
        run(made)
    assert failure.value.time == 0.0


def test_growth_that_shrinks_to_nothing_is_a_typed_error(body):
    # g = 1 + (0.4 - 1) t reaches 0 at t = 1/0.6
    made = Scene(
        body=body,
        terms=(SOLID,),
        processes=(TangentialGrowth(cortex=0.4),),
        until=2.0,
        stepping=Stepping(first=0.05, largest=0.05, smallest=1e-2),
    )
    with pytest.raises(NotConvergedError) as failure:
        run(made)
    assert 0.5 < failure.value.time < 1 / 0.6


def test_without_growth_and_load_nothing_moves(body):
    for step, _ in run(scene(body, first=0.5, largest=0.5)):
        assert not step.state["displacement"].any()
        assert step.numbers["newton_iterations"] == 0
        assert step.numbers["min_jacobian"] == pytest.approx(1.0, rel=1e-13)


def test_the_path_does_not_depend_on_the_steps(body):
    # elasticity has no memory: the end of a stable path is the same in 2 and in 10 steps
    ends = []
    for size in (0.5, 0.1):
        grow = TangentialGrowth(cortex=1.3)
        step = run(scene(body, processes=(grow,), first=size, largest=size, tolerance=1e-11))[-1][0]
        assert step.numbers["negative_pivots"] == 0
        ends.append(step.state["displacement"])
    assert np.abs(ends[0]).max() > 0.01
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)


def folding():
    """A body that folds until its walls touch."""
    made = semicircle(radius=1.0, thickness=0.2, size=0.1)
    return Scene(
        body=made,
        terms=(SOLID, SelfContact()),
        processes=(TangentialGrowth(cortex=2.6),),
        until=0.7,
        stepping=Stepping(first=0.1, largest=0.1),
    )


def test_a_march_goes_on_as_if_it_had_not_been_interrupted():
    made = folding()
    whole = run(made)
    middle = len(whole) - 2
    dhat = SelfContact().on(made.body).dhat
    assert whole[middle - 1][0].numbers["min_gap"] < dhat  # interrupted while walls are in contact
    rest = list(march(folding(), whole[middle - 1][1]))
    assert len(rest) == len(whole) - middle
    for (one, _), (other, _) in zip(whole[middle:], rest, strict=True):
        assert np.array_equal(one.state["displacement"], other.state["displacement"])
        assert one.numbers["energy"] == other.numbers["energy"]
        assert one.numbers["newton_iterations"] == other.numbers["newton_iterations"]


def test_a_full_body_keeps_its_mirror_symmetry_while_it_is_stable():
    made = semicircle(radius=1.0, thickness=0.2, size=0.1, base="roller")
    grow = TangentialGrowth(cortex=1.4)
    u = run(scene(made, processes=(grow,), first=0.5, largest=0.5, tolerance=1e-11))[-1]
    place = {(round(x, 9), round(y, 9)): k for k, (x, y) in enumerate(made.nodes.T.tolist())}
    image = [place[(round(-x, 9) + 0.0, round(y, 9))] for x, y in made.nodes.T.tolist()]
    u = u[0].state["displacement"]
    assert np.abs(u).max() > 0.01
    np.testing.assert_allclose(u[:, image], np.array([[-1.0], [1.0]]) * u, atol=1e-9)


@pytest.mark.parametrize(
    "process",
    [
        TangentialGrowth(cortex=1.5),
        TangentialGrowth(cortex=1.5, core=1.1, radial_core=1.2, swelling_core=1.1),
        TangentialGrowth(cortex=1.5, out_of_plane="tangential", history=Exponential()),
        TangentialGrowth(cortex=1.5, modulation=0.5),
    ],
    ids=["cortex", "core", "out of plane", "modulated"],
)
def test_growth_passes_the_examination(body, process):
    fields = {"displacement": np.zeros_like(body.nodes)}
    if process.modulation:
        fields["pattern"] = body.cortex.mesh.doflocs[0] / 2  # from 0 to 1
    end = check_process(process, body, State(0.0, fields), 0.5)
    deep = body.in_cortex
    core, swell = (process.history.factor(g, 0.5) for g in (process.core, process.swelling_core))
    np.testing.assert_allclose(end["growth"][0][:, ~deep], core * swell, rtol=1e-13)
    np.testing.assert_allclose(end["growth"][1][:, deep], 1.0, rtol=1e-13)
    share = 1 + process.modulation * (body.quadrature.points[0][:, deep] - 1)
    most = 1 + (process.history.factor(1.5, 0.5) - 1) * share
    np.testing.assert_allclose(end["growth"][0][:, deep], most, rtol=1e-13)
    out = end["growth"][0] if process.out_of_plane == "tangential" else 1.0
    np.testing.assert_allclose(end["growth"][2], out * np.ones_like(end["growth"][2]), rtol=1e-14)
    assert (end["growth"] > 0).all()


def test_a_scene_refuses_what_does_not_fit(body):
    with pytest.raises(ValueError, match="body"):
        Scene(body=body.mesh, terms=(SOLID,))
    with pytest.raises(ValueError, match="terms") as failure:
        Scene(body=body, terms=())
    message_names(failure.value, "Elastic")
    with pytest.raises(ValueError, match="terms") as failure:
        Scene(body=body, terms=(TangentialGrowth(),))
    message_names(failure.value, "TangentialGrowth", "processes")
    with pytest.raises(ValueError, match="until"):
        Scene(body=body, terms=(SOLID,), until=0.0)
    with pytest.raises(ValueError, match="seed"):
        Scene(body=body, terms=(SOLID,), seed=-1)
    with pytest.raises(MissingFieldError, match="pattern") as failure:
        Scene(body=body, terms=(SOLID,), processes=(TangentialGrowth(modulation=0.5),))
    message_names(failure.value, "TangentialGrowth", "no earlier process writes")
    with pytest.raises(ValueError, match="terms holds the class Elastic") as failure:
        Scene(body=body, terms=(Elastic,))
    message_names(failure.value, "write Elastic(...)")
    with pytest.raises(ValueError, match="processes holds the class TangentialGrowth"):
        Scene(body=body, terms=(SOLID,), processes=(TangentialGrowth,))
    with pytest.raises(ValueError, match="must be a Stepping object"):
        Scene(body=body, terms=(SOLID,), stepping={"first": 0.1})
    with pytest.raises(ValueError, match="Watcher writes the field 'clock', which is written already"):
        Scene(body=body, terms=(SOLID,), processes=(Watcher(), Watcher()))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"first": 0.0}, ("first", "positive")),
        ({"largest": 1.5}, ("largest", "at most 1")),
        ({"first": 0.2, "largest": 0.1}, ("first=0.2", "largest=0.1", "order")),
        ({"smallest": 0.5}, ("smallest=0.5",)),
        ({"tolerance": float("nan")}, ("tolerance", "finite")),
        ({"iterations": 0}, ("iterations", "at least 1")),
        ({"seconds": 0.0}, ("seconds", "positive")),
        ({"tolerance": 1.0}, ("tolerance=1", "at most 0.001", "no equilibrium")),
        ({"seconds": float("nan")}, ("seconds", "finite")),
        ({"seconds": "60"}, ("seconds='60'", "finite")),
    ],
)
def test_bad_stepping_is_refused(options, words):
    with pytest.raises(ValueError, match=words[0].split("=")[0]) as failure:
        Stepping(**options)
    message_names(failure.value, *words)


def test_progress_is_a_value(body):
    made = scene(body, first=0.5, largest=0.5)
    start = begin(made)
    assert start.dt == 0.5
    again = replace(start, dt=0.25)
    assert next(march(made, again))[0].numbers["step"] == 0.25
    assert start.state.time == 0.0


@pytest.mark.parametrize(
    ("term", "other", "power"),
    [(Inertia(density=1.3), Inertia(density=2.0), 2), (Drag(coefficient=0.7), Drag(coefficient=0.9), 1)],
)
def test_inertia_and_drag_pass_the_examination(body, term, other, power):
    rng = np.random.default_rng(0)
    shape = body.nodes.shape
    state = State(0.3, {"displacement": rng.standard_normal(shape), "velocity": rng.standard_normal(shape)})
    samples = [rng.standard_normal(2 * shape[1]) for _ in range(2)]
    # both are measured from the last step: neither balanced nor blind to motion
    check_term(term, body, state, samples, step=0.1, balanced=False, objective=False, other=other)
    mass = term.density if isinstance(term, Inertia) else term.coefficient
    still = State(0.3, {"displacement": np.zeros(shape)})
    moved = np.tile([0.3, -0.2], shape[1])
    # a translation by d until forces balance, after 0.1 or half of it, on an area of 2: ½ m |d|² / span^power
    for step, span in ((TimeStep(0.1), 0.1), (TimeStep(0.1, 0.5), 0.05)):
        energy = term.on(body).during(still, step).evaluate(moved).energy
        assert energy == pytest.approx(0.5 * mass * 2.0 * 0.13 / span**power, rel=1e-12)


@dataclass(frozen=True)
class Fence(Term, Operator, Potential):
    """No energy, but nothing may move farther than `limit`."""

    limit: float

    def on(self, body):
        return self

    def during(self, state, step):
        return self

    def evaluate(self, x):
        return Inside(self.limit, x)


@dataclass(frozen=True)
class Inside(Evaluation):
    limit: float
    x: np.ndarray
    energy, has_hessian = 0.0, False

    def gradient(self):
        return np.zeros_like(self.x), 0.0

    def hessian(self, convexity):
        return Hessian(Entries(NONE, NONE), np.zeros(0))

    def largest_step(self, direction):
        return 1.0 if np.abs(self.x + direction).max() <= self.limit else 0.5


class Border(Fence):
    """No energy, but nothing that has moved farther than `limit` is a body."""

    def evaluate(self, x):
        return Across(self.limit, x)


class Across(Inside):
    def largest_step(self, direction):
        return 1.0

    def is_valid(self):
        return np.abs(self.x).max() <= self.limit


NONE = np.zeros(0, dtype=np.int64)


def test_a_rejected_end_leaves_no_tangent_behind(body, monkeypatch):
    """Forces balance in the middle of a step, which is admissible; its end is not, so that it is halved."""
    kept = []
    minimise = Minimiser.minimise

    def spied(self, *arguments):
        kept.append(self.memory.point)
        return minimise(self, *arguments)

    monkeypatch.setattr(Minimiser, "minimise", spied)

    def first_step(limit):
        made = scene(
            body,
            Fence(limit),
            Drag(coefficient=1e-3),
            processes=(TangentialGrowth(cortex=1.3),),
            first=0.2,
            largest=0.2,
            scheme="midpoint",
        )
        return next(march(made, begin(made)))[0]

    free = first_step(np.inf)
    assert free.numbers["step"] == pytest.approx(0.2)
    kept.clear()
    step = first_step(0.75 * np.abs(free.state["displacement"]).max())
    assert step.numbers["step"] == pytest.approx(0.1)
    assert kept == [None, None]


def test_the_time_limit_holds_inside_a_step(body, monkeypatch):
    clock = iter(np.arange(0.0, 1e6))  # every look at it takes a second
    for name in ("march", "newton", "problem"):
        monkeypatch.setattr(f"turingfold.solve.{name}.perf_counter", lambda: float(next(clock)))
    made = scene(body, processes=(TangentialGrowth(cortex=3.0),), first=1.0, largest=1.0, seconds=9.0)
    with pytest.raises(NotConvergedError, match=r"time limit of 9 s.*resume=True") as stopped:
        run(made)
    assert stopped.value.time == 0.0
    assert next(clock) < 40  # not until the step is over


def test_a_scene_that_nothing_holds_together_is_refused(body):
    made = Scene(body=body, terms=(SelfContact(),))
    with pytest.raises(ValueError, match=r"resists deformation.*Elastic"):
        run(made)


@dataclass(frozen=True)
class Careless(Process, Evolution):
    """A process whose methods return what they were told to."""

    first: object
    later: object
    writes = keeps = ("clock",)

    def on(self, body):
        return self

    def start(self, state, seed):
        return self.first

    def advance(self, before, now, dt):
        return self.later


@pytest.mark.parametrize("first", [None, {"time": np.zeros(1)}, [np.zeros(1)]])
def test_a_process_returns_the_fields_it_writes(body, first):
    good = {"clock": np.zeros(1)}
    with pytest.raises(ValueError, match=r"Careless\.start.*\(clock\)"):
        begin(scene(body, processes=(Careless(first, good),)))
    with pytest.raises(ValueError, match=r"Careless\.advance.*\(clock\)"):
        run(scene(body, processes=(Careless(good, first),)))


@dataclass(frozen=True)
class Indiscreet(Fence):
    """It leaves a field that it does not declare."""

    def evaluate(self, x):
        return Telling(self.limit, x)


class Telling(Inside):
    def finish(self, wanted):
        return {"secret": self.x}


def test_a_term_leaves_only_what_it_declares(body):
    with pytest.raises(ValueError, match=r"Telling\.finish returned secret, which no term declares"):
        run(scene(body, Indiscreet(np.inf)))


@dataclass(frozen=True)
class Observer(Process, Evolution):
    """A process that keeps what it is given."""

    reads: tuple[str, ...] = ("growth",)
    seen: list = field(default_factory=list)

    def on(self, body):
        return self

    def start(self, state, seed):
        return {}

    def advance(self, before, now, dt):
        self.seen.append((before, now, dt))
        return {}


@pytest.mark.parametrize("element", ["quadratic", "mixed"])
def test_a_process_is_given_the_last_equilibrium_whole(body, element):
    """Growth, shape and stress of `before` belong together; `now` has what earlier processes have made."""
    solid = Elastic(gray=SOLID.gray, element=element)
    first, last = Observer(("displacement", "cauchy_stress")), Observer()
    stepping = Stepping(first=0.1, largest=0.2)
    made = Scene(
        body=body, terms=(solid, Refuser(longest=0.15)), stepping=stepping,
        processes=(first, TangentialGrowth(cortex=1.4), last),
    )  # fmt: skip
    states = [step.state for step, _ in run(made)]
    problem = Problem(made)
    free = np.setdiff1d(np.arange(problem.n_dofs), problem.held)
    assert len(first.seen) == len(last.seen) > len(states)  # some steps were refused
    for (before, now, dt), (_, later, _) in zip(first.seen, last.seen, strict=True):
        assert now.time == later.time == before.time + dt
        assert "growth" not in now
        cortex = body.in_cortex
        np.testing.assert_allclose(later["growth"][0][:, cortex], 1 + 0.4 * now.time, rtol=1e-13)
        np.testing.assert_allclose(before["growth"][0][:, cortex], 1 + 0.4 * before.time, rtol=1e-13)
        if before.time == 0.0:
            assert not before["displacement"].any()
            continue
        assert any(before.time == state.time for state in states)
        x = before["displacement"].T.ravel()
        at = solid.on(body).during(before, TimeStep(dt)).evaluate(x)
        forces, scale = at.gradient()
        assert np.linalg.norm(forces[free]) <= 1.01 * stepping.tolerance * np.sqrt(scale)
        stress = at.finish(frozenset({"cauchy_stress"}))["cauchy_stress"]
        np.testing.assert_allclose(before["cauchy_stress"], stress, atol=1e-9 * np.abs(stress).max())
        assert np.abs(stress).max() > 1e-2


@dataclass
class Attempt:
    time: float
    dt: float
    snaps: bool = False
    minimiser: Minimiser | None = None


def attempts(monkeypatch, refused=lambda time: False):
    """Return a list of steps tried from now on; those from a time that is refused fail unless they snap."""
    tried = []
    processed, minimise, to_minimum = Problem.processed, Minimiser.minimise, Creep.to_minimum

    def noted(self, before, dt):
        tried.append(Attempt(before.time, dt))
        return processed(self, before, dt)

    def hindered(self, *given, **options):
        tried[-1].minimiser = self
        if refused(tried[-1].time) and not tried[-1].snaps:
            raise NotConvergedError("no way on")
        return minimise(self, *given, **options)

    def snapping(self, *given, **options):
        tried[-1].snaps = True
        return to_minimum(self, *given, **options)

    monkeypatch.setattr(Problem, "processed", noted)
    monkeypatch.setattr(Minimiser, "minimise", hindered)
    monkeypatch.setattr(Creep, "to_minimum", snapping)
    return tried


@pytest.mark.parametrize(
    ("smallest", "sizes"),
    [(1e-6, [0.2, 0.1, 0.05, 0.025, 0.0125]), (0.025, [0.2, 0.1, 0.05, 0.025, 0.025]), (0.2, [0.2, 0.2])],
)
def test_an_end_that_is_no_body_is_refused_before_it_is_taken(body, monkeypatch, smallest, sizes):
    """However short the steps may be, the march does not stop for it: the result tells of it."""
    tried = attempts(monkeypatch)
    growing = (TangentialGrowth(cortex=1.3),)
    steps = run(scene(body, Border(1e-9), processes=growing, first=0.2, largest=0.2, smallest=smallest))
    assert [one.dt for one in tried if one.time == 0] == pytest.approx(sizes)
    assert len(tried) == len(steps) + len(sizes) - 1  # from what is no body, steps go on as ever
    assert steps[-1][0].state.time == pytest.approx(1.0)


def test_a_shorter_step_to_what_is_a_body_is_taken(body, monkeypatch):
    growing = (TangentialGrowth(cortex=1.3),)
    free = run(scene(body, processes=growing, first=0.2, largest=0.2))[0][0]
    limit = 0.75 * np.abs(free.state["displacement"]).max()
    step, _ = next(iter(run(scene(body, Border(limit), processes=growing, first=0.2, largest=0.2))))
    assert step.numbers["step"] == pytest.approx(0.1)


def test_after_a_snap_steps_are_as_long_as_before_it(body, monkeypatch):
    tried = attempts(monkeypatch, lambda time: abs(time - 0.4) < 1e-9)
    steps = run(scene(body, processes=(TangentialGrowth(cortex=1.1),), first=0.1, largest=0.1))
    snapped = [bool(step.numbers["snapped"]) for step, _ in steps]
    assert snapped.count(True) == 1
    assert [one.dt for one in tried if one.time == pytest.approx(0.4)] == pytest.approx(
        [0.1, 0.05, 0.025, 0.0125]
    )
    last = snapped.index(True)
    assert steps[last][1].past == ()  # what led to the snap foretells nothing of what follows
    after = tried[last + 4]
    assert (after.time, after.dt) == (pytest.approx(0.4125), pytest.approx(0.1))


def test_a_step_far_shorter_than_the_latest_snaps_when_it_fails(body, monkeypatch):
    made = scene(body, processes=(TangentialGrowth(cortex=1.1),), first=0.1, largest=0.1)
    _, progress = run(made)[3]
    tried = attempts(monkeypatch, lambda time: True)
    next(march(made, replace(progress, dt=0.02)))
    # an eighth of 0.1 is more than 0.01
    assert [(one.dt, one.snaps) for one in tried] == [(0.02, False), (0.01, True)]


def test_a_tolerance_below_round_off_stops_the_march_at_once(body, monkeypatch):
    tried = attempts(monkeypatch)
    made = scene(body, processes=(TangentialGrowth(cortex=1.3),), tolerance=1e-18)
    with pytest.raises(NotConvergedError, match="round-off keeps the residual at") as caught:
        run(made)
    assert len(tried) == 1
    assert tried[0].minimiser.effort.iterations < 15
    remedy = float(re.search(r"tolerance=([-.e0-9]+)\) or more", str(caught.value)).group(1))
    assert 1e-16 < remedy < 1e-12
    assert run(replace(made, stepping=Stepping(tolerance=remedy)))[-1][0].state.time == 1.0
