"""Thickness of the cortex along the pial surface: of a body, before and after growth, and of a section."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array
from ..geometry.body import Body
from ..geometry.paths import Path
from ..outlines.section import Section
from ..state import State


@dataclass(frozen=True, kw_only=True)
class ThicknessProfile:
    """Thickness of the cortex at the nodes of a pial surface, (n,) each; m.

    arc: length along the undeformed surface, one part after the other.  start, grown: of the undeformed and
    of the deformed body.  given: of a section at the nearest of its points; None without one. NaN where
    `Section.thickness` has no value.
    """

    arc: Array
    start: Array
    grown: Array
    given: Array | None

    def __str__(self) -> str:
        each = {"given": self.given, "at the start": self.start, "grown": self.grown}
        return "thickness " + ", ".join(
            "{} {:.2f} mm ({:.2f} to {:.2f})".format(name, *(1e3 * np.nanpercentile(values, (50, 5, 95))))
            for name, values in each.items()
            if values is not None
        )


def thickness_profile(body: Body, state: State, section: Section | None = None) -> ThicknessProfile:
    """Return the thickness of the cortex along the pial surface, by the same measure for body and section.

    T = (|p - w| + |w - q|) / 2, see `Section.thickness`.
    state: deformed, such as `result.last`.  section: that the body was made from, in the same place; a node
    has the value of the nearest of its pial points, within one thickness.
    Raises ValueError for half a body, and for a section without a white surface.
    """
    if body.mirror:
        raise ValueError("thickness_profile: the body is half of one; give a whole body.")
    start, grown = _section(body, body.nodes), _section(body, body.nodes + state["displacement"])
    arcs, before = [], 0.0
    for curve, path in zip(body.pial_curves.parts, body.pial_paths, strict=True):
        arcs.append(before + curve.arc[: len(path.nodes)])
        before += curve.length
    return ThicknessProfile(
        arc=np.concatenate(arcs),
        start=np.concatenate(start.thickness()),
        grown=np.concatenate(grown.thickness()),
        given=None if section is None else _nearest(section, start, body.thickness),
    )


def _section(body: Body, at: Array) -> Section:
    """Return the curves of a body as a section, with its nodes at places (2, n)."""

    def curves(paths: tuple[Path, ...]) -> list[Array]:
        return [at[:, path.nodes] for path in paths]

    return Section(curves(body.pial_paths), curves(body.interface_paths))


def _nearest(section: Section, body: Section, farthest: float) -> Array:
    """Return the thickness of a section at the places of a body's pial surface, (n,)."""
    values = np.append(np.concatenate(section.thickness()), np.nan)
    tree = cKDTree(np.concatenate(section.pial, axis=1).T)
    near = tree.query(np.concatenate(body.pial, axis=1).T, distance_upper_bound=farthest)[1]
    return np.asarray(values[near])
