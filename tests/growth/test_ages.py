"""Ages: shares of growth by week, times and back, stops at which a step ends, and results asked by age."""

import numpy as np
import pytest

from turingfold import (
    Days,
    Elastic,
    InadmissibleStateError,
    NeoHookean,
    RateGrowth,
    Scene,
    Stepping,
    StoppedError,
    TangentialGrowth,
    Weeks,
    load,
    semicircle,
    simulate,
)
from turingfold.growth.histories import growth_time

pytestmark = pytest.mark.filterwarnings("ignore::turingfold.CoarseMeshWarning")


def scene(*processes, until=1.0, **stepping):
    body = semicircle(radius=1.0, thickness=0.3, size=0.3)
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    return Scene(body=body, terms=(solid,), processes=processes, until=until, stepping=Stepping(**stepping))


def test_weeks_follow_the_published_curves():
    def wang(w):
        return np.polyval([6.926e-5, -0.00665, 0.250, -3.0189], w)

    def gompertz(w):
        return 0.987 * np.exp(-np.exp(-0.134 * (w - 29.433)))

    assert wang(np.array([22.0, 44.0])) == pytest.approx([0, 1], abs=0.01)  # the range that is accepted
    for curve, share in (("wang", wang), ("gompertz", gompertz)):
        weeks = Weeks(curve=curve, duration=2.0)
        for week in (28, 32, 36, 40):
            expected = 1 + 0.9 * (share(week) - share(28)) / (share(40) - share(28))
            assert weeks.factor(1.9, 2.0 * (week - 28) / 12) == pytest.approx(expected, rel=1e-13)
    assert Weeks(curve="gompertz").factor(2.0, 0.5) > Weeks().factor(2.0, 0.5) + 0.1


def test_ages_and_times_are_inverse_and_labelled():
    weeks, days = Weeks(start=25.0, duration=3.0), Days(duration=0.44)
    assert weeks.times(25, 32, 40) == pytest.approx([0, 1.4, 3])
    assert weeks.label(1.4) == "week 32"
    assert weeks.label(1.5) == "week 32.5"
    for ages, every in ((weeks, (25, 30.3, 40)), (days, (0, 4, 31, 32))):
        assert [ages.age(ages.time(age)) for age in every] == pytest.approx(every)
    assert days.time(8) == growth_time(8, duration=0.44)
    assert days.label(days.time(8)) == "P8"
    assert days.label(0.44 * (1 + 1e-12)) == "P32"
    assert days.factor(2.0, 0.22) == 1.5


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Weeks(start=21.0), "start=21 must be between 22 and 44"),
        (lambda: Weeks(end=45.0), "end=45 must be between 22 and 44"),
        (lambda: Weeks(start=40.0, end=30.0), "start=40 must be an earlier week than end=30"),
        (lambda: Weeks(curve="linear"), "curve='linear'"),
        (lambda: Weeks(duration=0.0), "duration=0"),
        (lambda: Weeks().time(41), "week=41 must be between 28 and 40"),
        (lambda: Days().time(33), "day=33 must be between 0 and 32"),
        (lambda: Days(slowing=-1.0), "slowing=-1"),
        (lambda: RateGrowth(ages=8), "ages=8"),
        (lambda: Stepping(stops=(-0.1, 0.2)), "stops holds -0.1"),
        (lambda: Stepping(stops=(np.nan,)), "stops is nan"),
        (lambda: scene(stops=(0.2, 1.5)), "holds 1.5, after the scene's end until=1"),
    ],
)
def test_what_is_out_of_range_is_refused_by_name(make, message):
    with pytest.raises(ValueError, match=message):
        make()
    with pytest.raises(InadmissibleStateError, match="week 46"):
        Weeks().factor(1.9, 1.5)


def test_a_result_is_asked_by_week_and_day(tmp_path):
    weeks = Weeks()
    stops = weeks.times(30, 32.1, 36)
    growing = scene(TangentialGrowth(cortex=1.05, history=weeks), first=0.2, largest=0.2, stops=stops)
    result = simulate(growing, tmp_path / "out", frames=2)
    stored = load(tmp_path / "out")
    for found in (result, stored):
        for week, stop in zip((30, 32.1, 36), stops, strict=True):
            assert found.at(week=week).time == pytest.approx(stop, rel=1e-14)
        assert found.at(week=28).time == 0.0
        assert found.label() == "week 40"
        assert found.label(found.at(week=32.1)) == "week 32.1"
        with pytest.raises(ValueError, match=r"week=33: time=0.41\d* has no .*exact=False.*Stepping\(stops="):
            found.at(week=33)
        assert found.at(week=33, exact=False).time == pytest.approx(0.3417, abs=0.1)
    with pytest.raises(
        ValueError, match=r"^week=41 must be between 28 and 40; other weeks need [^.]*\.\.\.\)\.$"
    ):
        result.at(week=41)
    with pytest.raises(ValueError, match=r"^week='32' must be a finite number"):
        result.at(week="32")
    with pytest.raises(ValueError, match=r"day=3: no process of the scene has ages in days \(it has: weeks"):
        result.at(day=3)
    with pytest.raises(ValueError, match="one of time, week and day, not 2"):
        result.at(day=3, week=30)
    days = Days(duration=0.4)
    ferret = scene(RateGrowth(rate=0.1, thinning=0.0, ages=days), until=0.4, stops=days.times(4, 8))
    ran = simulate(ferret)
    assert ran.at(day=8).time == pytest.approx(days.time(8), rel=1e-14)
    assert ran.label() == "P32"
    with pytest.raises(ValueError, match="it has: none"):
        simulate(scene(TangentialGrowth(cortex=1.01), first=1.0, largest=1.0)).at(week=30)


def test_steps_go_on_as_long_as_before_a_stop():
    steps = [row["step"] for row in simulate(
        scene(TangentialGrowth(cortex=1.05), first=0.2, largest=0.2, stops=(0.21, 0.5, 0.699))
    ).history]  # fmt: skip
    assert steps == pytest.approx([0.2, 0.01, 0.2, 0.09, 0.199, 0.2, 0.101])


def test_processes_of_different_ages_are_refused():
    two = TangentialGrowth(cortex=1.01, history=Weeks()), TangentialGrowth(cortex=1.01, history=Weeks(end=38))
    with pytest.raises(ValueError, match="different ages"):
        simulate(scene(*two, first=1.0, largest=1.0))


@pytest.mark.parametrize(
    "law",
    [
        TangentialGrowth(cortex=1.05, history=Days(duration=0.5)),
        RateGrowth(rate=0.1, thinning=0.0, ages=Days(duration=0.5)),
    ],
)
def test_a_run_ends_where_its_ages_do(law):
    with pytest.raises(StoppedError, match=r"is after P32.* end the scene by until=0\.5") as failure:
        simulate(scene(law, first=0.1, largest=0.2))
    assert failure.value.result.last.time == pytest.approx(0.5, abs=1e-3)
    assert failure.value.result.label().startswith("P3")  # pictures have their ages
