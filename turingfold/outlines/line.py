"""Points along a smooth curve: the spline through measured points, with or without smoothing."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from ..arrays import Array
from .region import along

FINER = 32  # points of a line per step: so many that the chord between two is the curve
LEFT = 0.1  # share of its length that smoothing must leave of a curve


def line(
    points: Array, closed: bool, step: float, smooth: float = 0.0, lacking: float | None = None
) -> Array:
    """Return points on the curve through points (2, n), every 32nd about `step` apart, (2, m).

    The curve is a cubic spline, after details shorter than `smooth` (m) are taken away: the evenly resampled
    points are convolved with the kernel 2g - g*g, g a Gaussian of standard deviation `smooth`, so that a
    circle of radius R shrinks by only R (smooth/R)⁴/4. The ends of an open curve stay where they are; a
    closed one does not repeat its first point.
    lacking: move a smoothed curve, counter-clockwise, along its normals until it encloses as much as before
    and so much more, m²; an open one with the chord between its ends. If None narrow sulci, which fill up
    more than wide gyri wear off, make the tissue larger.
    Raises ValueError for a `smooth` that leaves nothing of the curve.
    """
    nodes = np.concatenate([points, points[:, :1]], axis=1) if closed else points
    at = along(nodes)
    if smooth > 0:
        length, given = at[-1], at
        count = max(nodes.shape[1], int(np.ceil(4 * length / smooth)))
        at = np.linspace(0.0, length, count + 1)
        nodes = np.stack([np.interp(at, given, x) for x in nodes])
        nodes = _smoothed(nodes, closed, smooth / (length / count))
        if (left := along(nodes)[-1]) < LEFT * length:
            raise ValueError(
                f"smooth is {smooth / length:.2g} of the length of a curve, and {left / length:.2g} "
                f"of that is left; at least {LEFT:g} must stay, so make it smaller."
            )
    spline = CubicSpline(at, nodes.T, bc_type="periodic" if closed else "not-a-knot")
    dense = np.linspace(0.0, at[-1], 8 * len(at))
    arc = along(spline(dense).T)
    count = FINER * max(2, round(float(arc[-1]) / step))
    ways = np.linspace(0.0, arc[-1], count + 1)[: count if closed else count + 1]
    even = np.interp(ways, arc, dense)
    curve = np.asarray(spline(even).T)
    if smooth > 0 and lacking is not None:
        x, y = spline(even, 1).T / np.hypot(*spline(even, 1).T)
        ends = 1.0 if closed else np.minimum(ways, ways[::-1]).clip(max=2 * smooth) / (2 * smooth)
        outward = ends * np.stack([y, -x])
        curve += _widening(curve, outward, _enclosed(points, points) + lacking) * outward
    return curve


def _widening(curve: Array, outward: Array, area: float) -> float:
    """Return the d for which a curve (2, n) moved by d times `outward` (2, n) encloses an area; m.

    For polygons A(p + d v) = A(p, p) + d (A(p, v) + A(v, p)) + d² A(v, v), A the bilinear form of the area.
    """
    more = area - _enclosed(curve, curve)
    slope = _enclosed(curve, outward) + _enclosed(outward, curve)
    root = np.sqrt(max(0.0, slope**2 + 4 * _enclosed(outward, outward) * more))
    return float(np.float32(2 * more / (slope + root)))  # free of the round-off of sums


def _enclosed(a: Array, b: Array) -> float:
    """Return ½ ∮ a × db, of polygons (2, n); with a = b what they enclose counter-clockwise."""
    return 0.5 * float(np.sum(a[0] * np.roll(b[1], -1) - a[1] * np.roll(b[0], -1)))


def _smoothed(nodes: Array, closed: bool, width: float) -> Array:
    """Filter evenly spaced nodes (2, n + 1); width: the Gaussian's standard deviation in steps."""
    ends = nodes[:, :1], nodes[:, -1:]
    if closed:
        loop = nodes[:, :-1]
    else:  # odd reflection about both ends keeps them in place
        straight = np.linspace(0.0, 1.0, nodes.shape[1]) * (ends[1] - ends[0]) + ends[0]
        bent = nodes - straight
        loop = np.concatenate([bent[:, :-1], -bent[:, :0:-1]], axis=1)
    wave = 2 * np.pi * np.fft.rfftfreq(loop.shape[1])
    kept = 1.0 - (1.0 - np.exp(-0.5 * (width * wave) ** 2)) ** 2
    loop = np.fft.irfft(np.fft.rfft(loop) * kept, loop.shape[1])
    return np.concatenate([loop, loop[:, :1]], axis=1) if closed else loop[:, : nodes.shape[1]] + straight
