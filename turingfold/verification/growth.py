"""Growth without buckling: discs, rings, free swelling, growth driven by stress, ages."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ..arrays import Array
from ..geometry.body import by_node
from ..geometry.shapes import semicircle
from ..growth.ages import Weeks
from ..growth.laws import TangentialGrowth
from ..growth.stress_driven import StressGrowth, VolumeGrowth
from ..growth.swelling import Swelling
from ..parts import TimeStep
from ..scene import Scene
from ..state import State
from ..stepping import Stepping
from ..terms.elastic.material import NeoHookean
from ..terms.elastic.term import Elastic
from .check import Check, Quantity, printed, quantities
from .exact import disc, free_ring, incompressible_stress
from .setups import GRAY, SOFT, WHITE, bar, equilibrium, evaluated, last_step, quarter_ring

STIFF = NeoHookean(mu=1e3, kappa=5e3)
LAYER = 2.5 / 40.4
# core, cortex, thickness, growth: core stretch, outer radius, stress of the core
DISCS = (
    ("document 1, g = 1.2", (WHITE, GRAY, LAYER, 1.2), ("1.0015094462", "1.0112836843", "23.5332")),
    ("document 2, g = 1.2", (SOFT, SOFT, LAYER, 1.2), ("1.0040961501", "1.0115104492", "0.0437447")),
    ("T/R = .1, g = 1.1", (SOFT, SOFT, 0.1, 1.1), ("1.003222", "1.009302", "0.03440")),
    ("T/R = .1, g = 1.2", (SOFT, SOFT, 0.1, 1.2), ("1.006568", "1.018205", "0.07020")),
)


def exact_discs() -> list[Quantity]:
    """(R Π)' = H with Π = g ∂ψ/∂a, H = ∂ψ/∂b, a = r', b = r/(g R), integrated with a relative error of 1e-11.

    The known numbers come from another code; their printed digits must agree.
    """
    found = []
    for name, given, known in DISCS:
        names = [f"{name}: {what}" for what in ("core stretch", "outer radius", "core stress")]
        found += printed(names, known, disc(*given))
    return found


def stiff_and_soft_cortex() -> list[Quantity]:
    """Core stretch and outer radius, g = 1.2, cortex 1000 times stiffer and softer; and axisymmetric g = 4.

    To the eight decimals of an independent computation.
    """
    rows = (
        ("1000 x stiffer", disc(SOFT, STIFF, LAYER, 1.2), ("1.19173505", "1.18038336")),
        ("1000 x softer", disc(STIFF, SOFT, LAYER, 1.2), ("1.00000422", "1.00784200")),
    )
    found = []
    for name, got, known in rows:
        found += printed([f"{name}: core stretch", f"{name}: outer radius"], known, got[:2])
    far = disc(WHITE, GRAY, LAYER, 4.0)[1], disc(SOFT, SOFT, LAYER, 4.0)[1]
    names = ["document 1, g = 4: outer radius", "document 2, g = 4: outer radius"]
    return found + printed(names, ("1.09078631", "1.06321547"), far)


def grown_discs() -> list[Quantity]:
    """The program's half disc on rollers against the exact one: largest error of the pial radius, g = 1.2.

    Two elements through the cortex: quadratic elements are off by less than 1e-5 of the radius.
    """
    rows = (("document 1", WHITE, GRAY, "fixed"), ("document 2", SOFT, SOFT, "fixed"),
            ("document 2, growth of area", SOFT, SOFT, "tangential"))  # fmt: skip
    found = []
    for name, core, cortex, out in rows:
        radii, stretch = grown_disc(core, cortex, LAYER / 2, out)
        exact = disc(core, cortex, LAYER, 1.2, 1.2 if out == "tangential" else 1.0)
        far = radii[np.argmax(np.abs(radii - exact[1]))]
        found += quantities(
            [f"{name}: pial radius", f"{name}: core stretch"], exact[:2][::-1], [far, stretch], 1e-5
        )
    return found


def free_rings() -> list[Quantity]:
    """r² = a² + g (R² - A²) with no load on either side, g = 1.1: a = 0.571776, b = 1.073279; and g = 1.2.

    The program's quarter ring with κ = 500 μ against the exact solution for that κ, off by its mesh, 1e-5;
    and that against the closed form, to which it tends as μ/κ.
    """
    found = []
    for growth, known in ((1.1, ("0.571776", "1.073279")), (1.2, ("0.644479", "1.146889"))):
        a = brentq(partial(_inner_stress, growth), 0.5, 0.8)
        closed = a, float(np.sqrt(a * a + growth * 0.75))
        found += printed([f"g = {growth}: a, closed form", f"g = {growth}: b"], known, closed)
    material = NeoHookean(mu=1.0, kappa=500.0)
    body, sides, radius = quarter_ring(0.5, 1.0, 24, 12)
    factors = np.ones((3, *body.quadrature.weights.shape))
    factors[0] = 1.2
    # the bulk part's round-off is large against the shear part that the residual is measured by
    u, _ = equilibrium(
        body, Elastic(gray=material), sides, np.zeros(2 * len(radius)), growth=factors, tolerance=5e-10
    )
    moved = np.hypot(*(body.nodes + u))
    got = [moved[np.isclose(radius, R)].mean() for R in (0.5, 1.0)]
    exact = free_ring(material, 1.2)
    return [
        *found,
        *quantities(["κ = 500, g = 1.2: a of the mesh", "κ = 500, g = 1.2: b of the mesh"], exact, got, 1e-5),
        Quantity("κ = 500, g = 1.2: a, exact against closed form", closed[0], exact[0], 2e-5),
    ]


def rings_on_a_core() -> list[Quantity]:
    """A ring A = 0.9 on a core that keeps its size: b² = 0.81 + 0.19 g, and the core stress T_rr(A).

    The compressible solution at κ = 1e4 μ tends to it as 1/κ.
    """
    stiff, found = NeoHookean(mu=1.0, kappa=1e4), []
    for growth, known in ((1.1, ("1.009455", "0.041747")), (1.2, ("1.018823", "0.087368"))):
        closed = float(np.sqrt(0.81 + growth * 0.19)), incompressible_stress(growth, 0.9, 0.9, 1.0)
        got = disc(stiff, stiff, 0.1, growth)[1:]
        names = [f"g = {growth}: outer radius", f"g = {growth}: core stress / μ"]
        found += printed([f"{name}, closed form" for name in names], known, closed)
        found += quantities([f"{name}, κ = 1e4 μ" for name in names], closed, got, 1e-3)
    return found


def free_swelling() -> list[Quantity]:
    """A free body swells without stress: stretch 1 + β in the plane where z is free to thicken.

    Held in z, g_z = 1 + β, it takes the stretch λ at which ∂ψ/∂λ = 0 of F* = diag(λ/g, λ/g, 1/g), g = 1 + β.
    The body is a half disc on rollers; equilibrium to 1e-10.
    """
    found, g = [], 1.3

    def slope(stretch: float) -> float:  # ∂/∂λ of μ/2 (I₁ J^{-2/3} - 3) + κ/2 (J - 1)²
        a, z = stretch / g, 1 / g
        J = a * a * z
        shear = 2 * a * J ** (-2 / 3) - (2 / 3) * (2 * a * a + z * z) * J ** (-2 / 3) / a
        return float(SOFT.mu * shear + SOFT.kappa * (J - 1) * 2 * a * z)

    held = brentq(slope, 1.0, 2.0, xtol=1e-14)
    for out, known in (("fixed", g), ("tangential", held)):
        body = semicircle(radius=1.0, thickness=0.2, size=0.2, base="roller")
        swell = Swelling(coefficient=g - 1, zone="all", out_of_plane=out)
        scene = Scene(
            body=body, terms=(Elastic(gray=SOFT),), processes=(swell,),
            stepping=Stepping(first=0.5, largest=0.5, tolerance=1e-10),
        )  # fmt: skip
        moved = body.nodes + last_step(scene).state["displacement"]
        words = "free in z" if out == "fixed" else "held in z"
        found.append(Quantity(f"stretch, {words}", known, float(np.hypot(*moved)[body.pial].mean()), 1e-7))
    return found


def stress_growth() -> list[Quantity]:
    """Ġ G⁻¹ = a σ of a bar held at stretches (1.2, 1) and (1.15, 1.15), a μ = 1, t = 0.3, from the law of σ.

    The differential equation is solved to 1e-11; the process takes 160 steps of order one, off by 1e-4.
    Bayly et al. (2013), Phys. Biol. 10, 016005.
    """
    found = []
    for name, stretches in (("uniaxial", (1.2, 1.0)), ("equibiaxial", (1.15, 1.15))):
        exact = solve_ivp(
            partial(_growth_rate, stretches), (0, 0.3), np.ones(2), rtol=1e-11, atol=1e-12
        ).y[:, -1]  # fmt: skip
        got = held_growth(StressGrowth(rate=1 / WHITE.mu), stretches, 0.3, 160)[:2]
        found += quantities([f"{name}: growth along x", f"{name}: growth along y"], exact, got, 3e-4)
    return found


def stress_growth_order() -> list[Quantity]:
    """The error of growth in response to stress falls with order 1 in the step; 40 and 80 steps."""
    stretches = (1.2, 1.0)
    exact = solve_ivp(partial(_growth_rate, stretches), (0, 0.3), np.ones(2), rtol=1e-11, atol=1e-12).y[0, -1]
    law = StressGrowth(rate=1 / WHITE.mu)
    errors = [abs(held_growth(law, stretches, 0.3, n)[0] - exact) for n in (40, 80)]
    return [Quantity("order in the step", 1.0, float(np.log2(errors[0] / errors[1])), 0.1)]


def volume_growth() -> list[Quantity]:
    """ϑ̇ = G_s ⟨J/ϑ² - J⁰⟩ of a bar held at the area J = 1.2 · 1.1: it ends at ϑ² = J/J⁰.

    Budday et al. (2014); G_s t = 1e6 has come to its end.
    """
    found = []
    for set_point in (1.0, 1.05):
        got = held_growth(VolumeGrowth(rate=1e6, set_point=set_point), (1.2, 1.1), 1.0, 80)[0]
        known = float(np.sqrt(1.2 * 1.1 / set_point))
        found.append(Quantity(f"growth, J⁰ = {set_point:g}", known, float(got), 1e-3))
    return found


def weeks() -> list[Quantity]:
    """Shares of growth s(w) = 6.926e-5 w³ - 0.00665 w² + 0.250 w - 3.0189, or 0.987 exp(-exp(-0.134 (w -
    29.433))): g = 1 + 0.9 (s(w) - s(28))/(s(40) - s(28)), at week 32. Wang et al. (2019).
    """  # fmt: skip

    def wang(w: float) -> float:
        return 6.926e-5 * w**3 - 0.00665 * w**2 + 0.250 * w - 3.0189

    def gompertz(w: float) -> float:
        return float(0.987 * np.exp(-np.exp(-0.134 * (w - 29.433))))

    found = []
    for curve, share in (("wang", wang), ("gompertz", gompertz)):
        known = 1 + 0.9 * (share(32) - share(28)) / (share(40) - share(28))
        got = Weeks(curve=curve).factor(1.9, 1 / 3)
        found.append(Quantity(f"{curve}: growth at week 32", known, got, 1e-12))
    return found


def disc_order() -> list[Quantity]:
    """Order of the pial radius of document 1's disc, g = 1.2: at least 3 with quadratic elements.

    Elements through the cortex: 1, 2 and 4; the radius gains a little on the displacement's L2 order.
    """
    exact = disc(WHITE, GRAY, LAYER, 1.2)[1]
    errors = [np.abs(grown_disc(WHITE, GRAY, LAYER / n, "fixed")[0] - exact).max() for n in (1, 2, 4)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    return [Quantity("mean order, 1 to 4 elements", 3.0, float(orders.mean()), 0.2)]


def grown_disc(core: NeoHookean, cortex: NeoHookean, size: float, out: str) -> tuple[Array, float]:
    """Return the radii of the pial nodes of a half disc of radius 1 grown by 1.2, and its core's stretch."""
    body = semicircle(radius=1.0, thickness=LAYER, size=size, base="roller", coarsening=1.35)
    scene = Scene(
        body=body, terms=(Elastic(gray=cortex, white=core),),
        processes=(TangentialGrowth(cortex=1.2, out_of_plane=out),),
        stepping=Stepping(first=0.25, largest=0.5, tolerance=1e-10),
    )  # fmt: skip
    radius = np.hypot(*body.nodes)
    moved = np.hypot(*(body.nodes + last_step(scene).state["displacement"]))
    inner = (radius < 0.9 * (1 - LAYER)) & (radius > 0)
    return moved[body.pial], float((moved[inner] / radius[inner]).mean())


def held_growth(
    law: StressGrowth | VolumeGrowth, stretches: tuple[float, float], until: float, steps: int
) -> Array:
    """Return the growth (3,) of white matter in a bar that is held at two stretches, after so many steps."""
    body, solid, dt = bar(), Elastic(gray=WHITE), until / steps
    evolution, operator = law.on(body), solid.on(body)
    u = np.diag(np.asarray(stretches) - 1.0) @ body.nodes
    state = State(0.0, {"displacement": u})
    state = state.updated(**evolution.start(state, 0))
    for _ in range(steps):
        at = evaluated(operator.during(state, TimeStep(dt)), by_node(u))
        before = state.updated(**at.finish(frozenset(solid.writes)))
        now = State(state.time + dt)
        state = before.updated(now.time, **evolution.advance(before, now, dt))
    return np.asarray(state["growth"][:, 0, np.flatnonzero(~body.in_cortex)[0]])


def _growth_rate(stretches: tuple[float, float], time: float, growth: Array) -> Array:
    """Return Ġ of a bar at fixed stretches with a μ = 1, from σ_i = μ J^{-5/3} (λ_i² - I₁/3) + κ (J - 1)."""
    elastic = np.array([stretches[0] / growth[0], stretches[1] / growth[1], 1.0])
    J = elastic.prod()
    ratio = WHITE.kappa / WHITE.mu
    stress = J ** (-5 / 3) * (elastic**2 - (elastic**2).mean()) + ratio * (J - 1)
    return np.asarray(growth * stress[:2])


def _inner_stress(growth: float, a: float) -> float:
    return incompressible_stress(growth, a, 0.5, 1.0)


AXISYMMETRIC = "exact axisymmetric solution"
CHECKS = (
    Check("Growth: discs, exact solution", exact_discs, "independent integration"),
    Check("Growth: discs, stiff, soft and far", stiff_and_soft_cortex, "independent integration"),
    Check("Growth: discs, program", grown_discs, AXISYMMETRIC),
    Check("Growth: free ring", free_rings, AXISYMMETRIC),
    Check("Growth: ring on a core", rings_on_a_core, AXISYMMETRIC),
    Check("Growth: free swelling", free_swelling, "closed form"),
    Check("Growth: stress-driven bars", stress_growth, "Bayly et al. 2013"),
    Check("Growth: volume-driven bar", volume_growth, "Budday et al. 2014"),
    Check("Growth: weeks", weeks, "Wang et al. 2019"),
    Check("Growth: order of the disc", disc_order, AXISYMMETRIC, full=True),
    Check("Growth: order in the step", stress_growth_order, "Bayly et al. 2013", full=True),
)
