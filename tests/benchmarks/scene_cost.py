"""What a scene pays for: time, peak memory and modules of the eight combinations of hypotheses.

Each runs in a fresh process:

    python tests/benchmarks/scene_cost.py [--quick]      prints the table, draws figures/scene_cost.png

ATH: tension of axons.  IPH: the pattern says where.  DGH: two layers of different elasticity. Growth and
contact are the same in all. Stops where a module of a part that a scene lacks is imported.
"""

import json
import subprocess
import sys
from argparse import ArgumentParser
from itertools import product
from pathlib import Path

from matplotlib.figure import Figure

RUN = """
import json, resource, sys
from time import perf_counter
asked, began = json.loads(sys.argv[1]), perf_counter()
from turingfold import (
    Elastic, NeoHookean, Scene, SelfContact, Stepping, TangentialGrowth, semicircle, simulate
)
gray = NeoHookean.from_young(1389.0, 0.4583)
terms = [
    Elastic(gray=gray, white=NeoHookean.from_young(1895.0, 0.4583) if asked["DGH"] else None), SelfContact()
]
grow, processes = TangentialGrowth(cortex=asked["cortex"], core=1.05, radial_core=1.1), []
if asked["ATH"]:
    from turingfold import AxonalTension
    terms.append(AxonalTension(strength=0.75, patches=0 if asked["IPH"] else 12))
if asked["IPH"]:
    from turingfold import Schnakenberg, Turing
    processes.append(Turing(Schnakenberg()))
steps = Stepping()
if asked["inertia"]:
    from turingfold import Inertia
    terms.append(Inertia(density=1100.0))
    steps = Stepping(first=1 / 200, largest=1 / 50)
imported = perf_counter()
body = semicircle(radius=0.0404, thickness=2.5e-3, elements=asked["elements"])
scene = Scene(body=body, terms=tuple(terms), processes=(*processes, grow), stepping=steps)
built = perf_counter()
result = simulate(scene)
loaded = [name for name in sys.modules if name.startswith("turingfold.")]
print(json.dumps({
    "status": result.status, "dofs": result.summary()["dofs"], "steps": len(result.history),
    "imports": imported - began, "body": built - imported, "parts": dict(result.seconds_by_part),
    "seconds": perf_counter() - began, "modules": loaded,
    "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
}))
"""
OWN = {"ATH": "turingfold.terms.tension", "IPH": "turingfold.turing", "inertia": "turingfold.terms.dynamics"}
ALWAYS = "turingfold.terms.damping", "turingfold.growth.swelling", "turingfold.figures", "turingfold.cli"
GROUPS = {
    "imports": ("imports",), "body": ("body",), "start (pattern)": ("starting",),
    "fields of processes": ("processes",), "forces, tangents": ("forces", "tangents"),
    "factorisations": ("factorisations", "orderings"), "contact, search": ("step bounds", "line searches"),
}  # fmt: skip
COLOURS = "#999999", "#56b4e9", "#009e73", "#f0e442", "#e69f00", "#0072b2", "#cc79a7", "#dddddd"


def measured(asked):
    """Return what a scene took in a process of its own; RuntimeError for a module that it does not need."""
    command = [sys.executable, "-W", "ignore", "-c", RUN, json.dumps(asked)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr)
    found = json.loads(done.stdout)
    absent = [*(module for part, module in OWN.items() if not asked[part]), *ALWAYS]
    extra = [name for name in found["modules"] for module in absent if f"{name}.".startswith(f"{module}.")]
    if extra:
        raise RuntimeError(f"{asked} imports {', '.join(extra)}")
    return found


def scenes(quick):
    """Return what is asked of each scene, by name."""
    common = {"elements": 1.5 if quick else 2, "cortex": 1.3 if quick else 2.3}
    found = {}
    for on in product((False, True), repeat=3):
        parts = dict(zip(("ATH", "IPH", "DGH"), on, strict=True))
        name = " + ".join(part for part, there in parts.items() if there) or "growth alone"
        found[name] = {**common, **parts, "inertia": False}
    found["all three, with inertia"] = {**common, "ATH": True, "IPH": True, "DGH": True, "inertia": True}
    return found


def draw(figure, rows):
    """Draw the time by kind of work, with memory and the number of modules."""
    figure.set_size_inches(10, 5)
    axes, left = figure.subplots(), [0.0] * len(rows)
    for (group, names), colour in zip([*GROUPS.items(), ("rest", ())], COLOURS, strict=True):
        for k, row in enumerate(rows.values()):
            times = {**row["parts"], "imports": row["imports"], "body": row["body"]}
            width = sum(times.get(name, 0.0) for name in names) if names else row["seconds"] - left[k]
            axes.barh(k, width, left=left[k], color=colour, label=group if k == 0 else None)
            left[k] += width
    for k, row in enumerate(rows.values()):
        words = f"  {row['megabytes']:.0f} MB, {len(row['modules'])} modules, {row['steps']} steps"
        axes.text(left[k], k, words, va="center", fontsize=8)
    axes.set_yticks(range(len(rows)), rows)
    axes.set(xlabel="time (s) in a fresh process, imports and all", xlim=(0, 1.35 * max(left)))
    axes.invert_yaxis()
    figure.legend(loc="outside lower center", ncols=4, frameon=False)


def main():
    """Measure, print, draw."""
    asked = ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("--quick", action="store_true", help="less growth, larger elements, drawn here")
    quick = asked.parse_args().quick
    heads = ("seconds", "imports", "pattern", "MB", "modules", "steps")
    print(f"{'scene':26} " + " ".join(f"{head:>8}" for head in heads) + "  status")
    rows = {}
    for name, own in scenes(quick).items():
        row = rows[name] = measured(own)
        print(
            f"{name:26} {row['seconds']:8.2f} {row['imports']:8.2f} {row['parts'].get('starting', 0.0):8.2f} "
            f"{row['megabytes']:8.0f} {len(row['modules']):8d} {row['steps']:8d}  {row['status']}",
            flush=True,
        )  # fmt: skip
    figure = Figure(layout="constrained")
    draw(figure, rows)
    path = Path("scene_cost.png") if quick else Path(__file__).parents[2] / "figures" / "scene_cost.png"
    figure.savefig(path, dpi=150, facecolor="white")
    print(f"figure: {path}")


if __name__ == "__main__":
    main()
