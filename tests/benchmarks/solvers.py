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
from turingfold.parts import TimeStep
from turingfold.solve.linear import Cholmod, SuperLu
from turingfold.solve.problem import Problem, configuration
from turingfold.solve.sparsity import Assembler, Sparsity

AT = 0.3  # of the growth path


def tangent(elements: float) -> tuple[Sparsity, Array, Array]:
    """Return sparsity and values of the tangent, and the rigid motions of its unknowns, (n, 3)."""
    scene = growth_path(brain(elements))
    problem, nodes = Problem(scene), scene.body.nodes
    state = problem.processed(problem.start(), AT)
    at = configuration(problem.potentials(state, TimeStep(AT)), np.zeros(nodes.size))
    assert at is not None
    assembler = Assembler(problem.n_dofs, problem.held)
    sparsity, values = assembler.assemble(at.hessians(0.0))
    node, along_x = assembler.free // 2, assembler.free % 2 == 0
    turned = np.where(along_x, -nodes[1, node], nodes[0, node]) / scene.body.length
    return sparsity, values, np.stack([along_x, ~along_x, turned], axis=1).astype(float)


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


def direct(kind: type[Cholmod] | type[SuperLu], sparsity: Sparsity, values: Array, load: Array) -> float:
    """Return the time of a factorisation and a solve."""
    solver = kind(sparsity)

    def work() -> None:
        solver.factorize(values)
        solver.solve(load)

    work()  # which finds SuperLU's ordering
    return seconds(work)


def report(elements: float) -> str:
    """Return the times on one mesh as a line."""
    sparsity, values, rigid = tangent(elements)
    load = np.random.default_rng(0).standard_normal(sparsity.n)
    half = sparsity.lower(values)
    K = (half + tril(half, -1).T).tocsr()
    unit = direct(Cholmod, sparsity, values, load)
    superlu = direct(SuperLu, sparsity, values, load) / unit
    amg, steps = seconds(lambda: multigrid(K, rigid, load)) / unit, multigrid(K, rigid, load)
    return (
        f"{sparsity.n} unknowns: CHOLMOD {unit:.3f} s; in units of it SuperLU {superlu:.3g}, pyamg {amg:.3g} "
        f"({steps} iterations)"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", type=float, nargs="+", default=[5, 11, 19.49], help="across the cortex")
    for elements in parser.parse_args().elements:
        print(report(elements))


if __name__ == "__main__":
    main()
