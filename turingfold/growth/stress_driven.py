"""Growth of white matter in response to stress: axons that are pulled grow longer."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..checks import one_of, positive
from ..errors import StepTooLongError
from ..geometry.body import Body
from ..geometry.layers import cortex_indicator
from ..parts import Evolution, Fields, Process
from ..state import State
from .laws import OUT_OF_PLANE, multiplied

LARGEST = 0.2  # of the logarithm of a growth factor in one step; a longer step is taken in shorter ones


@dataclass(frozen=True, kw_only=True)
class _Responding(Process):
    """A law of white matter whose growth goes on from the last equilibrium; writes "growth".

    end: time of the scene after which it does not respond any more; None for never.
    """

    rate: float
    out_of_plane: str = "fixed"
    end: float | None = None

    def __post_init__(self) -> None:
        positive("rate", self.rate, remedy="leave the law out for none")
        if self.end is not None:
            positive("end", self.end, remedy="leave it out for a response that goes on")
        one_of("out_of_plane", self.out_of_plane, OUT_OF_PLANE)

    @property
    def optional(self) -> tuple[str, ...]:
        """The growth by an earlier law, which it multiplies."""
        return ("growth",)

    @property
    def writes(self) -> tuple[str, ...]:
        """Growth factors along tangent, normal and z, and its own share of them; each (3, q, e)."""
        return ("growth", "response")

    @property
    def keeps(self) -> tuple[str, ...]:
        """Its own share of the growth."""
        return ("response",)

    @property
    def remembers(self) -> bool:
        """It does: growth adds up along the way."""
        return True

    def on(self, body: Body) -> RespondingOnBody:
        """Return the law on a body."""
        return RespondingOnBody(self, body)

    @abstractmethod
    def increments(self, body: Body, before: State, dt: float) -> Array:
        """Return the changes of the logarithms of the growth factors over a step, (3, q, e)."""


@dataclass(frozen=True, kw_only=True)
class StressGrowth(_Responding):
    """White matter grows along the stress that it bears: Ġ G⁻¹ = a Rᵀ σ R (Bayly et al. 2013).

    With σ the Cauchy stress and R the rotation of the elastic deformation F* = R U, of which the components
    along tangent and normal of the nearest pial point count: ġ_t/g_t = a σ_tt, ġ_n/g_n = a σ_nn. Shear
    between the two does not grow. g_z = 1 ("fixed") or ġ_z/g_z = a σ_zz ("tangential").
    Each step is implicit in how growth relaxes the stress of a point whose deformation stays: of first order
    in the step, and stable at any.
    rate: a in 1/(Pa · time); 1/(a μ) is the time in which growth relaxes shear stress.  end: time after which
    nothing grows.
    Source: Bayly, Okamoto, Xu, Shi, Taber (2013) Phys. Biol. 10:016005.
    """

    @property
    def reads(self) -> tuple[str, ...]:
        """The last equilibrium: its shape, its stress, and the moduli that growth relaxes it by."""
        return ("displacement", "cauchy_stress", "moduli")

    def increments(self, body: Body, before: State, dt: float) -> Array:
        """Return the changes of the logarithms of the growth factors over a step, (3, q, e)."""
        stress = in_tissue(body, before)
        (mu, kappa), count = before["moduli"], 2 if self.out_of_plane == "fixed" else 3
        grown = stress[:count]
        mean = grown.mean(0)
        # at a fixed deformation, growth by ε relaxes the deviator by 2 μ ε and the mean by count κ ε, and the
        # in-plane mean by 2 μ/3 ε more where z does not grow
        volume = count * kappa + (2 * mu / 3 if count == 2 else 0.0)
        change = np.zeros_like(stress)
        a = self.rate * dt
        change[:count] = a * (grown - mean) / (1 + 2 * a * mu) + a * mean / (1 + a * volume)
        return change


@dataclass(frozen=True, kw_only=True)
class VolumeGrowth(_Responding):
    """White matter grows where it is stretched in volume beyond a set point: ϑ̇ = G_s ⟨J* - J⁰⟩.

    Growth is isotropic in the plane, g_t = g_n = ϑ, with g_z = 1 ("fixed") or ϑ ("tangential"); ⟨x⟩ is x
    where positive, else 0. Each step is implicit in how growth lowers J* of a point whose deformation stays:
    of first order in the step, stable at any, and never below the set point.
    rate: G_s per unit of time.  set_point: J⁰.  end: time after which nothing grows.
    Source: Budday, Steinmann, Kuhl (2014) J. Mech. Phys. Solids 72:75.
    """

    set_point: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("set_point", self.set_point, remedy="1 grows in response to any gain of volume")

    @property
    def reads(self) -> tuple[str, ...]:
        """The elastic volume ratio of the last equilibrium."""
        return ("elastic_volume",)

    def increments(self, body: Body, before: State, dt: float) -> Array:
        """Return the changes of the logarithms of the growth factors over a step, (3, q, e)."""
        J, old = before["elastic_volume"], before["response"][0]
        count = 2 if self.out_of_plane == "fixed" else 3
        excess = np.maximum(J - self.set_point, 0.0)
        slope = count * J / old
        now = old + self.rate * dt * excess / (1 + self.rate * dt * slope)
        change = np.zeros((3, *J.shape))
        change[:count] = np.log(now / old)
        return change


class RespondingOnBody(Evolution):
    """A law of white matter on one body."""

    def __init__(self, law: _Responding, body: Body) -> None:
        self.law, self.body = law, body
        self.white = 1.0 - cortex_indicator(body)

    def start(self, state: State, seed: int) -> Fields:
        """Return no growth of its own."""
        return self._fields(np.ones((3, *self.white.shape)), state)

    def advance(self, before: State, now: State, dt: float) -> Fields:
        """Return the growth after the response to the last equilibrium."""
        end = self.law.end
        grows = dt if end is None else min(dt, end - before.time)
        if grows <= 0:
            return self._fields(before["response"], now)
        change = self.white * self.law.increments(self.body, before, grows)
        if (most := float(np.abs(change).max())) > LARGEST:
            raise StepTooLongError(
                f"{type(self.law).__name__}: growth would change by a factor of {np.exp(most):.3g} in a step "
                f"of {dt:.3g}, more than {np.exp(LARGEST):.3g}; use a smaller rate={self.law.rate:g}, or "
                "allow shorter steps (Stepping(smallest=...))",
                length=0.5 * dt,
                time=before.time,
            )
        return self._fields(before["response"] * np.exp(change), now)

    def _fields(self, response: Array, state: State) -> Fields:
        return {"response": response, "growth": multiplied(type(self.law).__name__, response, state)}


def in_tissue(body: Body, state: State) -> Array:
    """Return the Cauchy stress turned back with the tissue: along tangent, normal and z, (3, q, e); Pa.

    R of F* = R U is found in the plane, where it turns by atan2(F*₂₁ - F*₁₂, F*₁₁ + F*₂₂).
    """
    xx, yy, xy, zz = state["cauchy_stress"]
    u = state["displacement"][:, body.triangles]
    moved = np.einsum("iae,amq,mjqe->ijqe", u, body.quadrature.derivatives, body.quadrature.inverse)
    F = moved + np.eye(2)[:, :, None, None]
    (tx, ty), growth = body.tangent, state["growth"]
    t, n = np.stack([tx, ty]), np.stack([-ty, tx])
    inverse = np.einsum("iqe,jqe->ijqe", t / growth[0], t) + np.einsum("iqe,jqe->ijqe", n / growth[1], n)
    elastic = np.einsum("ikqe,kjqe->ijqe", F, inverse)
    angle = np.arctan2(elastic[1, 0] - elastic[0, 1], elastic[0, 0] + elastic[1, 1])
    c, s = np.cos(angle), np.sin(angle)
    x, y = c * tx - s * ty, s * tx + c * ty  # the turned tangent
    along = x * x * xx + 2 * x * y * xy + y * y * yy
    return np.stack([along, xx + yy - along, zz])
