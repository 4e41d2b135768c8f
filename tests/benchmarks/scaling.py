"""Time and memory of the growth path on finer meshes: 4.8 times the time for 4 times the unknowns, 900 MB.

    python tests/benchmarks/scaling.py [--repeats 3]

Times alternate between the two meshes in one process; peak memory is that of a process of its own, imports
included, that takes the whole path.
"""

import argparse
import resource
import subprocess
import sys
from math import log
from statistics import median
from time import process_time

from common import brain, growth_path, spread

from turingfold import simulate

COARSE, FINE, LARGE = 4.6, 10, 17.4  # elements through the cortex: 16 000, 64 000 and 181 000 unknowns


def run(elements: float) -> tuple[int, float]:
    """Return the number of unknowns and the time of one path."""
    scene = growth_path(brain(elements))
    began = process_time()
    result = simulate(scene)
    return result.summary()["dofs"], process_time() - began


def peak_memory() -> float:
    """Return the peak memory of this process so far; MB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3, help="runs to take the median of")
    parser.add_argument("--memory", action="store_true", help="run the large mesh, print its peak memory")
    chosen = parser.parse_args()
    if chosen.memory:
        print(f"{run(LARGE)[0]} unknowns: peak memory {peak_memory():.0f} MB, target 900 MB")
        return
    run(4)  # imports
    pairs = [(run(COARSE), run(FINE)) for _ in range(chosen.repeats)]
    (few, _), (many, _) = pairs[0]
    ratios = [fine / coarse for (_, coarse), (_, fine) in pairs]
    power = log(median(ratios)) / log(many / few)
    print(f"{few} -> {many} unknowns: {spread(ratios)} times the time")
    print(f"for 4 times the unknowns that is {4**power:.3g} times the time, target 4.8")
    subprocess.run([sys.executable, __file__, "--memory"], check=True)


if __name__ == "__main__":
    main()
