"""What the benchmarks share: paths for peers to follow, and the unit of cost."""

import runpy
from argparse import ArgumentParser
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np

from turingfold import (
    Elastic,
    NeoHookean,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    semicircle,
    simulate,
)
from turingfold.geometry.body import Body
from turingfold.parts import TimeStep
from turingfold.results.result import Result
from turingfold.solve.linear import NotPositiveDefinite, solver_for
from turingfold.solve.sparsity import Assembler

CASES = Path(__file__).parents[2] / "cases"
RADIUS, THICKNESS = 0.0404, 2.5e-3
GRAY, WHITE = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)
GROWTH, STEPS, TOLERANCE = 1.45, 15, 1e-8


def drawn(file: str, scenes, draw) -> None:
    """Run scenes(quick), measure and draw them by draw(results, figure); quick ones in the working folder."""
    from matplotlib.figure import Figure

    asked = ArgumentParser()
    asked.add_argument("--quick", action="store_true")
    quick, name = asked.parse_args().quick, f"{Path(file).stem}.png"
    figure = Figure(layout="constrained")
    draw({own: timed(scene) for own, scene in scenes(quick=quick).items()}, figure)
    path = Path(name) if quick else CASES.parent / "figures" / name
    figure.savefig(path, dpi=200, facecolor="white")
    print(f"figure: {path}")


def timed(scene: Scene) -> Result:
    """Return the result of a scene with the time of the processor, which other programs do not change."""
    began = process_time()
    result = simulate(scene)
    return replace(result, seconds=process_time() - began, seconds_by_part={})


def growth_path(body: Body) -> Scene:
    """Return the growth of a sharp cortex from 1 to 1.45 in 15 equal steps, without contact."""
    return Scene(
        body=body,
        terms=(Elastic(gray=GRAY, white=WHITE),),
        processes=(TangentialGrowth(cortex=GROWTH),),
        stepping=Stepping(first=1 / STEPS, largest=1 / STEPS, tolerance=TOLERANCE),
    )


def brain(elements: float) -> Body:
    """Return the semi-circle with a clamped base and so many elements through its cortex."""
    return semicircle(radius=RADIUS, thickness=THICKNESS, size=THICKNESS / elements)


@dataclass(frozen=True)
class Step:
    """What acts in a step, and how near to equilibrium its end is.

    growth: factors along tangent, normal and z, (3, q, e).  load: nodal forces, (2 n_nodes,).  force: norm of
    the nodal forces that are left.
    """

    growth: np.ndarray
    load: np.ndarray
    force: float


def before_touching(elements: float) -> Scene:
    """Return Figure 3 without contact, until the last of its steps in which no walls push on each other."""
    scenes = runpy.run_path(str(CASES / "figure3.py"))["scenes"]
    (scene,) = scenes(elements=elements).values()
    contact = next(term for term in scene.terms if isinstance(term, SelfContact))
    operator, last = contact.on(scene.body), 0.0
    for state in simulate(replace(scene, until=0.6 * scene.until)).states[1:]:
        pushing = operator.during(state, TimeStep(scene.until)).evaluate(state["displacement"].T.ravel())
        if pushing.has_hessian:
            break
        last = state.time
    share = scene.stepping.largest * scene.until / last  # steps as long as before
    terms = tuple(term for term in scene.terms if term is not contact)
    stepping = Stepping(first=share, largest=share, tolerance=TOLERANCE)
    return replace(scene, terms=terms, until=last, stepping=stepping)


def steps_of(result: Result) -> list[Step]:
    """Return what acts in each step of a result, and the forces at which turingfold ends it."""
    scene, found = result.scene, []
    operators = [term.on(scene.body) for term in scene.terms]
    for state in result.states[1:]:
        acting = (operator.during(state, TimeStep(scene.until)) for operator in operators)
        potentials = [potential for potential in acting if potential is not None]
        at = [potential.evaluate(state["displacement"].T.ravel()) for potential in potentials]
        loads = [-evaluation.gradient()[0] for evaluation in at if not evaluation.has_hessian]
        load = np.sum([np.zeros(scene.body.nodes.size), *loads], axis=0)
        scale = np.sqrt(sum(evaluation.gradient()[1] for evaluation in at))
        found.append(Step(state["growth"], load, TOLERANCE * scale))
    return found


def solve_seconds(result: Result, repeats: int = 20) -> list[float]:
    """Return the times of factorising the last state's tangent and solving with it, without its ordering."""
    scene, state = result.scene, result.last
    potentials = [term.on(scene.body).during(state, TimeStep(scene.until)) for term in scene.terms]
    x = state["displacement"].T.ravel()
    evaluations = [potential.evaluate(x) for potential in potentials if potential is not None]
    assembler = Assembler(len(x), scene.body.fixed)
    hessians = [evaluation.hessian(0.0) for evaluation in evaluations if evaluation.has_hessian]
    pattern, values = assembler.assemble(hessians)
    solver, load = solver_for(pattern), np.ones(pattern.n)
    times = []
    for _ in range(repeats):
        began = process_time()
        try:
            solver.factorize(values)
        except NotPositiveDefinite:
            raise SystemExit("the last state is no minimum; its matrix is no measure of cost") from None
        solver.solve(load)
        times.append(process_time() - began)
    return times


def spread(values: list[float]) -> str:
    """Return the median of some numbers, and their range."""
    return f"{median(values):.3g} ({min(values):.3g} to {max(values):.3g})"
