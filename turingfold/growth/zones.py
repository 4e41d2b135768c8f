"""Zones: parts of the body where growth or cortical thickness differ, with ramps at their edge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from ..arrays import Array
from ..checks import between, finite, finite_array, instance, one_of, positive
from ..geometry.body import Body

RAMPS = ("smooth", "straight")


@runtime_checkable
class Region(Protocol):
    """A part of the plane, fading at its edge."""

    def share(self, body: Body) -> Array:
        """Return how far each integration point belongs to the region, from 0 to 1; (q, e)."""


@dataclass(frozen=True, kw_only=True)
class Ellipse:
    """The inside of an ellipse: share 1 up to the semi-axes less `edge`, 0 beyond the semi-axes.

    centre, semi_axes: (x, y) and (a, b) in m.  angle: of the first axis against x, rad.
    edge: width of the ramp, in m along the smaller semi-axis.  ramp: "smooth" (3s² - 2s³) or "straight".
    """

    centre: tuple[float, float]
    semi_axes: tuple[float, float]
    edge: float
    angle: float = 0.0
    ramp: str = "smooth"

    def __post_init__(self) -> None:
        finite_array("centre", self.centre, (2,))
        axes = finite_array("semi_axes", self.semi_axes, (2,)).tolist()
        smaller = min(positive("semi_axes", axis) for axis in axes)
        finite("angle", self.angle)
        positive("edge", self.edge, at_most=smaller, remedy="the ramp lies inside the ellipse")
        one_of("ramp", self.ramp, RAMPS)

    def share(self, body: Body) -> Array:
        """Return how far each integration point belongs to the region, (q, e)."""
        x, y = body.quadrature.points - np.array(self.centre)[:, None, None]
        c, s = np.cos(self.angle), np.sin(self.angle)
        a, b = self.semi_axes
        radius = np.hypot((c * x + s * y) / a, (c * y - s * x) / b)
        return _ramp((1.0 - radius) * min(a, b) / self.edge, self.ramp)


@dataclass(frozen=True, kw_only=True)
class HalfPlane:
    """What lies behind the line through `point`: share 0 on the line, 1 from the depth `edge` behind it on.

    point: (x, y) in m.  normal: points out of the region; its length does not matter.  edge in m.
    """

    point: tuple[float, float]
    normal: tuple[float, float]
    edge: float
    ramp: str = "smooth"

    def __post_init__(self) -> None:
        finite_array("point", self.point, (2,))
        if not np.hypot(*finite_array("normal", self.normal, (2,))) > 0:
            raise ValueError(
                f"normal={self.normal!r} has no length; give the direction that leads out of the region."
            )
        positive("edge", self.edge)
        one_of("ramp", self.ramp, RAMPS)

    def share(self, body: Body) -> Array:
        """Return how far each integration point belongs to the region, (q, e)."""
        normal = np.array(self.normal) / np.hypot(*self.normal)
        behind = -np.tensordot(normal, body.quadrature.points - np.array(self.point)[:, None, None], 1)
        return _ramp(behind / self.edge, self.ramp)


@dataclass(frozen=True, kw_only=True)
class Window:
    """The tissue below a part of the pial surface, from `start` to `end` as shares of its length in [0, 1].

    The surface is counted counter-clockwise, that of a closed outline from the outline's first point; there a
    window with start > end goes round it.
    edge: width of the ramps, inside the window, as such a share.
    """

    start: float
    end: float
    edge: float
    ramp: str = "smooth"

    def __post_init__(self) -> None:
        between("start", self.start, 0.0, 1.0)
        between("end", self.end, 0.0, 1.0)
        if self.start == self.end:
            raise ValueError(
                f"start={self.start:g} and end={self.end:g} leave no window; 0 and 1 are the whole surface."
            )
        most = 0.5000001 * (self._stop - self.start)
        positive("edge", self.edge, at_most=most, remedy="both ramps must fit in")
        one_of("ramp", self.ramp, RAMPS)

    def share(self, body: Body) -> Array:
        """Return how far each integration point belongs to the region, (q, e)."""
        along, closed = body.share_from_start(body.arc), body.pial_curve.closed
        if self.start > self.end:
            if not closed:
                raise ValueError(
                    f"start={self.start:g} must be less than end={self.end:g} on a pial surface that is not "
                    "closed; exchange them, or give two zones."
                )
            along = self.start + (along - self.start) % 1.0
        return _ramp(np.minimum(along - self.start, self._stop - along) / self.edge, self.ramp)

    @property
    def _stop(self) -> float:
        """Return the end, counted on from the start."""
        return self.end + (1.0 if self.end < self.start else 0.0)


@dataclass(frozen=True, kw_only=True)
class Zone:
    """A region where growth is multiplied by `growth` and the cortical thickness by `thickness`.

    growth multiplies rates and the excess of growth factors over 1: 0 is no growth, 0.25 a quarter of it.
    """

    region: Region
    growth: float = 1.0
    thickness: float = 1.0

    def __post_init__(self) -> None:
        instance("region", self.region, Region, "Ellipse(...), Window(...) or HalfPlane(...)")
        between("growth", self.growth, 0.0, 100.0, "0 is no growth, 1 no change")
        positive("thickness", self.thickness, at_most=10.0)


def checked_zones(zones: object) -> tuple[Zone, ...]:
    """Return zones as a tuple; raises ValueError for anything else among them."""
    found = tuple(zones) if isinstance(zones, (tuple, list)) else (zones,)
    for zone in found:
        if not isinstance(zone, Zone):
            raise ValueError(f"zones holds {zone!r}, which is no Zone; write Zone(region=..., growth=...).")
    return found


def gain(body: Body, zones: tuple[Zone, ...]) -> Array:
    """Return the factor Π (1 + share (growth - 1)) on growth at the integration points, (q, e)."""
    return _product(body, [(zone, zone.growth) for zone in zones if zone.growth != 1.0])


def local_thickness(body: Body, zones: tuple[Zone, ...]) -> Array:
    """Return the cortical thickness at the integration points, (q, e); m."""
    factors = [(zone, zone.thickness) for zone in zones if zone.thickness != 1.0]
    return body.thickness * _product(body, factors)


def _product(body: Body, factors: list[tuple[Zone, float]]) -> Array:
    total = np.ones_like(body.quadrature.weights)
    for zone, factor in factors:
        share = zone.region.share(body)
        if not share.max() > 0:
            raise ValueError(
                f"{zone.region!r} lies outside the body, which extends from {_shown(body.nodes.min(1))} to "
                f"{_shown(body.nodes.max(1))} m; move or enlarge it."
            )
        total *= 1.0 + share * (factor - 1.0)
    return total


def _ramp(along: Array, ramp: str) -> Array:
    s = np.clip(along, 0.0, 1.0)
    return s if ramp == "straight" else s * s * (3.0 - 2.0 * s)


def _shown(point: Array) -> str:
    return f"({point[0]:.4g}, {point[1]:.4g})"
