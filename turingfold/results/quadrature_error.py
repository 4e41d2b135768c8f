"""How far numbers of an equilibrium are off by its integration points: what twice the order changes.

At the equilibrium u with tangent K, the finer rule leaves forces r' and the energy E'. The body answers them
by e = -K⁻¹ r', so that a number J is off by J(u + e) - J(u) and the energy by E' - E + ½ r'·e.
"""

from __future__ import annotations

from dataclasses import fields
from typing import ClassVar

import numpy as np

from ..arrays import Array
from ..geometry.body import Body
from ..solve.problem import Problem
from ..solve.sparsity import Assembler
from ..state import State
from .carried import NoEstimateError, at_rest, forces_of, on_another_body, solution
from .estimate import ENERGY, Numbers
from .measures import shape_numbers
from .step_error import steps_matter


class Sharper(Body):
    """A body with 16 integration points in each triangle, of order 8."""

    order: ClassVar[int] = 2 * Body.order


def quadrature_errors(problem: Problem, state: State) -> Numbers:
    """Return by how much the integration points leave the numbers of the last state off, by name.

    The errors that `estimated` tells have these in them. It takes one factorisation.
    Raises NoEstimateError where errors add up over the steps, for mixed elements, whose integration points
    are their own, and where the finer rule cannot take the state.
    """
    scene = problem.scene
    if steps_matter(scene):
        raise NoEstimateError("errors of motions, and of what remembers, add up over the steps")
    at = at_rest(problem, state)
    if at.is_condensed:
        raise NoEstimateError("mixed elements have integration points of their own, of order 6")
    body = sharper(scene.body)
    _, there = on_another_body(scene, state, body, lambda _, values: _at_points(scene.body, body, values))
    assembler = Assembler(problem.n_dofs, problem.held)
    solve = solution(*assembler.assemble(at.hessians(0.0)), scene)
    forces, e = forces_of(there)[assembler.free], np.zeros(problem.n_dofs)
    e[assembler.free] = -solve(forces)
    before = shape_numbers(body, state["displacement"])
    after = shape_numbers(body, (there.x + e).reshape(-1, 2).T)
    off = {name: abs(after[name] - before[name]) for name in before}
    return off | {ENERGY: abs(there.energy - at.energy + 0.5 * float(forces @ e[assembler.free]))}


def sharper(body: Body) -> Sharper:
    """Return a body with more integration points."""
    return Sharper(**{field.name: getattr(body, field.name) for field in fields(body)})


def _at_points(body: Body, finer: Body, values: Array) -> Array:
    """Return a field at a finer rule's points: by the polynomial through the values at the points of each."""
    if values.shape[-2:] != body.quadrature.weights.shape:  # of the nodes, which are the same
        return values
    to_points = finer.quadrature.shapes.T @ np.linalg.pinv(body.quadrature.shapes.T)
    return np.asarray(to_points @ values)
