"""Solvers of the tangent of document 1's grown semi-circle: CHOLMOD, SuperLU, pyamg.

    python tests/benchmarks/solvers.py [--elements 5 11 19.49]

Processor times. CHOLMOD and SuperLU: a factorisation and a solve, the ordering apart. pyamg: smoothed
aggregation with the rigid motions as near null space, made anew, and conjugate gradients to 1e-8.
"""

import argparse
from collections.abc import Callable
from time import process_time

import numpy as np
import pyamg
from common import brain, growth_path
from scipy.sparse import csr_matrix, tril
from scipy.sparse.linalg import cg

from turingfold.arrays import Array
from turingfold.solve.linear import Cholmod, SuperLu
from turingfold.solve.march import acting, begin, discretised, processed
from turingfold.solve.sparsity import Assembler, Pattern

AT = 0.3  # of the growth path


def tangent(elements: float) -> tuple[Pattern, Array, Array]:
    """Return pattern and values of the tangent, and the rigid motions of its unknowns, (n, 3)."""
    scene = growth_path(brain(elements))
    operators, held = discretised(scene)
    start = begin(scene).state
    state = start.updated(AT, **processed(scene, start, AT))
    nodes = scene.body.nodes
    gatherer = Assembler(nodes.size, held)
    at = [potential.evaluate(np.zeros(nodes.size)) for potential in acting(operators, state, AT)]
    pattern, values = gatherer.assemble([e.hessian(0.0) for e in at])
    node, along_x = gatherer.free // 2, gatherer.free % 2 == 0
    turned = np.where(along_x, -nodes[1, node], nodes[0, node]) / scene.body.length
    return pattern, values, np.stack([along_x, ~along_x, turned], axis=1).astype(float)


def seconds(work: Callable[[], object]) -> float:
    """Return the processor time of some work, the least of three."""
    times = []
    for _ in range(3):
        began = process_time()
        work()
        times.append(process_time() - began)
    return min(times)


def multigrid(K: csr_matrix, rigid: Array, load: Array) -> int:
    """Solve with a new hierarchy; return the iterations."""
    hierarchy = pyamg.smoothed_aggregation_solver(K, B=rigid, strength=("symmetric", {"theta": 0.0}))
    steps: list[int] = []
    _, failed = cg(K, load, rtol=1e-8, M=hierarchy.aspreconditioner(), callback=lambda _: steps.append(1))
    if failed:
        raise SystemExit("conjugate gradients did not converge")
    return len(steps)


def direct(kind: type[Cholmod] | type[SuperLu], pattern: Pattern, values: Array, load: Array) -> float:
    """Return the time of a factorisation and a solve."""
    solver = kind(pattern)

    def work() -> None:
        solver.factorize(values)
        solver.solve(load)

    work()  # which finds SuperLU's ordering
    return seconds(work)


def report(elements: float) -> str:
    """Return the times on one mesh as a line."""
    pattern, values, rigid = tangent(elements)
    load = np.random.default_rng(0).standard_normal(pattern.n)
    half = pattern.lower(values)
    K = (half + tril(half, -1).T).tocsr()
    unit = direct(Cholmod, pattern, values, load)
    superlu = direct(SuperLu, pattern, values, load) / unit
    amg, steps = seconds(lambda: multigrid(K, rigid, load)) / unit, multigrid(K, rigid, load)
    return (
        f"{pattern.n} unknowns: CHOLMOD {unit:.3f} s; in units of it SuperLU {superlu:.3g}, pyamg {amg:.3g} "
        f"({steps} iterations)"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", type=float, nargs="+", default=[5, 11, 19.49], help="across the cortex")
    for elements in parser.parse_args().elements:
        print(report(elements))


if __name__ == "__main__":
    main()
