"""Pieces that pictures are made of: shaded layers, outlines, loads per length, limits of colours; mm.

A PNG is made smaller by `compact`.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array, Booleans, Integers, add_up
from ..geometry.body import Body
from ..results.loading import UnfinishedWarning
from ..results.result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

MM = 1e3
CORE, INK = "#e8e6e1", "#333333"
# of a quadratic triangle: four straight ones
PARTS = np.array([(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)])
BARYCENTRIC = np.array([(1, 0, 0, 0.5, 0, 0.5), (0, 1, 0, 0.5, 0.5, 0), (0, 0, 1, 0, 0.5, 0.5)])


def copies(body: Body, points: Array) -> Iterator[Array]:
    """Yield points or vectors (2, n), and for a half body their mirror image about x = 0."""
    yield points
    if body.mirror:
        yield points * np.array([[-1.0], [1.0]])


def around(along: Array) -> Array:
    """Return points or vectors (2, n) at a curve's nodes, with the first again at the end if it is closed.

    It is closed if n is even: there are as many edge middles as vertices then.
    """
    return along if along.shape[1] % 2 else np.concatenate([along, along[:, :1]], axis=1)


def shaded(
    axes: Axes, points: Array, body: Body, layer: Booleans, values: Array, colors: ScalarMappable
) -> None:
    """Shade the elements of a layer by values at all nodes (n,), smoothly."""
    from matplotlib.tri import Triangulation

    nodes, local = np.unique(body.triangles[:, layer], return_inverse=True)
    corners = local.reshape(6, -1)[PARTS].transpose(0, 2, 1).reshape(-1, 3)
    x, y = MM * points[:, nodes]
    triangles = Triangulation(x, y, corners)
    drawn = axes.tripcolor(triangles, values[nodes], shading="gouraud", cmap=colors.get_cmap())
    drawn.set_norm(colors.norm)


def at_nodes(body: Body, values: Array, layer: Booleans) -> Array:
    """Return values (q, e) at the nodes (n,) of a layer: linear in each triangle, averaged at nodes."""
    at_points = BARYCENTRIC @ body.quadrature.shapes
    extrapolated = BARYCENTRIC.T @ np.linalg.lstsq(at_points.T, values[:, layer], rcond=None)[0]
    nodes, n = body.triangles[:, layer].ravel(), body.nodes.shape[1]
    count = np.bincount(nodes, minlength=n)
    return np.asarray(add_up(nodes, extrapolated, n) / np.maximum(count, 1))


def colour_limits(values: Array, weights: Array, *, centred: bool) -> tuple[float, float]:
    """Return the values that all but 1 % of the area stay within; from 0 unless `centred`."""
    order = np.argsort(values, axis=None)
    share = np.cumsum(weights.ravel()[order]) / weights.sum()
    low, high = (float(np.interp(s, share, values.ravel()[order])) for s in (0.01, 0.99))
    low = low if centred else 0.0
    return (low, high) if high > low else (low, low + max(1e-12, abs(low)))


def per_length(points: Array, forces: Array, count: int) -> tuple[Array, Array]:
    """Return middles (2, m) of about `count` stretches of a path and the force per length on each, (2, m).

    points, forces: at the path's nodes, (2, n); n is even if it is closed, see `around`.
    Half the force on a corner belongs to either edge; that on the two ends of an open path to none.
    """
    closed = points.shape[1] % 2 == 0
    points, forces = around(points), around(forces)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points)))])[::2]
    corners = forces[:, ::2].copy()
    if not closed:
        corners[:, [0, -1]] = 0.0
    on_edges = forces[:, 1::2] + 0.5 * (corners[:, :-1] + corners[:, 1:])
    cut = np.arange(0, on_edges.shape[1], max(1, round(on_edges.shape[1] / count)))
    lengths = np.add.reduceat(np.diff(arc), cut)
    middles = arc[cut] + lengths / 2
    at = np.stack([np.interp(middles, arc, coordinate[::2]) for coordinate in points])
    return at, np.add.reduceat(on_edges, cut, axis=1) / lengths


def shown(number: float) -> str:
    """Return a number with two digits that count, without an exponent."""
    return f"{float(f'{number:.2g}'):g}"


def mark_unfinished(figure: Figure, results: Mapping[str, Result]) -> None:
    """Write below a figure, and warn, which of its results did not reach the end of their scenes."""
    words = [f"{name}: {result.unfinished}" for name, result in results.items() if result.unfinished]
    if words:
        figure.supxlabel("\n".join(words), color="C3", fontsize=8)
        warnings.warn("drawn unfinished: " + "; ".join(words), UnfinishedWarning, stacklevel=2)


def sulci(count: int) -> str:
    """Return a number of sulci in words."""
    return f"{count} {'sulcus' if count == 1 else 'sulci'}"


def core(axes: Axes, points: Array, body: Body) -> None:
    """Fill the body with the colour of tissue that shows nothing."""
    if len(body.pial_paths) == 1 and "hole" not in body.mesh.boundaries:
        path = np.concatenate([body.pial, _closing(body)])
        axes.fill(*(MM * points[:, path]), color=CORE, linewidth=0)
        return
    from matplotlib.collections import PolyCollection

    triangles = list(MM * points[:, body.mesh.t].transpose(2, 1, 0))
    axes.add_collection(PolyCollection(triangles, facecolor=CORE, edgecolor=CORE, linewidth=0.3))


def pial_lines(body: Body, points: Array) -> Iterator[Array]:
    """Yield the parts of the pial surface, closed ones with their first point at the end, of moved nodes."""
    for path in body.pial_paths:
        for copy in copies(body, points):
            yield around(copy[:, path.nodes])


def edge(axes: Axes, points: Array, body: Body) -> None:
    """Draw the pial surface, the base and the walls of holes."""
    if len(body.pial_paths) > 1 or "hole" in body.mesh.boundaries:
        for name in body.mesh.boundaries:
            for path in body.boundary_paths(name):
                axes.plot(*(MM * around(points[:, path.nodes])), color=INK, linewidth=0.8)
        return
    axes.plot(*(MM * around(points[:, body.pial])), color=INK, linewidth=0.8)
    closing = _closing(body)
    if closing.size and not body.mirror:
        axes.plot(*(MM * points[:, closing]), color=INK, linewidth=0.8)


def _closing(body: Body) -> Integers:
    """Return the nodes of the base, from the end of the pial surface back to its start."""
    if body.pial_curve.closed or "base" not in (body.mesh.boundaries or {}):
        return np.zeros(0, dtype=np.int64)
    base = body.boundary_path("base")[0]
    return base if base[0] == body.pial[-1] else base[::-1] if base[-1] == body.pial[-1] else base


def frame(axes: Axes) -> None:
    """Give both axes the same scale and hide them."""
    axes.set_aspect("equal")
    axes.set_axis_off()


def compact(picture: bytes) -> bytes:
    """Return a PNG picture in the 256 colours that suit it best.

    Shading makes tens of thousands of colours, which PNG hardly compresses; with 256 of them the file has a
    third of its size, and no difference is seen.
    """
    from PIL import Image

    made = io.BytesIO()
    with Image.open(io.BytesIO(picture)) as image:
        few = image.convert("RGB").quantize(256, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
        few.save(made, "png", optimize=True, dpi=image.info["dpi"])
    return made.getvalue()


def round_length(length: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten up to `length`."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(m for m in (1, 2, 5) if m * power <= length * (1 + 1e-9)) * power)


def inside(body: Body) -> tuple[float, float]:
    """Return a point in the middle of the body, where there is room for text; mm."""
    x, y = body.nodes
    middle = 0.0 if body.mirror else 0.5 * (x.min() + x.max())
    return MM * middle, MM * (y.min() + 0.4 * np.ptp(y))
