"""Bodies in several parts: what works on all of them, and what refuses them by name."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from turingfold import (
    AxonalTension,
    Drag,
    Elastic,
    HoldingForceWarning,
    NeoHookean,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    figures,
    load,
    outline,
    simulate,
)
from turingfold.geometry.body import by_node
from turingfold.growth.imperfection import Imperfection
from turingfold.growth.zones import Window
from turingfold.parts import TimeStep
from turingfold.results.codec import decode
from turingfold.results.document import stored
from turingfold.results.holding import warn_of_holding

AT = 2 * np.pi * np.arange(120) / 120
CIRCLE = np.stack([np.cos(AT), np.sin(AT)])
SHIFT = np.array([[2.05], [0.0]])


@pytest.fixture(scope="module")
def pair():
    """Two discs, 0.05 apart."""
    return outline([CIRCLE, CIRCLE + SHIFT], thickness=0.2, size=0.1)


def scene(body, growth, *terms, first=0.1):
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    processes = (TangentialGrowth(cortex=growth),)
    steps = Stepping(first=first, largest=max(first, 0.25))
    return Scene(body=body, terms=(solid, *terms), processes=processes, stepping=steps)


def test_parts_that_do_not_meet_grow_as_each_by_itself(pair):
    alone = simulate(scene(outline(CIRCLE, thickness=0.2, size=0.1), 1.05))
    both = simulate(scene(pair, 1.05))
    area = alone.summary()["area_growth"]
    assert both.summary()["area_growth"] == pytest.approx(area, rel=1e-4)
    left, right = both.pial_parts()
    assert np.ptp(left[0]) == pytest.approx(np.ptp(alone.pial()[0]), rel=1e-3)
    assert np.ptp(right[1]) == pytest.approx(np.ptp(left[1]), rel=1e-3)


def test_parts_that_grow_into_each_other_touch_and_do_not_cross(pair, tmp_path):
    with pytest.warns(HoldingForceWarning):
        result = simulate(scene(pair, 1.25, SelfContact()), out=tmp_path / "pair")
    summary = result.summary()
    assert summary["converged"]
    assert summary["self_intersections"] == summary["inverted_elements"] == 0
    free = simulate(scene(pair, 1.25)).summary()
    assert free["self_intersections"] > 0  # without contact they pass through each other
    again = load(tmp_path / "pair")
    assert again.scene.body.changes == pair.changes
    assert again.summary()["folds"] == summary["folds"]
    import matplotlib.pyplot as plt

    axes = plt.figure().add_subplot()
    figures.section(axes, result)
    figures.outline(axes, pair)
    assert len(axes.lines) >= 6


def test_what_holds_parts_in_place_carries_what_others_push_with(pair):
    begun = scene(pair, 1.25, SelfContact())
    with pytest.warns(HoldingForceWarning, match=r"with Drag\(coefficient=\.\.\.\), small beside"):
        result = simulate(begun)
    contact = begun.terms[1].on(pair).during(result.last, TimeStep(1.0, over=True))
    pushed = contact.evaluate(by_node(result.last["displacement"])).gradient()[0].reshape(-1, 2)
    left = pair.nodes[0] < 1.025
    free = [row["holding_force"] for row in result.history if np.isnan(row["min_gap"])]
    assert max(free) < 1e-6 < 1e-2 < result.history[-1]["holding_force"]
    # each part is held at one node near its middle, and at another against rotation: no sum, no moment
    x, y = pair.nodes + result.last["displacement"]
    carried = []
    for part in (left, ~left):
        held = [dof for dof in pair.fixed.tolist() if part[dof // 2]]
        motions = np.array([[1 - d % 2, d % 2, x[d // 2] if d % 2 else -y[d // 2]] for d in held]).T
        fx, fy = pushed[part].T
        carried += np.linalg.solve(
            motions, [fx.sum(), fy.sum(), (x[part] * fy - y[part] * fx).sum()]
        ).tolist()
    assert result.history[-1]["holding_force"] == pytest.approx(np.abs(carried).max(), rel=1e-5)
    dragged = simulate(replace(begun, terms=(*begun.terms, Drag(coefficient=1e-4))))
    assert dragged.summary()["holding_force"] is None
    moved = [dragged.last["displacement"][0, part].mean() for part in (left, ~left)]
    assert moved[0] < -0.01 < 0.01 < moved[1]


@pytest.mark.parametrize(("before", "told"), [((np.nan, 0.5), 0), ((0.5, np.nan), 0), ((np.nan,), 1)])
def test_a_holding_force_is_told_once_though_a_row_before_has_none(pair, before, told):
    """As of a run that went on, of which a cell was empty; 0.5 N/m are 2.5 of the shear modulus times T."""
    rows = [{"holding_force": force} for force in before]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warn_of_holding(scene(pair, 1.25), rows, 0.6)
    assert len(caught) == told


def test_a_stiff_cortex_hides_no_force_that_holds_a_soft_core():
    """The parts would move by a sixth farther apart if nothing held them, as a run with little drag shows."""
    loops = [1e-2 * (CIRCLE + np.array([[side], [0.0]])) for side in (-1.02, 1.02)]
    apart = outline(loops, thickness=1.5e-3, elements=2)
    layers = Elastic(gray=NeoHookean.from_young(1e6, 0.45), white=NeoHookean.from_young(1e3, 0.45))
    grow = TangentialGrowth(cortex=1.05)
    begun = Scene(body=apart, processes=(grow,), terms=(layers, SelfContact(gap=0.4)))
    with pytest.warns(HoldingForceWarning, match="of the least shear modulus"):
        held = simulate(begun)
    free = simulate(replace(begun, terms=(*begun.terms, Drag(coefficient=1e4))))
    right = apart.nodes[0] > 0
    moved = [r.last["displacement"][0] for r in (held, free)]
    gaps = [x[right].mean() - x[~right].mean() for x in moved]
    assert gaps[1] > 1.1 * gaps[0] > 0


def test_the_gyrification_index_of_circles_is_one(pair):
    still = simulate(scene(pair, 1.0 + 1e-6, first=1.0))
    assert still.summary()["gyrification_index"] == pytest.approx(1.0, abs=1e-3)
    with pytest.warns(UserWarning, match="lies inside another"):
        ring = outline([CIRCLE, 0.4 * CIRCLE], thickness=0.1, size=0.1)
    summary = simulate(scene(ring, 1.0 + 1e-6, first=1.0)).summary()
    assert summary["gyrification_index"] == pytest.approx(1.4, abs=2e-3)  # a closed-off sulcus counts


def test_what_goes_along_one_surface_refuses_several_by_name(pair):
    with pytest.raises(ValueError, match="gray-white interface has 2 parts"):
        AxonalTension(strength=1.0, patches=4).on(pair)
    with pytest.raises(ValueError, match="pial surface has 2 parts"):
        Imperfection(amplitude=0.1).on(pair).start(None, 0)
    with pytest.raises(ValueError, match="pial surface has 2 parts"):
        Window(start=0.1, end=0.3, edge=0.05).share(pair)
    result = simulate(scene(pair, 1.01, first=1.0))
    with pytest.raises(ValueError, match="pial surface has 2 parts"):
        result.pial()


def test_results_without_the_later_numbers_of_changes_can_be_read():
    """scene.json of before 2026-11-29 has no moved_at_walls, thickened and filled."""
    at = 2 * np.pi * np.arange(100) / 100
    body = outline(np.stack([np.cos(at), np.sin(at)]), thickness=0.2, size=0.1)
    document, arrays = stored(Scene(body=body, terms=(Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),)))
    told = document["scene"]["body"]["changes"]
    for name in ("moved_at_walls", "thickened", "filled"):
        del told[name]
    changes = decode(document["scene"], arrays).body.changes
    assert changes.filled is None
    assert str(changes).startswith("pial surface moved by at most")
