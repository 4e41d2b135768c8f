"""Bodies of simple shape, and their equilibria, for problems that need no scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from skfem import MeshTri1, MeshTri2

from ..arrays import Array, Integers
from ..geometry.body import Body
from ..parts import Evaluation, Potential, Term, TimeStep
from ..scene import Scene
from ..solve.march import Step, begin, march
from ..solve.newton import Minimiser
from ..state import State
from ..terms.elastic.material import NeoHookean
from ..terms.elastic.term import Elastic

GRAY, WHITE = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)  # document 1
SOFT = NeoHookean(mu=1.0, kappa=5.0)  # document 2


def equilibrium(
    body: Body, term: Elastic, fixed: Integers, x: Array, *, growth: Array | None = None,
    loads: Sequence[Potential] = (), tolerance: float = 1e-11,
) -> tuple[Array, Potential]:  # fmt: skip
    """Return the displacement (2, n) that minimises the energy from x (2 n,) on, and the potential of `term`.

    fixed: unknowns that keep their value.  growth: factors (3, q, e).
    """
    state = State(1.0, {"displacement": np.zeros_like(body.nodes)})
    if growth is not None:
        state = state.updated(growth=growth)
    potential = active(term, body, state)
    minimiser = Minimiser(2 * body.nodes.shape[1], np.unique(fixed), tolerance, 60)
    return minimiser.minimise((potential, *loads), x).x.reshape(-1, 2).T, potential


def active(term: Term, body: Body, state: State) -> Potential:
    """Return the potential of a term that acts in the state."""
    potential = term.on(body).during(state, TimeStep(1.0))
    if potential is None:
        raise RuntimeError(f"{type(term).__name__} does not act at t = {state.time:g}.")
    return potential


def evaluated(potential: Potential | None, x: Array) -> Evaluation:
    """Return the evaluation of a potential at an admissible displacement (2 n,)."""
    found = None if potential is None else potential.evaluate(x)
    if found is None:
        raise RuntimeError("the potential does not act, or the displacement is not admissible.")
    return found


def last_step(scene: Scene) -> Step:
    """Return the last step of a scene."""
    *_, (step, _) = march(scene, begin(scene))
    return step


def quarter_ring(inner: float, outer: float, around: int, across: int) -> tuple[Body, Integers, Array]:
    """Return a quarter of a ring, the fixed unknowns of its two straight sides, and the nodes' radii."""
    angles, radii = np.linspace(0, np.pi / 2, around + 1), np.linspace(inner, outer, across + 1)
    grid = MeshTri1.init_tensor(angles, radii).with_boundaries({"pial": lambda p: p[1] == outer})
    flat = MeshTri2.from_mesh(grid)
    angle, radius = flat.doflocs
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    x[angle == np.pi / 2], y[angle == 0] = 0.0, 0.0
    mesh = MeshTri2(np.stack([x, y]), flat.t, _boundaries=grid.boundaries, validate=False)
    body = Body(mesh, outer - inner, "free")
    left, bottom = (np.flatnonzero(body.nodes[axis] == 0) for axis in (0, 1))
    return body, np.concatenate([2 * left, 2 * bottom + 1]), np.hypot(*body.nodes)


def distorted(n: int, amount: float, seed: int = 0) -> tuple[Body, Integers]:
    """Return the unit square, inner vertices moved by up to `amount` of an edge, and its rim's unknowns."""
    mesh = MeshTri1.init_tensor(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    p = mesh.p.copy()
    inside = ((p > 0) & (p < 1)).all(0)
    p[:, inside] += amount / n * np.random.default_rng(seed).uniform(-1, 1, (2, inside.sum()))
    body = Body(MeshTri1(p, mesh.t).with_boundaries({"pial": lambda x: x[1] == 1}), 0.5, "free")
    nodes = np.flatnonzero(((body.nodes == 0) | (body.nodes == 1)).any(0))
    return body, np.concatenate([2 * nodes, 2 * nodes + 1])


def half_strip(length: float, layers: int) -> Body:
    """Return half a wave length of a strip with a cortex of thickness 1 between two rollers.

    It is at least 12 cortex thicknesses deep, and 1.5 wave lengths. layers: of elements through the cortex.
    """
    depths, size = [k / layers for k in range(layers + 1)], 1 / layers
    while depths[-1] < max(12.0, 1.5 * length):
        size = min(1.3 * size, max(1.5, length / 12))
        depths.append(depths[-1] + size)
    across = np.linspace(0, length / 2, round(length / 2 * layers) + 1)
    mesh = MeshTri1.init_tensor(across, -np.array(depths[::-1]))
    right = length / 2 - 1e-9
    sides = {"pial": lambda x: x[1] == 0, "mirror": lambda x: x[0] == 0, "base": lambda x: x[0] > right}
    return Body(mesh.with_boundaries(sides), 1.0, "roller")


def bar() -> Body:
    """Return a bar along x whose upper fifth is cortex."""
    mesh = MeshTri1.init_tensor(np.linspace(0, 1, 3), np.linspace(0, 0.5, 6))
    sides = {"pial": lambda x: x[1] == 0.5, "base": lambda x: x[1] == 0.0}
    return Body(mesh.with_boundaries(sides), 0.1)
