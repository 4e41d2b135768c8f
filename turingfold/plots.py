"""Pictures of a result, each a function of the Axes it draws on; lengths in mm, stresses in kPa.

The colours can be told apart by the colour-blind: viridis for quantities, Okabe and Ito's for the rest.
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
    """Draw the deformed body coloured by a field, with colour bar and scale bar; return what has the colours.

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


def outline(axes: Axes, body: Body, *, color: str = INK, label: str = "before folding") -> None:
    """Draw the undeformed outline, dashed."""
    points = MM * along_pial(body, body.nodes[:, body.pial])
    axes.plot(*points, color=color, linewidth=1.1, linestyle=(0, (4, 3)), label=label)


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
        _bar_inside(axes, mapped, "activator û", [0, 0.5, 1])


def load_arrows(
    axes: Axes, scene: Scene, state: State, term: Term, *, count: int = 96, share: float = 1.0
) -> None:
    """Draw the load of a term at the end of the scene on the undeformed body, as about `count` arrows.

    The load is a force per area of the curve it acts on, N/m²; forces at the curve's ends are left out.
    share: of the body's width that is shown, around the apex.
    """
    body = scene.body
    potential = term.on(body).during(State(scene.until, state.fields), scene.until)
    at = potential.evaluate(np.zeros(body.nodes.size)) if potential is not None else None
    if at is None:
        raise ValueError(f"{type(term).__name__} has no load to draw at the end of the scene.")
    forces = -at.gradient()[0].reshape(-1, 2).T
    path = max(body.interface, body.pial, key=lambda nodes: float(np.abs(forces[:, nodes]).sum()))
    start, load = _per_length(body.nodes[:, path], forces[:, path], count)
    width, top = np.ptp(body.nodes[0]) * (2 if body.mirror else 1), body.nodes[1].max()
    length = 1.6 * np.hypot(*np.diff(start)).mean() / np.hypot(*load).max()
    for points, origin, arrow in zip(*(_copies(body, v) for v in (body.nodes, start, load)), strict=True):
        _core(axes, points, body)
        _edge(axes, points, body)
        axes.plot(*(MM * points[:, body.interface]), color="#999999", linewidth=0.8)
        axes.quiver(
            *(MM * origin), *(MM * length * arrow), angles="xy", scale_units="xy", scale=1, pivot="mid",
            color=VERMILION, width=0.006, headwidth=4, headlength=4, headaxislength=3.5, zorder=3,
        )  # fmt: skip
    _frame(axes)
    middle, low = _inside(body)
    if share < 1:
        axes.set_xlim(middle - MM * share * width / 2, middle + MM * share * width / 2)
        axes.set_ylim(MM * (top - 0.47 * share * width), MM * (top + 0.03 * share * width))
        low = MM * (top - 0.3 * share * width)
    largest = f"largest {_shown(np.hypot(*load).max())} N/m²"
    axes.text(middle, low, largest, color=VERMILION, ha="center", va="center")


def pial_history(axes: Axes, result: Result, *, count: int = 8, bar: bool = True) -> None:
    """Draw the pial surface at `count` evenly spaced times, coloured by growth."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    times = np.array([state.time for state in result.states])
    wanted = np.linspace(times[0], times[-1], count)
    chosen = sorted({int(np.abs(times - time).argmin()) for time in wanted})
    factors = [growth(result.states[k]) for k in chosen]
    colors = ScalarMappable(Normalize(min(factors), max(*factors, min(factors) + 1e-9)), "viridis_r")
    for k, factor in zip(chosen, factors, strict=True):
        axes.plot(*(MM * result.pial(k)), color=colors.to_rgba(np.array(factor)), linewidth=0.9)
    _frame(axes)
    if bar:
        _bar_inside(axes, colors, "tangential growth", [min(factors), max(factors)])


def scale_bar(axes: Axes, body: Body) -> None:
    """Draw a scale bar of a round length, about a fifth of the body, below it."""
    x, y = MM * body.nodes
    right, width = x.max(), np.ptp(x) * (2 if body.mirror else 1)
    length, level = _round(0.2 * width), y.min() - 0.05 * width
    axes.plot([right - length, right], [level, level], color=INK, linewidth=2.5, solid_capstyle="butt")
    axes.text(right - length / 2, level - 0.012 * width, f"{length:g} mm", ha="center", va="top", color=INK)


def folding(figure: Figure, result: Result, *, term: Term) -> None:
    """Draw the whole story of a scene with a pattern: activator, load of `term`, outlines, folded section."""
    figure.set_size_inches(13, 6)
    grid = figure.add_gridspec(3, 2, width_ratios=(1, 2))
    small, main = [figure.add_subplot(grid[k, 0]) for k in range(3)], figure.add_subplot(grid[:, 1])
    activator(small[0], result)
    load_arrows(small[1], result.scene, result.last, term, share=0.45)
    pial_history(small[2], result)
    section(main, result)
    outline(main, result.scene.body)
    main.legend(loc="lower left", frameon=False, bbox_to_anchor=(0.0, 0.02))
    small[0].sharex(small[2])
    titles = ("activator on the cortical band", "load of the tension, enlarged", "pial surface over time")
    for letter, title, axes in zip("abcd", [*titles, measures(result)], [*small, main], strict=True):
        axes.set_title(f"$\\bf{{{letter}}}$   {title}", loc="left", fontsize=11)


def measures(result: Result) -> str:
    """Return growth, sulci, gyrification index and registration as one line."""
    s = result.summary()
    words = [f"growth {s['growth']:.2f}", f"{s['folds']} sulci"]
    words.append(f"gyrification index {s['gyrification_index']:.2f}")
    if s["registration"] is not None:
        words.append(f"registration {s['registration']:+.2f}")
    return ", ".join(words)


def _inside(body: Body) -> tuple[float, float]:
    """Return a point in the middle of the body, where there is room for text; mm."""
    x, y = body.nodes
    middle = 0.0 if body.mirror else 0.5 * (x.min() + x.max())
    return MM * middle, MM * (y.min() + 0.4 * np.ptp(y))


def _bar_inside(axes: Axes, mapped: Any, label: str, ticks: list[float]) -> None:
    bar = axes.inset_axes((0.32, 0.32, 0.36, 0.06))
    axes.figure.colorbar(mapped, cax=bar, orientation="horizontal", ticks=ticks, label=label, format="%.3g")


def _copies(body: Body, points: Array) -> Iterator[Array]:
    """Yield points or vectors (2, n), and for a half body their mirror image about x = 0."""
    yield points
    if body.mirror:
        yield points * np.array([[-1.0], [1.0]])


def _shaded(axes: Axes, points: Array, body: Body, layer: Any, values: Array, norm: Any, shades: str) -> Any:
    from matplotlib.tri import Triangulation

    nodes, local = np.unique(body.triangles[:, layer], return_inverse=True)
    corners = local.reshape(6, -1)[PARTS].transpose(0, 2, 1).reshape(-1, 3)
    x, y = MM * points[:, nodes]
    triangles = Triangulation(x, y, corners)
    return axes.tripcolor(triangles, values[nodes], shading="gouraud", norm=norm, cmap=shades)


def _at_nodes(body: Body, values: Array, layer: Any) -> Array:
    """Return values (q, e) at the nodes (n,) of a layer: linear in each triangle, averaged at nodes."""
    at_points = BARYCENTRIC @ body.quadrature.shapes
    extrapolated = BARYCENTRIC.T @ np.linalg.lstsq(at_points.T, values[:, layer], rcond=None)[0]
    nodes, n = body.triangles[:, layer].ravel(), body.nodes.shape[1]
    count = np.bincount(nodes, minlength=n)
    return np.asarray(np.bincount(nodes, extrapolated.ravel(), minlength=n) / np.maximum(count, 1))


def _limits(values: Array, weights: Array, *, centred: bool) -> tuple[float, float]:
    order = np.argsort(values, axis=None)
    share = np.cumsum(weights.ravel()[order]) / weights.sum()
    low, high = (float(np.interp(s, share, values.ravel()[order])) for s in (0.01, 0.99))
    low = low if centred else 0.0
    return (low, high) if high > low else (low, low + max(1e-12, abs(low)))


def _per_length(points: Array, forces: Array, count: int) -> tuple[Array, Array]:
    """Return middles (2, m) of about `count` stretches of a path and the force per length on each, (2, m).

    Half the force on a corner belongs to either edge; that on the two ends of the path to none.
    """
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points)))])[::2]
    corners = forces[:, ::2].copy()
    corners[:, [0, -1]] = 0.0
    on_edges = forces[:, 1::2] + 0.5 * (corners[:, :-1] + corners[:, 1:])
    cut = np.arange(0, on_edges.shape[1], max(1, round(on_edges.shape[1] / count)))
    lengths = np.add.reduceat(np.diff(arc), cut)
    middles = arc[cut] + lengths / 2
    at = np.stack([np.interp(middles, arc, coordinate[::2]) for coordinate in points])
    return at, np.add.reduceat(on_edges, cut, axis=1) / lengths


def _shown(number: float) -> str:
    """Return a number with two digits that count, without an exponent."""
    return f"{float(f'{number:.2g}'):g}"


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
