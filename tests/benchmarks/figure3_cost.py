"""Cost of Figure 3 to touching walls, in factorisations of its matrix: at most 120, 40 % of it outside.

    python tests/benchmarks/figure3_cost.py [--repeats 3]

The unit is one factorisation plus solve of the last tangent with its symbolic part reused, the median of 20
timings around each run in the same process. Both are processor times of one thread, so that other work on the
machine counts little. The first run is not counted: it imports what it needs.
"""

import argparse
import runpy
from statistics import median
from time import process_time

from common import CASES, solve_seconds, spread

from turingfold import simulate


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3, help="runs to take the median of")
    repeats = parser.parse_args().repeats
    scene = next(iter(runpy.run_path(str(CASES / "figure3.py"))["scenes"]().values()))
    units = solve_seconds(simulate(scene), 10)
    costs, outside = [], []
    for _ in range(repeats):
        began = process_time()
        result = simulate(scene)
        seconds = process_time() - began
        before, units = units, solve_seconds(result, 10)
        parts = result.seconds_by_part
        costs.append(seconds / median(before + units))
        outside.append(1 - parts["factorisations"] / result.seconds)
    numbers = result.summary()
    print(f"{numbers['dofs']} unknowns, g = {numbers['growth']:.3g}, {numbers['steps']} steps, "
          f"{numbers['newton_iterations']} iterations, {numbers['factorizations']} factorisations, "
          f"{numbers['folds']} folds, {numbers['self_intersections']} intersections")  # fmt: skip
    print(f"cost in factorisations with solve: {spread(costs)}, target 120")
    print(f"share of time outside factorise-and-solve: {spread(outside)}, target 0.4")
    for part, spent in sorted(parts.items(), key=lambda item: -item[1]):
        print(f"  {part:15s} {spent / result.seconds:6.1%}")


if __name__ == "__main__":
    main()
