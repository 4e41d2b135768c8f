"""Reaction and diffusion: linear theory, spectra, steady patterns, trajectories, growing domains.

Numbers called independent were computed to 12 digits by spectral methods that share no code with this one.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from skfem import MeshTri, MeshTri2

from ..arrays import Array, Integers
from ..turing.eigenvalues import rightmost_eigenvalues
from ..turing.growing_domain import march_on_growing_domain
from ..turing.integrators.rosenbrock import Snapshot, march
from ..turing.kinetics.activator_inhibitor import FitzHughNagumo, GiererMeinhardt
from ..turing.kinetics.base import Kinetics
from ..turing.kinetics.bvam import BVAM
from ..turing.kinetics.chemical import Brusselator, GrayScott, LengyelEpstein, Schnakenberg, Thomas
from ..turing.kinetics.user import UserKinetics
from ..turing.modes import sign_changes, spectrum
from ..turing.reaction_diffusion import Discretisation, ReactionDiffusion, discretise
from ..turing.stability import conditions
from ..turing.steady import settle
from .check import Check, Quantity, quantities

INNER = 1 - 2.5 / 40.4  # radius of the band's inner side
D_U = 0.00207680687228251  # for which 12 half waves grow fastest on the band, D_v = 10 D_u
# kinetics, D_u, D_v: critical ratio and k², fastest k² and rate
LINEAR: tuple[tuple[str, Kinetics, float, float, tuple[float, float, float, float]], ...] = (
    ("Schnakenberg .1, .9", Schnakenberg(a=0.1, b=0.9), 1.0, 10.0,
     (8.567627457812106, 0.3416407864998738, 0.3185449728701349, 0.05719095841793663)),
    ("Schnakenberg .2, 1.3", Schnakenberg(a=0.2, b=1.3), 1.0, 30.0,
     (22.45262968532129, 0.3165611772087666, 0.282547435193277, 0.09023077059365739)),
    ("Gierer-Meinhardt", GiererMeinhardt(a=0.5, b=1.0, c=6.1, K=0.0), 1.0, 100.0,
     (47.17530642546601, 0.3595899560105791, 0.2723909488508353, 0.2402999512704732)),
    ("Gierer-Meinhardt, K=.12", GiererMeinhardt(a=0.1, b=1.0, c=1.0, K=0.12), 1.0, 30.0,
     (15.99821561434795, 0.2728094764600305, 0.2063016053587913, 0.1569574644222937)),
    ("Brusselator 2, 3", Brusselator(A=2.0, B=3.0), 1.0, 8.0,
     (7.464101615137755, 0.7320508075688773, 0.7175291203606145, 0.05772600824779646)),
    ("Brusselator 4.5, 6.75", Brusselator(A=4.5, B=6.75), 7.0, 56.0,
     (7.929212447933741, 0.2282966016219023, 0.2286046013983575, 0.01625384926488448)),
    ("BVAM .45", BVAM(alpha=0.899, beta=-0.91, gamma=-0.899, r1=3.5, r2=0.0), 1.032, 2.0,
     (1.879866518353726, 0.2010286225402504, 0.1983809389063258, 0.01318056866579396)),
    ("BVAM .84", BVAM(alpha=0.398, beta=-0.4, gamma=-0.398, r1=3.5, r2=0.0), 0.244, 2.0,
     (7.912546076590369, 0.7119823192429343, 0.6996222785308183, 0.006937903811907906)),
    ("FitzHugh-Nagumo", FitzHughNagumo(e_v=10.0, a_v=1.0, a_z=0.0, kappa=-0.005), 2.8e-4, 0.05,
     (20.18703333731917, 744.4856778217388, 635.1986415908327, 0.4977806568841962)),
    ("Gray-Scott", GrayScott(F=0.055, k=0.062), 1.0, 0.5,
     (1.67838585787336, 0.04678403252230434, 0.04481248246904095, 0.008841849416819313)),
    ("Lengyel-Epstein", LengyelEpstein(a=12.0, b=0.31, sigma=50.0), 1.0, 53.5,
     (39.17646841609899, 0.8380510649262388, 0.7298236754973686, 0.2493999756778766)),
)  # fmt: skip
# u at both radii on a peak and in a trough, v at the outer radius
STEADY = 1.43889924415, 0.57606079403, 1.43621625583, 0.57840272116, 0.71326159766, 1.07227023556
TRAJECTORY = {5.0: 1.0738509474, 10.0: 1.0971704400, 20.0: 1.1641050834}  # u on a peak of the outer side
SPECTRUM = {1: 1.0652378737175, 4: 17.043664162186, 8: 68.172841484829, 12: 153.38208724244}


def linear_theory() -> list[Quantity]:
    """√d_c = (√det J + √(-f_v g_u))/J_aa; k_c² = √(det J/(D_a D_i)) at d_c;
    fastest k² = [(D_u + D_v) √(-f_v g_u/(D_u D_v)) sign(D_v - D_u) - (f_u - g_v)]/(D_v - D_u).

    Murray, Mathematical Biology II, ch. 2; evaluated to 30 digits and found by a search too. Both are closed
    forms: round-off alone is tolerated.
    """  # fmt: skip
    found = []
    for name, kinetics, d_u, d_v, known in LINEAR:
        at = conditions(kinetics, d_u, d_v)
        got = (at.critical_ratio, at.critical_k2, at.fastest_k2, at.fastest_rate)
        names = [f"{name}: {what}" for what in ("critical ratio", "critical k²", "fastest k²", "its rate")]
        found += quantities(names, known, got, 1e-9)
    return found


def closed_thresholds() -> list[Quantity]:
    """Brusselator d_c = A²/(√B - 1)²; Schnakenberg, with s = a + b, from J = (2b/s - 1, s²; -2b/s, -s²).

    There √d_c = s (1 + √(2b/s))/(2b/s - 1). Thomas's set: 27.015, usually quoted 27.03; to its five digits.
    """
    brusselator = 4 / (3**0.5 - 1) ** 2
    slope = 2 * 0.9
    schnakenberg = ((1 + slope**0.5) / (slope - 1)) ** 2
    pairs = ((Brusselator(A=2.0, B=3.0), brusselator), (Schnakenberg(a=0.1, b=0.9), schnakenberg))
    found = [
        Quantity(f"{type(one).__name__}: critical ratio", known, conditions(one, 1, 30).critical_ratio, 1e-12)
        for one, known in pairs
    ]
    thomas = conditions(Thomas(), 1.0, 30.0).critical_ratio
    return [*found, Quantity("Thomas: critical ratio", 27.015, thomas, 2e-5)]


def mode_isolation() -> list[Quantity]:
    """k²± = γ [B ± √(B² - 4 d det J)]/(2d), B = d f_u + g_v = 7, det J = 1, d = 10, γ = 29: 5.8 and 14.5.

    Madzvamuse et al. (2003) choose γ so that the mode (1, 0) of the unit square, π², lies alone in the band.
    """
    at = conditions(Schnakenberg(a=0.1, b=0.9), 1 / 29, 10 / 29)
    return quantities(["lower end of the band", "upper end"], [5.8, 14.5], at.band, 1e-12)


def laplace_spectrum() -> list[Quantity]:
    """k² of the modes cos mθ of half an annulus without flux: zeros of J'_m(k) Y'_m(k r) - J'_m(k r) Y'_m(k).

    Quadratic elements, eight per half wave of the last, are off by less than 1e-4.
    """
    mesh = semi_annulus(96, 2)
    modes = spectrum(discretise(mesh, 2), 160.0, outer_line(mesh))
    got = {mode.half_waves: mode.value for mode in modes}
    names = [f"k², {m} half waves" for m in SPECTRUM]
    return quantities(names, [*SPECTRUM.values()], [got[m] for m in SPECTRUM], 1e-4)


def band_growth_rate() -> list[Quantity]:
    """λ of the fastest of all modes of the band: 12 half waves, 0.05719095841, by the dispersion relation."""
    system = band(120, 1)
    leading = rightmost_eigenvalues(system, system.uniform(1.0, 0.9))[0].real
    return [Quantity("fastest rate", 0.05719095841, float(leading), 1e-5)]


def band_steady_state() -> list[Quantity]:
    """The steady pattern of 12 half waves on the band; and ⟨u⟩ = a + b, as ∫ (p + q) = 0 without flux.

    At 16 elements a wave length quadratic elements are off by 3e-5.
    """
    system = band(96, 2)
    found = settle(system, start(system)).state
    names = ["u out, peak", "u out, trough", "u in, peak", "u in, trough", "v out, peak", "v out, trough"]
    mean = Quantity("mean of u", 1.0, float(system.space.mean(found)[0]), 1e-12)
    return [*quantities(names, STEADY, probes(system, found), 6e-5), mean]


def band_trajectory() -> list[Quantity]:
    """u on a peak, from u = 1 + 0.05 cos 12θ, v = 0.9; the differences are those of the mesh, 3e-5."""
    system, found = band(96, 2), []
    for time, known in TRAJECTORY.items():
        end = last(march(system, start(system), until=time, tolerance=1e-6))
        found.append(Quantity(f"u at t = {time:g}", known, float(probes(system, end.state)[0]), 6e-5))
    return found


def robertson() -> list[Quantity]:
    """A' = -0.04 A + 1e4 B C, B' = 0.04 A - 1e4 B C - 3e7 B², C = 1 - A - B, at t = 40.

    Hairer and Wanner (1996), ch. IV.1; the local error is 1e-6.
    """
    kinetics = UserKinetics(
        p=lambda a, b: -0.04 * a + 1e4 * b * (1 - a - b),
        q=lambda a, b: 0.04 * a - 1e4 * b * (1 - a - b) - 3e7 * b * b,
        partial_derivatives=lambda a, b: (
            -0.04 - 1e4 * b, 1e4 * (1 - a - 2 * b), 0.04 + 1e4 * b, -1e4 * (1 - a - 2 * b) - 6e7 * b,
        ),
        guesses=((0.8, 1e-5),),
    )  # fmt: skip
    system = ReactionDiffusion(discretise(semi_annulus(12, 1), 1), kinetics, 1.0, 1.0)
    end = last(march(system, system.uniform(1.0, 0.0), until=40.0, tolerance=1e-6))
    return quantities(["A", "B"], [0.715827069, 9.18553476e-6], end.state.mean(1), 1e-5)


def diffusion_conserves() -> list[Quantity]:
    """∫ u changes at the rate ∫ p alone: with u' = D ∇²u it stays; to round-off over ten steps."""
    nothing = UserKinetics(p=lambda u, v: 0 * u, q=lambda u, v: -v, guesses=((1.0, 1.0),))
    system = ReactionDiffusion(discretise(semi_annulus(24, 2), 2), nothing, 0.1, 0.1)
    state = system.uniform(1.0, 1.0)
    state[0] += np.random.default_rng(0).uniform(-0.5, 0.5, state.shape[1])
    end = last(march(system, state, until=1.0, tolerance=1e-4)).state
    change = float(system.space.mean(end)[0] / system.space.mean(state)[0] - 1)
    return [Quantity("change of the mean", 0.0, change, 1e-12)]


def growing_strip_decay() -> list[Quantity]:
    """u = (1 + exp(-D π² ∫ L⁻² dt) cos πx)/Lⁿ on a strip, or square, of side L = 3^t that dilutes."""
    nothing = UserKinetics(p=lambda u, v: 0 * u, q=lambda u, v: -v, guesses=((1.0, 1.0),))
    space, _ = strip(16)
    system, found = ReactionDiffusion(space, nothing, 0.1, 0.1), []
    begin = system.uniform(1.0, 1.0)
    begin[0] += np.cos(np.pi * space.nodes[0])
    spread = (1 - 3.0**-2) / (2 * np.log(3.0))
    for n in (1, 2):
        run = march_on_growing_domain(
            system, begin, lambda t: 3.0**t, until=1.0, dimensions=n, tolerance=1e-6, change=0.01
        )
        at_zero = float(last(run).state[0, int(np.argmin(space.nodes.sum(0)))])
        exact = float((1 + np.exp(-0.1 * np.pi**2 * spread)) / 3.0**n)
        found.append(Quantity(f"u at x = 0, {n} dimensions", exact, at_zero, 3e-5))
    return found


def mode_doubling() -> list[Quantity]:
    """Half waves on a strip of length e^{ρt} double each time that the strip does: every ln 2/ρ = 69.3.

    Crampin et al. (1999); Schnakenberg, D = 0.01 and 1, ρ = 0.01. A doubling is seen to within a step.
    """
    space, line = strip(192)
    system = ReactionDiffusion(space, Schnakenberg(a=0.1, b=0.9), 0.01, 1.0)
    begin = system.uniform(1.0, 0.9)
    begin[0] += 0.001 * np.cos(np.pi * space.nodes[0])
    seen: dict[int, float] = {}
    for moment in march_on_growing_domain(
        system, begin, lambda t: float(np.exp(0.01 * t)), until=285.0, dimensions=1, tolerance=1e-3
    ):
        along = moment.state[0, line]
        seen.setdefault(sign_changes(along - along.mean()), moment.time)
    times = [seen.get(count, float("nan")) for count in (2, 4, 8, 16)]
    names = ["from 2 to 4", "from 4 to 8", "from 8 to 16"]
    return quantities(names, [np.log(2.0) / 0.01] * 3, np.diff(times), 0.015)


def steady_state_order() -> list[Quantity]:
    """Order of the steady pattern's error at vertices: 2 with linear elements, 4 with quadratic ones.

    At vertices quadratic elements gain an order on a uniform mesh; their size is halved once.
    """
    found = []
    for degree, along, order, tolerance in ((1, 96, 2.0, 0.1), (2, 48, 4.0, 0.25)):
        errors = []
        for n in (along, 2 * along):
            system = band(n, n // 48, degree)
            errors.append(np.abs(probes(system, settle(system, start(system)).state) - STEADY).max())
        rate = float(np.log2(errors[0] / errors[1]))
        found.append(Quantity(f"order, degree {degree}", order, rate, tolerance))
    return found


def semi_annulus(along: int, across: int) -> MeshTri2:
    """Return a structured, exactly curved mesh of the band INNER < r < 1, 0 < θ < π."""
    flat = MeshTri.init_tensor(np.linspace(0, np.pi, along + 1), np.linspace(INNER, 1, across + 1))
    curved = MeshTri2.from_mesh(flat)
    theta, r = curved.doflocs
    return MeshTri2(np.stack([r * np.cos(theta), r * np.sin(theta)]), curved.t[[0, 2, 1]], validate=False)


def outer_line(mesh: MeshTri2) -> Integers:
    """Return the vertices on the outer side by angle."""
    x, y = mesh.doflocs[:, : mesh.nvertices]
    outer = np.flatnonzero(np.hypot(x, y) > 1 - 1e-9)
    return np.asarray(outer[np.argsort(np.arctan2(y[outer], x[outer]))])


def strip(along: int) -> tuple[Discretisation, Integers]:
    """Return a straight strip of length 1, one element across, and the nodes along it."""
    space = discretise(MeshTri.init_tensor(np.linspace(0, 1, along + 1), np.array([0, 1 / along])), 2)
    line = np.flatnonzero(space.nodes[1] == 0.0)
    return space, np.asarray(line[np.argsort(space.nodes[0, line])])


def band(along: int, across: int, degree: int = 2) -> ReactionDiffusion:
    """Return Schnakenberg's kinetics on the band, with 12 half waves growing fastest."""
    kinetics = Schnakenberg(a=0.1, b=0.9)
    return ReactionDiffusion(discretise(semi_annulus(along, across), degree), kinetics, D_U, 10 * D_U)


def start(system: ReactionDiffusion) -> Array:
    """Return u = 1 + 0.05 cos 12θ, v = 0.9."""
    state = system.uniform(1.0, 0.9)
    x, y = system.space.nodes
    state[0] += 0.05 * np.cos(12 * np.arctan2(y, x))
    return state


def probes(system: ReactionDiffusion, state: Array) -> Array:
    """Return the six values of STEADY, taken at θ = π/3 and 5π/12, away from the corners."""
    x, y = system.space.nodes
    places = [
        int(np.hypot(x - r * np.cos(angle), y - r * np.sin(angle)).argmin())
        for r in (1.0, INNER)
        for angle in (np.pi / 3, np.pi / 3 + np.pi / 12)
    ]
    return np.concatenate([state[0, places], state[1, places[:2]]])


def last(moments: Iterable[Snapshot]) -> Snapshot:
    """Return the last of a run."""
    *_, end = moments
    return end


MURRAY = "Murray, Mathematical Biology II, ch. 2"
SPECTRAL = "independent spectral solution"
CHECKS = (
    Check("Turing: linear theory", linear_theory, MURRAY),
    Check("Turing: closed thresholds", closed_thresholds, MURRAY),
    Check("Turing: mode isolation", mode_isolation, "Madzvamuse et al. 2003"),
    Check("Turing: Laplace spectrum", laplace_spectrum, "Bessel functions"),
    Check("Turing: growth rate on the band", band_growth_rate, "dispersion relation"),
    Check("Turing: steady pattern", band_steady_state, SPECTRAL),
    Check("Turing: trajectory", band_trajectory, SPECTRAL),
    Check("Turing: Robertson", robertson, "Hairer & Wanner 1996, IV.1"),
    Check("Turing: diffusion conserves", diffusion_conserves, "zero flux"),
    Check("Turing: growing strip", growing_strip_decay, "closed form"),
    Check("Turing: mode doubling", mode_doubling, "Crampin et al. 1999", full=True),
    Check("Turing: order of the pattern", steady_state_order, SPECTRAL, full=True),
)
