"""The gray-white interface: the line at one depth below the pial surface."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.spatial import Voronoi, cKDTree

from ..arrays import Array, Booleans
from ..geometry.polygon import inside, intersections
from .line import Line

FINE = 24  # samples per thickness
SLACK = 4e-3  # share of the thickness by which a sample may be too close before it counts as swallowed
POCKET = 0.15  # share of the interface around a pocket of white matter that may be cut off
DEEPEST = 2 / 3  # largest thickness, as a share of the radius of the largest circle inside the pial surface
ROUND = 600  # samples of the pial surface from which that circle is found
REACH = 6.0  # an end of the interface is continued over this many samples to meet the base


def interface(pial: Line, thickness: float, loop: Array, rounding: float = 0.0) -> Array:
    """Return the interface as a fine polyline (2, n), in the direction of the pial surface.

    loop: the outline as a closed polygon. Where normals of length `thickness` meet, the offset curve crosses
    itself: this raises ValueError, saying where, or with `rounding` (m) makes the interface turn there with
    that radius.
    A closed pial surface gives a line whose last point is its first.
    """
    reach = thickness + rounding
    s = _samples(pial, reach)
    on, normal = pial.at(s), pial.normal(s)
    if not pial.closed:
        on, normal, s = _with_turns(pial, on, normal, s)
    deep = on + reach * normal
    distance, _ = cKDTree(pial.at(pial.spaced(reach / (4 * FINE))).T).query(deep.T)
    kept = np.asarray(distance >= reach * (1 - SLACK))
    if not pial.closed:
        kept &= inside(deep, loop)
    if not kept.any():
        raise ValueError(
            f"thickness={thickness:g} m leaves no white matter anywhere inside the outline; use a thinner "
            "cortex."
        )
    used = np.flatnonzero(kept)
    lost = ~kept
    if not pial.closed:  # beyond the first and last sample lies the base
        lost[: used[0]] = lost[used[-1] :] = False
    if lost.any() and rounding == 0:
        raise ValueError(_refusal(pial, s[lost], thickness))
    shallow = on + thickness * normal
    parts = _rounded(deep, shallow, kept, pial.closed, reach, rounding)
    return np.concatenate([*parts, parts[0][:, :1]] if pial.closed else parts, axis=1)


def refuse_thick(pial: Line, thickness: float, loop: Array, ground: Array | None) -> None:
    """Raise ValueError for a cortex thicker than 2/3 of the largest depth below the pial surface.

    That depth is the radius of the largest circle that no pial point lies in, its centre inside the outline
    or on the base (`ground`); less than 1 % of its centre is then cortex by θ(y) = 1/(1 + exp(10 (y/T - 1))).
    """
    around = pial.at(pial.spaced(pial.length / ROUND))
    centres = Voronoi(around.T).vertices.T
    centres = centres[:, inside(centres, loop[:, :: max(1, loop.shape[1] // ROUND)])]
    if ground is not None:
        steps = np.hypot(*np.diff(ground, axis=1))
        along = np.linspace(0.0, 1.0, ROUND) * steps.sum()
        arc = np.concatenate([[0.0], np.cumsum(steps)])
        centres = np.concatenate([centres, [np.interp(along, arc, x) for x in ground]], axis=1)
    depths = np.asarray(cKDTree(around.T).query(centres.T)[0])
    k = int(np.argmax(depths))
    depth, (x, y) = float(depths[k]), centres[:, k]
    if thickness > DEEPEST * depth:
        raise ValueError(
            f"thickness={thickness:g} m must be at most {DEEPEST * depth:.4g} m, two thirds of the largest "
            f"depth below the pial surface ({depth:.4g} m, at ({x:.4g}, {y:.4g}) m), or it leaves hardly any "
            "white matter; use a thinner cortex."
        )


def onto_base(white: Array, base: Array) -> Array:
    """Return an open interface with its two ends moved to where it meets the base polyline (2, m)."""
    moved = white.copy()
    for end, neighbour in ((0, 1), (-1, -2)):
        before, step = white[:, neighbour], REACH * (white[:, end] - white[:, neighbour])
        ahead = np.stack([before, before + step])[:, :, None]
        _, _, share, _ = intersections(ahead, np.stack([base[:, :-1], base[:, 1:]]))
        if not len(share):
            raise ValueError(
                f"the gray-white interface ends at ({white[0, end]:.4g}, {white[1, end]:.4g}) m without "
                "reaching the base; move the ends of the base, or use a thinner cortex."
            )
        moved[:, end] = before + share.min() * step
    return moved


def _samples(pial: Line, reach: float) -> Array:
    """Return arc lengths at which both the pial surface and its offset advance by about reach/FINE."""
    even = np.linspace(0.0, pial.length, max(64, round(pial.length * FINE / reach)))
    density = 1.0 + reach * np.abs(pial.curvature(even))
    count = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(even))])
    number = max(64, round(count[-1] * FINE / reach))
    s = np.interp(np.linspace(0.0, count[-1], number), count, even)
    return s[:-1] if pial.closed else s


def _with_turns(pial: Line, on: Array, normal: Array, s: Array) -> tuple[Array, Array, Array]:
    """Add the normals that turn outward around the two ends of an open pial surface."""
    angle = np.linspace(0.0, 0.75 * np.pi, 2 * FINE)[1:]
    before, after = angle[::-1], angle
    first, last = normal[:, 0], normal[:, -1]
    # the tangent is the normal turned back by a right angle
    turned = [
        np.outer(first, np.cos(before)) - np.outer([first[1], -first[0]], np.sin(before)),
        normal,
        np.outer(last, np.cos(after)) + np.outer([last[1], -last[0]], np.sin(after)),
    ]
    count = len(angle)
    ends = [np.repeat(on[:, :1], count, axis=1), on, np.repeat(on[:, -1:], count, axis=1)]
    along = np.concatenate([np.zeros(count), s, np.full(count, pial.length)])
    return np.concatenate(ends, axis=1), np.concatenate(turned, axis=1), along


def _rounded(
    deep: Array, shallow: Array, kept: Booleans, closed: bool, reach: float, rounding: float
) -> list[Array]:
    """Return the kept runs of `shallow`, in order, and between them arcs around the corners of `deep`."""
    if closed:
        gaps = np.flatnonzero(kept & ~np.roll(kept, 1))
        shift = -int(gaps[0]) if len(gaps) else 0
        deep, shallow, kept = np.roll(deep, shift, 1), np.roll(shallow, shift, 1), np.roll(kept, shift)
    if kept.all():
        return [shallow]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], kept.astype(int), [0]])))
    runs = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
    path = _main_line(deep, runs, closed, 0.25 * reach)
    parts: list[Array] = [shallow[:, slice(*path[0])]]
    for (_, end), (begin, after) in pairwise(path):
        corner = 0.5 * (deep[:, end - 1] + deep[:, begin])
        parts += [_arc(corner, shallow[:, end - 1], shallow[:, begin], rounding), shallow[:, begin:after]]
    return parts[:-1] if closed else parts


def _main_line(
    deep: Array, runs: list[tuple[int, int]], closed: bool, widest: float
) -> list[tuple[int, int]]:
    """Return the runs that follow each other with gaps of at most `widest`; a closed line ends as it begins.

    What is left out are pockets of white matter that the cortex cuts off; only small ones are.
    """
    length = {(begin, end): float(np.hypot(*np.diff(deep[:, begin:end])).sum()) for begin, end in runs}
    most = POCKET * sum(length.values())
    if closed:
        longest = max(range(len(runs)), key=lambda k: length[runs[k]])
        runs = [*runs[longest:], *runs[: longest + 1]]
    path, left = [runs[0]], runs[1:]
    while left:
        end = path[-1][1] - 1
        gaps = [float(np.hypot(*(deep[:, end] - deep[:, begin]))) for begin, _ in left]
        following = next((k for k, gap in enumerate(gaps) if gap <= widest), len(gaps))
        if any(length[run] > most for run in left[:following]) or following == len(gaps):
            raise ValueError(
                f"the cortex cuts the white matter in two near ({deep[0, end]:.4g}, {deep[1, end]:.4g}) m: "
                f"the interface jumps by {gaps[0]:.3g} m there; use a thinner cortex."
            )
        path.append(left[following])
        left = left[following + 1 :]
    return path


def _arc(centre: Array, start: Array, end: Array, radius: float) -> Array:
    """Return points between `start` and `end`, counter-clockwise around the centre."""
    a, b = complex(*(start - centre)), complex(*(end - centre))
    turn = np.angle(b / a) % (2 * np.pi)
    count = max(2, round(turn * FINE / np.pi))
    spin = np.angle(a) + turn * np.arange(1, count) / count
    return centre[:, None] + radius * np.stack([np.cos(spin), np.sin(spin)])


def _refusal(pial: Line, lost: Array, thickness: float) -> str:
    bend = pial.curvature(lost)
    k = int(np.argmax(bend))
    x, y = pial.at(lost[k : k + 1])[:, 0]
    cause = (
        f"its radius of curvature is {1 / bend[k]:.3g} m there"
        if bend[k] * thickness > 0.9
        else "opposite sides of the outline come closer than two thicknesses there"
    )
    return (
        f"thickness={thickness:g} m is too large near ({x:.4g}, {y:.4g}) m, {lost[k]:.3g} m along the pial "
        f'surface: {cause}. Use a thinner cortex, smooth=..., or tight="trim", which rounds it inside.'
    )
