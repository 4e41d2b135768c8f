"""What was changed of a measured outline so that elements of the asked size fill it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..arrays import Array


@dataclass(frozen=True, kw_only=True)
class Changes:
    """Differences between measured curves and the body made from them.

    moved: largest distance of a point of the given pial surface from that of the body, m; of pieces that were
    kept.  lost, added: area taken away and filled, as shares of the given area.  cortex: change of the
    cortex's area as a share of what lies between the given pial and white surfaces; None without the latter.
    dropped: (x, y, area) of pieces too small for the elements; m and m².  smallest_angle: of the triangles,
    degrees.  notes: what was repaired, in words.
    """

    moved: float
    lost: float
    added: float
    cortex: float | None
    dropped: tuple[tuple[float, float, float], ...]
    smallest_angle: float
    notes: tuple[str, ...] = ()

    def placed(self, centre: Array, unit: float, smallest_angle: float) -> Changes:
        """Return the changes in m of what was made in units of `unit` around `centre`, (2, 1), m."""
        x0, y0 = centre.ravel().tolist()
        dropped = [(x0 + unit * x, y0 + unit * y, area * unit**2) for x, y, area in self.dropped]
        return replace(self, moved=self.moved * unit, dropped=tuple(dropped), smallest_angle=smallest_angle)

    def __str__(self) -> str:
        told = [
            f"pial surface moved by at most {self.moved:.3g} m",
            f"area lost {self.lost:.2%}, filled {self.added:.2%}",
            f"{len(self.dropped)} pieces left out" if self.dropped else "",
            *self.notes,
        ]
        return "; ".join(part for part in told if part)
