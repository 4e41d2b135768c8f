"""Band problem A, whose spectral solution is in data/turing_oracle.json, and meshes for it."""

import json
from pathlib import Path

import numpy as np
from skfem import MeshTri, MeshTri2

from turingfold.turing.kinetics.chemical import Schnakenberg
from turingfold.turing.reaction_diffusion import ReactionDiffusion, discretise

ORACLE = json.loads((Path(__file__).parents[1] / "data" / "turing_oracle.json").read_text())
PROBLEM_A = ORACLE["pde"]["semi_annulus_schnakenberg_m12"]
R_IN = float(ORACLE["pde"]["semi_annulus"]["R_inner"])


def semi_annulus(along: int, across: int, angle: float = np.pi) -> MeshTri2:
    """Return a structured, exactly curved mesh of the band R_IN < r < 1, 0 < θ < angle."""
    flat = MeshTri.init_tensor(np.linspace(0, angle, along + 1), np.linspace(R_IN, 1, across + 1))
    curved = MeshTri2.from_mesh(flat)
    theta, r = curved.doflocs
    return MeshTri2(np.stack([r * np.cos(theta), r * np.sin(theta)]), curved.t[[0, 2, 1]], validate=False)


def outer_line(mesh: MeshTri2) -> np.ndarray:
    """Return the vertices on the outer side by angle."""
    x, y = mesh.doflocs[:, : mesh.nvertices]
    outer = np.flatnonzero(np.hypot(x, y) > 1 - 1e-9)
    return outer[np.argsort(np.arctan2(y[outer], x[outer]))]


def problem_a(mesh: MeshTri2, degree: int, **options: bool) -> ReactionDiffusion:
    space = discretise(mesh, degree, **options)
    return ReactionDiffusion(space, Schnakenberg(), float(PROBLEM_A["Du"]), float(PROBLEM_A["Dv"]))


def initial_a(system: ReactionDiffusion, amplitude: float = 0.05) -> np.ndarray:
    """Return u = 1 + amplitude cos 12θ, v = 0.9."""
    state = system.uniform(1.0, 0.9)
    x, y = system.space.nodes
    state[0] += amplitude * np.cos(12 * np.arctan2(y, x))
    return state


def probes(system: ReactionDiffusion, state: np.ndarray) -> np.ndarray:
    """Return the six values of the oracle's columns, away from the corners, where elements lose order."""
    nodes = system.space.nodes

    def node(r: float, theta: float) -> int:
        distance = np.hypot(nodes[0] - r * np.cos(theta), nodes[1] - r * np.sin(theta))
        assert distance.min() < 1e-9
        return int(distance.argmin())

    peak, trough = np.pi / 3, np.pi / 3 + np.pi / 12
    u, v = state
    places = [node(1, peak), node(1, trough), node(R_IN, peak), node(R_IN, trough)]
    return np.array([*u[places], *v[places[:2]]])


def steady_a() -> np.ndarray:
    return np.array(PROBLEM_A["steady_state"]["values"], dtype=float)


def trajectory_a(time: float) -> np.ndarray:
    rows = np.array(PROBLEM_A["trajectory"]["rows"], dtype=float)
    return rows[np.flatnonzero(rows[:, 0] == time)[0], 1:]
