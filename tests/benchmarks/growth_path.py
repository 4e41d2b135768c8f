"""Time of a growth path against NGSolve and FElupe. Targets: 0.35 of NGSolve's, 0.15 of FElupe's.

    python tests/benchmarks/growth_path.py [--elements 5] [--repeats 3] [--peers ngsolve felupe] [--threads 2]
        [--predict] [--figure3]

Semi-circle of document 1, quadratic triangles, sharp cortex growing from 1 to 1.45 in 15 equal steps, no
contact. All solve the same discrete problem, on one mesh with one quadrature, to the same nodal forces:
1e-8 of turingfold's scale at the end of each step. Runs alternate in one process. The peers assemble (and
NGSolve factorises) with two threads, turingfold works with one. What belongs to the
mesh, and the compilation of kernels, is prepared before; operators and orderings are part of every run.
With --figure3 it is the body of Figure 3 with its tension, growth of the core and swelling, until the last
of its steps in which no walls push on each other.
With --predict the peers, too, start each step from the continued last one. With --threads 1 processor times
are compared; those also mean something on a machine that is busy with other work.
"""

import argparse
from collections.abc import Callable
from importlib import import_module
from statistics import median
from time import perf_counter, process_time

import numpy as np
from common import before_touching, brain, growth_path, spread, steps_of

from turingfold import Scene, simulate


def timed(
    run: Callable[[], tuple[np.ndarray, int]], clock: Callable[[], float]
) -> tuple[float, np.ndarray, int]:
    """Return the time of a run, its displacement and its iterations."""
    began = clock()
    displacement, iterations = run()
    return clock() - began, displacement, iterations


def ours(scene: Scene) -> tuple[np.ndarray, int]:
    """Return the displacement of the nodes and the iterations of turingfold."""
    result = simulate(scene)
    return result.last["displacement"], result.summary()["newton_iterations"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", type=int, default=5, help="elements through the cortex")
    parser.add_argument("--repeats", type=int, default=3, help="alternating runs to take the median of")
    parser.add_argument("--peers", nargs="+", default=["ngsolve", "felupe"], help="those to compare with")
    parser.add_argument("--threads", type=int, default=2, help="threads of the peers")
    parser.add_argument("--predict", action="store_true", help="let peers start from the continued last step")
    parser.add_argument("--figure3", action="store_true", help="Figure 3 until its walls touch")
    chosen = parser.parse_args()
    scene = (before_touching if chosen.figure3 else lambda n: growth_path(brain(n)))(chosen.elements)
    steps = steps_of(simulate(scene))
    clock = process_time if chosen.threads == 1 else perf_counter
    settings = scene.body, chosen.predict, chosen.threads
    peers = [import_module(f"peer_{name}").Peer(*settings) for name in chosen.peers]
    print(f"{scene.body.nodes.size - len(scene.body.fixed)} unknowns, {scene.body.mesh.nelements} triangles")
    times: dict[str, list[float]] = {peer.name: [] for peer in peers}
    ratios: dict[str, list[float]] = {peer.name: [] for peer in peers}
    for _ in range(chosen.repeats):
        for peer in peers:
            seconds, expected, iterations = timed(lambda: ours(scene), clock)
            theirs, found, others = timed(lambda peer=peer: peer.run(steps), clock)
            times[peer.name].append(theirs)
            ratios[peer.name].append(seconds / theirs)
            apart = np.abs(found - expected).max() / np.abs(expected).max()
            print(f"turingfold {seconds:.2f} s, {iterations} iterations")
            print(f"{peer.name} {theirs:.2f} s, {others} iterations, displacement differs by {apart:.1e}")
            if not apart < 1e-6:
                raise SystemExit(f"{peer.name} solves another problem: displacements differ by {apart:.2g}")
    for name, found in ratios.items():
        print(f"turingfold / {name}: {spread(found)}; {name} took {median(times[name]):.2f} s")


if __name__ == "__main__":
    main()
