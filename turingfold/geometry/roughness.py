"""Seeded roughness: smooth noise along the pial surface, the same on every mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..checks import one_of, positive, whole
from .body import Body, by_node
from .mirror import FLIP, mirror_images


def noise(share: Array, modes: int, seed: int, symmetric: bool = False, closed: bool = False) -> Array:
    """Return ξ = √(2/M) Σ_m a_m cos(m π s + φ_m), of unit variance, at shares s of the arc length in [0, 1].

    a_m: standard normal.  symmetric: even modes with φ_m = 0 about s = 1/2 only.  closed: those with an even
    number of half waves, so that the noise does not jump where the surface closes.
    """
    random = np.random.default_rng(seed)
    if closed and not symmetric:
        modes = max(1, modes // 2)
    amplitude, phase = random.standard_normal(modes), random.uniform(0.0, 2 * np.pi, modes)
    order = np.arange(1, modes + 1)
    if symmetric:
        waves = np.cos(2 * np.pi * np.multiply.outer(share - 0.5, order))
    else:
        waves = np.cos((2 if closed else 1) * np.pi * np.multiply.outer(share, order) + phase)
    return np.asarray(np.sqrt(2 / modes) * waves @ amplitude)


def geometric_imperfection(
    body: Body,
    amplitude: float,
    *,
    of: str = "shape",
    modes: int = 80,
    seed: int = 0,
    symmetric: bool = False,
) -> Body:
    """Return the body with its pial surface displaced along the normal by amplitude·ξ; m.

    of "shape": the interface moves alike, and the displacement fades over two cortical thicknesses below it;
    "thickness": it fades from the pial surface to the interface, so that the cortex is thicker and thinner.
    At the base it fades to nothing.  symmetric: about the apex; a mirror-symmetric body stays so to the bit.
    Raises ValueError where it would turn triangles over: use a smaller amplitude or fewer modes there.
    """
    one_of("of", of, ("shape", "thickness"))
    positive("amplitude", amplitude, at_most=body.thickness, remedy="the most is the cortical thickness")
    whole("modes", modes, at_least=1, remedy="80 are the default")
    whole("seed", seed, at_least=0)
    depth, tangent, arc = body.pial_curve.nearest(body.nodes)
    share = body.pial_share(arc)
    normal, closed = np.stack([tangent[1], -tangent[0]]), body.pial_curve.closed
    below = (depth - body.thickness) / (2 * body.thickness) if of == "shape" else depth / body.thickness
    fade = np.clip(1.0 - below, 0.0, 1.0)
    if not closed:
        fade *= np.clip(np.minimum(share, 1.0 - share) * body.pial_curve.length / body.thickness, 0.0, 1.0)
    shift = amplitude * fade * noise(share, modes, seed, symmetric or body.mirror, closed) * normal
    moved = by_node(shift)
    moved[body.supported] = 0.0
    points = body.nodes + moved.reshape(-1, 2).T
    images = mirror_images(body) if symmetric else None
    if images is not None:  # the arc length of the foot is only known to round-off
        points = 0.5 * (points + FLIP * points[:, images])
    try:
        return replace(body, mesh=replace(body.mesh, doflocs=points))
    except ValueError as error:
        raise ValueError(
            f"amplitude={amplitude:g} m with modes={modes} turns triangles over; use a smaller amplitude or "
            f"fewer modes ({error})"
        ) from error
