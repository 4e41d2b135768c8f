"""Elliptic Fourier descriptors of outlines (Kuhl & Giardina 1982)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import whole
from .polyline import Polyline, as_polyline

ORDERS = (5, 15, 25)  # the orders of Choi et al. 2025


@dataclass(frozen=True)
class EllipticFourier:
    """x(s) = centre + sum_k matrices[k] (cos 2 pi (k+1) s, sin 2 pi (k+1) s), s the fraction of the arc.

    centre (2,) and matrices (order, 2, 2) in m; row 0 is x, row 1 is y.
    """

    centre: Array
    matrices: Array

    @property
    def order(self) -> int:
        """Number of harmonics."""
        return int(self.matrices.shape[0])

    @property
    def amplitudes(self) -> Array:
        """Amplitudes (order,) over the first: independent of place, turn, scale, direction and start."""
        amplitude = np.sqrt(np.sum(self.matrices**2, axis=(1, 2)))
        return np.asarray(amplitude / amplitude[0])

    def at(self, s: Array) -> Array:
        """Return points (2, n) at fractions s (n,) of the arc."""
        angle = 2 * np.pi * np.arange(1, self.order + 1)[:, None] * s
        waves = np.stack((np.cos(angle), np.sin(angle)), axis=1)
        return np.asarray(self.centre[:, None] + np.einsum("kij,kjn->in", self.matrices, waves))


def fourier_descriptors(points: Any, order: int, *, closed: bool | None = None) -> EllipticFourier:
    """Return the elliptic Fourier descriptors of the polyline, exactly integrated, up to `order` harmonics.

    A pial surface is run through there and back, which leaves the terms in cos(pi k s) of its arc.
    Raises ValueError if order is not in 1 ... n/2, n the number of points.
    """
    return _descriptors(_loop(as_polyline(points, closed)), order)


def reconstruction_error(points: Any, order: int, *, closed: bool | None = None) -> float:
    """Return the root mean square distance of points and reconstruction, over the body's radius."""
    curve = as_polyline(points, closed)
    loop = _loop(curve)
    missed = _descriptors(loop, order).at(loop.arc / loop.length) - loop.points
    return float(np.sqrt(np.sum(loop.weights * np.sum(missed**2, axis=0)) / loop.length)) / curve.radius


def _loop(curve: Polyline) -> Polyline:
    if curve.closed:
        return curve
    return Polyline(np.hstack((curve.points, curve.points[:, -2:0:-1])), closed=True)


def _descriptors(loop: Polyline, order: int) -> EllipticFourier:
    if whole("order", order, at_least=1) > loop.size // 2:
        raise ValueError(f"order={order} must be at most half the points, {loop.size // 2}; resample.")
    k = np.arange(1, order + 1)[:, None]
    corners = np.append(loop.arc, loop.length) / loop.length
    # On a polyline the velocity is constant in pieces: its coefficients are differences at the corners.
    velocity = loop.segments / np.diff(corners)
    cosine, sine = (np.diff(wave(2 * np.pi * k * corners), axis=1) for wave in (np.cos, np.sin))
    matrices = np.stack((cosine @ velocity.T, sine @ velocity.T), axis=2) / (2 * np.pi**2 * k**2)[:, :, None]
    centre = np.sum(loop.weights * loop.points, axis=1) / loop.length
    return EllipticFourier(centre, matrices)
