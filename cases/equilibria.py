"""Why folds snap in, and why a brain has more than one way to fold: the path of equilibria. About 30 s.

    turingfold run cases/equilibria.py      draws figures/equilibria.png

Half a disc with a thick cortex (T/R = 0.15) and the materials of Figure 3, mirrored, without any load but
growth. Its equilibria, followed by arc length, turn back at limit points: there the body snaps to the next
stable piece (solid; dashed states are unstable), and sulci close one after the other. At one growth there are
several stable states. Crosses: marches of 10, 20 and 40 steps; each leaves the path where its piece ends,
and comes to rest in a state of lower energy, on a piece that this path does not reach.
"""

import numpy as np

from turingfold import (
    Result,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    bifurcation_diagram,
    equilibria,
    figures,
    fold_amplitude,
    half,
    human,
    largest_growth,
    path_arrays,
    path_of_arrays,
    run_case,
    semicircle,
)
from turingfold import parameters as p

STEPS = {"10 steps": "x", "20 steps": "+", "40 steps": "1"}


@p.quick(elements=2)
def scenes(
    quick=False, *,
    radius: p.Radius = 0.0404, thickness: p.Thickness = 0.15 * 0.0404, elements: p.Elements = 4,
    layers: p.Layers = "sigmoid",
    young_gray: p.YoungGray = 1389.0, young_white: p.YoungWhite = 1895.0, poisson: p.Poisson = 0.4583,
    cortex: p.Cortex = 2.0, core: p.Core = 1.0, radial_core: p.RadialCore = 1.0,
):  # fmt: skip
    body = half(semicircle(radius=radius, thickness=thickness, elements=elements, layers=layers))
    solid = human.tissue(young_gray=young_gray, young_white=young_white, poisson=poisson)
    grow = TangentialGrowth(cortex=cortex, core=core, radial_core=radial_core)
    found = {}
    for name in STEPS:
        step = 1 / int(name.split()[0])
        stepping = Stepping(first=step, largest=step)
        found[name] = Scene(body=body, processes=(grow,), terms=(solid, SelfContact()), stepping=stepping)
    return found


def computed(results):
    return path_arrays(equilibria(results["10 steps"].scene, arc=0.1))


def draw(results, figure, computed):
    scene, path = results["10 steps"].scene, path_of_arrays(computed)
    figure.set_size_inches(10, 6)
    left, right = figure.subfigures(1, 2, width_ratios=(2, 1))
    axes = left.add_subplot()
    bifurcation_diagram(axes, scene.body, path)
    for name, marker in STEPS.items():
        states = results[name].states
        heights = fold_amplitude(scene.body, [state["displacement"] for state in states])
        growth = [largest_growth(state) for state in states]
        axes.plot(growth, 1e3 * heights, marker, color="#333333", markersize=5, label=f"march, {name}")
    energies = ", ".join(f"{result.history[-1]['energy']:.4f}" for result in results.values())
    title = f"energy at the end: path {path.points[-1].energy:.4f}, marches {energies} J/m"
    axes.set_title(title, fontsize=9)
    axes.legend(frameon=False, fontsize=8, loc="upper left")
    followed = Result(scene, tuple(point.state for point in path.points), ())
    # the last state of each stable piece: at the limit point where it ends, or at the end of growth
    ends = np.flatnonzero(path.stable & ~np.append(path.stable[1:], False) & (path.of("rate") > 0))
    for k, place in enumerate(ends[:3]):
        panel = right.add_subplot(3, 1, k + 1)
        figures.layers(panel, followed, place)
        letter, growth = "ABC"[k], path.points[place].growth
        panel.set_title(f"{letter}  growth {growth:.2f}, {figures.numbers(followed, place)}", fontsize=8)
        at = fold_amplitude(scene.body, [path.points[place].state["displacement"]])[0]
        axes.annotate(letter, (growth, 1e3 * at), xytext=(4, 4), textcoords="offset points")


if __name__ == "__main__":
    run_case(__file__)
