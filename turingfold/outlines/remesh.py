"""The next stage of growth: the deformed outline, traced anew and meshed anew, free of stress."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..checks import positive
from ..geometry.body import Body
from ..geometry.curve import Curve
from ..geometry.paths import Path
from ..geometry.quadratic import weights
from ..state import State
from .build import outline
from .region import even_odd, rings

SAMPLES = 10.0  # points on the curve per inset


def remeshed(body: Body, state: State, *, size: float, inset: float) -> Body:
    """Return the inside of the deformed pial surface, meshed anew: the next stage's start, without stress.

    The new surface runs `inset` (m) inside the old one, as if traced on an image whose pixels are twice as
    wide: walls of sulci that touch stand 2·inset apart again, and creases become round. Area shrinks by inset
    times perimeter. The cortex has its nominal thickness again, or where the interface was given that of the
    deformed one; depth and tangents follow the new shape.
    size: element edge in the cortex, m.
    Raises ValueError for an open pial surface, and where nothing is left.
    """
    positive("inset", inset, at_most=0.5 * body.thickness, remedy="it must be small against the cortex")
    if not all(path.closed for path in body.pial_paths):
        raise ValueError("only a closed pial surface can be meshed anew; see stress_free_restart(...).")
    moved = body.nodes + state["displacement"]

    def sampled(paths: tuple[Path, ...]) -> list[Array]:
        return [_sampled(Curve(moved[:, path.nodes], closed=True), inset / SAMPLES) for path in paths]

    traced = [ring[:, :-1] for ring in rings(even_odd(sampled(body.pial_paths)).buffer(-inset))]
    if not traced:
        raise ValueError(f"inset={inset:g} m leaves nothing of the body; use a smaller one.")
    even, walls = body.depth_by == "thickness", body.boundary_paths("hole")
    made = outline(
        traced,
        thickness=body.thickness if even else None,
        size=size,
        layers=body.layers,
        smooth=inset,
        interface=None if even else sampled(body.interface_paths),
        holes=sampled(walls),
        hole=body.hole if walls else "free",
    )
    return replace(made, thickness=body.thickness)


def _sampled(curve: Curve, step: float) -> Array:
    """Return points about a step apart on a closed curve, (2, n)."""
    count = int(np.ceil(curve.length / step / curve.segments.shape[2]))
    shapes = weights(np.linspace(0.0, 1.0, count, endpoint=False))
    return np.asarray(np.einsum("kim,kx->imx", curve.segments, shapes).reshape(2, -1))
