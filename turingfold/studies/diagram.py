"""Pictures of a study's points: phase diagrams on grids, scattered points, bands of percentiles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..models.declared import as_text
from .columns import Column

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize

BANDS = ((5, 95, 0.2), (25, 75, 0.45))  # percentiles, and how dark they are
FEW = 12  # different values of x that are each a place of their own; more are put into bins
LEVELS = 24  # whole numbers that are told apart by their colours
TICKS = (9, 14)  # numbers that have room along x and along y
LETTERS = 36  # of the words along x that have room side by side
MISSING = "#d55e00"


@dataclass(frozen=True)
class Values:
    """One column of a study: numbers as they are drawn, or the places of words along an axis.

    numbers: (n,), NaN where there is none.  words: of the places 0, 1, ..., none for numbers.
    whole: whether they are whole numbers.
    """

    heading: str
    numbers: Array
    words: tuple[str, ...] = ()
    whole: bool = False


def values_of(column: Column, values: Sequence[Any]) -> Values:
    """Return a column as it is drawn: lengths in mm, words and switches as places along an axis."""
    if any(isinstance(value, str | bool) for value in values):
        names = [as_text(value) for value in values]
        words = tuple(dict.fromkeys(names))
        return Values(column.heading, np.array([words.index(name) for name in names], dtype=float), words)
    numbers = np.array([np.nan if value is None else value for value in values], dtype=float)
    whole = all(value is None or isinstance(value, int) for value in values)
    if column.unit == "m":
        return Values(column._replace(unit="mm").heading, 1e3 * numbers)
    return Values(column.heading, numbers, whole=whole)


def phase_diagram(axes: Axes, x: Values, y: Values, colour: Values) -> None:
    """Draw each point in the colour of a measure; as cells where the points are those of a grid.

    Several points of one place are drawn as their median. A cross is a point without that measure.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm, Normalize

    known = np.isfinite(colour.numbers)
    places, of_place = np.unique(np.stack([x.numbers, y.numbers]), axis=1, return_inverse=True)
    medians = np.array([
        np.median(own) if (own := colour.numbers[known & (of_place == k)]).size else np.nan
        for k in range(places.shape[1])
    ])  # fmt: skip
    shown = medians[np.isfinite(medians)]
    if shown.size == 0:
        raise ValueError(f"no point has a value of {colour.heading}; there is nothing to draw.")
    norm = _levels(shown) if colour.whole else Normalize(shown.min(), shown.max())
    colors = ScalarMappable(norm, "viridis")
    columns, rows = (np.unique(along) for along in places)
    if min(len(columns), len(rows)) > 1 and len(columns) * len(rows) == places.shape[1]:
        cells = medians.reshape(len(columns), len(rows)).T
        axes.pcolormesh(
            _edges(columns), _edges(rows), np.ma.masked_invalid(cells), cmap=colors.get_cmap(), norm=norm,
            edgecolors="white", linewidth=0.5,
        )  # fmt: skip
    else:
        seen = np.isfinite(medians)
        across, up = places[:, seen]
        axes.scatter(across, up, c=medians[seen], cmap=colors.get_cmap(), norm=norm, s=36)
    missing = places[:, ~np.isfinite(medians)]
    if missing.size:
        axes.plot(*missing, "x", color=MISSING, label="no result")
        axes.legend(fontsize=8, loc="upper right")
    _name(axes, x, y)
    bar = axes.figure.colorbar(colors, ax=axes, label=colour.heading)
    if isinstance(norm, BoundaryNorm):
        bar.set_ticks(_apart(np.unique(shown[shown == np.round(shown)]), TICKS[1]).tolist())


def bands(axes: Axes, x: Values, y: Values) -> None:
    """Draw the median of a measure along x, with the bands that hold 50 and 90 % of the points."""
    known = np.isfinite(y.numbers) & np.isfinite(x.numbers)
    if not known.any():
        raise ValueError(f"no point has a value of {y.heading}; there is nothing to draw.")
    middles, groups = _grouped(x.numbers[known], y.numbers[known])
    for low, high, dark in BANDS:
        below, above = ([float(np.percentile(own, q)) for own in groups] for q in (low, high))
        label = f"{high - low} % of points"
        axes.fill_between(middles, below, above, color="C0", alpha=dark, linewidth=0, label=label)
    axes.plot(middles, [float(np.median(own)) for own in groups], color="C0", label="median")
    axes.plot(x.numbers[known], y.numbers[known], ".", color="0.4", markersize=3, zorder=0)
    _name(axes, x, y)


def _grouped(x: Array, y: Array) -> tuple[Array, list[Array]]:
    """Return places along x, and the values of y at each; bins of equally many where x is continuous."""
    places = np.unique(x)
    if len(places) <= FEW:
        return places, [y[x == place] for place in places]
    order = np.argsort(x, kind="stable")
    bins = np.array_split(order, int(np.clip(np.sqrt(len(x)), 2, FEW)))
    return np.array([x[own].mean() for own in bins]), [y[own] for own in bins]


def _levels(shown: Array) -> Normalize:
    from matplotlib.colors import BoundaryNorm, Normalize

    low, high = int(shown.min()), int(np.ceil(shown.max()))
    if high - low >= LEVELS:
        return Normalize(low, high)
    return BoundaryNorm(np.arange(low, high + 2) - 0.5, 256)


def _edges(middles: Array) -> Array:
    """Return the edges between places, and half a distance beyond the first and the last."""
    between = 0.5 * (middles[1:] + middles[:-1])
    return np.concatenate([[2 * middles[0] - between[0]], between, [2 * middles[-1] - between[-1]]])


def _name(axes: Axes, x: Values, y: Values) -> None:
    """Write what the axes show, with the places of words and of the few values of a grid."""
    axes.set(xlabel=x.heading, ylabel=y.heading)
    for values, ticks, most in zip((x, y), (axes.set_xticks, axes.set_yticks), TICKS, strict=True):
        if values.words:
            ticks(range(len(values.words)), values.words)
        elif len(places := np.unique(values.numbers[np.isfinite(values.numbers)])) <= FEW:
            some = _apart(places, most)
            ticks(some, [f"{place:.3g}" for place in some])
    if sum(map(len, x.words)) > LETTERS:
        axes.tick_params(axis="x", labelrotation=30)
        for label in axes.get_xticklabels():
            label.set_horizontalalignment("right")


def _apart(places: Array, most: int) -> Array:
    """Return the first of sorted places, the last, and those between that leave room for numbers.

    most: how many numbers have room side by side.
    """
    if not places.size:  # such as medians of counts that are all fractions
        return places
    gap = np.ptp(places) / (most - 1) * (1 - 1e-9)
    chosen = [places[0]]
    for place in places[1:-1]:
        if place - chosen[-1] >= gap <= places[-1] - place:
            chosen.append(place)
    return np.array([*chosen, places[-1]] if len(places) > 1 else chosen)
