"""The human brain slice of document 1, 28th gestational week: its tissue, and what acts on it; SI units.

Radius 40.4 mm, cortex 2.5 mm; Young's modulus of gray matter 1389 ± 289 Pa, of white 1895 ± 592 Pa, Poisson's
ratio 0.4583.
"""

from __future__ import annotations

import numpy as np

from ..checks import one_of
from ..geometry.body import Body
from ..growth.ages import Weeks
from ..growth.histories import History, Linear, Table
from ..growth.laws import TangentialGrowth
from ..growth.stress_driven import StressGrowth
from ..growth.swelling import Swelling
from ..growth.zones import Ellipse
from ..parts import Load, Process, Term
from ..scene import Scene
from ..stepping import Stepping
from ..terms.boundary_loads import BoundaryLoads, PeakLoads
from ..terms.contact import SelfContact
from ..terms.damping import StiffnessDamping
from ..terms.dynamics import Inertia
from ..terms.elastic.material import NeoHookean
from ..terms.elastic.term import Elastic
from ..terms.tension import AxonalTension
from ..turing.kinetics.named import kinetics_named
from ..turing.process import Turing

GROWTH_LAWS = "prescribed", "stress", "cortex"
LOADS = "tension", "figure1"
REST = 1.0  # s after growth in which a motion dies
SWELLING_EDGE = 0.25  # of the inner core's smaller semi-axis, over which swelling sets in
HALF_WAVE = 2.115  # width of a half wave in thicknesses of the cortex: 24 of them in Figure 3, π 40.4/2.5/24


def brain(
    body: Body, *, young_gray: float = 1389.0, young_white: float = 1895.0, poisson: float = 0.4583,
    two_layers: bool = True, cortex: float = 2.3, core: float = 1.05, radial_core: float = 1.1,
    swelling: float = 0.2, growth_law: str = "prescribed", stress_rate: float = 1.0,
    kinetics: str = "Schnakenberg", half_waves: int | None = None, strength: float = 0.75,
    pattern: bool = True, tension: bool = True, loads: str = "tension", dynamics: bool = False,
    duration: float = 10.0, density: float = 1100.0, damping: float = 0.01, local_error: float = 0.02,
    ages: Weeks | None = None, stops: tuple[float, ...] = (), seed: int = 0,
) -> Scene:  # fmt: skip
    """Return the scene of Figures 2 and 3 on a body: pattern, pull, growth of cortex and core, contact.

    dynamics: with inertia and damping, from rest, in seconds: growth takes `duration`, and a second follows
    in which the motion dies; otherwise growth takes the time 1 and passes through equilibria.
    damping, density: of `motion`.  local_error: of `resolved`.
    ages: the history of growth, whose end is then that of the scene.  stops: times at which a step ends.
    Others: `tissue`, `pattern_and_pull`, `growth`.
    """
    time = ages.duration if ages else duration if dynamics else 1.0
    history = ages or (Table(times=(0.0, time), shares=(0.0, 1.0)) if dynamics else Linear())
    solid = tissue(young_gray=young_gray, young_white=young_white, poisson=poisson, two_layers=two_layers)
    morphogens, pull = pattern_and_pull(
        kinetics=kinetics, half_waves=_waves(body, half_waves), strength=strength, pattern=pattern,
        tension=tension, loads=loads, body=body, ramp=0.1 * time,
    )  # fmt: skip
    grow = growth(
        body, cortex=cortex, core=core, radial_core=radial_core, swelling=swelling, law=growth_law,
        rate=stress_rate, solid=solid, history=history, duration=time,
    )  # fmt: skip
    processes, terms = (*morphogens, *grow), (solid, *pull, SelfContact())
    if not dynamics:
        stepping = Stepping(stops=stops)
        return Scene(body=body, processes=processes, terms=terms, until=time, stepping=stepping, seed=seed)
    return Scene(
        body=body, processes=processes, terms=(*terms, *motion(solid, density=density, damping=damping)),
        until=time if ages else time + REST, seed=seed,
        stepping=resolved(body, local_error=local_error, stops=stops),
    )  # fmt: skip


def half_waves(body: Body, width: float = HALF_WAVE) -> int:
    """Return the even number of half waves along the pial surface nearest to L/(width T), at least 2.

    width: of a half wave, in thicknesses of the cortex.
    """
    along = body.pial_curves.length * (2 if body.mirror else 1)
    return max(2, 2 * round(along / (2 * width * body.thickness)))


def tissue(
    *, young_gray: float = 1389.0, young_white: float = 1895.0, poisson: float = 0.4583,
    two_layers: bool = True,
) -> Elastic:  # fmt: skip
    """Return cortex and core, moduli in Pa; without `two_layers` the core is gray matter too."""
    gray = NeoHookean.from_young(young_gray, poisson)
    return Elastic(gray=gray, white=NeoHookean.from_young(young_white, poisson) if two_layers else None)


def growth(
    body: Body, *, cortex: float = 2.3, core: float = 1.05, radial_core: float = 1.1, swelling: float = 0.2,
    law: str = "prescribed", solid: Elastic | None = None, rate: float = 1.0, history: History | None = None,
    duration: float = 1.0,
) -> tuple[Process, ...]:  # fmt: skip
    """Return the growth of cortex and core, and the swelling of the inner core where there is any.

    cortex, core: tangential factors at the end.  radial_core: radial factor of the core.
    swelling: excess of the stretch, in x, y and z, inside half the body's semi-axes.
    law: "prescribed"; "cortex", which alone grows; or "stress": white matter grows along the stress that it
    bears in place of `core` and `radial_core`, at `rate` over the shear modulus of `solid`'s white matter and
    `duration`.
    """
    one_of("law", law, GROWTH_LAWS)
    history = history or Linear()
    if law != "prescribed":
        core = radial_core = 1.0
    found: list[Process] = [
        TangentialGrowth(cortex=cortex, core=core, radial_core=radial_core, history=history)
    ]
    if swelling and law != "cortex":
        width, height = 0.5 * np.ptp(body.nodes[0]), float(body.nodes[1].max())
        axes = 0.5 * float(width) * (2 if body.mirror else 1), 0.5 * height
        inner = Ellipse(centre=(0.0, 0.0), semi_axes=axes, edge=SWELLING_EDGE * min(axes))
        found.append(Swelling(coefficient=swelling, zone=inner, history=history))
    if law == "stress":
        solid = solid or tissue()
        modulus = (solid.white or solid.gray).mu
        found.append(StressGrowth(rate=rate / (modulus * duration), end=duration))
    return tuple(found)


def pattern_and_pull(
    *, kinetics: str = "Schnakenberg", half_waves: int = 24, strength: float = 0.5, pattern: bool = True,
    tension: bool = True, patches: int | None = None, ramp: float = 0.1, loads: str = "tension",
    body: Body | None = None,
) -> tuple[tuple[Turing, ...], tuple[Load, ...]]:  # fmt: skip
    """Return the morphogens, and what pulls; empty where it is off.

    loads: "tension" of axons along the gray-white interface, or "figure1", the arrows of document 1's Figure
    1: pairs of forces on the pial surface of `body`, which pull together across each peak.
    Without a pattern there are `patches` places, by default as many as it has waves, that pull equally.
    strength: of the tension, or of each arrow, N/m.  ramp: time over which it rises.
    """
    one_of("loads", loads, LOADS)
    morphogens = (Turing(kinetics_named(kinetics), half_waves=half_waves),) if pattern else ()
    places = 0 if pattern else patches or max(1, half_waves // 2)
    if not tension:
        return morphogens, ()
    if loads == "tension":
        return morphogens, (AxonalTension(strength=strength, patches=places, ramp=ramp),)
    if body is None:
        raise ValueError("loads='figure1' are arrows on the surface of a body; give body=.")
    # as far apart as the cortex is thick on either side, each spread over half of that
    distance, width = body.thickness, 0.5 * body.thickness
    if pattern:
        return morphogens, (PeakLoads(strength=strength, distance=distance, width=width, ramp=ramp),)
    return morphogens, (_pairs(body, places, strength, distance, width, ramp),)


def motion(solid: Elastic, *, density: float = 1100.0, damping: float = 0.01) -> tuple[Term, ...]:
    """Return inertia, and the damping by which a motion dies: a stress of `damping`, s, times the rate.

    density: kg/m³. A vibration of frequency ω has the damping ratio damping·ω/2. Document 1 gives none; the
    choice is ours, and part of the model: the energy that snaps set free must go somewhere.
    """
    inertia = Inertia(density=density)
    return (inertia, StiffnessDamping(elastic=solid, time=damping)) if damping else (inertia,)


def resolved(body: Body, *, local_error: float = 0.02, stops: tuple[float, ...] = ()) -> Stepping:
    """Return steps that resolve the motion of a body: each off by at most `local_error` thicknesses."""
    bound = local_error * body.thickness
    return Stepping(first=1 / 1000, largest=1 / 40, smallest=1e-7, local_error=bound, stops=stops)


def _waves(body: Body, given: int | None) -> int:
    return given or half_waves(body)


def _pairs(
    body: Body, count: int, strength: float, distance: float, width: float, ramp: float
) -> BoundaryLoads:
    """Return pairs of forces that pull together across `count` evenly spaced places of the pial surface.

    Pairs that reach beyond an end of the surface are left out; half a body has the forces of its half.
    """
    curve = body.pial_curve
    length = curve.length * (2 if body.mirror else 1)
    middles = (np.arange(count) + 0.5) / count * length
    middles = middles[(middles >= distance) & (middles <= length - distance)]
    ends = np.stack([middles - distance, middles + distance])
    beyond = ends > curve.length  # in the other half
    inside = np.where(beyond, length - ends, ends)
    x, y = (np.interp(inside, curve.arc, along) for along in curve.points)
    points = np.stack([np.where(beyond, -x, x), y])
    apart = points[:, 1] - points[:, 0]
    pull = strength * apart / np.hypot(*apart)
    forces = np.concatenate([pull, -pull], axis=1).T[~beyond.ravel()]
    return BoundaryLoads(
        places=tuple((ends / length)[~beyond].tolist()),
        forces=tuple(map(tuple, forces.tolist())),
        width=width,
        ramp=ramp,
    )
