"""The next stage of growth: the deformed outline, traced anew and meshed anew, free of stress."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array
from ..checks import positive
from ..geometry.body import Body
from ..geometry.curve import Curve
from ..geometry.polygon import inside
from ..state import State
from .build import outline

SAMPLES = 10.0  # points on the curve per inset
CELLS = 3.0  # grid cells per inset


def retraced(body: Body, state: State, *, size: float, inset: float) -> Body:
    """Return the inside of the deformed pial surface, meshed anew: the next stage's start, without stress.

    The new surface runs `inset` (m) inside the old one, as if traced on an image whose pixels are twice as
    wide: walls of sulci that touch stand 2·inset apart again, and creases become round. Area shrinks by inset
    times perimeter. The cortex has its nominal thickness again; depth and tangents follow the new shape.
    size: element edge in the cortex, m.
    Raises ValueError for an open pial surface, and where the new outline cannot be meshed.
    """
    positive("inset", inset, at_most=0.5 * body.thickness, remedy="it must be small against the cortex")
    if not body.pial_curve.closed:
        raise ValueError("only a closed pial surface can be traced anew; use restart(body, state).")
    moved = Curve((body.nodes + state["displacement"])[:, body.pial], closed=True)
    traced = _inside_by(moved, inset)
    return outline(
        traced, thickness=body.thickness, size=size, smooth=inset, tight="trim", layers=body.layers
    )


def _inside_by(curve: Curve, inset: float) -> Array:
    """Return the longest line at the distance `inset` inside a closed curve, (2, n).

    It is a contour of the distance on a grid, put in place exactly; unlike the offset of a spline it does not
    mind creases and touching walls.
    """
    from contourpy import contour_generator  # comes with matplotlib

    start, middle, end = curve.segments
    count = int(np.ceil(SAMPLES * curve.length / inset / start.shape[1]))
    xi = np.linspace(-1.0, 1.0, count, endpoint=False)
    shapes = np.stack([0.5 * xi * (xi - 1), 1 - xi**2, 0.5 * xi * (xi + 1)])
    loop = np.einsum("kim,kx->imx", np.stack([start, middle, end]), shapes).reshape(2, -1)
    tree = cKDTree(loop.T)
    x, y = (np.arange(a.min(), a.max(), inset / CELLS) for a in loop)
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    distance = np.asarray(tree.query(grid.reshape(-1, 2), distance_upper_bound=2 * inset)[0])
    field = np.minimum(distance, 2 * inset).reshape(grid.shape[:2])
    lines = contour_generator(x, y, field).lines(inset)
    within = [np.asarray(line).T for line in lines if inside(np.asarray(line)[:1].T, loop)[0]]
    if not within:
        raise ValueError(f"inset={inset:g} m leaves nothing of the body; use a smaller one.")
    found = max(within, key=lambda line: float(np.hypot(*np.diff(line, axis=1)).sum()))
    away, foot = tree.query(found.T)
    return np.asarray(loop[:, foot] + inset * (found - loop[:, foot]) / away)
