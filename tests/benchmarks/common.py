"""What the benchmarks share: the growth path of document 1's semi-circle, and the unit of cost."""

from argparse import ArgumentParser
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np

from turingfold import Elastic, NeoHookean, Scene, Stepping, TangentialGrowth, semicircle, simulate
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
