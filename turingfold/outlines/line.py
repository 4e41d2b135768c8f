"""A smooth curve by arc length: the spline through measured points, with or without smoothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from ..arrays import Array

LEFT = 0.1  # share of its length that smoothing must leave of a curve


@dataclass(frozen=True, eq=False)
class Line:
    """A cubic spline over its arc length s in [0, length]; m."""

    spline: CubicSpline
    length: float
    closed: bool

    def at(self, s: Array) -> Array:
        """Return the points (2, n) at arc lengths s (n,)."""
        return np.asarray(self.spline(s % self.length if self.closed else s)).T

    def spaced(self, step: float) -> Array:
        """Return evenly spaced arc lengths about `step` apart; those of a closed line leave out its end."""
        count = max(2, round(self.length / step))
        return (
            np.linspace(0.0, self.length, count, endpoint=False)
            if self.closed
            else np.linspace(0.0, self.length, count + 1)
        )


def line(points: Array, closed: bool, smooth: float = 0.0) -> Line:
    """Return the curve through points (2, n), after taking away details shorter than `smooth` (m).

    Smoothing convolves the evenly resampled points with the kernel 2g - g*g, g a Gaussian of standard
    deviation `smooth`: a circle of radius R shrinks by only R (smooth/R)⁴/4. The ends of an open curve stay
    where they are.
    Raises ValueError for a `smooth` that leaves nothing of the curve.
    """
    nodes = np.concatenate([points, points[:, :1]], axis=1) if closed else points
    chord = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(nodes, axis=1)))])
    if smooth > 0:
        count = max(nodes.shape[1], int(np.ceil(4 * chord[-1] / smooth)))
        even = np.linspace(0.0, chord[-1], count + 1)
        nodes = np.stack([np.interp(even, chord, x) for x in nodes])
        nodes = _smoothed(nodes, closed, smooth / (chord[-1] / count))
        left = float(np.hypot(*np.diff(nodes, axis=1)).sum())
        if left < LEFT * chord[-1]:
            raise ValueError(
                f"smooth={smooth:g} m leaves {left / chord[-1]:.2g} of the length {chord[-1]:.4g} m of the "
                f"pial surface; at least {LEFT:g} must stay, so make it smaller."
            )
        chord = even
    by_chord = _spline(chord, nodes, closed)
    # once more over the arc length of the first spline
    fine = np.linspace(0.0, chord[-1], 8 * len(chord))
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(by_chord(fine).T)))])
    at = np.interp(np.linspace(0.0, arc[-1], 4 * len(chord)), arc, fine)
    along = np.linspace(0.0, arc[-1], 4 * len(chord))
    return Line(_spline(along, by_chord(at).T, closed), float(arc[-1]), closed)


def _spline(over: Array, nodes: Array, closed: bool) -> CubicSpline:
    if closed:
        nodes = nodes.copy()
        nodes[:, -1] = nodes[:, 0]
    return CubicSpline(over, nodes.T, bc_type="periodic" if closed else "not-a-knot")


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
