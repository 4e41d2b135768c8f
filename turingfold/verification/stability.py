"""Thresholds of buckling: strips, films on a deep core, half discs."""

from __future__ import annotations

import numpy as np
from skfem import MeshTri1

from ..geometry.body import Body
from ..geometry.shapes import semicircle
from ..growth.laws import TangentialGrowth
from ..scene import Scene
from ..stability.buckling import Buckling, buckling
from ..stepping import Stepping
from ..terms.elastic.material import NeoHookean
from ..terms.elastic.term import Elastic
from .check import Check, Quantity
from .setups import GRAY, SOFT, WHITE, half_strip

NEARLY = NeoHookean.from_young(3.0, 0.4999)
# ratio of moduli, out of plane: critical growth and wave length over film thickness
FILMS = (
    (1.0, "fixed", 1.5968, 4.90),
    (10.0, "fixed", 1.1186, 9.87),
    (1.0, "tangential", 1.3092, 6.21),
    (10.0, "tangential", 1.0739, 10.45),
)
# thickness over radius, ratio of moduli, layers, out of plane: critical growth and half waves
DISCS = (
    (0.1, 1.0, "sigmoid", "fixed", 1.7195, 15),
    (0.1, 1.0, "sharp", "fixed", 1.6881, 14),
    (0.2, 1.0, "sigmoid", "fixed", 1.7846, 7),
    (0.1, 1.0, "sharp", "tangential", 1.3852, 12),
    (0.1, 3.0, "sharp", "fixed", 1.3445, 9),
    (0.1, 10.0, "sharp", "fixed", 1.1716, 6),
)


def strips() -> list[Quantity]:
    """Boundary conditions of the incremental waves e^{ikx} e^{sy} in cortex and core become dependent.

    One wave length, 12 cortex thicknesses deep, an independent tangent at the exact homogeneous state. Four
    elements through the cortex: within 0.15 %.
    """
    rows = (
        ("κ = 5 μ", Elastic(gray=SOFT), 4.10, 1.6297),
        ("document 1", Elastic(gray=GRAY, white=WHITE), 3.61, 1.7324),
        ("κ = 5 μ, cortex 10 x", Elastic(gray=NeoHookean(mu=10.0, kappa=50.0), white=SOFT), 9.61, 1.1286),
        ("Poisson .4999", Elastic(gray=NEARLY), 4.90, 1.5969),
    )
    return [
        Quantity(f"{name}: critical growth", known, grown(half_strip(length, 4), term, known).growth, 1.5e-3)
        for name, term, length, known in rows
    ]


def films() -> list[Quantity]:
    """An incompressible growing film on a half space, at its critical wave length; Holland et al. (2017).

    Here ν = 0.4999, a core at least 12 thicknesses deep, four elements through the film: within 0.2 %.
    """
    found = []
    for ratio, out, known, length in FILMS:
        film = NeoHookean(mu=ratio * NEARLY.mu, kappa=ratio * NEARLY.kappa)
        got = grown(half_strip(length, 4), Elastic(gray=film, white=NEARLY), known, out).growth
        words = "g_z = 1" if out == "fixed" else "g_z = g"
        found.append(Quantity(f"modulus ratio {ratio:g}, {words}: critical growth", known, got, 2e-3))
    return found


def half_spaces() -> list[Quantity]:
    """Compressed by g along its surface, a half space wrinkles at the strain 1 - 1/g, in waves of any length.

    Incompressible: λ = 1/g solves λ⁶ + λ⁴ + 3 λ² = 1, 1 - 0.5437 = 0.4563 (Biot 1963). Compressible ones by
    the same equations with the program's energy, solved independently.

    A block 3 by 12 between rollers, four elements to a unit. The quadratic element is within 0.03 %; waves of
    the size of an element of the mixed one grow 0.7 % early, on any mesh, as nothing has a length here.
    """
    found = []
    for name, material, known in (
        ("Poisson .4999", NEARLY, 0.4563), ("κ = 5 μ", SOFT, 0.4362), ("Poisson .4583", WHITE, 0.4476),
        ("Poisson .3", NeoHookean.from_young(1.0, 0.3), 0.4329),
    ):  # fmt: skip
        law = TangentialGrowth(cortex=2.1, core=2.1)
        steps = Stepping(first=0.05, largest=0.05)
        scene = Scene(
            body=half_strip(6.0, 4), terms=(Elastic(gray=material),), processes=(law,), stepping=steps
        )
        got = buckling(scene).growth
        tolerance = 8e-3 if material is NEARLY else 1e-3
        found.append(Quantity(f"{name}: critical strain", known, 1 - 1 / got, tolerance))
    return found


def column() -> list[Quantity]:
    """A strip of length L and thickness T between guided ends buckles at the strain π²/12 (T/L)², Euler.

    Force π² E' I/L², I = T³/12, over E' T, E' = E/(1 - ν²); ends turn no more than they do in half a wave. It
    grows by g along itself between fixed walls, and the strain is 1 - 1/g. At T/L = 1/40 shear and the
    strain itself, neglected by Euler, are of the size of (T/L)² (1.2 E'/G + 1) π²/12: 0.3 %.
    """
    slender = 40
    mesh = MeshTri1.init_tensor(np.linspace(0, slender, 2 * slender + 1), np.linspace(0, 1, 3))
    sides = {"pial": lambda x: x[1] == 1, "mirror": lambda x: x[0] == 0, "base": lambda x: x[0] == slender}
    body = Body(mesh.with_boundaries(sides), 0.5, "roller")
    strain = np.pi**2 / 12 / slender**2
    growth = 1 + 2 * strain
    steps = Stepping(first=0.1, largest=0.1)
    scene = Scene(
        body=body, terms=(Elastic(gray=SOFT),), stepping=steps,
        processes=(TangentialGrowth(cortex=growth, core=growth),),
    )  # fmt: skip
    got = buckling(scene)
    return [Quantity("critical strain", strain, 1 - 1 / got.growth, 1e-2)]


def discs() -> list[Quantity]:
    """Half discs on rollers, κ = 5 μ, modes cos nθ, from the increments of the exact axisymmetric state.

    Two elements through the cortex lie up to 0.4 % above; neighbouring modes are as close, so n is ± 1.
    """
    found = []
    for thickness, ratio, layers, out, growth, mode in DISCS:
        body = semicircle(radius=1.0, thickness=thickness, size=thickness / 2, base="roller", layers=layers)
        gray = NeoHookean(mu=ratio * SOFT.mu, kappa=ratio * SOFT.kappa)
        at = grown(body, Elastic(gray=gray, white=SOFT), growth, out)
        name = f"T/R {thickness:g}, ratio {ratio:g}, {layers}, {out}"
        found += [
            Quantity(f"{name}: critical growth", growth, at.growth, 4e-3),
            Quantity(f"{name}: half waves", mode, at.mode, 1.01 / mode),
        ]
    return found


def thin_and_document_1() -> list[Quantity]:
    """The cortex of a quarter of the thickness folds into four times the waves: g = 1.6668, n = 61.

    The body of document 1 on rollers: g = 1.782, n = 26. Three and four elements through the cortex: 0.5 %.
    """
    thin = semicircle(radius=1.0, thickness=0.025, size=0.025 / 3, base="roller", layers="sigmoid")
    human = semicircle(radius=0.0404, thickness=2.5e-3, size=2.5e-3 / 4, base="roller")
    found = []
    for name, body, term, growth, mode in (
        ("T/R = .025", thin, Elastic(gray=SOFT), 1.6668, 61),
        ("document 1", human, Elastic(gray=GRAY, white=WHITE), 1.782, 26),
    ):
        at = grown(body, term, growth)
        found += [
            Quantity(f"{name}: critical growth", growth, at.growth, 5e-3),
            Quantity(f"{name}: half waves", mode, at.mode, 1.01 / mode),
        ]
    return found


def finer_disc() -> list[Quantity]:
    """The threshold of a half disc with a cortex ten times as stiff, four elements through the cortex.

    Two of them are held to 0.4 %; with an error of order two and more, four come within 0.1 %.
    """
    gray = NeoHookean(mu=10 * SOFT.mu, kappa=10 * SOFT.kappa)
    body = semicircle(radius=1.0, thickness=0.1, size=0.025, base="roller")
    got = grown(body, Elastic(gray=gray, white=SOFT), 1.1716).growth
    return [Quantity("critical growth, four elements", 1.1716, got, 1e-3)]


def grown(body: Body, term: Elastic, known: float, out: str = "fixed") -> Buckling:
    """Return where a body with a growing cortex buckles, followed up to a fourth beyond the known growth."""
    law = TangentialGrowth(cortex=1 + 1.25 * (known - 1), out_of_plane=out)
    steps = Stepping(first=0.1, largest=0.1)
    return buckling(Scene(body=body, terms=(term,), processes=(law,), stepping=steps))


CHECKS = (
    Check("Buckling: strips", strips, "exact incremental equations"),
    Check("Buckling: films on a half space", films, "Holland et al. 2017"),
    Check("Buckling: surface of a half space", half_spaces, "Biot 1963; independent equations"),
    Check("Buckling: column", column, "Euler"),
    Check("Buckling: half discs", discs, "independent integration"),
    Check("Buckling: thin cortex, document 1", thin_and_document_1, "independent integration", full=True),
    Check("Buckling: finer half disc", finer_disc, "independent integration", full=True),
)
