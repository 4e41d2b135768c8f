"""Growth that is given along the pial surface: by values at places, and at ages."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..checks import finite_array, instance, one_of
from ..errors import InadmissibleStateError
from ..geometry.body import Body
from ..geometry.layers import cortex_indicator
from ..geometry.surface_table import BETWEEN, Places, SurfaceTable, checked_places, evenly, on_surface
from ..state import State
from .ages import Ages, Weeks
from .histories import History, Linear
from .laws import OUT_OF_PLANE, GrowthLaw, GrowthOnBody, check_factor

OF = ("length", "area")
SLACK = 1e-9  # by which round-off may pass the first and the last age of a table


@dataclass(frozen=True, kw_only=True)
class GrowthMap(GrowthLaw):
    """Tangential growth of the cortex, different from place to place; writes "growth".

    g_t = 1 + θ (g(s) - 1), s the nearest pial point.
    cortex: factors g at the end of the history, two or more.
    places: of each factor along the pial surface, as shares of its length or as points in m, such as
    landmarks, or all points of an outline. Left out, they are evenly spaced, from one end of the surface,
    counter-clockwise, to the other; round a closed one, where it begins and ends anywhere, the first factor
    follows the last. Half a body needs them: shares are of the whole surface, and those up to 0.5 lie on it.
    between: places: "linear" in arc length, or "nearest", as in regions of constant growth.
    out_of_plane: "fixed" (g_z = 1) or "tangential" (g_z = g_t).
    Raises ValueError for fewer than two factors, or one outside 0.3 to 5, and places off the surface.
    """

    cortex: tuple[float, ...]
    places: Places | None = None
    between: str = "linear"
    out_of_plane: str = "fixed"
    history: History = field(default_factory=Linear)

    def __post_init__(self) -> None:
        values = finite_array("cortex", self.cortex, (None,))
        if values.size < 2 or not values.min() > 0:
            raise ValueError(f"cortex={self.cortex!r} must be two or more positive growth factors.")
        for value in (values.min(), values.max()):
            check_factor("cortex", float(value))
        object.__setattr__(self, "cortex", tuple(values.tolist()))
        if self.places is not None:
            object.__setattr__(self, "places", checked_places(self.places, values.size, "cortex"))
        one_of("between", self.between, BETWEEN)
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)
        instance("history", self.history, History, "Linear() or Exponential()")

    def on(self, body: Body) -> GrowthOnBody:
        """Return the law on a body; raises ValueError on half a body without places."""
        self._places(body)
        return super().on(body)

    def _places(self, body: Body) -> Places:
        return self.places or evenly(body, len(self.cortex), "GrowthMap")

    def factors(self, body: Body, state: State, time: float) -> tuple[Array, Array]:
        """Return g_t and g_n = 1 at a time."""
        values = np.array([self.history.factor(final, time) for final in self.cortex])
        return _grown(body, on_surface(body, self._places(body), values, self.between))


@dataclass(frozen=True, kw_only=True)
class GrowthTable(GrowthLaw):
    """Tangential growth of the cortex by place and age, as regional growth is published; writes "growth".

    g_t = 1 + θ (f(s, a)/f(s, a₀) - 1), s the nearest pial point, a the age, a₀ that at t = 0; f is linear
    between the ages of the table.
    at: ages of the table's rows, increasing, in the unit of `ages`; they hold all ages from start to end.
    cortex: a row of values to each age, one to each place; only their ratios matter, so that they may be
    sizes, or growth since any age. From the scene's start on lengths grow by factors from 0.3 to 5.
    of: "length" along the surface, or "area" of the cortex, which grows as the square of a length.
    places, between, out_of_plane: as of `GrowthMap`.  ages: which times of the scene are which ages.
    """

    at: tuple[float, ...]
    cortex: tuple[tuple[float, ...], ...]
    places: Places
    ages: Ages = field(default_factory=Weeks)
    of: str = "length"
    between: str = "linear"
    out_of_plane: str = "fixed"

    def __post_init__(self) -> None:
        at, rows = finite_array("at", self.at, (None,)), finite_array("cortex", self.cortex, (None, None))
        if len(at) < 2 or not (np.diff(at) > 0).all() or len(at) != len(rows):
            raise ValueError(
                f"at={self.at!r} must be two or more ages in increasing order, one for each of the "
                f"{len(rows)} rows of cortex."
            )
        if not rows.min() > 0:
            raise ValueError(f"cortex holds {rows.min():g}; sizes and growth factors are positive.")
        object.__setattr__(self, "at", tuple(at.tolist()))
        object.__setattr__(self, "cortex", tuple(tuple(row) for row in rows.tolist()))
        object.__setattr__(self, "places", checked_places(self.places, rows.shape[1], "the rows of cortex"))
        instance("ages", self.ages, Ages, "Weeks(start=28, end=40)")
        one_of("of", self.of, OF)
        one_of("between", self.between, BETWEEN)
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)
        start = self.ages.age(0.0)
        if not at[0] - SLACK <= start < at[-1]:
            raise ValueError(
                f"at goes from {self.ages.unit} {at[0]:g} to {at[-1]:g}, and the scene begins at {start:g}; "
                "give rows for all its ages."
            )
        for age in at[at > start]:
            self._check(age, self._lengths(age))

    @classmethod
    def read(
        cls, file: str | Path, *, ages: Ages, of: str = "length", between: str = "linear",
        out_of_plane: str = "fixed",
    ) -> GrowthTable:  # fmt: skip
        """Return the growth in a CSV file: a row to each place, "s" or "x [mm], y [mm]", a column to each
        age, named by its number with or without a word, such as "week 28".

        Raises ValueError, naming the file, for columns without a number, and as `SurfaceTable.read`.
        """
        table = SurfaceTable.read(file)
        words = [column.split() for column in table.columns]
        try:
            at = tuple(float(word[-1].lstrip("Pp")) for word in words)
        except (ValueError, IndexError) as error:
            raise ValueError(
                f"{Path(file).name}: the columns of values are {', '.join(table.columns)}; each must be "
                'named by its age, such as "28" or "week 28".'
            ) from error
        return cls(
            at=at, cortex=tuple(zip(*table.values, strict=True)), places=table.places, ages=ages, of=of,
            between=between, out_of_plane=out_of_plane,
        )  # fmt: skip

    def factors(self, body: Body, state: State, time: float) -> tuple[Array, Array]:
        """Return g_t and g_n = 1 at a time; raises InadmissibleStateError beyond the table's last age."""
        now = self.ages.age(time)
        if now > self.at[-1] * (1 + SLACK):
            raise InadmissibleStateError(
                f"GrowthTable: t = {time:.4g} is {self.ages.unit} {now:.4g}, but the table ends at "
                f"{self.at[-1]:g}; end the scene earlier, or give more rows.",
                time=time,
            )
        return _grown(body, on_surface(body, self.places, self._lengths(now), self.between))

    def _lengths(self, age: float) -> Array:
        """Return by how much lengths have grown at an age at each of the places, (k,)."""
        columns, when = np.array(self.cortex).T, (self.ages.age(0.0), age)
        before, size = np.array([np.interp(when, self.at, column) for column in columns]).T
        ratio = size / before
        return np.asarray(np.sqrt(ratio) if self.of == "area" else ratio)

    def _check(self, age: float, lengths: Array) -> None:
        """Raise ValueError for factors of growth outside 0.3 to 5, naming the place and the age."""
        k = int(np.argmax(np.abs(np.log(lengths))))
        if not 0.3 <= lengths[k] <= 5.0:
            unit, start = self.ages.unit, self.ages.age(0.0)
            remedy = "" if self.of == "area" else ', or of="area" where the values are areas'
            raise ValueError(
                f"cortex: at place {k} lengths grow by {lengths[k]:.4g} from {unit} {start:g} to {unit} "
                f"{age:g}; the factor must be between 0.3 and 5. Leave out the ages that the scene does not "
                f"reach, or correct the values{remedy}."
            )


def _grown(body: Body, local: Array) -> tuple[Array, Array]:
    along = 1.0 + cortex_indicator(body) * (local - 1.0)
    return along, np.ones_like(along)
