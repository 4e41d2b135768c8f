"""Panels: folded sections side by side on one scale, with their numbers below, each drawn on its own Axes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array, add_up
from ..geometry.body import Body
from ..results.measures import gyrification, sulci_of
from ..results.result import Result
from ..results.units import with_error
from .sections import scale_bar
from .style import MM, PARTS, copies, edge, frame, pial_lines, sulci

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


WHITE, GRAY, INK = "#f3e9dc", "#b9887f", "#3b2626"
MIDDLES = np.array([(0, 1), (1, 2), (0, 2)])  # corners beside the nodes 3, 4, 5


def layers(axes: Axes, result: Result, step: int = -1) -> None:
    """Draw the deformed body, dark where tissue grows in the course of the run, light where it does not."""
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.tri import Triangulation

    body, state = result.scene.body, result.states[step]
    shades = LinearSegmentedColormap.from_list("tissue", [WHITE, GRAY])
    values = _at_nodes(body, _share(result))
    points = body.nodes + state["displacement"]
    corners = body.triangles[PARTS].transpose(0, 2, 1).reshape(-1, 3)
    for sign in (1.0, -1.0) if body.mirror else (1.0,):
        triangles = Triangulation(sign * points[0], points[1], corners)
        axes.tripcolor(triangles, values, shading="gouraud", cmap=shades, vmin=0.0, vmax=1.0, rasterized=True)
    for pial in pial_lines(body, points):
        axes.plot(*pial, color=INK, linewidth=0.8)
    axes.set_aspect("equal")
    axes.set_axis_off()


def tissue(axes: Axes, body: Body) -> None:
    """Draw the undeformed body, gray matter dark and white matter light, in mm, with a scale bar."""
    from matplotlib.colors import ListedColormap

    shades = ListedColormap([WHITE, GRAY])
    corners, gray = body.mesh.t.T, body.in_cortex.astype(float)
    for points in copies(body, body.nodes):
        x, y = MM * points[:, : body.mesh.nvertices]
        axes.tripcolor(
            x, y, corners, facecolors=gray, cmap=shades, vmin=0.0, vmax=1.0, edgecolors="face", linewidth=0.6,
            antialiased=True,
        )  # fmt: skip
        edge(axes, points, body)
    frame(axes)
    scale_bar(axes, body)


def before(axes: Axes, result: Result) -> None:
    """Draw the undeformed outline, dotted."""
    body = result.scene.body
    for pial in pial_lines(body, body.nodes):
        axes.plot(*pial, color=INK, linewidth=0.7, linestyle=(0, (1, 2)))


def numbers(result: Result, step: int = -1) -> str:
    """Return fold count, gyrification index and mean sulcal depth, in units of the thickness, as one line.

    Above it, of the end of a run that stopped, that and where.
    """
    body = result.scene.body
    displacement = result.states[step]["displacement"]
    count, deep = sulci_of(body, displacement)
    index = gyrification(body, displacement)
    depth = f", depth {deep / body.thickness:.1f} T" if count else ""
    last = result.states[step] is result.last
    off = result.error("gyrification_index") if last else None
    stopped = f"{result.unfinished}\n" if last and result.unfinished else ""
    return f"{stopped}{sulci(count)}, GI {with_error(index, off)}{depth}"


def grid(
    figure: Figure,
    panels: Mapping[str, tuple[Result, int]],
    *,
    columns: int,
    notes: Mapping[str, str] | None = None,
    width: float = 3.2,
) -> list[Axes]:
    """Draw a panel for each title, all on one scale, with a letter, the numbers and possibly a note below.

    panels: result and step by title, each looked up once: they may be loaded only then.  width: of a panel,
    inch.  Returns the Axes in the order of the panels.
    """
    rows = -(-len(panels) // columns)
    found, boxes = [], []
    for k, (title, (result, step)) in enumerate(panels.items()):
        axes = figure.add_subplot(rows, columns, k + 1)
        layers(axes, result, step)
        boxes.append(_box(result, step))
        axes.set_title(f"$\\bf{{{_letter(k)}}}$  {title}", loc="left", fontsize=9)
        below = numbers(result, step)
        if notes and title in notes:
            below += "\n" + notes[title]
        axes.text(0.5, -0.02, below, transform=axes.transAxes, ha="center", va="top", fontsize=8)
        found.append(axes)
    low, high = np.min([a for a, _ in boxes], axis=0), np.max([b for _, b in boxes], axis=0)
    for axes in found:
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
    height = width * float((high - low)[1] / (high - low)[0])
    figure.set_size_inches(columns * width, rows * (height + 0.62))
    return found


def _letter(k: int) -> str:
    """Return a, b, ..., z, aa, ab, ..."""
    return (_letter(k // 26 - 1) if k >= 26 else "") + chr(ord("a") + k % 26)


def nearest_step(result: Result, time: float) -> int:
    """Return the place of the state whose time is nearest to `time`."""
    return int(np.argmin([abs(state.time - time) for state in result.states]))


def _box(result: Result, step: int) -> tuple[Array, Array]:
    body = result.scene.body
    moved = np.concatenate(list(copies(body, body.nodes + result.states[step]["displacement"])), axis=1)
    low, high = moved.min(axis=1), moved.max(axis=1)
    margin = 0.03 * (high - low).max()
    return low - margin, high + margin


def _share(result: Result) -> Array:
    """Return the growth at the end in units of the largest, or the cortex where nothing grows, (q, e)."""
    body, state = result.scene.body, result.last
    extra = np.log(state["growth"][0]) if "growth" in state else np.zeros_like(body.quadrature.weights)
    if np.ptp(extra) < 1e-6:
        return np.broadcast_to(body.in_cortex.astype(float), extra.shape)
    return np.asarray(np.clip(extra / np.percentile(extra, 98), 0.0, 1.0))


def _at_nodes(body: Body, values: Array) -> Array:
    """Return values (q, e) averaged at the corners, and at the edge middles the mean of two corners, (n,)."""
    weights = body.quadrature.weights * (1e-12 + np.maximum(body.quadrature.shapes[:3], 0.0)[:, :, None])
    count, corners = body.nodes.shape[1], body.triangles[:3]
    total = add_up(corners, weights.sum(1), count)
    found = add_up(corners, (weights * values).sum(1), count)
    means = np.asarray(found / np.where(total > 0, total, 1.0))
    means[body.triangles[3:]] = means[body.triangles[MIDDLES]].mean(1)
    return means
