"""Bodies of simple shape, meshed by rings that follow the pial surface and grow coarser inward."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from skfem import MeshTri2

from ..arrays import Array, Integers
from ..checks import one_of, positive
from ..memory import refuse_too_many
from .body import BASES, Body
from .mirror import FLIP
from .triangles import straight_mesh

LARGEST = 5.0  # m, half a body; models in units of their own have a radius of about 1
SLENDER = 4.0  # at most, edges across over edges along the cortex
CORE, COARSEST = 0.1, 0.2  # of the core's radius: how large its elements may be, that of a coarse cortex too
OF_CORE = 3  # elements through the cortex up to which that is so; more of them make the core as much finer
Quarter = Callable[[Array, float], Array]  # (fraction of the way from base to apex, depth) -> points (2, n)


def semicircle(
    *, radius: float, thickness: float, size: float | None = None, elements: float | None = None,
    along: float = 1.0, base: str = "clamped", layers: str = "sharp", coarsening: float = 1.35,
) -> Body:  # fmt: skip
    """Return the upper half of a disc around the origin.

    radius and thickness (of the cortex) in m; size: element edge in the cortex, m, or elements: their number
    through the cortex; along: how many times shorter they are along the surface, as suits a cortex that grows
    as many times longer; base "clamped", "roller" or "free"; layers "sharp" or "sigmoid", see `Body`;
    coarsening: growth of the element size from ring to ring below the cortex, to a tenth of the core's
    radius, less where the cortex has more than three elements through it, or to that in the cortex, but not
    beyond a fifth.
    """
    positive("radius", radius)
    return semiellipse(
        width=2 * radius, height=radius, thickness=thickness, size=size, elements=elements, along=along,
        base=base, layers=layers, coarsening=coarsening,
    )  # fmt: skip


def semiellipse(
    *, width: float, height: float, thickness: float, size: float | None = None,
    elements: float | None = None, along: float = 1.0, base: str = "clamped", layers: str = "sharp",
    coarsening: float = 1.35,
) -> Body:  # fmt: skip
    """Return the upper half of an ellipse with its full width along the base and its apex at `height`; m.

    The cortex has the same thickness everywhere, measured along the normal of the pial surface. The other
    arguments are those of `semicircle`.
    Raises ValueError where the normals of the pial surface would meet inside the cortex. Warns of lengths
    that seem to be in mm.
    """
    a, b = positive("width", width) / 2, positive("height", height)
    size = element_size(size, elements, thickness)
    one_of("base", base, BASES)
    positive("coarsening", coarsening, at_most=3.0)
    if positive("along", along, at_most=SLENDER) < 1:
        raise ValueError(f"along={along:g} must be at least 1 (1: elements as long along as across).")
    if coarsening < 1:
        raise ValueError(f"coarsening={coarsening:g} must be at least 1 (1: no coarsening inward).")
    sharpest = min(a * a / b, b * b / a)
    limit = min(0.5 * min(a, b), sharpest)
    if not 0 < positive("thickness", thickness) < limit:
        raise ValueError(
            f"thickness={thickness:g} m must be less than {limit:g} m: half the smaller semi-axis "
            f"({min(a, b) / 2:g} m) and the smallest radius of curvature ({sharpest:g} m); use a thinner "
            "cortex."
        )
    question = f"are size, thickness={thickness:g} and width={2 * a:g} in the same unit?"
    refuse_too_many(_triangles(a, b, thickness, size, along, coarsening), size, question)
    if size > 2 * thickness:
        raise ValueError(
            f"size={size:g} m must be at most twice the thickness {thickness:g} m; use smaller elements."
        )
    if max(a, b) > LARGEST:
        warnings.warn(
            f"a half width of {a:g} m and a height of {b:g} m with a cortex of {thickness:g} m: lengths are "
            f"in m, {a:g} mm are {1e-3 * a:g}; loads in N/m and contact distances would not suit this body.",
            stacklevel=2,
        )
    return Body(_mirrored(_quarter_mesh(a, b, thickness, size, along, coarsening)), thickness, base, layers)


def element_size(size: float | None, elements: float | None, thickness: float) -> float:
    """Return the element edge in the cortex, m: `size`, or thickness/elements; exactly one is to be given."""
    if (size is None) == (elements is None):
        given = "neither" if size is None else f"size={size!r} and elements={elements!r}"
        raise ValueError(
            f"{given} given: say either size= (element edge in the cortex, m) or elements= (their number "
            "through the cortex)."
        )
    if elements is None:
        return positive("size", size)
    return positive("thickness", thickness) / positive("elements", elements)


def _triangles(
    a: float, b: float, thickness: float, size: float, along: float, coarsening: float
) -> float:  # fmt: skip
    """Return about how many triangles half an ellipse gets: layers of the cortex, then coarser ones.

    Of two and fewer elements through the cortex it is up to twice as many as are made.
    """
    arc = 0.5 * np.pi * (3 * (a + b) - np.sqrt((3 * a + b) * (a + 3 * b)))
    layer = 2 * along * arc / size
    coarsest = max(size, _coarsest(size, thickness) * 0.5 * (a + b))
    coarsened = np.pi * a * b / coarsest**2 + layer / along * coarsening / max(coarsening - 1, 1e-9)
    return float(layer * thickness / size + min(np.pi * a * b / size**2, coarsened))


def _coarsest(size: float, thickness: float) -> float:
    """Return how large elements of the core may be, as a share of its radius."""
    return CORE * min(1.0, OF_CORE * size / thickness)


# The right half is built from rings, then mirrored: symmetry holds to the last bit.


@dataclass(frozen=True)
class _Half:
    points: Array
    triangles: Integers
    middles: dict[tuple[int, int], tuple[float, float]]  # of the edges that follow the curved cortex
    pial: list[tuple[int, int]]
    cortex: int  # the first so many triangles


def _quarter_mesh(
    a: float, b: float, thickness: float, size: float, along: float, coarsening: float
) -> _Half:  # fmt: skip
    at, arc = _offset_quarter(a, b)
    layers = max(1, round(thickness / size))
    around = max(2, round(along * arc / size))
    rings: list[Array] = []
    points: list[tuple[float, float]] = []

    def add(ring: Array) -> None:
        rings.append(np.arange(len(points), len(points) + ring.shape[1]))
        points.extend((float(x), float(y)) for x, y in ring.T)

    fractions = np.linspace(0.0, 1.0, around + 1)
    for layer in range(layers + 1):
        add(at(fractions, thickness * layer / layers))
    triangles, middles = _cortex(rings, at, fractions, thickness, layers)
    cortex = len(triangles)

    # the core is filled with shrunken copies of the interface
    def scaled(share: float, count: int) -> Array:
        return share * at(np.linspace(0.0, 1.0, count + 1), thickness)

    mean_radius = 0.5 * (a + b) - thickness
    share, step, count = 1.0, max(size, arc / around) / mean_radius, around
    coarsest = min(max(_coarsest(size, thickness), step), COARSEST)
    while count > 2:
        step = min(step * coarsening, coarsest)
        share -= step
        fitting = round(around / along * share * (size / mean_radius) / step) if share > 0.6 * step else 0
        if fitting < 2:
            break
        count = min(fitting, count)
        add(scaled(share, count))
        triangles += _zip(rings[-2].tolist(), rings[-1].tolist())
    centre = len(points)
    points.append((0.0, 0.0))
    last = rings[-1].tolist()
    triangles += [(p, q, centre) for p, q in pairwise(last)]
    outer = rings[0].tolist()
    return _Half(
        np.array(points).T,
        np.array(triangles).T,
        middles,
        list(pairwise(outer)),
        cortex,
    )


def _offset_quarter(a: float, b: float) -> tuple[Quarter, float]:
    """Return the map (fraction of pial arc, depth) -> point of a quarter ellipse, and its arc length."""
    angle = np.linspace(0.0, np.pi / 2, 4001)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    middle, half_width = 0.5 * (angle[1:] + angle[:-1]), 0.5 * (angle[1] - angle[0])
    speed = sum(
        w * np.hypot(a * np.sin(middle + half_width * x), b * np.cos(middle + half_width * x))
        for x, w in zip(nodes, weights, strict=True)
    )
    arc = np.concatenate([[0.0], np.cumsum(half_width * speed)])
    angle_at = CubicSpline(arc / arc[-1], angle)

    def at(fraction: Array, depth: float) -> Array:
        phi = angle_at(fraction)
        cosine, sine = np.cos(phi), np.sin(phi)
        cosine = np.where(fraction == 1.0, 0.0, cosine)
        sine = np.where(fraction == 0.0, 0.0, sine)
        stretch = np.hypot(b * cosine, a * sine)
        return np.stack([a * cosine - depth * b * cosine / stretch, b * sine - depth * a * sine / stretch])

    return at, float(arc[-1])


def _cortex(
    rings: list[Array], at: Quarter, fractions: Array, thickness: float, layers: int
) -> tuple[list[tuple[int, int, int]], dict[tuple[int, int], tuple[float, float]]]:
    """Split the quadrilaterals between rings by alternating diagonals; edge middles lie on the curves."""
    triangles: list[tuple[int, int, int]] = []
    middles: dict[tuple[int, int], tuple[float, float]] = {}
    halfway = 0.5 * (fractions[1:] + fractions[:-1])

    def curve(ends: tuple[Array, Array], depth: float) -> None:
        for p, q, point in zip(*(e.tolist() for e in ends), at(halfway, depth).T.tolist(), strict=True):
            middles[min(p, q), max(p, q)] = (point[0], point[1])

    for layer in range(layers + 1):
        curve((rings[layer][:-1], rings[layer][1:]), thickness * layer / layers)
    for layer in range(layers):
        outer, inner = rings[layer], rings[layer + 1]
        for k in range(len(outer) - 1):
            o0, o1, i0, i1 = (int(v) for v in (outer[k], outer[k + 1], inner[k], inner[k + 1]))
            if (k + layer) % 2 == 0:
                triangles += [(o0, o1, i0), (o1, i1, i0)]
            else:
                triangles += [(o0, o1, i1), (o0, i1, i0)]
        even = (np.arange(len(outer) - 1) + layer) % 2 == 0
        diagonal = (np.where(even, outer[1:], outer[:-1]), np.where(even, inner[:-1], inner[1:]))
        curve(diagonal, thickness * (layer + 0.5) / layers)
    return triangles, middles


def _zip(outer: list[int], inner: list[int]) -> list[tuple[int, int, int]]:
    """Triangulate between two rings over the same angle, outer counter-clockwise, always closing the lag."""
    triangles = []
    i = j = 0
    n, m = len(outer) - 1, len(inner) - 1
    while i < n or j < m:
        if j == m or (i < n and (i + 0.5) * m <= (j + 0.5) * n):
            triangles.append((outer[i], outer[i + 1], inner[j]))
            i += 1
        else:
            triangles.append((outer[i], inner[j + 1], inner[j]))
            j += 1
    return triangles


def _mirrored(part: _Half) -> MeshTri2:
    """Join the right half with its mirror image and place the edge middles."""
    n = part.points.shape[1]
    on_axis = part.points[0] == 0.0
    image = np.where(on_axis, np.arange(n), n + np.cumsum(~on_axis) - 1)
    left = part.points[:, ~on_axis] * FLIP
    points = np.concatenate([part.points, left], axis=1)
    triangles = np.stack([part.triangles, image[part.triangles][[0, 2, 1]]], axis=2)
    triangles = np.concatenate([triangles[:, :, 0], triangles[:, :, 1]], axis=1)
    gray = np.concatenate([np.arange(part.cortex), part.triangles.shape[1] + np.arange(part.cortex)])
    straight = straight_mesh(points, triangles)
    mesh = MeshTri2.from_mesh(straight)
    facet = {(int(p), int(q)): k for k, (p, q) in enumerate(straight.facets.T)}
    middles = 0.5 * (points[:, straight.facets[0]] + points[:, straight.facets[1]])
    # mesh.doflocs is not mirrored to the last bit
    placed = np.ascontiguousarray(np.concatenate([points, middles], axis=1))
    for (p, q), (x, y) in part.middles.items():
        placed[:, straight.nvertices + facet[p, q]] = x, y
        p, q = sorted((int(image[p]), int(image[q])))
        placed[:, straight.nvertices + facet[p, q]] = -x, y
    pial = {facet[p, q] for p, q in part.pial}
    pial |= {facet[tuple(sorted((int(image[p]), int(image[q]))))] for p, q in part.pial}  # type: ignore[index]
    base = set(straight.boundary_facets().tolist()) - pial
    boundaries = {"pial": np.array(sorted(pial)), "base": np.array(sorted(base))}
    return MeshTri2(placed, mesh.t, _boundaries=boundaries, _subdomains={"cortex": gray}, validate=False)
