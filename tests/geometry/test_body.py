"""A body from any triangle mesh: orientation, paths, layers, integration, constraints, refusals."""

import numpy as np
import pytest
from checks import message_names
from hypothesis import given, settings
from hypothesis import strategies as st
from skfem import MeshQuad, MeshTri1, MeshTri2

from turingfold.geometry.body import Body
from turingfold.geometry.curve import Curve
from turingfold.geometry.paths import chains
from turingfold.geometry.shapes import semicircle


def rectangle(nx=6, ny=4, seed=None):
    """Return a 2 x 1 rectangle, its vertices renumbered at random where a seed is given."""
    mesh = MeshTri1.init_tensor(np.linspace(0, 2, nx + 1), np.linspace(0, 1, ny + 1))
    if seed is not None:
        order = np.random.default_rng(seed).permutation(mesh.p.shape[1])
        mesh = MeshTri1(mesh.p[:, order], np.argsort(order)[mesh.t])
    return mesh


def named(mesh):
    return mesh.with_boundaries({"pial": lambda p: p[1] == 1, "base": lambda p: p[1] == 0})


def area_of(points):
    """Signed area of a closed polygon (2, n)."""
    x, y = points
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


@pytest.mark.parametrize("seed", [None, 0, 1, 2])
def test_a_plain_mesh_becomes_a_body(seed):
    body = Body(named(rectangle(seed=seed)), 0.3)
    assert body.quadrature.weights.sum() == pytest.approx(2.0, rel=1e-13)
    # depth, tangent and arc below a flat surface, which runs from right to left
    points = body.quadrature.points
    np.testing.assert_allclose(body.depth, 1 - points[1], atol=1e-14)
    np.testing.assert_allclose(body.tangent[0], -1.0, rtol=1e-14)
    np.testing.assert_allclose(body.tangent[1], 0.0, atol=1e-14)
    np.testing.assert_allclose(body.arc, 2 - points[0], atol=1e-13)
    np.testing.assert_allclose(body.nodes[0, body.pial], np.linspace(2, 0, 13), atol=1e-14)
    # cells are 1/4 high and the cortex 0.3 thick: triangles with their centre above 0.7 are gray
    centres = body.mesh.p[1][body.mesh.t].mean(0)
    assert np.array_equal(body.in_cortex, centres > 0.7)


def test_the_interface_is_where_gray_meets_white():
    body = Body(named(rectangle()), 0.25)
    x, y = body.nodes[:, body.interface]
    np.testing.assert_allclose(y, 0.75, rtol=1e-14)
    np.testing.assert_allclose(x, np.linspace(2, 0, 13), atol=1e-14)
    assert body.interface[0] < body.mesh.nvertices <= body.interface[1]


def test_a_named_cortex_is_taken_as_it_is():
    mesh = named(rectangle())
    own = np.array([0, 3, 5])
    body = Body(mesh.with_subdomains({"cortex": own}), 0.25)
    assert np.array_equal(np.flatnonzero(body.in_cortex), own)


def test_triangles_of_both_orientations_become_positive():
    mesh = rectangle()
    t = mesh.t.copy()
    t[1:, ::3] = t[:0:-1, ::3]
    turned = named(MeshTri1(mesh.p, t, sort_t=False))
    body = Body(turned, 0.3)
    assert body.quadrature.weights.min() > 0
    assert body.quadrature.weights.sum() == pytest.approx(2.0, rel=1e-13)
    assert (body.mesh.mapping().detDF(np.array([[1 / 3], [1 / 3]])) > 0).all()
    np.testing.assert_allclose(body.depth, 1 - body.quadrature.points[1], atol=1e-14)


def test_quadratic_meshes_keep_their_curved_sides():
    flat = named(rectangle(12, 6))
    curved = MeshTri2.from_mesh(flat)
    x, y = curved.doflocs
    points = np.stack([x, y * (1 + 0.2 * np.sin(np.pi * x / 2))])
    body = Body(MeshTri2(points, curved.t, _boundaries=flat.boundaries), 0.3)
    # ∫₀² (1 + 0.2 sin(πx/2)) dx = 2 + 0.8/π
    assert body.quadrature.weights.sum() == pytest.approx(2 + 0.8 / np.pi, rel=1e-6)
    assert body.nodes.shape == curved.doflocs.shape


def test_a_closed_surface_goes_once_around():
    mesh = MeshTri1.init_circle(3)
    body = Body(mesh.with_boundaries({"pial": mesh.boundary_facets()}), 0.25, "free")
    assert body.pial_curve.closed
    assert len(body.pial) == 2 * len(mesh.boundary_facets())
    assert area_of(body.nodes[:, body.pial]) > 0
    assert body.pial_curve.length == pytest.approx(
        np.hypot(*np.diff(body.nodes[:, np.append(body.pial, body.pial[0])])).sum(), rel=1e-12
    )
    assert (np.diff(body.pial_arc) > 0).all()


@pytest.mark.parametrize("base", ["clamped", "roller", "free"])
def test_constraints(base):
    body = Body(named(rectangle()), 0.3, base)
    below = np.flatnonzero(body.nodes[1] == 0)
    along, across = (2 * below).tolist(), (2 * below + 1).tolist()
    expected = {"clamped": {*along, *across}, "roller": set(across), "free": set()}[base]
    assert set(body.supported.tolist()) == expected
    holds = set(body.fixed.tolist()) - expected
    assert len(holds) == {"clamped": 0, "roller": 1, "free": 3}[base]
    # the rigid motions that are left are none: translation in x, in y, and rotation
    x, y = body.nodes
    modes = np.stack([np.stack(m).T.ravel() for m in ((1 + 0 * x, 0 * x), (0 * x, 1 + 0 * x), (-y, x))])
    assert np.linalg.matrix_rank(modes[:, body.fixed]) == 3


def test_rollers_slide_on_a_vertical_line_too():
    mesh = rectangle().with_boundaries({"pial": lambda p: p[0] == 2, "base": lambda p: p[0] == 0})
    body = Body(mesh, 0.3, "roller")
    assert set(body.supported.tolist()) == set((2 * np.flatnonzero(body.nodes[0] == 0)).tolist())


def test_the_cortical_band_is_part_of_the_body():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    band = body.cortex
    assert np.array_equal(band.mesh.doflocs, body.nodes[:, band.nodes])
    assert band.mesh.nelements == body.in_cortex.sum()
    assert set(band.mesh.boundaries) >= {"pial", "interface"}
    assert len(band.mesh.boundaries["pial"]) == (len(body.pial) - 1) // 2
    assert len(band.mesh.boundaries["interface"]) == (len(body.interface) - 1) // 2


def test_band_values_arrive_at_the_integration_points():
    body = semicircle(radius=1.0, thickness=0.2, size=0.1)
    x, y = body.cortex.mesh.doflocs
    found = body.at_quadrature(body.cortex, 1 + x + 2 * y)  # affine, so exact also on curved triangles
    px, py = body.quadrature.points
    gray = body.in_cortex
    np.testing.assert_allclose(found[:, gray], (1 + px + 2 * py)[:, gray], rtol=1e-12)


def test_integration_is_exact_to_degree_four_with_positive_weights():
    body = Body(named(rectangle(2, 1)), 0.8)
    x, y = body.quadrature.points
    weights = body.quadrature.weights
    assert weights.min() > 0
    for i in range(5):
        for j in range(5 - i):
            exact = 2 ** (i + 1) / (i + 1) / (j + 1)
            assert (weights * x**i * y**j).sum() == pytest.approx(exact, rel=1e-12)


def test_shape_functions_reproduce_quadratics():
    body = semicircle(radius=1.0, thickness=0.3, size=0.3)
    q = body.quadrature
    np.testing.assert_allclose(q.shapes.sum(0), 1.0, rtol=1e-13)
    at = np.einsum("iae,aq->iqe", body.nodes[:, body.triangles], q.shapes)
    np.testing.assert_allclose(at, q.points, atol=1e-14)
    # ∂x/∂ξ ∂ξ/∂X = 1
    H = np.einsum("iae,amq->imqe", body.nodes[:, body.triangles], q.derivatives)
    identity = np.einsum("imqe,mkqe->qeik", H, q.inverse)
    assert np.abs(identity - np.eye(2)).max() < 1e-12


# curves


def circle(n, turn=2 * np.pi):
    angle = np.linspace(0, turn, 2 * n + 1)
    points = np.stack([np.cos(angle), np.sin(angle)])
    return Curve(points[:, :-1], True) if turn == 2 * np.pi else Curve(points)


# a quadratic segment over the angle 2δ of the unit circle has r² = 1 - (1 - cos δ)² ξ² (1 - ξ²), so that r is
# up to δ⁴/32 too small, and δ⁴/60 on average; where two segments meet, the tangent is δ³/4 off


@pytest.mark.parametrize("n", [10, 20, 40])
def test_lengths_of_circles(n):
    for turn in (np.pi, 2 * np.pi):
        delta = turn / n / 2
        short = 1 - circle(n, turn).length / turn
        assert short == pytest.approx(delta**4 / 60, rel=0.05)
        assert np.abs(np.diff(circle(n, turn).arc) / delta - 1).max() < 1.1 * delta**4 / 60


@settings(derandomize=True, max_examples=40, deadline=None)
@given(angle=st.floats(0.0, 6.28), radius=st.floats(0.6, 1.5))
def test_nearest_on_a_circle(angle, radius):
    away = np.array([[np.cos(angle)], [np.sin(angle)]])
    delta = np.pi / 40
    distance, tangent, arc = circle(40).nearest(radius * away)
    assert distance[0] == pytest.approx(abs(1 - radius), abs=1.01 * delta**4 / 32)
    # seen from the distance d, the foot moves by d/r of what the normal turns
    turned = 1.1 * delta**3 / 4 * (1 + abs(1 - radius) / radius)
    np.testing.assert_allclose(tangent[:, 0], [-away[1, 0], away[0, 0]], atol=turned)
    moved = (arc[0] - angle + np.pi) % (2 * np.pi) - np.pi
    # along a segment the angle is δ ξ - δ³/6 (ξ - ξ³), the arc length is interpolated as δ ξ
    slack = delta**3 / 6 * 0.385 + delta**4 * 2 * np.pi / 60
    assert moved == pytest.approx(0.0, abs=abs(1 - radius) * turned + 1.1 * slack)


@settings(derandomize=True, max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_nearest_is_no_farther_than_any_sampled_point(seed):
    rng = np.random.default_rng(seed)
    x = np.linspace(0, 4, 41)
    wave = 0.2 * np.sin(2 * x + rng.uniform(0, 6))
    curve = Curve(np.stack([x, wave]))
    points = np.stack([rng.uniform(-0.2, 4.2, 20), rng.uniform(-0.6, 0.6, 20)])
    distance = curve.nearest(points)[0]
    xi = np.linspace(-1, 1, 41)
    start, mid, end = curve.segments
    half, bend = 0.5 * (end - start), 0.5 * (start - 2 * mid + end)
    sampled = mid[:, :, None] + half[:, :, None] * xi + bend[:, :, None] * xi**2
    gaps = np.hypot(*(points[:, :, None] - sampled.reshape(2, 1, -1))).min(1)
    assert (distance <= gaps + 1e-12).all()
    assert (distance >= gaps - 0.01).all()


def test_edges_chain_in_any_order_and_part_by_part():
    order = np.random.default_rng(0).permutation(9)
    line, ring = np.stack([np.arange(9), np.arange(1, 10)]), np.stack([np.arange(9), (np.arange(9) + 1) % 9])
    ((path, closed),) = chains(line[:, order], "a line")
    assert not closed
    assert path.tolist() in (list(range(10)), list(range(9, -1, -1)))
    ((path, closed),) = chains(ring[:, order], "a ring")
    assert closed
    assert sorted(path.tolist()) == list(range(9))
    assert set(np.abs(np.diff(path)).tolist()) <= {1, 8}
    both = np.concatenate([ring, 20 + line], axis=1)[:, np.random.default_rng(1).permutation(18)]
    found = {closed: sorted(path.tolist()) for path, closed in chains(both, "both")}
    assert found == {True: list(range(9)), False: list(range(20, 30))}


def test_edges_that_branch_are_refused():
    with pytest.raises(ValueError, match="the edges of boundary 'pial' branch at 1 vertices"):
        chains(np.array([[0, 1, 1], [1, 2, 3]]), "boundary 'pial'")


def test_a_surface_or_interface_in_two_parts_is_known_by_its_parts():
    mesh = MeshTri1.init_tensor(np.linspace(0, 1, 5), np.linspace(0, 1, 5))
    sides = {"pial": lambda p: (p[0] == 0) | (p[0] == 1), "base": lambda p: p[1] == 0}
    gray = {"cortex": lambda p: (p[0] < 0.25) | (p[0] > 0.75)}
    body = Body(mesh.with_boundaries(sides).with_subdomains(gray), 0.25)
    for paths, x in ((body.pial_paths, (0, 1)), (body.interface_paths, (0.25, 0.75))):
        assert sorted(float(body.nodes[0, path.nodes].mean()) for path in paths) == pytest.approx(x)
        for path in paths:  # tissue, or white matter, on the left
            up = np.diff(body.nodes[1, path.nodes])
            assert (np.sign(up) == (1 if body.nodes[0, path.nodes[0]] > 0.5 else -1)).all()
    for name, plural in (
        ("pial", "pial_paths"),
        ("pial_curve", "pial_paths"),
        ("interface", "interface_paths"),
    ):
        with pytest.raises(ValueError, match=rf"has 2 parts, and one is needed here.*{plural}"):
            getattr(body, name)
    x = body.quadrature.points[0]
    assert body.depth == pytest.approx(np.minimum(x, 1 - x), abs=1e-12)
    assert body.pial_curves.length == pytest.approx(2.0)


def test_every_part_of_a_body_is_held_by_itself():
    one, other = (
        MeshTri1.init_circle(2, smoothed=True).scaled(r).translated((x, 0.0))
        for r, x in ((1.0, 0.0), (2.0, 4.0))
    )
    mesh = one + other
    body = Body(mesh.with_boundaries({"pial": mesh.boundary_facets()}), 0.5, "free")
    assert len(body.pial_paths) == 2
    assert body.pial_paths[0].nodes.shape == body.pial_paths[1].nodes.shape
    assert np.ptp(body.nodes[0, body.pial_paths[0].nodes]) == pytest.approx(4.0)  # the longest first
    x, y = body.nodes
    left = x < 1.5
    modes = [
        np.stack(m).T.ravel()
        for k in (left, ~left)
        for m in ((1.0 * k, 0 * x), (0 * x, 1.0 * k), (-y * k, x * k))
    ]
    assert len(body.fixed) == 6
    assert np.linalg.matrix_rank(np.stack(modes)[:, body.fixed]) == 6


@pytest.mark.parametrize("hole", ["free", "clamped"])
def test_the_wall_of_a_hole_is_held_where_it_is_clamped(hole):
    angles, radii = np.linspace(0, 2 * np.pi, 25), np.linspace(0.4, 1.0, 5)
    grid = MeshTri1.init_tensor(radii, angles[:-1])
    p = np.stack([grid.p[0] * np.cos(grid.p[1]), grid.p[0] * np.sin(grid.p[1])])
    n, m = len(radii), len(angles) - 1
    index = np.array(
        [[np.argmin(np.hypot(grid.p[0] - r, grid.p[1] - a)) for r in radii] for a in angles[:-1]]
    )
    around = np.roll(index, -1, axis=0)
    quads = [
        (index[j, i], index[j, i + 1], around[j, i + 1], around[j, i]) for j in range(m) for i in range(n - 1)
    ]
    t = np.array([tri for a, b, c, d in quads for tri in ((a, b, c), (a, c, d))]).T
    mesh = MeshTri1(p, t).with_boundaries(
        {"pial": lambda q: np.hypot(*q) > 0.95, "hole": lambda q: np.hypot(*q) < 0.45}
    )
    body = Body(mesh, 0.2, "free", hole=hole)
    wall = np.flatnonzero(np.hypot(*body.nodes) < 0.41)
    held = set(np.concatenate([2 * wall, 2 * wall + 1]).tolist()) if hole == "clamped" else set()
    assert set(body.supported.tolist()) == held
    assert len(body.fixed) == (len(held) or 3)
    (inner,) = body.boundary_paths("hole")
    assert area_of(body.nodes[:, inner.nodes]) < 0  # tissue on the left: clockwise around the hole


def test_between_two_surfaces_depth_is_a_share_of_the_way():
    # pial y = 1, interface y = 0.4 + 0.2 x: where these are straight the distances are known
    mesh = MeshTri1.init_tensor(np.linspace(0, 2, 41), np.linspace(0, 1, 21))
    p = mesh.p.copy()
    white = 0.4 + 0.2 * p[0]
    p[1] = np.where(p[1] >= 0.5, 1 - (1 - p[1]) / 0.5 * (1 - white), p[1] / 0.5 * white)
    sides = {"pial": lambda q: q[1] == 1, "base": lambda q: q[1] == 0}
    mesh = MeshTri1(p, mesh.t).with_boundaries(sides)
    gray = {"cortex": lambda q: q[1] > 0.4 + 0.2 * q[0]}
    body = Body(mesh.with_subdomains(gray), 0.4, depth_by="interface")
    x, y = body.quadrature.points
    signed = (y - 0.4 - 0.2 * x) / np.hypot(1, 0.2)
    inner = (x > 0.3) & (x < 1.7) & (y > 0.3)
    assert body.relative_depth[inner] == pytest.approx(((1 - y) / (1 - y + signed))[inner], rel=1e-9)
    plain = Body(mesh.with_subdomains(gray), 0.4)
    assert plain.relative_depth == pytest.approx(plain.depth / 0.4)


# what is refused


@pytest.mark.parametrize("bad", [0.0, -0.1, float("nan"), float("inf"), "thin"])
def test_thickness_must_be_positive(bad):
    with pytest.raises(ValueError, match="thickness"):
        Body(named(rectangle()), bad)


def test_meshes_of_other_cells_are_refused():
    with pytest.raises(ValueError, match="MeshQuad"):
        Body(MeshQuad.init_tensor(np.linspace(0, 1, 3), np.linspace(0, 1, 3)), 0.3)
    with pytest.raises(ValueError, match="mesh"):
        Body("mesh.msh", 0.3)


def test_unknown_bases_are_refused():
    with pytest.raises(ValueError, match="base") as failure:
        Body(named(rectangle()), 0.3, "glued")
    message_names(failure.value, "clamped", "roller", "free")


def test_missing_boundaries_are_named():
    with pytest.raises(ValueError, match="pial") as failure:
        Body(rectangle(), 0.3)
    message_names(failure.value, "none", "with_boundaries")
    only = rectangle().with_boundaries({"pial": lambda p: p[1] == 1})
    with pytest.raises(ValueError, match="base") as failure:
        Body(only, 0.3)
    message_names(failure.value, "pial")
    assert Body(only, 0.3, "free").supported.size == 0


def test_coordinates_must_be_finite():
    mesh = named(rectangle())
    p = mesh.p.copy()
    p[0, 4] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        Body(MeshTri1(p, mesh.t, _boundaries=mesh.boundaries, validate=False), 0.3)


def test_degenerate_triangles_are_refused():
    p = np.array([[0.0, 1.0, 2.0, 1.0], [0.0, 0.0, 0.0, 1.0]])
    mesh = MeshTri1(p, np.array([[0, 0, 1], [1, 1, 2], [2, 3, 3]]), validate=False)
    with pytest.raises(ValueError, match="degenerate") as failure:
        Body(mesh.with_boundaries({"pial": np.array([0])}), 0.1, "free")
    message_names(failure.value, "triangle 0", "area")


def test_triangles_that_fold_over_themselves_are_refused():
    flat = named(rectangle())
    curved = MeshTri2.from_mesh(flat)
    points = curved.doflocs.copy()
    facet = int(flat.boundaries["pial"][0])
    points[1, flat.nvertices + facet] -= 0.2  # the middle of a surface edge, near the opposite corner
    with pytest.raises(ValueError, match="folds over") as failure:
        Body(MeshTri2(points, curved.t, _boundaries=flat.boundaries), 0.3)
    message_names(failure.value, "triangle", "Jacobian", "middles")


def test_rollers_need_a_straight_base():
    mesh = rectangle()
    p = mesh.p.copy()
    p[1] += 0.1 * np.sin(3 * p[0]) * (1 - p[1])
    named_before = named(mesh)
    slanted = MeshTri1(p, mesh.t, _boundaries=named_before.boundaries)
    with pytest.raises(ValueError, match="base") as failure:
        Body(slanted, 0.3, "roller")
    message_names(failure.value, "horizontal or vertical", "clamped")


def test_a_cortex_thinner_than_the_elements_is_refused():
    with pytest.raises(ValueError, match="thickness") as failure:
        Body(named(rectangle(2, 1)), 0.1)
    message_names(failure.value, "no gray matter", "smaller elements")


def test_a_body_without_white_matter_has_no_interface():
    body = Body(named(rectangle()), 5.0)
    with pytest.raises(ValueError, match="thickness") as failure:
        _ = body.interface
    message_names(failure.value, "no white matter")


@pytest.mark.parametrize("layers", [1, 2, 5])
def test_elements_through_the_cortex_are_counted(layers):
    body = semicircle(radius=1.0, thickness=0.2, size=0.2 / layers)
    assert body.elements_through_cortex == pytest.approx(layers, rel=1e-6)
