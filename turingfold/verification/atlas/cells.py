"""The scenes of the atlas: each is drawn by its own seed, whatever the number of others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...geometry.shapes import semicircle
from ...growth.laws import TangentialGrowth
from ...parts import Term
from ...scene import Scene
from ...stepping import Stepping
from ...terms.contact import SelfContact
from ...terms.dynamics import Drag, Inertia
from ...terms.elastic.material import NeoHookean
from ...terms.elastic.term import Elastic
from ...terms.tension import AxonalTension
from ...turing.kinetics.named import KINETICS
from . import families

Cell = dict[str, Any]
KINDS = ("mechanics", "pattern", "march", *families.FAMILIES)
OFF, DRAG, INERTIA = "off", "drag", "inertia"


def drawn(kind: str, number: int, seed: int) -> Cell:
    """Return the parameters of a cell.

    Lengths are in units of the radius, moduli in those of white matter, times in shear-wave times of a body.
    """
    random = np.random.default_rng([seed, KINDS.index(kind), number])
    if kind in families.FAMILIES:
        return families.drawn(random, kind)
    choose, between = random.choice, random.uniform
    if kind == "mechanics":
        return {
            "poisson": float(choose([0.0, 0.3, 0.4, 0.4583, 0.48, 0.495, 0.4999])),
            "ratio": float(10 ** between(-1.5, 2.0)),
            "thickness": float(10 ** between(-1.1, -0.4)),
            "cortex": float(between(1.05, 3.0)),
            "core": float(choose([1.0, 1.0, between(0.8, 1.5)])),
            "out_of_plane": str(choose(["fixed", "tangential"])),
            "elements": float(choose([1.0, 1.5, 2.0])),
            "layers": str(choose(["sharp", "sigmoid"])),
            "base": str(choose(["clamped", "roller", "free"])),
            "element": str(choose(["auto", "auto", "auto", "mixed"])),
            "tension": float(choose([0.0, 10 ** between(-2, 0)])),
            "motion": str(choose([OFF, OFF, DRAG, INERTIA])),
            "largest": float(choose([0.05, 0.1, 0.25])),
        }
    cell: Cell = {"kinetics": str(choose(list(KINETICS)))}
    if kind == "pattern":
        return cell | {
            "beyond": float(10 ** between(-2, 1.3)),
            "thickness": float(10 ** between(-1.3, -0.6)),
            "half_waves": int(choose([3, 4, 6, 8, 12, 16])),
            "elements": float(choose([1.0, 1.5, 2.0])),
            "base": str(choose(["roller", "free"])),
            "initial": str(choose(["mode", "mode", "noise"])),
        }
    return cell | {
        "beyond": float(10 ** between(-1, 1.3)),
        "stiffness": float(10 ** between(0, 6)),
        "tolerance": float(10 ** between(-5, -2)),
        "half_waves": int(choose([2, 4, 8])),
    }


def scene(kind: str, cell: Mapping[str, Any], seconds: float) -> Scene:
    """Return the scene of a cell of the kind "mechanics" or of a family."""
    if kind in families.FAMILIES:
        return families.scene(cell, seconds)
    body = semicircle(
        radius=1.0, thickness=cell["thickness"], elements=cell["elements"], base=cell["base"],
        layers=cell["layers"],
    )  # fmt: skip
    gray, white = (NeoHookean.from_young(young, cell["poisson"]) for young in (3.0 * cell["ratio"], 3.0))
    elastic = Elastic(gray=gray, white=white, element=cell["element"])
    terms: list[Term] = [elastic, SelfContact()]
    if cell["tension"]:
        strength = cell["tension"] * elastic.shear_modulus * cell["thickness"]
        terms.append(AxonalTension(strength=strength, patches=6))
    if cell["motion"] == DRAG:
        terms.append(Drag(coefficient=1.0))
    if cell["motion"] == INERTIA:
        terms.append(Inertia(density=white.mu * 0.01))
    growth = TangentialGrowth(cortex=cell["cortex"], core=cell["core"], out_of_plane=cell["out_of_plane"])
    stepping = Stepping(first=cell["largest"], largest=cell["largest"], seconds=seconds)
    return Scene(body=body, terms=tuple(terms), processes=(growth,), stepping=stepping)
