"""The inner wall of a ring as pial surface: the body lies outside, and signs follow from that."""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from skfem import MeshTri1, MeshTri2
from small import GRAY

from turingfold import (
    Body,
    Elastic,
    InnerWall,
    Scene,
    State,
    Stepping,
    TangentialGrowth,
    cortical_thickness,
    find_folds,
    fold_count,
    gyrification_index,
    shape_index,
    signed_curvature,
    similarity,
    simulate,
)
from turingfold.morphometry.polyline import as_polyline, signed_distance
from turingfold.results.measures import fold_numbers
from turingfold.results.surface import along_pial

INNER, OUTER, AROUND = 0.01, 0.02, 96


def ring(pial, *, half=False):
    """Return a ring, or its upper half, with its inner or outer wall as pial surface."""
    angles = np.linspace(0, np.pi if half else 2 * np.pi, AROUND + 1)
    radii = np.linspace(INNER, OUTER, 7)
    r, t = np.meshgrid(radii, angles, indexing="ij")
    number = np.arange(r.size).reshape(r.shape)
    if not half:
        number[:, -1] = number[:, 0]
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    t3 = np.hstack([np.stack([a, b, c]).reshape(3, -1), np.stack([a, c, d]).reshape(3, -1)])
    used, local = np.unique(t3, return_inverse=True)
    points = np.stack([r * np.cos(t), r * np.sin(t)]).reshape(2, -1)[:, used]
    mesh = MeshTri2.from_mesh(MeshTri1(points, local.reshape(3, -1)))

    def wall(radius):
        return lambda x: np.abs(np.hypot(*x) - radius) < 1e-3 * radius

    walls = {"inner": wall(INNER), "outer": wall(OUTER)}
    base = (lambda x: x[1] < 1e-9) if half else walls["outer" if pial == "inner" else "inner"]
    mesh = mesh.with_boundaries({"pial": walls[pial], "base": base})
    return Body(mesh, thickness=0.003)


def folded(body, *, height, waves=8):
    """Return a state whose pial surface bulges into the open by height·cos(waves·θ), and that pattern."""
    x, y = body.nodes
    angle, r = np.arctan2(y, x), np.hypot(x, y)
    away = -1.0 if np.abs(r[body.pial] - INNER).max() < 1e-4 else 1.0
    wave = np.cos(waves * angle)
    fade = np.exp(-np.abs(r - r[body.pial].mean()) / 0.002)
    move = away * height * wave * fade * body.nodes / r
    return State(1.0, {"displacement": move, "pattern": 0.5 + 0.5 * wave[body.cortex.nodes]})


@pytest.mark.parametrize("half", [False, True])
def test_curvature_is_that_seen_from_the_body(half):
    for pial, expected in (("inner", -1 / INNER), ("outer", 1 / OUTER)):
        body = ring(pial, half=half)
        points = along_pial(body, body.nodes[:, body.pial])[:, ::2]  # the edges of this mesh are straight
        # the body is on the left
        x, y = points
        turns = np.sign(np.sum(x[:-1] * y[1:] - y[:-1] * x[1:]))
        assert turns == (-1 if pial == "inner" else 1)
        assert isinstance(points, InnerWall) == (pial == "inner")
        np.testing.assert_allclose(signed_curvature(points, closed=not half)[1:-1], expected, rtol=0.02)
        assert np.sign(shape_index(points, 0.003, closed=not half)).mean() == np.sign(expected)


@pytest.mark.parametrize("pial", ["inner", "outer"])
def test_gyri_stand_on_the_peaks_that_bulge_into_the_open(pial):
    body = ring(pial)
    for height, sign in ((0.001, 1.0), (-0.001, -1.0)):
        state = folded(body, height=height)
        numbers = fold_numbers(body, state)
        assert numbers["registration"] == pytest.approx(sign, abs=0.01)
        assert numbers["folds"] == 8
        rest, points = (along_pial(body, (body.nodes + u)[:, body.pial]) for u in (0, state["displacement"]))
        folds = find_folds(points, closed=True, reference=rest)
        assert folds.depth == pytest.approx(0.002, rel=0.01)
        r = np.hypot(*np.asarray(points))
        into_the_open = -r if pial == "inner" else r
        assert into_the_open[folds.gyri].min() > into_the_open[folds.sulci].max() + 0.0015
        assert (signed_curvature(points, closed=True)[folds.gyri] > 0).all()
        assert (signed_curvature(points, closed=True)[folds.sulci] < 0).all()


def test_distances_out_of_the_body_are_positive_whichever_side_it_is_on():
    body = ring("inner")
    wall = as_polyline(along_pial(body, body.nodes[:, body.pial]), True)
    places = np.array([[0.0, 0.015, 0.0], [0.005, 0.0, -0.012]])
    np.testing.assert_allclose(signed_distance(places, wall), [0.005, -0.005, -0.002], atol=1e-5)
    plain = as_polyline(np.asarray(wall.points), True)
    np.testing.assert_allclose(signed_distance(places, plain), [-0.005, 0.005, 0.002], atol=1e-5)


def test_measures_that_know_no_side_are_the_same():
    body = ring("inner")
    state = folded(body, height=0.001)
    points = along_pial(body, (body.nodes + state["displacement"])[:, body.pial])
    plain = np.asarray(points)
    assert gyrification_index(points) == gyrification_index(plain)
    assert similarity(points, points) == pytest.approx(1.0)
    inside = np.asarray(along_pial(body, body.nodes[:, body.interface]))
    np.testing.assert_allclose(
        cortical_thickness(points, inside).all, cortical_thickness(plain, inside).all, rtol=1e-12
    )
    with pytest.raises(ValueError, match="points are an InnerWall"):
        gyrification_index(points, closing=0.005)


def test_an_inner_wall_grows():
    body = ring("inner")
    grow = TangentialGrowth(cortex=1.2)
    scene = Scene(
        body=body, terms=(Elastic(gray=GRAY),), processes=(grow,),
        stepping=Stepping(first=0.25, largest=0.25),
    )  # fmt: skip
    result = simulate(scene)
    assert result.converged
    rest = result.pial(0)
    moved = np.hypot(*np.asarray(result.pial())) - np.hypot(*np.asarray(rest))
    assert moved.max() < 0  # the cortex finds room in the hole only
    assert fold_count(result.pial(), closed=True) == 0


def test_two_inner_walls_fold_as_each_alone():
    """Two rings beside each other whose pial surfaces are their inner walls."""
    one = ring("inner")
    state = folded(one, height=0.001)
    apart = np.array([[0.05], [0.0]])
    straight = one.mesh.p.shape[1]
    mesh = MeshTri2.from_mesh(
        MeshTri1(np.hstack([one.mesh.p, one.mesh.p + apart]), np.hstack([one.mesh.t, one.mesh.t + straight]))
    )

    def both(radius):
        return lambda x: np.abs(np.hypot(x[0] - 0.05 * (x[0] > 0.025), x[1]) - radius) < 1e-3 * radius

    two = Body(mesh.with_boundaries({"pial": both(INNER), "base": both(OUTER)}), thickness=0.003)
    _, place = cKDTree(one.nodes.T).query((two.nodes - apart * (two.nodes[0] > 0.025)).T)
    moved = State(1.0, {"displacement": state["displacement"][:, place]})
    alone, together = fold_numbers(one, state), fold_numbers(two, moved)
    assert together["folds"] == 2 * alone["folds"] == 16
    for name in ("sulcal_depth", "gyrification_index", "least_fold_depth", "self_intersections"):
        assert together[name] == pytest.approx(alone[name], rel=1e-9)
