"""Scenes of four families, drawn whole: ordinary, dynamic, stepping and extreme ones.

"ordinary" keeps inside the ranges that users use, "dynamic" adds inertia, drag or both, "stepping" has odd
step sizes, tolerances and stops, "extreme" lies far outside in several things at once, on coarse meshes.
Others than extreme ones have two elements through the cortex or more: with one, a triangle of the core may
turn over beside it, which is told as "invalid" (three of the first 85 drawn; the limit was set after that).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.random import Generator

from ...geometry.body import Body
from ...geometry.shapes import semiellipse
from ...growth.histories import Linear
from ...growth.imperfection import Imperfection
from ...growth.laws import TangentialGrowth
from ...growth.stress_driven import StressGrowth
from ...growth.swelling import Swelling
from ...outlines.build import outline
from ...parts import Process, Term
from ...scene import Scene
from ...stepping import EULER, MIDPOINT, Stepping
from ...terms.contact import SelfContact
from ...terms.damping import StiffnessDamping
from ...terms.dynamics import Drag, Inertia
from ...terms.elastic.material import NeoHookean
from ...terms.elastic.term import Elastic
from ...terms.tension import AxonalTension
from ...turing.kinetics.activator_inhibitor import GiererMeinhardt
from ...turing.kinetics.chemical import Schnakenberg
from ...turing.process import Turing

FAMILIES = ORDINARY, DYNAMIC, STEPPING, EXTREME = ("ordinary", "dynamic", "stepping", "extreme")
SHAPES = ("semicircle", "semiellipse", "disc", "ring", "outline")
KINETICS = {"Schnakenberg": Schnakenberg, "GiererMeinhardt": GiererMeinhardt}
YOUNG, DENSITY = 1895.0, 1100.0  # of white matter: Pa, kg/m³
AROUND, CUT = 240, 0.3  # points of a drawn curve, and how far below its centre it is cut off where it is held


def drawn(random: Generator, family: str) -> dict[str, Any]:
    """Return the parameters of a scene.

    Lengths are in units of the radius, moduli in those of white matter, tension in μT of the cortex, drag in
    μ/R² over the time, times in R √(ρ/μ).
    """
    far, choose = family == EXTREME, partial(_one_of, random)

    def between(low: float, high: float, lowest: float, highest: float) -> float:
        """Return a value between the first two; of extreme scenes half the times between the last two."""
        ends = (lowest, highest) if far and random.random() < 0.5 else (low, high)
        return float(np.exp(random.uniform(*np.log(ends))))

    moves = family == DYNAMIC or (far and random.random() < 0.2)
    scheme = choose(EULER, MIDPOINT) if moves else EULER
    cell = {
        "shape": choose(*SHAPES),
        "aspect": between(0.7, 1.4, 0.3, 3.0),
        "share": between(0.08, 0.2, 0.02, 0.45),
        "elements": choose(0.6, 1.0, 1.5) if far else choose(2.0, 2.0, 2.5),
        "base": choose("clamped", "roller", "free"),
        "layers": choose("sharp", "sharp", "sigmoid"),
        "element": choose("auto", "auto", "mixed"),
        "poisson": choose(*((0.0, 0.2, 0.4583, 0.499, 0.4999) if far else (0.3, 0.4, 0.45, 0.4583, 0.49))),
        "ratio": between(0.3, 10, 1e-3, 1e3),
        "cortex": between(1.2, 2.2, 0.4, 3.0),
        "core": between(1.0, 1.2, 0.6, 1.6),
        "radial": between(1.0, 1.2, 0.6, 1.6),
        "law": choose("none", "none", "swelling", "stress") if scheme == EULER else "none",
        "out_of_plane": choose("fixed", "tangential"),
        "tension": choose(0.0, between(0.05, 1.0, 1.0, 50.0)),
        "peaks": int(random.integers(3, 11)),
        "pull": choose("interface", "interface", "follower", "pial"),
        "pattern": choose("patches", *KINETICS),
        "gap": between(0.1, 0.8, 0.02, 0.9),
        "noise": choose(0.0, between(0.003, 0.03, 0.03, 0.1)),
        "of": choose("growth", "moduli"),
        "moving": choose("drag", "inertia", "both", "damped") if moves else "none",
        "drag": between(0.01, 10.0, 1e-4, 1e4),
        "until": between(1.0, 30.0, 0.1, 100.0),
        "scheme": scheme,
        "off": choose(0.0, 0.0, between(0.03, 0.3, 0.03, 0.3)) if moves else 0.0,
        "first": choose(0.05, 0.1),
        "largest": choose(0.1, 0.2),
        "smallest": 1e-5,
        "tolerance": choose(1e-8, 1e-6),
        "allowed": 60,
        "stops": 0,
        "unit": choose(1e-9, 1e-3, 1.0, 1e3) if far else 0.0404,
        "shift": choose(0.0, between(0.1, 1.0, 10.0, 1e3)),
        "solver": choose("auto", "superlu" if family == STEPPING else "auto"),
        "noise_seed": int(random.integers(1000)),
    }
    return cell | (_stepping(random) if family == STEPPING else {})


def _one_of(random: Generator, *values: Any) -> Any:
    return values[random.integers(len(values))]


def _stepping(random: Generator) -> dict[str, Any]:
    """Return steps of all lengths, tolerances and numbers of iterations."""
    choose = partial(_one_of, random)
    largest = float(10 ** random.uniform(-2, 0))
    first, smallest = (largest * float(10 ** random.uniform(-low, 0)) for low in (3, 0))
    return {
        "largest": largest, "first": first,
        "smallest": min(smallest, first) * choose(1.0, 0.1, 1e-3, 1e-6),
        "tolerance": float(10 ** random.uniform(-13, -3)), "allowed": choose(1, 3, 8, 20, 60, 300),
        "stops": choose(0, 1, 5),
    }  # fmt: skip


def _body(cell: Mapping[str, Any]) -> Body:
    radius, share, aspect = cell["unit"], cell["share"], cell["aspect"]
    elements, base, layers, shape = cell["elements"], cell["base"], cell["layers"], cell["shape"]
    if shape in ("semicircle", "semiellipse"):
        aspect = 1.0 if shape == "semicircle" else aspect
        # below half of the smaller semi-axis and the smallest radius of curvature
        thickness = radius * min(share, 0.4 * aspect, 0.8 * aspect**2, 0.8 / aspect)
        body = semiellipse(
            width=2 * radius, height=aspect * radius, thickness=thickness, elements=elements, base=base,
            layers=layers,
        )  # fmt: skip
    else:
        ring, wavy = shape == "ring", shape == "outline"
        held = base != "free" and not ring  # by a cut below the centre; a ring is by its inner side
        cut = np.arcsin(CUT) if held else 0.0
        angle = np.linspace(-cut, np.pi + cut, AROUND) if held else 2 * np.pi * np.arange(AROUND) / AROUND
        circle = np.stack([np.cos(angle), np.sin(angle)])
        waves = 0.1 * np.cos(4 * angle) + 0.05 * np.cos(6 * angle) if wavy else 0.0 * angle
        points = radius * (1.0 + waves) * circle * ([[1.0], [aspect]] if wavy else 1.0)
        body = outline(
            np.append(points, points[:, :1], axis=1), thickness=radius * share, elements=elements,
            layers=layers,
            base=base if held else "free", base_ends=points[:, [-1, 0]].T if held else None,
            holes=(radius * min(0.4, 0.6 * (1 - share)) * circle,) if ring else (),
            hole="clamped" if ring and base != "free" else "free",
        )  # fmt: skip
    return replace(body, mesh=body.mesh.translated((radius * cell["shift"], -radius * cell["shift"])))


def scene(cell: Mapping[str, Any], seconds: float) -> Scene:
    """Return the scene of a cell; raises ValueError for one that cannot be."""
    radius, body = cell["unit"], _body(cell)
    white = NeoHookean.from_young(YOUNG, cell["poisson"])
    gray = NeoHookean.from_young(YOUNG * cell["ratio"], cell["poisson"])
    elastic = Elastic(gray=gray, white=white, element=cell["element"])
    moving, until = cell["moving"], 1.0
    terms: list[Term] = [elastic, SelfContact(gap=cell["gap"])]
    if moving != "drag" and moving != "none":
        until = cell["until"] * radius * float(np.sqrt(DENSITY / white.mu))
        terms.append(Inertia(density=DENSITY))
    if moving in ("drag", "both"):
        terms.append(Drag(coefficient=cell["drag"] * white.mu / radius**2 * until))
    if moving == "damped":
        terms.append(StiffnessDamping(elastic=elastic, time=1e-3 * until))
    history = Linear(duration=until)
    processes: list[Process] = []
    if cell["tension"]:
        turing = cell["pattern"] != "patches"
        if turing:
            most = int(
                0.24 * body.pial_curve.length / body.cortex.mesh.param()
            )  # pairs of half waves it has room for
            processes.append(Turing(KINETICS[cell["pattern"]](), half_waves=2 * min(cell["peaks"], most)))
        pial = cell["pull"] == "pial"
        strength = cell["tension"] * gray.mu * (1.0 if pial else body.thickness)
        pull = AxonalTension(
            strength=strength, surface="pial" if pial else "interface", follower=cell["pull"] == "follower",
            patches=0 if turing else cell["peaks"], ramp=0.1 * until,
        )  # fmt: skip
        terms.append(pull)
    growth = TangentialGrowth(
        cortex=cell["cortex"], core=cell["core"], radial_core=cell["radial"], history=history,
        out_of_plane=cell["out_of_plane"],
    )  # fmt: skip
    processes.append(growth)
    if cell["law"] == "swelling":
        processes.append(Swelling(coefficient=0.1, history=history, out_of_plane=cell["out_of_plane"]))
    if cell["law"] == "stress":
        processes.append(StressGrowth(rate=1.0 / (white.mu * until)))
    if cell["noise"]:
        processes.append(Imperfection(amplitude=cell["noise"], of=cell["of"]))
    stops = tuple(until * share for share in (0.1, 0.1 + 1e-9, 0.33, 0.5, 1.0)[: cell["stops"]])
    stepping = Stepping(
        first=min(cell["first"], cell["largest"]), largest=cell["largest"], smallest=cell["smallest"],
        tolerance=cell["tolerance"], iterations=cell["allowed"], seconds=seconds, scheme=cell["scheme"],
        stops=stops, local_error=cell["off"] * body.thickness or None, solver=cell["solver"],
    )  # fmt: skip
    return Scene(
        body=body, terms=tuple(terms), processes=tuple(processes), until=until, seed=cell["noise_seed"],
        stepping=stepping,
    )  # fmt: skip
