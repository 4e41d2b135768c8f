"""Semi-circle and semi-ellipse: area, thickness, layers on edges, symmetry, triangles, bad input."""

import re

import numpy as np
import pytest
from checks import message_names
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from skfem import MeshTri1

from turingfold import memory
from turingfold.geometry.body import Body
from turingfold.geometry.mirror import half
from turingfold.geometry.shapes import semicircle, semiellipse
from turingfold.outlines import outline

SHAPES = {
    "document 1": {"width": 0.0808, "height": 0.0404, "thickness": 2.5e-3, "size": 1.25e-3},
    "thick": {"width": 2.0, "height": 1.0, "thickness": 0.2, "size": 0.1},
    "flat": {"width": 2.0, "height": 0.74, "thickness": 0.1, "size": 0.05},
    "tall": {"width": 1.6, "height": 1.1, "thickness": 0.08, "size": 0.04},
}


@pytest.fixture(scope="module", params=SHAPES)
def shape(request):
    options = SHAPES[request.param]
    return options, semiellipse(**options)


def ellipse_depth(point, a, b):
    """Distance of a point inside a half ellipse to its curve, at the root of (x - c(φ))·c'(φ)."""
    x, y = abs(point[0]), point[1]

    def along(phi):
        return -(x - a * np.cos(phi)) * a * np.sin(phi) + (y - b * np.sin(phi)) * b * np.cos(phi)

    at = [0.0, np.pi / 2]
    if along(0.0) * along(np.pi / 2) < 0:
        at.append(brentq(along, 0.0, np.pi / 2, xtol=1e-15))
    return min(np.hypot(x - a * np.cos(phi), y - b * np.sin(phi)) for phi in at)


def test_area_is_right_to_order_four():
    shape = {"width": 2.0, "height": 0.74, "thickness": 0.2}
    areas = [semiellipse(**shape, size=0.2 / n).quadrature.weights.sum() for n in (1, 2, 4)]
    errors = np.abs(np.array(areas) / (np.pi / 2 * 0.74) - 1)
    assert errors[0] < 1e-5
    assert (np.log2(errors[:-1] / errors[1:]) > 3.7).all()


def test_the_cortex_is_equally_thick_everywhere(shape):
    options, body = shape
    a, b = options["width"] / 2, options["height"]
    outer = body.nodes[:, body.pial]
    np.testing.assert_allclose((outer[0] / a) ** 2 + (outer[1] / b) ** 2, 1.0, rtol=1e-12)
    depths = [ellipse_depth(p, a, b) for p in body.nodes[:, body.interface].T]
    np.testing.assert_allclose(depths, options["thickness"], rtol=1e-8)


def test_depth_at_the_integration_points_is_the_distance(shape):
    options, body = shape
    gray = body.in_cortex
    points = body.quadrature.points[:, :, gray].reshape(2, -1)[:, ::7]
    exact = [ellipse_depth(p, options["width"] / 2, options["height"]) for p in points.T]
    found = body.depth[:, gray].ravel()[::7]
    # the quadratic edges leave the ellipse by O(size⁴)
    bound = 2e-3 * options["thickness"] * (options["size"] / options["thickness"]) ** 4
    assert np.abs(found - exact).max() < bound


def test_layers_meet_on_edges(shape):
    options, body = shape
    depth, gray = body.depth, body.in_cortex
    assert depth[:, gray].max() < options["thickness"]
    assert depth[:, ~gray].min() > 0.995 * options["thickness"]  # straight inner sides cut off a sliver
    # the cortical band has the area between the ellipse and its offset curve: T L - T²/2 ∫dφ = T L - π T²/2
    length = body.pial_curve.length
    expected = options["thickness"] * length - np.pi / 2 * options["thickness"] ** 2
    assert body.quadrature.weights[:, gray].sum() == pytest.approx(expected, rel=1e-6)


def test_tangents_are_those_of_the_ellipse(shape):
    options, body = shape
    gray = body.in_cortex
    outer = np.zeros_like(body.quadrature.weights, dtype=bool)
    outer[:, gray] = True
    foot = body.quadrature.points[:, outer] + body.depth[outer] * np.stack(
        [body.tangent[1][outer], -body.tangent[0][outer]]
    )
    a, b = options["width"] / 2, options["height"]
    assert np.abs((foot[0] / a) ** 2 + (foot[1] / b) ** 2 - 1).max() < 1e-4
    np.testing.assert_allclose(np.hypot(*body.tangent[:, outer]), 1.0, rtol=1e-13)
    normal = np.stack([foot[0] / a**2, foot[1] / b**2])
    across = (normal * body.tangent[:, outer]).sum(0) / np.hypot(*normal)
    assert np.abs(across).max() < 2e-3  # δ³/4 for edges of angle 2δ, sharper where the ellipse is


def test_all_triangles_are_positive_and_well_shaped(shape):
    _, body = shape
    assert body.quadrature.weights.min() > 0
    corners = body.mesh.p[:, body.mesh.t]
    sides = [corners[:, (k + 1) % 3] - corners[:, k] for k in range(3)]
    angles = [
        np.degrees(np.arccos(-(one * other).sum(0) / (np.hypot(*one) * np.hypot(*other))))
        for one, other in zip(sides, sides[1:] + sides[:1], strict=True)
    ]
    np.testing.assert_allclose(sum(angles), 180.0, rtol=1e-10)
    assert np.min(angles) > 15
    assert np.max(angles) < 140


def test_the_mesh_is_its_own_mirror_image(shape):
    _, body = shape
    x, y = body.nodes[:, : body.mesh.nvertices]
    unit = 1e-12 * body.length
    order = np.lexsort((np.round(y, 12), np.round(x, 12)))
    mirrored = np.lexsort((np.round(y, 12), np.round(-x, 12)))
    image = np.empty(len(x), dtype=int)
    image[order] = mirrored
    np.testing.assert_allclose(x[image], -x, atol=unit)
    np.testing.assert_allclose(y[image], y, atol=unit)
    triangles = {frozenset(t) for t in body.mesh.t.T.tolist()}
    assert {frozenset(image[list(t)].tolist()) for t in triangles} == triangles


def test_surface_and_interface_are_mirror_images_to_the_last_bit(shape):
    _, body = shape
    for nodes in (body.pial[1::2], body.interface[1::2]):
        x, y = body.nodes[:, nodes]
        assert np.array_equal(x, -x[::-1])
        assert np.array_equal(y, y[::-1])


def test_the_surface_runs_counter_clockwise_from_base_to_base(shape):
    options, body = shape
    x, y = body.nodes[:, body.pial]
    assert (x[0], y[0]) == (options["width"] / 2, 0.0)
    assert (x[-1], y[-1]) == (-options["width"] / 2, 0.0)
    assert (np.diff(np.arctan2(y, x)) > 0).all()
    base = body.nodes[:, body.boundary_path("base")[0]]
    assert not base[1].any()
    assert (np.diff(base[0]) > 0).all()
    assert (np.diff(body.nodes[0, body.interface]) < 0).all()


def test_arc_length_of_the_circle():
    body = semicircle(radius=2.0, thickness=0.3, size=0.1)
    np.testing.assert_allclose(body.pial_arc, 2.0 * np.linspace(0, np.pi, len(body.pial)), atol=1e-6)


def test_size_and_coarsening_do_what_they_say():
    fine = semicircle(radius=1.0, thickness=0.1, size=0.025)
    edges = np.diff(fine.pial_arc[::2])
    np.testing.assert_allclose(edges, 0.025, rtol=0.02)
    depth = np.unique(np.round(1 - np.hypot(*fine.nodes[:, : fine.mesh.nvertices]), 9))
    np.testing.assert_allclose(depth[:5], [0, 0.025, 0.05, 0.075, 0.1], atol=1e-9)
    even = semicircle(radius=1.0, thickness=0.1, size=0.025, coarsening=1.0)
    coarse = semicircle(radius=1.0, thickness=0.1, size=0.025, coarsening=2.0)
    assert coarse.mesh.nelements < fine.mesh.nelements < even.mesh.nelements
    # without coarsening, elements are of the cortex's size to the middle
    assert even.mesh.nelements == pytest.approx(np.pi / 2 / (0.025**2 / 2), rel=0.15)


def test_slender_elements_are_shorter_along_the_cortex_and_nowhere_else():
    even, slender = (semicircle(radius=1.0, thickness=0.1, size=0.025, along=n) for n in (1.0, 2.0))
    assert np.diff(slender.pial_arc[::2]) == pytest.approx(0.0125, rel=0.02)
    assert slender.elements_through_cortex == pytest.approx(even.elements_through_cortex, rel=1e-3)
    gray = [body.in_cortex.sum() for body in (even, slender)]
    white = [(~body.in_cortex).sum() for body in (even, slender)]
    assert gray[1] == pytest.approx(2 * gray[0], rel=0.02)
    assert white[0] <= white[1] < 1.3 * white[0]


@settings(derandomize=True, max_examples=15, deadline=None)
@given(height=st.floats(0.6, 1.6), share=st.floats(0.05, 0.45), per=st.integers(1, 3))
def test_any_proportions_make_a_body(height, share, per):
    limit = min(0.5 * min(1.0, height), min(1 / height, height**2))
    thickness = share * limit
    body = semiellipse(width=2.0, height=height, thickness=thickness, size=thickness / per)
    assert body.quadrature.weights.sum() == pytest.approx(np.pi / 2 * height, rel=1e-4)
    assert body.in_cortex.any()
    assert not body.in_cortex.all()


def test_half_is_one_half():
    whole = semiellipse(width=2.0, height=0.8, thickness=0.1, size=0.05, base="roller")
    part = half(whole)
    assert part.mirror
    assert not whole.mirror
    assert 2 * part.mesh.nelements == whole.mesh.nelements
    assert 2 * part.quadrature.weights.sum() == pytest.approx(whole.quadrature.weights.sum(), rel=1e-13)
    assert part.length == whole.length == 1.0
    assert part.nodes[0].min() == 0.0
    line = part.nodes[:, part.boundary_path("mirror")[0]]
    assert not line[0].any()
    assert line[1].min() == 0.0
    assert line[1].max() == 0.8
    known = {tuple(p) for p in whole.nodes.T.tolist()}
    assert {tuple(p) for p in part.nodes.T.tolist() if p[0] > 0} <= known
    # base: no motion across y = 0; mirror: none across x = 0
    fixed = set(part.fixed.tolist())
    on_base, on_line = np.flatnonzero(part.nodes[1] == 0), np.flatnonzero(part.nodes[0] == 0)
    assert fixed == {*(2 * on_base + 1).tolist(), *(2 * on_line).tolist()}
    assert np.array_equal(part.in_cortex.sum() * 2, whole.in_cortex.sum())


def test_what_is_not_symmetric_cannot_be_halved():
    mesh = MeshTri1.init_tensor(np.linspace(-1, 1, 6), np.linspace(0, 1, 4))
    named = mesh.with_boundaries({"pial": lambda p: p[1] == 1, "base": lambda p: p[1] == 0})
    with pytest.raises(ValueError, match="mirror-symmetric"):
        half(Body(named, 0.3))


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf"), "wide", None])
@pytest.mark.parametrize("name", ["width", "height", "thickness", "size"])
def test_lengths_must_be_positive(name, bad):
    with pytest.raises(ValueError, match=name):
        semiellipse(**{**SHAPES["thick"], name: bad})


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"thickness": 0.5}, ("thickness=0.5", "0.5 m", "half the smaller semi-axis", "thinner")),
        ({"height": 0.6, "thickness": 0.3}, ("thickness=0.3", "0.3 m")),
        ({"height": 0.3, "thickness": 0.1}, ("thickness=0.1", "0.09 m", "radius of curvature")),
        ({"size": 0.5}, ("size=0.5", "0.2", "smaller")),
        ({"base": "glued"}, ("base", "glued", "clamped", "roller", "free")),
        ({"coarsening": 0.9}, ("coarsening=0.9", "at least 1")),
        ({"coarsening": 5.0}, ("coarsening", "at most 3")),
        ({"along": 0.5}, ("along=0.5", "at least 1")),
        ({"along": 5.0}, ("along", "at most 4")),
    ],
)
def test_bad_shapes_are_refused(options, words):
    with pytest.raises(ValueError, match=words[0].split("=")[0]) as failure:
        semiellipse(**{**SHAPES["thick"], **options})
    message_names(failure.value, *words)


def outline_of_a_disc(radius, **options):
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    return outline(radius * np.stack([np.cos(angle), np.sin(angle)]), **options)


@pytest.mark.parametrize("bad", [-0.04, 0.0, float("nan")])
def test_a_radius_must_be_positive(bad):
    with pytest.raises(ValueError, match="radius"):
        semicircle(radius=bad, thickness=2.5e-3, size=1e-3)


@pytest.mark.parametrize("make", [semicircle, outline_of_a_disc])
def test_elements_through_the_cortex_set_the_size(make):
    # size = thickness/elements, so twice the thickness has the same number of elements through it
    for thickness in (0.1, 0.2):
        body = make(radius=1.0, thickness=thickness, elements=2)
        assert body.elements_through_cortex == pytest.approx(2, rel=0.1)
        same = make(radius=1.0, thickness=thickness, size=thickness / 2)
        np.testing.assert_array_equal(body.nodes, same.nodes)


@pytest.mark.parametrize("options", [{}, {"size": 0.05, "elements": 2}])
def test_either_size_or_elements_is_given(options):
    for make in (semicircle, outline_of_a_disc):
        with pytest.raises(ValueError, match="either size=") as failure:
            make(radius=1.0, thickness=0.1, **options)
        message_names(failure.value, "elements=", *(f"{k}={v}" for k, v in options.items()))


def test_millimetres_taken_for_metres_are_noticed():
    with pytest.warns(UserWarning, match=r"40\.4 m .* cortex of 2\.5 m.*40\.4 mm are 0\.0404") as told:
        semicircle(radius=40.4, thickness=2.5, elements=1)
    assert len(told) == 1


def test_lengths_in_different_units_are_refused_at_once():
    with pytest.raises(ValueError, match="same unit") as failure:
        semicircle(radius=40.4, thickness=2.5, size=2.5e-3)
    message_names(failure.value, "size=0.0025", "triangles", "GB of memory")


@pytest.mark.parametrize("options", [{}, {"along": 3.0}, {"coarsening": 1.0}, {"elements": 12}])
def test_triangles_expected_are_those_made_and_too_many_refused(options, monkeypatch):
    shape = {"width": 2.0, "height": 0.9, "thickness": 0.06, "elements": 4} | options
    made = semiellipse(**shape).mesh.nelements
    monkeypatch.setattr(memory, "memory_left", lambda: 1e5)
    with pytest.raises(ValueError, match=r"triangles, .* GB are left") as told:
        semiellipse(**shape)
    assert float(re.search("about (.*?) triangles", str(told.value))[1]) == pytest.approx(made, rel=0.3)
