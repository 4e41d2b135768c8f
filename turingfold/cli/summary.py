"""What a person is told of results: a few lines of numbers, with their errors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..figures.sections import areas
from ..figures.style import sulci
from ..results.holding import holding_words
from ..results.result import Result
from ..results.softness import soft_words
from ..results.units import length_unit, with_error
from .case import folder_name

LENGTH = {"perimeter": "pial length"}
BENT = 0.02  # difference of the two gyrification indices from which both are told


def told(case: str, results: Mapping[str, Result], base: Path) -> Iterator[str]:
    """Yield what a person wants to know: seven or eight lines for one scene, a line each for several.

    Lengths are in mm, or in cortical thicknesses for bodies in units of their own (`results.length_unit`).
    """
    summaries = {name: result.summary() for name, result in results.items()}
    if len(results) != 1:
        width = max(map(len, results), default=0)
        for name, s in summaries.items():
            end = results[name].unfinished
            end = f"{end.replace(s['status'], s['status'].upper(), 1)}:  " if end else ""
            yield (
                f"{name:<{width}}  {end}growth {s['growth']:.2f}  "
                f"{sulci(s['folds']):>9}  gyrification {_index(s, results[name])}  "
                f"{_gyri(s['registration'])}  {s['steps']} steps, {s['seconds']:.0f} s"
                f"{'  ' + words if (words := _stability(s)) else ''}"
            )
        yield f"results: {base}"
        return
    name, s = next(iter(summaries.items()))
    end = results[name].unfinished or "reached the end"
    if results[name].unfinished:
        yield f"NOT FINISHED: all numbers are of t = {s['time']:.6g} of {results[name].scene.until:.6g}"
    yield (
        f"{case}, {name}: {end} at largest growth {s['growth']:.2f} in {s['seconds']:.0f} s "
        f"({s['steps']} steps, {s['newton_iterations']} Newton iterations, {s['dofs']} unknowns)"
    )
    unit, word = length_unit(results[name].scene.body)
    thickness = " (T: cortical thickness)" if word == "T" else ""
    off = results[name].error("sulcal_depth")
    depth = with_error(s["sulcal_depth"] / unit, None if off is None else off / unit)
    deep = f", {depth} {word} deep on average{thickness}" if s["folds"] else ""
    hull, closed = s["gyrification_index"], s["closed_gyrification_index"]
    index = f"gyrification index {_index(s, results[name])}"
    if closed is not None and abs(hull - closed) > BENT:
        disc = f"the closing by a disc of radius {s['closing_radius'] / unit:.2g} {word}"
        index += f" against the convex hull, {closed:.2f} against {disc}"
    yield f"folds: {sulci(s['folds'])}{deep}; {index}"
    yield _told_errors(s)
    turned = f"; {s['inverted_elements']} element(s) turned over somewhere" if s["inverted_elements"] else ""
    yield f"walls: {s['self_intersections']} self-intersections{turned}{_on_the_way(s, unit, word)}"
    if words := holding_words(results[name].scene, s["holding_force"]):
        yield f"supports: {words}"
    if words := _stability(s):
        yield f"equilibria: {words}"
    waves = "" if s["pattern_half_waves"] is None else f"{s['pattern_half_waves']} half waves, "
    yield f"pattern: {waves}{_gyri(s['registration'])}{_chance(s)}"
    yield f"grown: {areas(results[name])}"
    yield f"results: {base / folder_name(name)}"


def _told_errors(s: Mapping[str, Any]) -> str:
    """Return the estimated errors of mesh and steps as text."""
    mesh, steps = _errors(s, "errors"), _errors(s, "step_errors")
    if not mesh:
        return "errors of mesh and steps: not estimated"
    rule = max(shares(s, "quadrature_errors").values(), default=0.0)
    inside = f" (its quadrature: up to {100 * rule:.1g} %)" if rule else ""
    steps = "none, but where there are several equilibria they choose one" if steps == "none" else steps
    told = f", estimated: {mesh}{inside}" if s["errors"] else f": not estimated ({mesh.rstrip('.')})"
    return f"errors of the mesh{told}; of the steps: {steps}"


def _on_the_way(s: Mapping[str, Any], unit: float, word: str) -> str:
    """Return the least of the whole run: of gaps between walls, of volume ratios at integration points."""
    gap, ratio = s["min_gap"], s["min_jacobian"]
    least = ["no contact" if gap is None else f"smallest gap {gap / unit:.2g} {word}"]
    if ratio is not None:
        least.append(f"least volume ratio of the elastic part at integration points, det F*, {ratio:.2f}")
    return f"; of all states: {', '.join(least)}"


def _errors(s: Mapping[str, Any], errors: str) -> str:
    """Return estimated errors in per cent, or why there are none; nothing where they were not wanted."""
    if not s[errors]:
        return str(s[f"no_{errors}"])
    words = [f"{named(name)} {100 * share:.2g} %" for name, share in shares(s, errors).items()]
    return ", ".join(words) or "none"


def named(number: str) -> str:
    """Return what a number of a summary is called."""
    return LENGTH.get(number, number.replace("_", " "))


def shares(s: Mapping[str, Any], errors: str) -> dict[str, float]:
    """Return estimated errors relative to the numbers that they are of, of those that are not zero."""
    return {name: abs(off / s[name]) for name, off in (s[errors] or {}).items() if off and s[name]}


def _index(s: Mapping[str, Any], result: Result) -> str:
    return with_error(s["gyrification_index"], result.error("gyrification_index"))


def _stability(s: Mapping[str, Any]) -> str:
    """Return what is not smooth or not stable on the way to the end, or nothing."""
    words = []
    if s["saddles"]:
        last = ", the last one too" if s["negative_pivots"] else ""
        words.append(f"{s['saddles']} of {s['steps']} states no minimum{last}")
    if s["snaps"]:
        words.append(f"{s['snaps']} of {s['steps']} reached by a snap")
    if s["damped_steps"]:
        words.append(f"{s['damped_steps']} of {s['steps']} damped, where walls met")
    words += [soft] if (soft := soft_words(s["softness"])) else []
    return "; ".join(words)


def _chance(s: Mapping[str, Any]) -> str:
    """Return what share of the pattern's phases register as far, on the side on which the gyri are."""
    if not s["registration"]:
        return ""
    if s["registration"] < 0:
        return f"; {100 * (1 - s['registration_p']):.1f} % of the pattern's phases register lower"
    return f"; {100 * s['registration_p']:.1f} % of the pattern's phases register as well or better"


def _gyri(registration: float | None) -> str:
    """Return where the gyri stand, as text."""
    if registration is None:
        return "no pattern"
    if abs(registration) < 0.5:
        return f"registration {registration:+.2f}"
    where = "on" if registration > 0 else "between"
    return f"registration {registration:+.2f}, gyri {where} the activator's peaks"
