"""Pictures of a result, each a function of the Axes it draws on; lengths in mm, stresses in kPa.

The colours can be told apart by the colour-blind: viridis and its kin for quantities, Okabe and Ito for lines.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .body import Body
from .checks import one_of
from .results import Result, along_pial, growth
from .scene import Scene, State, Term

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

MM = 1e3
CORE, INK, BLUE, VERMILION = "#e8e6e1", "#333333", "#0072b2", "#d55e00"
# of a quadratic triangle: four straight ones
PARTS = np.array([(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)])
BARYCENTRIC = np.array([(1, 0, 0, 0.5, 0, 0.5), (0, 1, 0, 0.5, 0.5, 0), (0, 0, 1, 0, 0.5, 0.5)])
FIELDS = {
    "von_mises": ("von Mises stress (kPa)", 1e-3),
    "pressure": ("pressure (kPa)", 1e-3),
    "jacobian": ("elastic volume ratio J*", 1.0),
}


def section(
    axes: Axes, result: Result, step: int = -1, *, field: str = "von_mises", bar: bool = True,
    limits: tuple[float, float] | None = None,
) -> Any:  # fmt: skip
    """Draw the deformed body coloured by a field, with colour bar and scale bar; return what carries the colours.

    field: "von_mises", "pressure" or "jacobian".  limits: of the colours, by default up to the value that is
    exceeded in 1 % of the area, so that a few points do not hide the rest.
    """
    from matplotlib.colors import Normalize

    one_of("field", field, tuple(FIELDS))
    body, state = result.scene.body, result.states[step]
    label, unit = FIELDS[field]
    values = unit * result.observe(step)[field]
    low, high = limits or _limits(values, body.quadrature.weights, centred=field != "von_mises")
    norm = Normalize(low, high)
    shades = "viridis" if field == "von_mises" else "cividis"
    mapped = None
    for points in _copies(body, body.nodes + state["displacement"]):
        for layer in (body.in_cortex, ~body.in_cortex):
            if layer.any():
                mapped = _shaded(axes, points, body, layer, _at_nodes(body, values, layer), norm, shades)
        axes.plot(*(MM * points[:, body.interface]), color="white", linewidth=0.6, alpha=0.8)
        _edge(axes, points, body)
    _frame(axes)
    scale_bar(axes, body)
    if bar and mapped is not None:
        beyond = "max" if field == "von_mises" else "both"
        axes.figure.colorbar(mapped, ax=axes, label=label, shrink=0.7, pad=0.02, extend=beyond)
    return mapped


def outline(axes: Axes, body: Body, *, color: str = "#777777", label: str = "before folding") -> None:
    """Draw the undeformed outline, dashed."""
    points = MM * along_pial(body, body.nodes[:, body.pial])
    axes.plot(*points, color=color, linewidth=1.0, linestyle=(0, (4, 3)), label=label)


def activator(axes: Axes, result: Result, *, bar: bool = True) -> None:
    """Draw the activator, from 0 to 1, on the band of the undeformed body."""
    from matplotlib.colors import Normalize

    body = result.scene.body
    pattern = np.zeros(body.nodes.shape[1])
    pattern[body.cortex.nodes] = result.last["pattern"]
    mapped = None
    for points in _copies(body, body.nodes):
        _core(axes, points, body)
        mapped = _shaded(axes, points, body, body.in_cortex, pattern, Normalize(0, 1), "viridis")
        _edge(axes, points, body)
    _frame(axes)
    if bar and mapped is not None:
        axes.figure.colorbar(mapped, ax=axes, label="activator û", shrink=0.7, pad=0.02, ticks=[0, 0.5, 1])


def load_arrows(axes: Axes, scene: Scene, state: State, term: Term, *, count: int = 72) -> None:
    """Draw the load of a term on the undeformed body, N/m² along the curve it acts on, as about `count` arrows."""
    body = scene.body
    at_rest = np.zeros(body.nodes.size)
    potential = term.on(body).during(State(scene.until, state.fields), scene.until)
    at = potential.evaluate(at_rest) if potential is not None else None
    if at is None:
        raise ValueError(f"{type(term).__name__} has no load to draw at the end of the scene.")
    forces = -at.gradient()[0].reshape(-1, 2).T
    paths = (body.interface, body.pial)
    path = max(paths, key=lambda nodes: float(np.abs(forces[:, nodes]).sum()))
    start, load = _per_length(body.nodes[:, path], forces[:, path], count)
    for points in _copies(body, body.nodes):
        _core(axes, points, body)
        axes.plot(*(MM * points[:, body.interface]), color="#999999", linewidth=0.8)
        _edge(axes, points, body)
    length = 0.07 * np.ptp(body.nodes[0]) * MM / np.hypot(*load).max()
    for origin, arrow in zip(_copies(body, start), _copies(body, load), strict=True):
        axes.quiver(
            *(MM * origin), *(length * arrow), angles="xy", scale_units="xy", scale=1, color=VERMILION, width=0.004,
            zorder=3,
        )  # fmt: skip
    _frame(axes)


def pial_history(axes: Axes, result: Result, *, count: int = 8, bar: bool = True) -> None:
    """Draw the pial surface at `count` evenly spaced times, coloured by growth."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    times = np.array([state.time for state in result.states])
    chosen = sorted({int(np.abs(times - t).argmin()) for t in np.linspace(times[0], times[-1], count)})
    factors = [growth(result.states[k]) for k in chosen]
    colors = ScalarMappable(Normalize(min(factors), max(*factors, min(factors) + 1e-9)), colormaps["plasma"].with_extremes())
    for k, factor in zip(chosen, factors, strict=True):
        axes.plot(*(MM * result.pial(k)), color=colors.to_rgba(np.array(0.9 * factor + 0.1 * min(factors))), linewidth=1.1)
    _frame(axes)
    if bar:
        axes.figure.colorbar(colors, ax=axes, label="tangential growth g", shrink=0.7, pad=0.02)


def scale_bar(axes: Axes, body: Body) -> None:
    """Draw a scale bar of a round length, about a fifth of the body, below it."""
    (left, right), bottom = MM * np.array([body.nodes[0].min(), body.nodes[0].max()]), MM * body.nodes[1].min()
    if body.mirror:
        left = -right
    length = _round(0.2 * (right - left))
    y = bottom - 0.05 * (right - left)
    axes.plot([right - length, right], [y, y], color=INK, linewidth=2.5, solid_capstyle="butt", clip_on=False)
    axes.text(right - length / 2, y - 0.012 * (right - left), f"{length:g} mm", ha="center", va="top", color=INK)


def folding(figure: Figure, result: Result, *, term: Term | None = None) -> None:
    """Draw the whole story of a scene with a pattern: activator, load of `term`, outlines, folded section."""
    figure.set_size_inches(13, 5.6)
    grid = figure.add_gridspec(3 if term is not None else 2, 2, width_ratios=(1, 2.1))
    left = iter(range(3))
    pattern_axes = figure.add_subplot(grid[next(left), 0])
    activator(pattern_axes, result)
    titles = [(pattern_axes, "activator on the cortical band")]
    if term is not None:
        load_axes = figure.add_subplot(grid[next(left), 0])
        load_arrows(load_axes, result.scene, result.last, term)
        titles.append((load_axes, "tension, as force on the tissue"))
    time_axes = figure.add_subplot(grid[next(left), 0])
    pial_history(time_axes, result)
    titles.append((time_axes, "pial surface while it grows"))
    main = figure.add_subplot(grid[:, 1])
    section(main, result)
    outline(main, result.scene.body)
    main.legend(loc="lower left", frameon=False, bbox_to_anchor=(0.0, -0.02))
    titles.append((main, measures(result)))
    for letter, (axes, title) in zip("abcd", titles, strict=False):
        axes.set_title(f"{letter}   {title}", loc="left", fontsize=10)


def measures(result: Result) -> str:
    """Return growth, sulci, gyrification index and registration as one line."""
    s = result.summary()
    words = [
        f"growth {s['growth']:.2f}", f"{s['folds']} sulci", f"gyrification index {s['gyrification_index']:.2f}",
    ]  # fmt: skip
    return ", ".join(words if s["registration"] is None else [*words, f"registration {s['registration']:+.2f}"])


def _copies(body: Body, points: Array) -> Iterator[Array]:
    """Yield points or vectors (2, n), and for a half body their mirror image about x = 0."""
    yield points
    if body.mirror:
        yield points * np.array([[-1.0], [1.0]])


def _shaded(axes: Axes, points: Array, body: Body, layer: Any, values: Array, norm: Any, shades: str) -> Any:
    nodes, local = np.unique(body.triangles[:, layer], return_inverse=True)
    corners = local.reshape(6, -1)[PARTS].transpose(0, 2, 1).reshape(-1, 3)
    x, y = MM * points[:, nodes]
    return axes.tripcolor(x, y, corners, values[nodes], shading="gouraud", norm=norm, cmap=shades)


def _at_nodes(body: Body, values: Array, layer: Any) -> Array:
    """Return values (q, e) at the nodes (n,) of a layer: linear in each triangle, then averaged at the nodes."""
    at_points = BARYCENTRIC @ body.quadrature.shapes
    extrapolated = BARYCENTRIC.T @ np.linalg.lstsq(at_points.T, values[:, layer], rcond=None)[0]
    nodes, n = body.triangles[:, layer].ravel(), body.nodes.shape[1]
    count = np.bincount(nodes, minlength=n)
    return np.asarray(np.bincount(nodes, extrapolated.ravel(), minlength=n) / np.maximum(count, 1))


def _limits(values: Array, weights: Array, *, centred: bool) -> tuple[float, float]:
    order = np.argsort(values, axis=None)
    share = np.cumsum(weights.ravel()[order]) / weights.sum()
    low, high = (float(values.ravel()[order][min(np.searchsorted(share, s), share.size - 1)]) for s in (0.01, 0.99))
    low = low if centred else 0.0
    return (low, high) if high > low else (low, low + max(1e-12, abs(low)))


def _per_length(points: Array, forces: Array, count: int) -> tuple[Array, Array]:
    """Return middles (2, m) of about `count` stretches of a path and the force per length on each, (2, m)."""
    steps = np.hypot(*np.diff(points))
    arc = np.concatenate([[0.0], np.cumsum(steps)])
    # middle nodes of quadratic edges carry more than corners: sum over whole edges before dividing
    edges = max(1, (len(arc) - 1) // 2 // count)
    own = np.zeros((2, (len(arc) - 1) // 2))
    own += forces[:, 1::2]
    share = forces[:, 0::2] * np.where(np.isin(np.arange(forces[:, 0::2].shape[1]), (0, own.shape[1])), 1.0, 0.5)
    own += share[:, :-1] + share[:, 1:]
    cut = np.arange(0, own.shape[1], edges)
    total, length = np.add.reduceat(own, cut, axis=1), np.add.reduceat(np.diff(arc[::2]), cut)
    middle = np.interp(arc[::2][cut] + length / 2, arc, points[0]), np.interp(
        arc[::2][cut] + length / 2, arc, points[1]
    )
    return np.array(middle), total / length


def _core(axes: Axes, points: Array, body: Body) -> None:
    path = np.concatenate([body.pial, _closing(body)])
    axes.fill(*(MM * points[:, path]), color=CORE, linewidth=0)


def _edge(axes: Axes, points: Array, body: Body) -> None:
    axes.plot(*(MM * points[:, body.pial]), color=INK, linewidth=0.8)
    closing = _closing(body)
    if closing.size and not body.mirror:
        axes.plot(*(MM * points[:, closing]), color=INK, linewidth=0.8)


def _closing(body: Body) -> Integers:
    """Return the nodes of the base, from the end of the pial surface back to its start."""
    if body.pial_curve.closed or "base" not in (body.mesh.boundaries or {}):
        return np.zeros(0, dtype=np.int64)
    base = body.boundary_path("base")[0]
    return base if base[0] == body.pial[-1] else base[::-1] if base[-1] == body.pial[-1] else base


def _frame(axes: Axes) -> None:
    axes.set_aspect("equal")
    axes.set_axis_off()


def _round(length: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten up to `length`."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(m for m in (1, 2, 5) if m * power <= length * (1 + 1e-9)) * power)
