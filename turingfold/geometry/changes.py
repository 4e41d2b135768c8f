"""What was changed of a measured outline so that elements of the asked size fill it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..arrays import Array

MUCH = 0.01  # share of the area, or of the cortex, from which on a change is worth a word
CLOSED = "{:.2%} of the pial surface lies in fissures that are gone, as their walls touch: draw them apart"
HOLES = "area of holes lost {:.2%}"


class OutlineWarning(UserWarning):
    """A body is not what a measured outline says."""


@dataclass(frozen=True, kw_only=True)
class Changes:
    """Differences between measured curves and the body made from them.

    moved: largest distance of a point of the given pial surface from that of the body, m; of pieces that were
    kept, and farther than half an element from where walls of sulci touch.  moved_at_walls: the same there,
    where walls are moved apart, and sulci closed off.  lost, added: area taken away and filled, by smoothing,
    too, as shares of the area inside the given curves; of steps of voxels only the sum counts.  cortex:
    change of the cortex's area as a share of what lies between the given pial and white surfaces; None
    without the latter.  thickened: the part of it by which the cortex becomes one element thick where it is
    given thinner, as on the medial wall.  dropped: (x, y, area) of pieces too small for the elements; m and
    m².  filled: number of closed-off sulci that are too small.  smallest_angle: of the triangles, degrees.
    notes: what was repaired, in words.  expected: what elements and smoothing of a smooth outline move its
    surface by at most, m.  starts: first points of the given pial curves, (x, y), m, from which shares of a
    closed surface are counted.
    closed: share of the given pial surface's length in fissures that are gone, an element or more inside the
    body, as their walls touch.  holes: share of the area of the given holes that those of the body lack; None
    without any.
    Results of earlier versions do not tell moved_at_walls, thickened, filled, expected, closed and holes,
    None, nor starts.
    """

    moved: float
    lost: float
    added: float
    cortex: float | None
    dropped: tuple[tuple[float, float, float], ...]
    smallest_angle: float
    moved_at_walls: float | None = None
    thickened: float | None = None
    filled: int | None = None
    notes: tuple[str, ...] = ()
    expected: float | None = None
    starts: tuple[tuple[float, float], ...] = ()
    closed: float | None = None
    holes: float | None = None

    def placed(self, centre: Array, unit: float, smallest_angle: float) -> Changes:
        """Return the changes in m of what was made in units of `unit` around `centre`, (2, 1), m."""
        x0, y0 = centre.ravel().tolist()
        dropped = [(x0 + unit * x, y0 + unit * y, area * unit**2) for x, y, area in self.dropped]
        return replace(
            self,
            moved=self.moved * unit,
            moved_at_walls=None if self.moved_at_walls is None else self.moved_at_walls * unit,
            dropped=tuple(dropped),
            smallest_angle=smallest_angle,
        )

    def remarks(self) -> tuple[str, ...]:
        """Return what the user of an outline should know, in words; nothing of a smooth one."""
        area = sum(piece[2] for piece in self.dropped)
        told = {
            f"pial surface moved by up to {self.moved:.3g} m": self.moved > (self.expected or float("inf")),
            f"area lost {self.lost:.2%}, filled {self.added:.2%}": self.lost + self.added > MUCH,
            f"cortex {self.cortex or 0.0:+.2%}": abs(self.cortex or 0.0) > MUCH,
            CLOSED.format(self.closed or 0.0): (self.closed or 0.0) > MUCH,
            HOLES.format(self.holes or 0.0): (self.holes or 0.0) > MUCH,
            f"{len(self.dropped)} pieces too small for the elements left out, {area:.2g} m²": self.dropped,
            f"{self.filled} closed-off sulci too small for the elements filled": self.filled,
        }
        return (*self.notes, *(words for words, holds in told.items() if holds))

    def _of_cortex(self) -> str:
        if self.cortex is None or abs(self.cortex) <= MUCH:
            return ""
        thin = f", by thin parts {self.thickened:.2%}" if self.thickened else ""
        return f"cortex {self.cortex:+.2%}{thin}"

    def __str__(self) -> str:
        told = [
            f"pial surface moved by at most {self.moved:.3g} m"
            + (f", {self.moved_at_walls:.3g} m where walls touch" if self.moved_at_walls else ""),
            f"area lost {self.lost:.2%}, filled {max(self.added, 0.0):.2%}",
            self._of_cortex(),
            CLOSED.format(self.closed) if self.closed and self.closed > MUCH else "",
            HOLES.format(self.holes) if self.holes and self.holes > MUCH else "",
            f"{len(self.dropped)} pieces left out" if self.dropped else "",
            f"{self.filled} closed-off sulci filled" if self.filled else "",
            *self.notes,
        ]
        return "; ".join(part for part in told if part)
