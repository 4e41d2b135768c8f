"""Axonal tension: tangential loads whose strength follows the pattern."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..checks import finite, one_of, whole
from ..geometry.body import Body
from ..parts import Entries, Evaluation, Hessian, Load, Operator, Potential, TimeStep
from ..state import State
from .doubts import of_line, of_stress
from .line import DERIVATIVES, SHAPES, WEIGHTS, DeadLoad, Line

SURFACES = ("interface", "pial")
DIRECTIONS = ("toward-peaks", "between-peaks")


@dataclass(frozen=True, kw_only=True)
class AxonalTension(Load):
    """Tension of axons, ∝ the pattern û, along the gray-white interface or as tractions on the pial surface.

    surface "interface": a line tension γ (strength in N/m), in the weak form -∫ γ T·∂_s v ds: no net
    force or moment. direction "toward-peaks": γ = strength û, which makes gyri at the peaks; "between-peaks":
    γ = strength (1 - û).
    surface "pial": tangential tractions of at most `strength` (Pa) along ±∂_s û, converging on the peaks
    (direction "toward-peaks", the arrows of the source's Figure 1; sulci form there) or between them
    ("between-peaks"; gyri form at the peaks).
    direction None: the one that makes gyri at the peaks.
    follower: loads follow the deforming line instead of keeping their direction; only on the interface, where
    the tension then has the energy ∫ γ |∂x/∂s| ds.
    patches: without a pattern, this many evenly spaced patches of equal strength, the first at the end of the
    pial surface, or at the first point of a closed outline; nothing is read then.
    ramp: time over which the load rises to its strength.
    """

    strength: float
    surface: str = "interface"
    direction: str | None = None
    follower: bool = False
    patches: int = 0
    ramp: float = 0.1

    def __post_init__(self) -> None:
        finite("strength", self.strength, "give the line tension in N/m, or the peak traction in Pa")
        one_of("surface", self.surface, SURFACES)
        if self.direction is not None:
            one_of("direction", self.direction, DIRECTIONS)
        whole("patches", self.patches, at_least=0)
        if finite("ramp", self.ramp) < 0:
            raise ValueError(f"ramp={self.ramp:g} must not be negative; 0 applies the load at once.")
        if self.follower and self.surface == "pial":
            raise ValueError(
                'follower=True needs surface="interface"; tractions that turn with the pial surface have no '
                "energy."
            )

    @property
    def reads(self) -> tuple[str, ...]:
        """The pattern, unless patches replace it."""
        return () if self.patches else ("pattern",)

    def doubt(self, body: Body, shear_modulus: float) -> str:
        """Return words for a strength far beyond μT (N/m) on the interface, or μ (Pa) on the pial surface."""
        what = "AxonalTension: strength"
        if self.surface == "interface":
            words = of_line(what, self.strength, body, shear_modulus)
        else:
            words = of_stress(what, self.strength, shear_modulus)
        units = 'a line tension (surface="interface") is in N/m, a traction (surface="pial") in Pa'
        return words and f"{words}; {units}."

    def on(self, body: Body) -> TensionOperator:
        """Return the term discretised on `body`."""
        return TensionOperator(body, self)


class TensionOperator(Operator):
    """Tension on one body: the curve it acts on and its integration points."""

    def __init__(self, body: Body, term: AxonalTension) -> None:
        self.body, self.term = body, term
        self.line = Line(body, body.interface if term.surface == "interface" else body.pial)
        pairs = np.array([(k, l) for k in range(6) for l in range(k + 1)]).T
        dofs = self.line.dofs.reshape(6, -1)
        one, other = dofs[pairs[0]], dofs[pairs[1]]
        self.pairs, self.entries = pairs, Entries(np.maximum(one, other), np.minimum(one, other))

    def pattern(self, state: State) -> Array:
        """Return û at the curve's nodes, (3, m)."""
        body, term = self.body, self.term
        if term.patches:
            share = body.share_from_start(body.pial_curve.nearest(body.nodes[:, self.line.nodes])[2])
            values = 0.5 * (1.0 + np.cos(2 * np.pi * term.patches * share))
        else:
            values = body.spread(body.cortex, state["pattern"])[self.line.nodes]
        return self.line.by_edge(values)

    def during(self, state: State, step: TimeStep) -> DeadLoad | FollowerTension | None:
        """Return the load at the state's time, or None while it is zero."""
        term = self.term
        rise = 1.0 if term.ramp == 0 else min(1.0, state.time / term.ramp)
        if rise == 0 or term.strength == 0:
            return None
        pattern = self.pattern(state)
        if term.surface == "pial":
            return DeadLoad(rise * self._tractions(pattern))
        line = rise * term.strength * np.einsum("km,kg->gm", self._weight(pattern), SHAPES)
        return FollowerTension(self, line) if term.follower else DeadLoad(self._line_forces(line))

    def _weight(self, pattern: Array) -> Array:
        return 1.0 - pattern if self.term.direction == "between-peaks" else pattern

    def _line_forces(self, line: Array) -> Array:
        """Nodal forces of a line tension with fixed direction: -∫ γ T ∂_s v ds, (2 n_nodes,)."""
        forces = -np.einsum("g,gm,igm,kg->kim", WEIGHTS, line, self.line.tangent, DERIVATIVES)
        return self.line.nodal(forces)

    def _tractions(self, pattern: Array) -> Array:
        """Nodal forces of the tractions ±strength (∂_s û / max|∂_s û|) t, (2 n_nodes,)."""
        line = self.line
        slope = np.einsum("km,kg->gm", pattern, DERIVATIVES) / line.speed
        largest = np.abs(slope).max()
        if largest <= 1e-9 * np.abs(pattern).max() / line.curve.length:  # uniform but for round-off
            return np.zeros(2 * self.body.nodes.shape[1])
        sign = 1.0 if self.term.direction == "toward-peaks" else -1.0
        traction = sign * self.term.strength * slope / largest
        forces = np.einsum("g,gm,gm,igm,kg->kim", WEIGHTS, line.speed, traction, line.tangent, SHAPES)
        return line.nodal(forces)


@dataclass(frozen=True)
class FollowerTension(Potential):
    """Line tension along the deformed line: energy ∫ γ |∂x/∂ξ| dξ."""

    operator: TensionOperator
    line: Array  # γ at the integration points, (g, m)

    def evaluate(self, x: Array) -> FollowerEvaluation:
        """Return energy and derivatives at x."""
        operator = self.operator
        at = operator.body.nodes + x.reshape(-1, 2).T
        return FollowerEvaluation(self, np.einsum("ikm,kg->igm", at[:, operator.line.edges], DERIVATIVES))


class FollowerEvaluation(Evaluation):
    """Energy of a line tension at one configuration."""

    def __init__(self, potential: FollowerTension, along: Array) -> None:
        self.potential = potential
        self.speed = np.hypot(*along)
        self.tangent = along / self.speed
        self.weights = WEIGHTS[:, None] * potential.line
        self.energy = float((self.weights * self.speed).sum())
        self.round_off = 1e-15 * float((np.abs(self.weights) * self.speed).sum())

    def gradient(self) -> tuple[Array, float]:
        """Return ∫ γ T ∂_ξ v dξ."""
        forces = np.einsum("gm,igm,kg->kim", self.weights, self.tangent, DERIVATIVES)
        return self.potential.operator.line.nodal(forces), float(np.vdot(forces, forces))

    def hessian(self, convexity: float) -> Hessian:
        """Return ∫ γ/|∂_ξ x| (1 - T⊗T) ∂_ξ v ∂_ξ w dξ; semi-definite for a pulling tension as it is."""
        operator = self.potential.operator
        weights = self.weights / self.speed
        if convexity > 0:
            weights = np.where(weights < 0, (1 - convexity) * weights, weights)
        normal = np.stack([-self.tangent[1], self.tangent[0]])
        parts = weights, normal, normal, DERIVATIVES, DERIVATIVES
        blocks = np.einsum("gm,igm,jgm,kg,lg->kiljm", *parts, optimize=True)
        values = blocks.reshape(6, 6, -1)[operator.pairs[0], operator.pairs[1]]
        return Hessian(operator.entries, values)
