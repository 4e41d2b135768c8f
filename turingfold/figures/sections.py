"""Pictures of a result, each a function of the Axes it draws on; lengths in mm, stresses in kPa.

Bodies and moduli that are numbers in units of their own are shown in these: see `results.length_unit` and
`results.stress_unit`.

The colours can be told apart by the colour-blind: viridis for quantities, Okabe and Ito's for the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..checks import one_of
from ..geometry.body import Body
from ..growth.measure import largest_growth
from ..parts import Load, Term, TimeStep
from ..results.result import Result, along_pial, pial_closed
from ..results.units import length_unit, stress_unit, with_error
from ..scene import Scene
from ..state import State
from .style import (
    INK,
    MM,
    around,
    at_nodes,
    colour_limits,
    copies,
    core,
    edge,
    frame,
    inside,
    per_length,
    pial_lines,
    round_length,
    shaded,
    shown,
    sulci,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure


VERMILION = "#d55e00"
FIELDS = {"von_mises": "von Mises stress", "pressure": "pressure", "jacobian": "elastic volume ratio J*"}


def section(
    axes: Axes, result: Result, step: int = -1, *, field: str = "von_mises", bar: bool = True,
    limits: tuple[float, float] | None = None,
) -> ScalarMappable:  # fmt: skip
    """Draw the deformed body coloured by a field, with colour bar and scale bar; return what has the colours.

    field: "von_mises", "pressure" or "jacobian".  limits: of the colours, by default up to the value that is
    exceeded in 1 % of the area, so that a few points do not hide the rest.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    one_of("field", field, tuple(FIELDS))
    body, state = result.scene.body, result.states[step]
    unit, label = _unit(result.scene, field)
    values = result.observe(step)[field] / unit
    low, high = limits or field_limits(result, step, field=field)
    colors = ScalarMappable(Normalize(low, high), "viridis" if field == "von_mises" else "cividis")
    for points in copies(body, body.nodes + state["displacement"]):
        for layer in (body.in_cortex, ~body.in_cortex):
            if layer.any():
                shaded(axes, points, body, layer, at_nodes(body, values, layer), colors)
        for path in body.interface_paths:
            axes.plot(*(MM * around(points[:, path.nodes])), color="white", linewidth=0.6, alpha=0.8)
        edge(axes, points, body)
    frame(axes)
    lowest = min(float((body.nodes[1] + one["displacement"][1]).min()) for one in result.states)
    scale_bar(axes, body, lowest)  # below every state: it keeps its place in a film
    if bar:
        beyond = "max" if field == "von_mises" else "both"
        axes.figure.colorbar(colors, ax=axes, label=label, shrink=0.7, pad=0.02, extend=beyond)
    return colors


def field_limits(result: Result, step: int = -1, *, field: str = "von_mises") -> tuple[float, float]:
    """Return the limits of colours that show a field of a state; see `section`."""
    values = result.observe(step)[field] / _unit(result.scene, field)[0]
    return colour_limits(values, result.scene.body.quadrature.weights, centred=field != "von_mises")


def outline(axes: Axes, body: Body, *, color: str = "white", label: str = "before folding") -> None:
    """Draw the undeformed outline, dashed; it shows on light and on dark."""
    from matplotlib.patheffects import withStroke

    parts = [body.nodes[:, path.nodes] for path in body.pial_paths]
    halo = [withStroke(linewidth=2.4, foreground=INK)]
    for part in [along_pial(body, parts[0])] if len(parts) == 1 else parts:
        axes.plot(
            *(MM * around(part)), color=color, linewidth=1.2, linestyle=(0, (4, 3)), label=label,
            path_effects=halo,
        )  # fmt: skip
        label = "_"


def activator(axes: Axes, result: Result, *, bar: bool = True) -> None:
    """Draw the activator, from 0 to 1, on the band of the undeformed body."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    body = result.scene.body
    colors = ScalarMappable(Normalize(0, 1), "viridis")
    pattern = body.spread(body.cortex, result.last["pattern"], outside=0.0)
    for points in copies(body, body.nodes):
        core(axes, points, body)
        shaded(axes, points, body, body.in_cortex, pattern, colors)
        edge(axes, points, body)
    frame(axes)
    if bar:
        _bar_inside(axes, body, colors, "activator û", [0, 0.5, 1])


def peaks(axes: Axes, result: Result, step: int = -1) -> None:
    """Mark the peaks of the activator, if there is one, as dots on the deformed pial surface."""
    pattern = result.pattern(step)
    if pattern is None:
        return
    before, after = (pattern[-1], pattern[0]) if pial_closed(result.scene.body) else (-np.inf, -np.inf)
    beside = np.concatenate([[before], pattern, [after]])
    high = pattern > max(0.5 * pattern.max(), 0.05)  # one that has died has none
    top = np.flatnonzero(high & (pattern >= beside[:-2]) & (pattern > beside[2:]))
    x, y = MM * result.pial(step)[:, top]
    axes.plot(x, y, "o", color=VERMILION, markeredgecolor="white", markersize=5, label="activator peaks")


def load_arrows(
    axes: Axes, scene: Scene, state: State, term: Term, *, count: int = 96, share: float = 1.0
) -> None:
    """Draw the load of a term at the end of the scene on the undeformed body, as about `count` arrows.

    The load is a force per area of the curve it acts on, in N/m² or in units of the moduli; forces at an open
    curve's ends are left out.
    share: of the body's width that is shown, around the apex.
    Raises ValueError for a term without load.
    """
    body, forces = scene.body, _load(scene, state, term)
    if forces is None:
        raise ValueError(f"{type(term).__name__} has no load to draw at the end of the scene.")
    path = max(body.interface, body.pial, key=lambda nodes: float(np.abs(forces[:, nodes]).sum()))
    start, load = per_length(body.nodes[:, path], forces[:, path], count)
    width, top = np.ptp(body.nodes[0]) * (2 if body.mirror else 1), body.nodes[1].max()
    length = 1.6 * np.hypot(*np.diff(start)).mean() / np.hypot(*load).max()
    for points, origin, arrow in zip(*(copies(body, v) for v in (body.nodes, start, load)), strict=True):
        core(axes, points, body)
        edge(axes, points, body)
        axes.plot(*(MM * around(points[:, body.interface])), color="#999999", linewidth=0.8)
        axes.quiver(
            *(MM * origin), *(MM * length * arrow), angles="xy", scale_units="xy", scale=1, pivot="mid",
            color=VERMILION, width=0.006, headwidth=4, headlength=4, headaxislength=3.5, zorder=3,
        )  # fmt: skip
    frame(axes)
    middle, low = inside(body)
    if share < 1:
        axes.set_xlim(middle - MM * share * width / 2, middle + MM * share * width / 2)
        axes.set_ylim(MM * (top - 0.47 * share * width), MM * (top + 0.03 * share * width))
        low = MM * (top - 0.3 * share * width)
    largest = f"largest {shown(np.hypot(*load).max())}" + (" N/m²" if stress_unit(scene)[1] else "")
    axes.text(middle, low, largest, color=VERMILION, ha="center", va="center")


def pial_history(axes: Axes, result: Result, *, count: int = 8, bar: bool = True) -> None:
    """Draw the pial surface at `count` evenly spaced times, coloured by growth."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    body, times = result.scene.body, np.array([state.time for state in result.states])
    wanted = np.linspace(times[0], times[-1], count)
    chosen = sorted({int(np.abs(times - time).argmin()) for time in wanted})
    factors = [largest_growth(result.states[k]) for k in chosen]
    colors = ScalarMappable(Normalize(min(factors), max(*factors, min(factors) + 1e-9)), "viridis_r")
    for k, factor in zip(chosen, factors, strict=True):
        points = body.nodes + result.states[k]["displacement"]
        for pial in pial_lines(body, points):
            axes.plot(*(MM * pial), color=colors.to_rgba(np.array(factor)), linewidth=0.9)
    frame(axes)
    if bar:
        _bar_inside(axes, body, colors, "tangential growth", [min(factors), max(factors)])


def section_grid(
    figure: Figure, rows: int, columns: int, results: Mapping[str, Result]
) -> Iterator[tuple[Axes, str, Result]]:
    """Draw the deformed bodies of several results in a grid, with the same colours, and yield each panel.

    The panel still lacks its title. One colour bar, of the von Mises stress, serves all.
    """
    grid = figure.subplots(rows, columns, squeeze=False)
    limits = 0.0, max(field_limits(result)[1] for result in results.values())
    for axes, (name, result) in zip(grid.ravel(), results.items(), strict=True):
        colors = section(axes, result, bar=False, limits=limits)
        outline(axes, result.scene.body)
        peaks(axes, result)
        yield axes, name, result
    handles = dict(zip(*reversed(grid.flat[0].get_legend_handles_labels()), strict=True))
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2, frameon=False)
    label = _unit(result.scene, "von_mises")[1]
    figure.colorbar(colors, ax=grid, label=label, shrink=0.4, aspect=30, extend="max")


def scale_bar(axes: Axes, body: Body, lowest: float | None = None) -> None:
    """Draw a scale bar of a round length, about a fifth of the body, below it; see `results.length_unit`.

    lowest: y of what is drawn, m; by default of the undeformed body.
    """
    x, y = MM * body.nodes
    right, width = x.max(), np.ptp(x) * (2 if body.mirror else 1)
    unit, name = length_unit(body)
    number = round_length(0.2 * width / (MM * unit))
    length, level = number * MM * unit, (y.min() if lowest is None else MM * lowest) - 0.05 * width
    axes.plot([right - length, right], [level, level], color=INK, linewidth=2.5, solid_capstyle="butt")
    axes.text(
        right - length / 2, level - 0.012 * width, f"{number:g} {name}", ha="center", va="top", color=INK
    )


def folding(figure: Figure, result: Result, *, term: Term | None = None) -> None:
    """Draw the whole story of a scene: activator, load of `term`, outlines, folded section.

    term: by default the first load of the scene.  The panels of the activator and of the load are left out
    where there is none.
    """
    scene, state = result.scene, result.last
    term = term or next((own for own in scene.terms if isinstance(own, Load)), None)
    story: dict[str, Callable[[Axes], None]] = {}
    if "pattern" in state:
        story["activator on the cortical band"] = lambda axes: activator(axes, result)
    if term is not None and _load(scene, state, term) is not None:
        story["load of the tension, enlarged"] = partial(
            load_arrows, scene=scene, state=state, term=term, share=0.45
        )
    story["pial surface over time"] = lambda axes: pial_history(axes, result)
    figure.set_size_inches(13, 6)
    grid = figure.add_gridspec(len(story), 2, width_ratios=(1, 2))
    small, main = [figure.add_subplot(grid[k, 0]) for k in range(len(story))], figure.add_subplot(grid[:, 1])
    for axes, draw in zip(small, story.values(), strict=True):
        draw(axes)
    section(main, result)
    outline(main, scene.body)
    peaks(main, result)
    main.legend(loc="lower left", frameon=False, bbox_to_anchor=(0.0, 0.0))
    if "pattern" in state:
        small[0].sharex(small[-1])
    titles = *story, f"{measures(result)}\n{areas(result)}"
    for letter, title, axes in zip("abcd", titles, [*small, main], strict=False):
        axes.set_title(f"$\\bf{{{letter}}}$   {title}", loc="left", fontsize=11)


def measures(result: Result) -> str:
    """Return growth, sulci, gyrification index and registration as one line; first, where a run stopped."""
    s = result.summary()
    words = [word for word in (result.unfinished, result.label()) if word]
    words += [f"growth {s['growth']:.2f}", sulci(s["folds"])]
    index = with_error(s["gyrification_index"], result.error("gyrification_index"))
    words.append(f"gyrification index {index}")
    if s["registration"] is not None:
        words.append(f"registration {s['registration']:+.2f}")
    return ", ".join(words)


def areas(result: Result) -> str:
    """Return how many times as large the whole, cortex, core and centre have become, as one line."""
    s, names = result.summary(), ("area", "cortex", "core", "centre")
    grown = {name: s[f"{name}_growth"] for name in names}
    return ", ".join(f"{name} {value:.2f}-fold" for name, value in grown.items() if value is not None)


def _load(scene: Scene, state: State, term: Term) -> Array | None:
    """Return the forces of a term on the undeformed body at the end of the scene, (2, n), if any."""
    if not all(name in state for name in term.reads):
        return None
    potential = term.on(scene.body).during(State(scene.until, state.fields), TimeStep(scene.until))
    at = potential.evaluate(np.zeros(scene.body.nodes.size)) if potential is not None else None
    if at is None:
        return None
    forces = -at.gradient()[0].reshape(-1, 2).T
    return forces if forces.any() else None


def _unit(scene: Scene, field: str) -> tuple[float, str]:
    """Return the unit that a field is shown in, and its label."""
    if field == "jacobian":
        return 1.0, FIELDS[field]
    unit, name = stress_unit(scene)
    return unit, f"{FIELDS[field]} ({name})" if name else f"{FIELDS[field]} (in units of the moduli)"


def _bar_inside(axes: Axes, body: Body, colors: ScalarMappable, label: str, ticks: list[float]) -> None:
    below = len(body.pial_paths) > 1 or pial_closed(body)
    level = 0.54 if below else 0.4  # clear of the sulci from below
    bar = axes.inset_axes((0.32, level, 0.36, 0.06))
    axes.figure.colorbar(colors, cax=bar, orientation="horizontal", ticks=ticks, label=label, format="%.3g")
