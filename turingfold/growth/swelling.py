"""Hygroscopic swelling: tissue or gel takes up a solvent, and grows alike in all directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Integers
from ..checks import between, finite, instance, one_of, positive
from ..geometry.body import Body
from ..geometry.layers import cortex_indicator
from ..parts import Evolution, Fields, Process
from ..state import State
from .diffusion import Diffusion
from .histories import History, Linear
from .laws import OUT_OF_PLANE, multiplied
from .zones import Region

ZONES = ("core", "cortex", "all")
STRETCHES = -0.7, 4.0  # of β: stretches from 0.3 to 5, beyond which no tissue of this model goes
SOURCES = ("pial", "interface", "hole")


@dataclass(frozen=True, kw_only=True)
class Swelling(Process):
    """Isotropic swelling g_t = g_n = g_z = 1 + β c χ; writes "growth" and "concentration".

    c is the concentration, 0 at the start, in units of that which gives the stretch 1 + β; χ is the zone's
    share of the tissue. c is the same everywhere and follows the history, c = history.factor(2, t) - 1; or it
    diffuses, ∂c/∂t = D ∇²c on the undeformed body, from a boundary where c = 1, with no flux through the
    others. Thin fronts overshoot on coarse meshes: where the diffusing c leaves [0, 1], it is put back there.
    coefficient: β, from -0.7 to 4.
    zone: where it swells: "core", "cortex" (both follow the body's layers), "all", or a region such as
    Ellipse(...).
    history: of c; Linear() where it does not diffuse.
    diffusivity: D, m² per unit of time.  source: "pial", "interface" (gray-white) or "hole" (a ventricle: the
    mesh's boundaries whose names begin so); give both or neither.
    out_of_plane: "tangential" (g_z as the others) or "fixed" (g_z = 1, where the slice is free to thicken).
    Raises ValueError for a source that the body does not have.
    """

    coefficient: float
    zone: str | Region = "core"
    history: History | None = None
    diffusivity: float | None = None
    source: str | None = None
    out_of_plane: str = "tangential"

    def __post_init__(self) -> None:
        if not finite("coefficient", self.coefficient) > -1.0:
            raise ValueError(
                f"coefficient={self.coefficient:g} must be more than -1, or the tissue would shrink to no "
                "volume where the concentration is 1."
            )
        between(
            "coefficient", self.coefficient, *STRETCHES, "per cent or a fraction? 0.2 is a stretch of 1.2"
        )
        if isinstance(self.zone, str):
            one_of("zone", self.zone, ZONES)
        else:
            instance("zone", self.zone, Region, '"core", or a region such as Ellipse(...)')
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)
        if (self.diffusivity is None) != (self.source is None):
            raise ValueError(
                f"diffusivity={self.diffusivity!r} and source={self.source!r} belong together; give both, "
                "or neither for a concentration that is the same everywhere."
            )
        if self.diffusivity is not None:
            positive("diffusivity", self.diffusivity, remedy="it is D in m² per unit of time")
            one_of("source", self.source, SOURCES)
            if self.history is not None:
                raise ValueError(
                    "history and diffusivity both say how the concentration changes; leave one of them out."
                )
        elif self.history is not None:
            instance("history", self.history, History, "Linear() or Exponential()")

    @property
    def optional(self) -> tuple[str, ...]:
        """The growth by an earlier law, which it multiplies."""
        return ("growth",)

    @property
    def writes(self) -> tuple[str, ...]:
        """Growth factors along tangent, normal and z, (3, q, e), and c, (q, e)."""
        return ("growth", "concentration")

    @property
    def keeps(self) -> tuple[str, ...]:
        """The concentration, for pictures."""
        return ("concentration",)

    def on(self, body: Body) -> SwellingOnBody:
        """Return the process on a body."""
        return SwellingOnBody(self, body)


class SwellingOnBody(Evolution):
    """Swelling of one body."""

    def __init__(self, swelling: Swelling, body: Body) -> None:
        self.swelling, self.body = swelling, body
        self.share = _share(swelling.zone, body)
        self.diffusion = None
        if swelling.diffusivity is not None and swelling.source is not None:
            self.diffusion = Diffusion(body, _source_nodes(body, swelling.source), swelling.diffusivity)

    def start(self, state: State, seed: int) -> Fields:
        """Return growth and concentration at the scene's start."""
        return self._at(state)

    def advance(self, before: State, now: State, dt: float) -> Fields:
        """Return growth and concentration at a time."""
        return self._at(now)

    def _at(self, state: State) -> Fields:
        own = self.swelling
        if self.diffusion is None:
            level = (own.history or Linear()).factor(2.0, state.time) - 1.0
            c = np.full(self.share.shape, level)
        else:
            nodal = self.diffusion.at(state.time)[self.body.triangles]
            c = np.clip(np.einsum("aq,ae->qe", self.body.quadrature.shapes, nodal), 0.0, 1.0)
        stretch = 1.0 + own.coefficient * self.share * c
        out = stretch if own.out_of_plane == "tangential" else np.ones_like(stretch)
        growth = multiplied("Swelling", np.stack([stretch, stretch, out]), state)
        return {"growth": growth, "concentration": c}


def _share(zone: str | Region, body: Body) -> Array:
    """Return how far each integration point belongs to the zone, (q, e)."""
    if isinstance(zone, Region):
        share = zone.share(body)
        if not share.max() > 0:
            raise ValueError(f"zone={zone!r} lies outside the body; move or enlarge it.")
        return share
    if zone == "all":
        return np.ones_like(body.quadrature.weights)
    gray = cortex_indicator(body)
    return gray if zone == "cortex" else 1.0 - gray


def _source_nodes(body: Body, source: str) -> Integers:
    """Return the nodes of a source, in no order; a body may have several holes."""
    if source == "interface":
        return np.concatenate([path.nodes for path in body.interface_paths])
    mesh = body.mesh
    facets = [np.asarray(own) for name, own in mesh.boundaries.items() if name.startswith(source)]
    if not facets:
        raise ValueError(
            f"source={source!r}: the body has no such boundary (it has: {', '.join(sorted(mesh.boundaries))})"
            '; choose another one, or name the facets of a ventricle "hole" with mesh.with_boundaries({...}).'
        )
    found = np.concatenate(facets)
    return np.union1d(mesh.facets[:, found], mesh.nvertices + found)
