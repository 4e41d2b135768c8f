"""What is wrong with a result that says it is valid, by formulas written again: no code of the solver's.

Sampled are all elements, corners included, and the curved boundary; forces come from differences of the
strain energy

    W = J_G [μ/2 (tr(F*ᵀ F*) J*^(-2/3) - 3) + κ/2 (J* - 1)²],   F* = F G⁻¹,

with F*_zz = 1/g_z in the trace and in J*. The forces of loads, contact and inertia are those of their terms.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from skfem import ElementTriP2
from skfem.quadrature import get_quadrature

from ...arrays import Array
from ...geometry.body import Body, by_node
from ...parts import TimeStep
from ...results.result import Result
from ...state import State
from ...terms.contact import SelfContact
from ...terms.elastic.term import Elastic

LATTICE = 8  # parts of a side of an element between the points that are sampled
ALONG = 48  # parts of a boundary edge
NUDGE = 1e-6  # of F for a difference of energies
UNBALANCED = 1e-6  # residual of what is no equilibrium; the solver stops at 1e-8 unless it is told otherwise
LOOSE = 10.0  # times the tolerance of a scene that allows more: the solver's unit has all forces in it


def faults(result: Result) -> list[str]:
    """Return what is wrong with a result that says it is valid; nothing where it is right."""
    body, found = result.scene.body, []
    for state in result.states:
        if not all(np.isfinite(values).all() for values in state.fields.values()):
            found.append(f"not finite at t = {state.time:.4g}")
            break
        if (least := least_determinant(body, state)) <= 0:
            found.append(f"det F* = {least:.2g} at t = {state.time:.4g}")
            break
        if crosses(body, body.nodes + state["displacement"]):
            found.append(f"the boundary crosses itself at t = {state.time:.4g}")
            break
    allowed = max(UNBALANCED, LOOSE * result.scene.stepping.tolerance)
    if not found and (left := residual(result)) > allowed:
        found.append(f"residual {left:.2g}")
    return found


def least_determinant(body: Body, state: State) -> float:
    """Return the least det ∂x/∂X at the lattice of all elements, its sign that of det F* where growth is."""
    steps = [(i / LATTICE, j / LATTICE) for i in range(LATTICE + 1) for j in range(LATTICE + 1 - i)]
    points = np.array(steps).T
    slopes = _slopes(*points)
    before, after = (
        np.einsum("iae,ajp->ijpe", (body.nodes + u)[:, body.triangles], slopes)
        for u in (0.0, state["displacement"])
    )
    if "bubble" in state:  # of mixed elements, 27 x y (1 - x - y)
        x, y = points
        bulge = 27 * np.stack([y * (1 - 2 * x - y), x * (1 - x - 2 * y)])
        after = after + np.einsum("ie,jp->ijpe", state["bubble"], bulge)
    before, after = _determinant(before), _determinant(after)
    least = float((after / before).min())
    grown = float(state["growth"].min()) if "growth" in state else 1.0
    return min(least, grown) if before.min() > 0 else -1.0


def crosses(body: Body, places: Array) -> bool:
    """Return whether the curved boundary, sampled along each edge, meets itself."""
    from shapely import MultiLineString

    edges, xi = body.mesh.boundary_facets(), np.arange(ALONG) / ALONG
    shares = np.stack([(1 - xi) * (1 - 2 * xi), 4 * xi * (1 - xi), xi * (2 * xi - 1)])
    after: dict[int, list[tuple[int, int]]] = {}
    for facet in edges:
        one, other = (int(node) for node in body.mesh.facets[:, facet])
        middle = int(body.mesh.nvertices + facet)
        after.setdefault(one, []).append((other, middle))
        after.setdefault(other, []).append((one, middle))
    curves: list[Array] = []
    while after:
        start = now = next(iter(after))
        last, pieces = -1, list[Array]()
        while now != start or not pieces:
            onward, middle = next(pair for pair in after.pop(now) if pair[1] != last)
            pieces.append(places[:, [now, middle, onward]] @ shares)
            now, last = onward, middle
        curves.append(np.concatenate([*pieces, pieces[0][:, :1]], axis=1).T)
    return not MultiLineString(curves).is_simple


def residual(result: Result) -> float:
    """Return the size of the forces left at the last state, relative to those on the elements."""
    scene, body, row = result.scene, result.scene.body, result.history[-1]
    last, before = result.last, result.states[-2]
    length, share = row["step"], 1.0 if row.get("damped") else scene.stepping.balance
    if share < 1:  # growth is linear in time
        time = before.time + share * length
        last = last.updated(time, **{
            name: before[name] + share * (last[name] - before[name])
            for name in ("displacement", "growth") if name in before
        })  # fmt: skip
    x, step = by_node(last["displacement"]), TimeStep(length, share)
    written = {name for term in scene.terms for name in term.writes if name in before}
    earlier = last.updated(**{name: before[name] for name in {*written, "displacement"}})
    total, size = np.zeros(x.size), 0.0
    held = body.fixed
    for term in scene.terms:
        operator = term.on(body)
        held = body.supported if operator.resists_rigid_motions else held
        if isinstance(term, Elastic) and not term.mixed:
            forces = _elastic_forces(term, body, last)
            size += float(np.vdot(forces, forces))
            for a, force in enumerate(forces):
                for i in (0, 1):
                    np.add.at(total, 2 * body.triangles[a] + i, force[i])
            continue
        if isinstance(term, SelfContact):
            potential = operator.during(last, replace(step, over=True))
        else:
            potential = operator.during(earlier, step)
        at = None if potential is None else potential.evaluate(x)
        if at is not None:
            gradient, square = at.gradient()
            total += gradient
            size += square if isinstance(term, Elastic) else 0.0
    total[held] = 0.0
    return float(np.linalg.norm(total) / np.sqrt(size)) if size > 0 else 0.0


def _elastic_forces(term: Elastic, body: Body, state: State) -> Array:
    """Return the forces of the elements on their nodes, (6, 2, e)."""
    points, weights = get_quadrature(ElementTriP2.refdom, 4)
    slopes = _slopes(*points)
    reference = np.einsum("iae,ajp->ijpe", body.nodes[:, body.triangles], slopes)
    area = weights[:, None] * _determinant(reference)
    inverse = np.linalg.inv(reference.transpose(2, 3, 0, 1)).transpose(2, 3, 0, 1)
    gradients = np.einsum("akp,kjpe->ajpe", slopes, inverse)  # ∂N/∂X
    moved = (body.nodes + state["displacement"])[:, body.triangles]
    F = np.einsum("iae,ajpe->ijpe", moved, gradients)
    growth = state["growth"] if "growth" in state else np.ones((3, *area.shape))
    t = body.tangent
    n = np.stack([t[1], -t[0]])
    undo = np.einsum("ipe,jpe->ijpe", t, t) / growth[0] + np.einsum("ipe,jpe->ijpe", n, n) / growth[1]
    gray = body.in_cortex.astype(float)[None] if body.layers == "sharp" else _indicator(body)
    white = term.white or term.gray
    factor = state.fields.get("modulus_factor", 1.0)
    mu = factor * (gray * term.gray.mu + (1 - gray) * white.mu)
    kappa = factor * (gray * term.gray.kappa + (1 - gray) * white.kappa)

    def energy(F: Array) -> Array:
        elastic = np.einsum("ijpe,jkpe->ikpe", F, undo)
        J = _determinant(elastic) / growth[2]
        trace = (elastic**2).sum((0, 1)) + growth[2] ** -2
        return np.asarray(
            growth.prod(0) * (mu / 2 * (trace * J ** (-2 / 3) - 3) + kappa / 2 * (J - 1) ** 2) * area
        )

    stress = np.zeros_like(F)
    for i in (0, 1):
        for j in (0, 1):
            shift = np.zeros_like(F)
            shift[i, j] = NUDGE
            stress[i, j] = (energy(F + shift) - energy(F - shift)) / (2 * NUDGE)
    return np.asarray(np.einsum("ijpe,ajpe->aie", stress, gradients))


def _indicator(body: Body) -> Array:
    return np.asarray(1 / (1 + np.exp(10 * (body.depth / body.thickness - 1))))


def _slopes(x: Array, y: Array) -> Array:
    """Return the derivatives of the six shape functions, (6, 2, p): corners, then sides 01, 12 and 02."""
    z, nil = 1 - x - y, np.zeros_like(x)
    along_x = [1 - 4 * z, 4 * x - 1, nil, 4 * (z - x), 4 * y, -4 * y]
    along_y = [1 - 4 * z, nil, 4 * y - 1, -4 * x, 4 * x, 4 * (z - y)]
    return np.stack([np.stack(along_x), np.stack(along_y)], axis=1)


def _determinant(A: Array) -> Array:
    return np.asarray(A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0])
