"""Forces at places along the pial surface, as arrows on a drawing: given, from a table, or beside peaks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..checks import finite, finite_array, one_of, positive
from ..errors import InadmissibleStateError
from ..geometry.body import Body
from ..geometry.surface_table import checked_places
from ..parts import Load, Operator, TimeStep
from ..state import State
from .doubts import of_line
from .line import SHAPES, WEIGHTS, DeadLoad, Line
from .load_table import Places, read_loads

SPREADS = ("gaussian", "hat")
PEAK = 0.5  # û that a peak reaches
FINEST = 0.5  # width over the length of the surface's edges
SMALL = 1e-9  # share of the loads that a resultant may have by round-off


@dataclass(frozen=True, kw_only=True)
class BoundaryLoads(Load):
    """Forces f at places of the pial surface, each spread along it; dead loads, with the energy -f·u.

    The load at arc length s is Σ f w(s - s₀), ∫ w ds = 1 on the surface: the resultant is Σ f, to round-off.
    places: shares of the pial surface's length in [0, 1], of a closed outline from its first point, or points
    (x, y) in m within `width` of it.
    forces: (f_x, f_y) of each, N/m (N per m of depth).
    width: of w, m; the standard deviation ("gaussian"), or half the base ("hat").
    ramp: time over which the loads rise.
    On half a body each has its mirror image, and both act on the half as on the whole.
    A body that nothing holds in some direction bears only loads without resultant (and moment) in it.
    Raises ValueError for places off the surface, and for a width that the mesh does not resolve.
    """

    places: Places
    forces: tuple[tuple[float, float], ...]
    width: float
    spread: str = "gaussian"
    ramp: float = 0.1

    def __post_init__(self) -> None:
        forces = finite_array("forces", self.forces, (None, 2))
        object.__setattr__(self, "places", checked_places(self.places, len(forces), "forces"))
        object.__setattr__(self, "forces", tuple(tuple(force) for force in forces.tolist()))
        _check_spreading(self.width, self.spread, self.ramp)

    @classmethod
    def read(
        cls, file: str | Path, *, width: float, spread: str = "gaussian", ramp: float = 0.1
    ) -> BoundaryLoads:
        """Return the loads of a CSV file with units in its header: "s" or "x [mm], y [mm]", then forces.

        s: share of the surface's length, without a unit.  fx, fy: in N/m, mN/m, µN/m or kN/m.
        Raises ValueError, naming file and line, for other columns or units, and for what is no number.
        """
        places, forces = read_loads(file)
        return cls(places=places, forces=forces, width=width, spread=spread, ramp=ramp)

    @property
    def resultant(self) -> tuple[float, float]:
        """The sum of the forces, N/m."""
        x, y = np.sum(self.forces, axis=0).tolist()
        return x, y

    def doubt(self, body: Body, shear_modulus: float) -> str:
        """Return words for a force far beyond μT."""
        largest = float(np.hypot(*np.transpose(self.forces)).max())
        words = of_line("BoundaryLoads: the largest of forces", largest, body, shear_modulus)
        return words and f"{words}; forces are in N/m, N per m of depth."

    def on(self, body: Body) -> BoundaryLoadsOnBody:
        """Return the loads on a body."""
        return BoundaryLoadsOnBody(self, body)


@dataclass(frozen=True, kw_only=True)
class PeakLoads(Load):
    """Two forces beside each peak of the pattern on the pial surface, which pull each other together.

    They act along the line between the two, so that each pair has neither resultant nor moment. A peak is a
    local maximum of û of at least 0.5; peaks less than `distance` from the end of a surface have no pair,
    and a pattern with such peaks alone stops the run.
    strength: of each force, N/m; negative pushes apart.  distance: of each from its peak along the surface,
    m.  width, spread, ramp: as of BoundaryLoads.
    """

    strength: float
    distance: float
    width: float
    spread: str = "gaussian"
    ramp: float = 0.1

    def __post_init__(self) -> None:
        finite("strength", self.strength, "give the force of each arrow in N/m")
        positive("distance", self.distance, remedy="it is from the peak to each of the two arrows, in m")
        _check_spreading(self.width, self.spread, self.ramp)

    @property
    def reads(self) -> tuple[str, ...]:
        """The pattern."""
        return ("pattern",)

    def doubt(self, body: Body, shear_modulus: float) -> str:
        """Return words for a strength far beyond μT."""
        words = of_line("PeakLoads: strength", self.strength, body, shear_modulus)
        return words and f"{words}; it is in N/m, N per m of depth."

    def on(self, body: Body) -> PeakLoadsOnBody:
        """Return the loads on a body."""
        return PeakLoadsOnBody(self, body)


class Spreading:
    """Forces spread along a body's pial surface, on half a body together with their mirror images.

    mirrored: whether the surface goes on beyond its start, and beyond its end, in the other half.
    """

    def __init__(self, body: Body, width: float, spread: str) -> None:
        self.line, self.width, self.spread = Line(body, body.pial), width, spread
        curve = self.line.curve
        held = body.mirror and not curve.closed
        self.mirrored = tuple(bool(held and curve.points[0, k] == 0) for k in (0, -1))
        arc = self.line.by_edge(curve.arc)
        if curve.closed:
            arc[2, -1] = curve.length
        self.arc = np.einsum("km,kg->gm", arc, SHAPES)
        edge = float((arc[2] - arc[0]).max())
        if width > curve.length:
            raise ValueError(
                f"width={width:g} m is more than the length of the pial surface, {curve.length:.3g} m; it is "
                f"in m: {width:g} mm are {1e-3 * width:g}."
            )
        if width < FINEST * edge:
            raise ValueError(
                f"width={width:g} m must be at least {FINEST * edge:.3g} m, half the longest edge of the "
                "pial surface, which could not resolve it; use smaller elements or a larger width."
            )

    def kernel(self, place: float) -> Array:
        """Return w ds at the integration points for the force along x and along y, (2, g, m).

        place: arc length, beyond a mirrored end that of a place in the other half. The sums are 1; on half a
        body, where the image pushes the other way along x, that is of the force and its image on the whole.
        """
        own = self._shape(place)
        if not any(self.mirrored):
            return np.stack([own / own.sum()] * 2)
        image = self._shape(-place if self.mirrored[0] else 2 * self.line.curve.length - place)
        return np.asarray(np.stack([own - image, own + image]) / (own + image).sum())

    def _shape(self, place: float) -> Array:
        away, length = np.abs(self.arc - place), self.line.curve.length
        if self.line.curve.closed:
            away = np.minimum(away, length - away)
        elif all(self.mirrored):  # half of a closed surface
            away = np.minimum(away, 2 * length - away)
        away = away / self.width
        shape = np.exp(-0.5 * away**2) if self.spread == "gaussian" else np.maximum(0.0, 1.0 - away)
        return np.asarray(WEIGHTS[:, None] * self.line.speed * shape)

    def centre(self, kernel: Array) -> Array:
        """Return the centre (2,) of a spread force."""
        points = np.einsum("kim,kg->igm", self.line.curve.segments, SHAPES)
        return np.asarray((kernel * points).sum((1, 2)))

    def forces(self, kernels: Sequence[Array], forces: Array) -> Array:
        """Return the nodal forces (2 n_nodes,) of spread forces (k, 2)."""
        if not len(kernels):
            return np.zeros(self.line.n_dofs)
        density = np.einsum("ligm,li->igm", np.stack(kernels), forces)
        return self.line.nodal(np.einsum("igm,kg->kim", density, SHAPES))


class BoundaryLoadsOnBody(Operator):
    """Given loads on one body."""

    def __init__(self, term: BoundaryLoads, body: Body) -> None:
        self.term, self.body = term, body
        spreading = Spreading(body, term.width, term.spread)
        kernels = [spreading.kernel(place) for place in _arcs(term, body)]
        self.forces = spreading.forces(kernels, np.array(term.forces))

    def check_balance(self) -> None:
        """Raise ValueError for a resultant, or moment, that nothing bears."""
        forces, at = self.forces.reshape(-1, 2), (self.body.nodes - self.body.nodes.mean(1, keepdims=True)).T
        free = [not (self.body.supported % 2 == i).any() for i in (0, 1)]
        x, y = forces.sum(0)
        moment = float((at[:, 0] * forces[:, 1] - at[:, 1] * forces[:, 0]).sum())
        size = np.abs(np.array(self.term.forces)).sum()
        unborne = max(abs(x) * free[0], abs(y) * free[1], abs(moment) / self.body.length * all(free))
        if unborne > SMALL * size:
            raise ValueError(
                f"BoundaryLoads: the forces add up to ({x:.3g}, {y:.3g}) N/m and the moment {moment:.3g} N "
                f"about the body's middle, which a body with base={self.body.base!r} does not bear: it would "
                'move away. Balance the loads, use base="clamped", or add Drag(...) or Inertia(...).'
            )

    def during(self, state: State, step: TimeStep) -> DeadLoad | None:
        """Return the loads at the state's time, or None while they are zero."""
        return _risen(self.forces, self.term.ramp, state.time)


class PeakLoadsOnBody(Operator):
    """Pairs of forces beside the peaks of a pattern, on one body."""

    def __init__(self, term: PeakLoads, body: Body) -> None:
        self.term, self.body = term, body
        self.spreading = Spreading(body, term.width, term.spread)

    def during(self, state: State, step: TimeStep) -> DeadLoad | None:
        """Return the loads at the state's time, or None while they are zero."""
        kernels: list[Array] = []
        forces: list[Array] = []
        line, distance, mirrored = self.spreading.line, self.term.distance, self.spreading.mirrored
        length = line.curve.length
        values = self.body.spread(self.body.cortex, state["pattern"])[line.nodes]
        for peak in peaks(line, values, mirrored):
            ends = np.array([peak - distance, peak + distance])
            if line.curve.closed:
                ends %= length
            elif (ends[0] < 0 and not mirrored[0]) or (ends[1] > length and not mirrored[1]):
                continue
            pair = [self.spreading.kernel(end) for end in ends]
            apart = self.spreading.centre(pair[1]) - self.spreading.centre(pair[0])
            pull = self.term.strength * apart / np.hypot(*apart)
            # of a pair across the mirror one is the image of the other
            inside = [not (mirrored[0] and peak == 0), not (mirrored[1] and peak == length)]
            kernels += [kernel for kernel, one in zip(pair, inside, strict=True) if one]
            forces += [force for force, one in zip((pull, -pull), inside, strict=True) if one]
        if values.max() >= PEAK and not forces:
            raise InadmissibleStateError(
                f"PeakLoads: every peak of the pattern is less than distance={distance:g} m from an end of "
                "the surface, so that nothing pulls; use a smaller distance or a pattern with more waves",
                time=state.time,
            )
        return _risen(self.spreading.forces(kernels, np.array(forces)), self.term.ramp, state.time)


def peaks(line: Line, values: Array, mirrored: Sequence[bool] = (False, False)) -> Array:
    """Return the arc lengths of the local maxima, of at least 0.5, of values at a line's nodes (n,).

    mirrored: whether the values go on beyond the start, and beyond the end, as their mirror image.
    """
    count, arc, length = len(values), line.curve.arc, line.curve.length
    ends = ((0, 1, 0.0), (-1, -2, length))
    found = [at for one, (k, j, at) in zip(mirrored, ends, strict=True) if one and values[k] > values[j]]
    found = [at for at in found if values[0 if at == 0 else -1] >= PEAK]
    for k in range(count) if line.curve.closed else range(1, count - 1):
        low, mid, high = (float(values[j % count]) for j in (k - 1, k, k + 1))
        if mid < PEAK or not (mid > low and mid >= high):
            continue
        before, after = arc[k - 1] - arc[k], arc[(k + 1) % count] - arc[k]
        a, b = before % -length, after % length
        # the top of the parabola through the three
        rise, fall = (low - mid) / a, (high - mid) / b
        bend = (fall - rise) / (b - a)
        found.append((arc[k] - 0.5 * (rise - a * bend) / bend) % length)
    return np.array(found)


def _arcs(term: BoundaryLoads, body: Body) -> Array:
    """Return the arc length of each place; raises ValueError for one off the surface."""
    curve, places = body.pial_curve, np.array(term.places)
    if places.ndim == 1:
        arc = places * curve.length * (2.0 if body.mirror else 1.0)
        if arc.max() > curve.length * (1 + 1e-12):
            raise ValueError(f"places holds {places.max():g}; half a body has the shares 0 to 0.5.")
        return np.asarray((arc + body.first_arcs[0]) % curve.length if curve.closed else arc)
    away, _, arc = curve.nearest(places.T)
    k = int(np.argmax(away))
    if away[k] > term.width:
        x, y = places[k]
        raise ValueError(
            f"place {k}, ({x:.4g}, {y:.4g}) m, lies {away[k]:.3g} m off the pial surface, more than "
            f"width={term.width:g} m; give places on it, in m."
        )
    return arc


def _risen(forces: Array, ramp: float, time: float) -> DeadLoad | None:
    rise = 1.0 if ramp == 0 else min(1.0, time / ramp)
    return DeadLoad(rise * forces) if rise > 0 and forces.any() else None


def _check_spreading(width: float, spread: str, ramp: float) -> None:
    positive("width", width, remedy="it is the length over which each force is spread, in m")
    one_of("spread", spread, SPREADS)
    if finite("ramp", ramp) < 0:
        raise ValueError(f"ramp={ramp:g} must not be negative; 0 applies the loads at once.")
