"""Numbers of one state: how much area has grown, and how the pial surface folds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array, Booleans, Integers
from ..geometry.body import Body
from ..geometry.triangles import folded_over
from ..state import State
from ..terms.boundary import crossings
from .surface import along_pial, pial_closed

if TYPE_CHECKING:
    from ..morphometry.folds import Folds

SPLIT = 16  # small triangles along a side of an element on the edge of the centre


def area_numbers(body: Body, state: State) -> dict[str, float | None]:
    """Return the deformed over the undeformed area of the whole, of cortex and core, and of its centre.

    The core is what lies below the cortex, the centre what lies deeper than half of the largest depth: in a
    disc, inside half the radius. None for a body without such a part.
    """
    weights, displacement = body.quadrature.weights, state["displacement"]
    stretched = weights * _area_ratio(body, displacement)

    def growth(where: Booleans) -> float | None:
        return float(stretched[where].sum() / weights[where].sum()) if where.any() else None

    core = np.broadcast_to(~body.in_cortex, weights.shape)
    return {
        "area_growth": growth(np.ones_like(core)),
        "cortex_growth": growth(~core),
        "core_growth": growth(core),
        "centre_growth": _centre_growth(body, displacement, stretched),
    }


def _centre_growth(body: Body, displacement: Array, stretched: Array) -> float:
    """Return the deformed over the undeformed area of the centre.

    Elements that its edge crosses are made of small triangles, each of which lies inside or outside.
    stretched: deformed areas of the integration points, (q, e).
    """
    depth = body.pial_curves.nearest(body.nodes)[0]
    half = 0.5 * float(depth.max())
    deep = (depth > half)[body.triangles]
    inside, crossed = deep.all(0), deep.any(0) & ~deep.all(0)
    shapes, small = _small_triangles()
    old, new = (
        np.einsum("pa,iae->ipe", shapes, (body.nodes + u)[:, body.triangles[:, crossed]])[:, small]
        for u in (0.0, displacement)
    )  # (2, 3, triangles, e)
    middles = old.mean(1)
    within = body.pial_curves.nearest(middles.reshape(2, -1))[0].reshape(middles.shape[1:]) > half
    before, after = (_areas(x)[within].sum() for x in (old, new))
    rest = body.quadrature.weights[:, inside].sum()
    return float((stretched[:, inside].sum() + after) / (rest + before))


def _areas(corners: Array) -> Array:
    """Return the areas of straight triangles with corners (2, 3, ...)."""
    (x, y), (u, v) = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(0.5 * (x * v - y * u))


def _small_triangles() -> tuple[Array, Integers]:
    """Return shape functions at the corners of small triangles in one, (p, 6), and each one's, (3, k).

    Nodes 3, 4 and 5 lie between the corners 0 and 1, 1 and 2, 0 and 2.
    """
    corners = [(i, j) for i in range(SPLIT + 1) for j in range(SPLIT + 1 - i)]
    place = {corner: k for k, corner in enumerate(corners)}
    up = [((i, j), (i + 1, j), (i, j + 1)) for i, j in corners if i + j < SPLIT]
    down = [((i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in corners if i + j < SPLIT - 1]
    b, c = np.array(corners).T / SPLIT
    a = 1.0 - b - c
    shapes = [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * a * c]
    return np.stack(shapes, axis=1), np.array([[place[one] for one in each] for each in (*up, *down)]).T


def _area_ratio(body: Body, displacement: Array) -> Array:
    """Return det ∂x/∂X at the integration points, (q, e); their weighted sum is the exact deformed area."""
    rule, moved = body.quadrature, (body.nodes + displacement)[:, body.triangles]
    F = np.einsum("iae,abq,bjqe->ijqe", moved, rule.derivatives, rule.inverse)
    return np.asarray(F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0])


def fold_numbers(body: Body, state: State) -> dict[str, float | None]:
    """Return what is wrong with the shape of a state, if anything, and what its pial surface looks like.

    inverted_elements: triangles turned over somewhere.  gyrification_index is against
    the convex hull, closed_gyrification_index against the closing by a disc of closing_radius, m.
    sulcal_depth: mean, m, of the sulci that are at least least_fold_depth, m, deep and still there after
    averaging along fold_smoothing, m.  mirror_error: m, None for a body that is not its own mirror image.
    registration, registration_p: with the pattern, and the share of the pattern's phases that register as
    well or better; pattern_half_waves: along the pial surface; None without a pattern.
    Of a pial surface in several parts see `_numbers_of_parts`.
    """
    if len(body.pial_paths) > 1:
        return _numbers_of_parts(body, state)
    from ..morphometry.closing import closing_radius
    from ..morphometry.folds import find_folds
    from ..morphometry.polyline import InnerWall
    from ..morphometry.registration import registration_null
    from ..morphometry.shape import gyrification_index
    from ..morphometry.walls import mirror_error

    rest, pial = (along_pial(body, (body.nodes + u)[:, body.pial]) for u in (0.0, state["displacement"]))
    pattern, closed = pial_pattern(body, state), pial_closed(body)
    folds = find_folds(pial, thickness=body.thickness, closed=closed)
    radius = closing_radius(pial, body.thickness, closed=closed)
    found = None if pattern is None else registration_null(pattern, pial, rest, closed=closed)
    inner = isinstance(pial, InnerWall)  # which has no closing
    symmetric = mirror_error(rest) <= 1e-9 * body.length
    return {
        "inverted_elements": inverted(body, state),
        "self_intersections": crossings(body, state["displacement"]),
        "gyrification_index": gyrification_index(pial, closed=closed),
        "closed_gyrification_index": (
            None if inner else gyrification_index(pial, closing=radius, closed=closed)
        ),
        "closing_radius": None if inner else radius,
        "folds": folds.count,
        "sulcal_depth": folds.depth,
        "least_fold_depth": folds.prominence,
        "fold_smoothing": folds.smoothing,
        "mirror_error": mirror_error(pial) if symmetric else None,
        "registration": None if found is None else found.value,
        "registration_p": None if found is None else found.p,
        "pattern_half_waves": None if pattern is None else _half_waves(pattern, closed=closed),
    }


def _half_waves(pattern: Array, *, closed: bool) -> int | None:
    """Return of how many half waves a pattern is, by its changes of sign about the mean; None of none."""
    from ..turing.modes import sign_changes

    if not np.ptp(pattern):
        return None
    changes = sign_changes(pattern - pattern.mean())
    return changes + (changes % 2 if closed else 0)


def _numbers_of_parts(body: Body, state: State) -> dict[str, float | None]:
    """Return the numbers of `fold_numbers` for a pial surface in several parts.

    Folds are those of the `_surfaces` of all pieces of tissue, their depth the mean over all sulci. The
    gyrification index is the length of all parts, with closed-off sulci, over that of the surfaces' hulls.
    """
    folds = _folds(body, state["displacement"])
    return {
        "inverted_elements": inverted(body, state),
        "self_intersections": crossings(body, state["displacement"]),
        "gyrification_index": gyrification(body, state["displacement"]),
        "closed_gyrification_index": None,
        "closing_radius": None,
        "folds": sum(found.count for found in folds),
        "sulcal_depth": _mean_depth(folds),
        "least_fold_depth": folds[0].prominence,
        "fold_smoothing": folds[0].smoothing,
        "mirror_error": None,
        "registration": None,
        "registration_p": None,
        "pattern_half_waves": None,
    }


def shape_numbers(body: Body, displacement: Array) -> dict[str, float]:
    """Return pial length, m, gyrification index, and mean sulcal depth, m, of a deformed body."""
    from ..morphometry.polyline import perimeter

    return {
        "perimeter": sum(perimeter(pial, closed=closed) for pial, closed in _whole(body, displacement)),
        "gyrification_index": gyrification(body, displacement),
        "sulcal_depth": sulci_of(body, displacement)[1],
    }


def sulci_of(body: Body, displacement: Array) -> tuple[int, float]:
    """Return the number of sulci of a deformed body, and their mean depth, m."""
    folds = _folds(body, displacement)
    return sum(found.count for found in folds), _mean_depth(folds)


def _folds(body: Body, displacement: Array) -> list[Folds]:
    """Return the folds of each surface that may have some."""
    from ..morphometry.folds import find_folds

    surfaces = _whole(body, displacement)
    if len(surfaces) > 1:
        surfaces = _folding(_surfaces(surfaces), body.thickness)
    return [find_folds(pial, thickness=body.thickness, closed=closed) for pial, closed in surfaces]


def _whole(body: Body, displacement: Array) -> list[tuple[Array, bool]]:
    """Return the parts of the pial surface and whether they are closed; the half of a body is completed."""
    parts = _parts(body, displacement)
    return parts if len(parts) > 1 else [(along_pial(body, parts[0][0]), pial_closed(body))]


def inverted(body: Body, state: State) -> int:
    """Return the number of triangles that are turned over somewhere; mixed ones with their bubbles."""
    moved = body.nodes + state["displacement"]
    return len(folded_over(body.mesh, moved, state.fields.get("bubble")))


def _parts(body: Body, displacement: Array) -> list[tuple[Array, bool]]:
    moved = body.nodes + displacement
    return [(moved[:, path.nodes], path.closed) for path in body.pial_paths]


def _mean_depth(folds: Sequence[Folds]) -> float:
    """Return the mean depth of all sulci, m."""
    return sum(found.count * found.depth for found in folds) / max(1, sum(found.count for found in folds))


def _surfaces(parts: list[tuple[Array, bool]]) -> list[tuple[Array, bool]]:
    """Return the outer ones of parts of a pial surface; where all are inner walls, as of ventricles, all.

    An inner wall beside outer surfaces is a sulcus whose mouth has closed.
    """
    from ..morphometry.polyline import InnerWall, enclosed_area

    outer = [(pial, closed) for pial, closed in parts if not closed or enclosed_area(pial) > 0]
    return outer or [(pial.view(InnerWall), closed) for pial, closed in parts]


def _folding(surfaces: list[tuple[Array, bool]], thickness: float) -> list[tuple[Array, bool]]:
    """Return the surfaces that a cortex so thick may fold; where none is as large, all.

    Islands of a section, which the plane cuts off the tip of a gyrus, may be smaller than their cortex.
    """
    from ..morphometry.polyline import as_polyline

    large = [(pial, closed) for pial, closed in surfaces if as_polyline(pial, closed).may_fold(thickness)]
    return large or surfaces


def gyrification(body: Body, displacement: Array) -> float:
    """Return the gyrification index of the deformed pial surface, of several parts that of all together."""
    from ..morphometry.polyline import as_polyline
    from ..morphometry.shape import gyrification_index

    if len(body.pial_paths) == 1:
        pial = along_pial(body, (body.nodes + displacement)[:, body.pial])
        return gyrification_index(pial, closed=pial_closed(body))
    parts = _parts(body, displacement)
    lengths = [as_polyline(pial, closed).length for pial, closed in parts]
    hulls = [
        as_polyline(pial, closed).length / gyrification_index(pial, closed=closed)
        for pial, closed in _surfaces(parts)
    ]
    return sum(lengths) / sum(hulls)


def pial_pattern(body: Body, state: State) -> Array | None:
    """Return the pattern û along the pial surface, (n,), or None without a pattern."""
    if "pattern" not in state:
        return None
    return along_pial(body, body.spread(body.cortex, state["pattern"], outside=0.0)[body.pial])
