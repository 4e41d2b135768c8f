"""Where a fit begins, and within which limits."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..checks import finite
from ..results.files import write_whole, writing
from ..scene import Scene
from .parameters import values_in

BEST = "fit.json"


def limits(
    bounds: tuple[float, float] | Mapping[str, tuple[float, float]] | None, to: Sequence[str]
) -> tuple[Array, Array]:
    """Return the least and largest value of each parameter, (p,); infinite where none are given.

    bounds: of all parameters, or by their names or those of maps, such as "GrowthMap.cortex"; "" is of all.
    Those of a single parameter go before those of its map.
    Raises ValueError for a name that is none of the parameters, and for what are no limits.
    """
    low, high = np.full(len(to), -np.inf), np.full(len(to), np.inf)
    if bounds is None:
        return low, high
    named = bounds if isinstance(bounds, Mapping) else {"": bounds}
    for name in sorted(named, key=len):
        own = [not name or one == name or one.startswith(f"{name}.") for one in to]
        if not any(own):
            raise ValueError(f"bounds names {name}, which is not fitted; fitted are {', '.join(to)}.")
        try:
            low[own], high[own] = map(float, named[name])
        except (TypeError, ValueError):
            raise ValueError(
                f"bounds={bounds!r}: give two numbers, least and largest value, or such pairs by name."
            ) from None
    if not (low < high).all():
        raise ValueError(f"bounds={bounds!r}: each is the least and the largest value, in this order.")
    return low, high


def begun_with(
    scene: Scene, to: tuple[str, ...], bounds: tuple[float, float] | Mapping[str, tuple[float, float]] | None,
    folder: Path | None, *, resume: bool,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Return the values that a fit begins with, and their least and largest ones, (p,) each.

    folder: of the fit that is resumed.
    Raises ValueError for limits that are none, values outside them, and nothing to resume.
    """
    values = values_in(scene, to)
    if resume:
        if folder is None:
            raise ValueError("resume=True goes on from what `out` holds; give that folder.")
        values = best_so_far(folder, to, values)
    low, high = limits(bounds, to)
    return checked_start(values, low, high, to), low, high


def checked_start(values: Array, low: Array, high: Array, to: Sequence[str]) -> Array:
    """Return the values that a fit begins with, (p,); raises ValueError for one outside its limits."""
    for name, value, least, most in zip(to, values.tolist(), low.tolist(), high.tolist(), strict=True):
        if not least <= value <= most:
            raise ValueError(
                f"{name} begins at {value:.6g}, outside its bounds {least:.6g} to {most:.6g}; give the scene "
                "(or the fit that is resumed) a value between them, or wider bounds."
            )
    return values


def check_fitted(to: Sequence[str]) -> None:
    """Raise ValueError where the fitted parameters are none, one word, or one of them twice."""
    if isinstance(to, str) or not len(to):
        raise ValueError(f'to={to!r}: give a list of one parameter or more, such as ["Elastic.gray.mu"].')
    if twice := [name for name in dict.fromkeys(to) if list(to).count(name) > 1]:
        raise ValueError(f"to names {', '.join(twice)} twice; give each parameter once.")


def make_folder(folder: Path) -> None:
    """Make the folder of a fit; raises OutputError where it cannot be."""
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)


def keep_best(
    folder: Path, to: tuple[str, ...], values: Array, misfit: float, smoothness: float, solves: int
) -> None:
    """Store what a fit has come to, whole.

    misfit: root mean square distance of the outlines, m.  smoothness: the weight it was fitted with.
    """
    document = {
        "misfit": misfit, "parameters": dict(zip(to, values.tolist(), strict=True)), "solves": solves,
        "smoothness": smoothness,
    }  # fmt: skip
    make_folder(folder)
    write_whole(folder / BEST, json.dumps(document, indent=1).encode())


def best_so_far(folder: Path, to: tuple[str, ...], values: Array) -> Array:
    """Return the values that an earlier fit in a folder came to, (p,), or those given where there is none.

    Raises ValueError where it was one of other parameters, or its file is damaged.
    """
    file = folder / BEST
    if not file.is_file():
        return values
    try:
        known = json.loads(file.read_text(encoding="utf-8"))["parameters"]
        found = np.array([finite(name, float(known[name])) for name in to])
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(
            f"{file} is damaged or of a fit with other parameters ({type(error).__name__}: {error}); fit in "
            "another folder, or without resume."
        ) from error
    if set(known) != set(to):
        raise ValueError(f"{file} is of a fit of {', '.join(known)}; fit in another folder.")
    return found
