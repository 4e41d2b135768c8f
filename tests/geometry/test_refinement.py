"""Bodies on finer meshes: the same geometry, the same names, the same numbers for old nodes."""

import numpy as np
import pytest
from checks import message_names
from small import elastic_scene

from turingfold import Body, half, outline, refined, semicircle, semiellipse, simulate
from turingfold.geometry.mirror import mirror_images

ANGLE = np.linspace(0, 2 * np.pi, 80, endpoint=False)
BODIES = {
    "clamped": semicircle(radius=1.0, thickness=0.25, size=0.2),
    "half, on rollers": half(semiellipse(width=2.0, height=0.6, thickness=0.2, size=0.15, base="roller")),
    "closed": outline(np.stack([1.3 * np.cos(ANGLE), np.sin(ANGLE)]), thickness=0.2, size=0.2),
}


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_refinement_keeps_geometry_names_and_numbers(body):
    finer, n = refined(body, 2), body.nodes.shape[1]
    assert finer.mesh.nelements == 16 * body.mesh.nelements
    assert np.array_equal(finer.nodes[:, :n], body.nodes)
    assert finer.quadrature.weights.sum() == pytest.approx(body.quadrature.weights.sum(), rel=1e-13)
    gray, white = body.in_cortex, ~body.in_cortex
    for kind, fine in ((gray, finer.in_cortex), (white, ~finer.in_cortex)):
        areas = finer.quadrature.weights[:, fine].sum(), body.quadrature.weights[:, kind].sum()
        assert areas[0] == pytest.approx(areas[1], rel=1e-13)
    assert finer.pial_curve.length == pytest.approx(body.pial_curve.length, rel=1e-10)
    assert set(finer.mesh.boundaries) == set(body.mesh.boundaries)
    assert set(body.pial) <= set(finer.pial)
    assert set(body.interface) <= set(finer.interface)
    assert set(body.supported) <= set(finer.supported)
    assert (finer.base, finer.thickness, finer.mirror) == (body.base, body.thickness, body.mirror)
    assert finer.elements_through_cortex == pytest.approx(4 * body.elements_through_cortex, rel=0.02)


def test_new_nodes_lie_on_the_curved_edges():
    body = BODIES["clamped"]
    finer, curve = refined(body), body.pial_curve
    new = np.setdiff1d(finer.pial, body.pial)
    assert len(new) == len(body.pial) - 1
    assert curve.nearest(finer.nodes[:, new])[0].max() < 1e-12
    assert np.abs(np.hypot(*finer.nodes[:, new]) - 1.0).min() > 1e-6  # the edges only approach the circle


def test_a_symmetric_mesh_stays_symmetric():
    assert mirror_images(refined(BODIES["clamped"])) is not None


def test_energies_approach_each_other_fourth_order_in_the_size():
    body = semicircle(radius=1.0, thickness=0.25, size=0.25, base="roller")
    results = [simulate(elastic_scene(body=refined(body, times))) for times in range(4)]
    energies = [result.history[-1]["energy"] for result in results]
    first, second, third = np.abs(np.diff(energies))
    assert 3.0 < np.log2(first / second) < 5.0
    assert 3.0 < np.log2(second / third) < 5.0


@pytest.mark.parametrize("times", [-1, 1.5, True])
def test_numbers_of_refinements_that_are_none_are_refused(times):
    with pytest.raises(ValueError, match="times") as refused:
        refined(BODIES["clamped"], times)
    message_names(refused.value, "times", str(times))


def test_named_parts_of_the_mesh_are_kept():
    body = BODIES["clamped"]
    left = np.flatnonzero(body.mesh.p[0, body.mesh.t].mean(0) < 0)
    named = Body(body.mesh.with_subdomains({"left": left}), body.thickness, body.base)
    finer = refined(named)
    found = np.sort(finer.mesh.subdomains["left"])
    assert np.array_equal(found, np.flatnonzero(finer.mesh.p[0, finer.mesh.t].mean(0) < 0))
