"""The pial surface of a body; that of a half body is completed by its mirror image."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, Integers
from ..geometry.body import Body
from ..morphometry.polyline import InnerWall, enclosed_area


def along_pial(body: Body, values: Array) -> Array:
    """Return values (n,) or points (2, n) along the pial surface; a half body's with their mirror image.

    The body is on the left of the points. Where they run clockwise it lies outside: they are an `InnerWall`.
    """
    found = _completed(body, values)
    return facing(found) if found.ndim == 2 else found


def facing(points: Array) -> Array:
    """Return points (2, n) with the body on their left, as an `InnerWall` where they run clockwise."""
    return points.view(InnerWall) if enclosed_area(points) < 0 else points


def _completed(body: Body, values: Array) -> Array:
    if not body.mirror:
        return values
    line, first, last = _mirror(body)
    image = values[..., ::-1].copy()
    if values.ndim == 2:
        image[0] = 2 * line - image[0]
    # a point on the mirror is its own image
    if last:
        return np.concatenate([values, image[..., 1 : image.shape[-1] - first]], axis=-1)
    return np.concatenate([image[..., : image.shape[-1] - first], values], axis=-1)


def pial_closed(body: Body) -> bool:
    """Return whether the pial surface, completed by its image, is closed."""
    return all(_mirror(body)[1:]) if body.mirror else body.pial_curve.closed


def mirror_line(body: Body) -> float:
    """Return x of a half body's mirror; m."""
    return float(body.nodes[0, body.boundary_path("mirror")[0][0]])


def outer_ends(body: Body) -> Integers:
    """Return the nodes, (1 or 2,), at which an open pial surface ends that is completed by its image."""
    ends = body.pial[[0, -1]]
    return ends[~np.array(_mirror(body)[1:])] if body.mirror else ends


def _mirror(body: Body) -> tuple[float, bool, bool]:
    """Return x of the mirror, and whether the pial surface starts and ends on it."""
    line = mirror_line(body)
    first, last = np.abs(body.nodes[0, body.pial[[0, -1]]] - line) <= 1e-9 * body.length
    return line, bool(first), bool(last)
