"""A result as a notebook shows it: the folded body as an SVG picture beside its numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from typing import Any

import numpy as np

from ..arrays import Array, Integers
from ..geometry.body import Body
from ..state import State
from .units import length_unit, with_error

WIDTH = 360  # of the picture, px
MARGIN = 0.02  # of its width
CORE, CORTEX, INK = "#f3e9dc", "#b9887f", "#3b2626"


def as_html(
    body: Body, state: State, s: Mapping[str, Any], end: str, error: Callable[[str], float | None]
) -> str:
    """Return the picture of a state, and the numbers of its summary.

    end: how the run ended, in words.  error: of a number, by name; None where nothing tells it.
    """
    unit, word = length_unit(body)
    off = error("sulcal_depth")
    depth = with_error(s["sulcal_depth"] / unit, None if off is None else off / unit)
    depth = f"{depth} {word}" if s["folds"] else "-"
    rows = {
        "run": f"{end}, in {s['seconds']:.3g} s and {s['steps']} steps",
        "growth": f"{s['growth']:.3f}",
        "sulci": f"{s['folds']}, {depth} deep",
        "gyrification index": with_error(s["gyrification_index"], error("gyrification_index")),
        "registration": "no pattern" if s["registration"] is None else f"{s['registration']:+.2f}",
        "area over that at rest": f"{s['area_growth']:.3f}",
        "smallest J*": "-" if s["min_jacobian"] is None else f"{s['min_jacobian']:.3f}",
        "unknowns": f"{s['dofs']}, {s['elements_through_cortex']:g} elements through the cortex",
    }
    if s["message"]:
        rows["message"] = s["message"]
    cells = "".join(f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in rows.items())
    return f"<div>{picture(body, state['displacement'])}<table>{cells}</table></div>"


def picture(body: Body, displacement: Array) -> str:
    """Return the deformed body as SVG, cortex and core, with the outline at rest dotted."""
    places = [body.nodes + displacement, body.nodes]
    if body.mirror:
        places = [np.concatenate([x, x * np.array([[-1.0], [1.0]])], axis=1) for x in places]
    low, high = (end([end(x, axis=1) for x in places], axis=0) for end in (np.min, np.max))
    scale = WIDTH * (1 - 2 * MARGIN) / float(high[0] - low[0])
    height = scale * float(high[1] - low[1]) + 2 * MARGIN * WIDTH
    moved, rest = (
        MARGIN * WIDTH + scale * np.stack([x[0] - low[0], high[1] - x[1]]) for x in places
    )  # y points down
    every, sides = body.triangles, (0, body.nodes.shape[1]) if body.mirror else (0,)
    parts = [(every[:, ~body.in_cortex], moved, f'fill="{CORE}"')]
    parts += [(every[:, body.in_cortex], moved, f'fill="{CORTEX}"')]
    parts += [(every, moved, f'fill="none" stroke="{INK}"')]
    parts += [(every, rest, f'fill="none" stroke="{INK}" stroke-width="0.6" stroke-dasharray="1 3"')]
    paths = "".join(
        f'<path fill-rule="evenodd" {style} d="{_loops(triangles, x[:, first:])}"/>'
        for triangles, x, style in parts
        for first in sides
    )
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height:.0f}">{paths}</svg>'


def _loops(triangles: Integers, points: Array) -> str:
    """Return the boundary of quadratic triangles (6, e) as the data of an SVG path."""
    a, b, c, ab, bc, ac = triangles
    edges = np.concatenate([[a, ab, b], [b, bc, c], [c, ac, a]], axis=1)
    middles, count = np.unique(edges[1], return_counts=True)
    outer = edges[:, np.isin(edges[1], middles[count == 1])]
    onward: dict[int, list[tuple[int, int]]] = {}
    for start, middle, end in outer.T.tolist():
        onward.setdefault(start, []).append((middle, end))
    words = []
    while onward:
        node = next(iter(onward))
        loop = [node]
        while node in onward:
            middle, end = onward[node].pop()
            if not onward[node]:
                del onward[node]
            loop += [middle, end]
            node = end
        words.append("M" + "L".join(f"{x:.1f},{y:.1f}" for x, y in points[:, loop[:-1]].T) + "Z")
    return "".join(words)
