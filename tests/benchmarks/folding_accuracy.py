"""Error of growth, onset of buckling, and folded state against run time. About 4 min.

    python tests/benchmarks/folding_accuracy.py [--quick]      draws its figure

Left: a disc whose cortex (T/R = 0.1, sharp, kappa = 5 mu) grows by 20 %, and the growth at which it buckles,
both against a spectral solution in the radius. Middle: half of Figure 3 with as many elements along the
cortex as across it, and with twice as many along it, as by default, against 12 across and along and a finer
core; accuracy_cost.py has what --accuracy chooses. Right: tension in patches at 3 elements with equal steps,
against 90 steps. Times of runs shorter than 2 s: medians of three.

    elements across, along   growth    onset     Figure 3: energy   gyrification   sulcal depth
    2, 2                     8.0e-5    2.6e-3    2.9e-2             4.3e-2         6.2e-2
    4, 4                     1.1e-5    2.6e-4    1.0e-2             1.7e-2         2.3e-2
    6, 6                     3.5e-6    7e-5      3.1e-3             1.0e-2         9.0e-3
    8, 8                     1.5e-6    3e-5      1.5e-3             6.6e-3         4.6e-3
    2, 4                                         1.3e-2             1.1e-2         9.8e-3
    3, 6, the default                            6.1e-3             5.0e-3         1.3e-3
    4, 8                                         4.4e-3             3.0e-3         2.7e-3

Onsets from 4 on are read from the figure. What grows to twice its length along the surface is resolved evenly
by elements half as long; chosen after
seeing this. Against 12 across, 18 along and a core of 0.05, which take seven times as long (energy
0.200149 J/m, index 1.45413, depth 1.8535 T), the default is off by 6.1e-3, 7.0e-3 and 9.4e-4, 6, 6 with the
former core of 0.2 by 1.9e-2, 1.2e-2 and 1.1e-2.
Steps choose between neighbouring equilibria: from 5 to 45, all end up to 0.08 T from where 90 end, and up to
3e-4 of the energy.
"""

from dataclasses import replace
from importlib.util import find_spec
from statistics import median
from time import process_time

import numpy as np
from common import CASES, drawn, timed
from numpy.polynomial import chebyshev
from scipy.interpolate import BarycentricInterpolator
from scipy.optimize import brentq

from turingfold import (
    AxonalTension,
    Elastic,
    NeoHookean,
    Scene,
    SelfContact,
    Stepping,
    TangentialGrowth,
    buckling,
    half,
    semicircle,
)
from turingfold.cli.case import load_case

DISC, GROWTH, ONSET = 0.1, 1.2, 2.0  # T/R; growth of the smooth disc and of the one that buckles
MU, KAPPA = 1.0, 5.0
THICKNESS, RADIUS = 2.5e-3, 0.0404  # of the brain, m
ACROSS, EVEN, SLENDER, FINEST = (1, 2, 3, 4, 6, 8), (2, 3, 4, 6, 8), (2, 3, 4), 12
ALONG, DEFAULT = 2, 3  # times as many elements along the cortex as across it, in slender ones; Figure 3's own
STEPS, MOST = (5, 10, 15, 20, 30, 45), 90
SHORT = 2.0  # s


def disc(across, growth, stepping, **mesh):
    """Return half of a half disc on rollers, which is a disc in its even modes."""
    body = half(semicircle(radius=1.0, thickness=DISC, size=DISC / across, base="roller", **mesh))
    grow = TangentialGrowth(cortex=growth)
    solid = Elastic(gray=NeoHookean(mu=MU, kappa=KAPPA))
    return Scene(body=body, processes=(grow,), terms=(solid,), stepping=stepping)


def brain(across, stepping):
    body = half(semicircle(radius=RADIUS, thickness=THICKNESS, size=THICKNESS / across))
    gray, white = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)
    terms = (Elastic(gray=gray, white=white), AxonalTension(strength=0.5, patches=12), SelfContact())
    return Scene(body=body, processes=(TangentialGrowth(cortex=1.9),), terms=terms, stepping=stepping)


def figure3(across, along=1, **mesh):
    """Return half of the case figure3."""
    case = load_case(CASES / "figure3.py")
    given = {"elements": across, "along": along, "halved": True}
    (scene,) = case.scenes(given, quick=False).values()
    if mesh:
        body = half(semicircle(radius=RADIUS, thickness=THICKNESS, elements=across, **mesh))
        scene = replace(scene, body=body)
    return scene


def scenes(quick=False):
    across, even, slender = (ACROSS[:3], (2, 3), (2, 3)) if quick else (ACROSS, EVEN, SLENDER)
    steps, most = ((5, 10), 20) if quick else (STEPS, MOST)
    found = {f"disc, {n}": disc(n, GROWTH, Stepping(first=0.25, largest=0.25)) for n in across}
    found |= {f"folded, {n}": figure3(n) for n in even}
    found |= {f"slender, {n}": figure3(n, ALONG) for n in slender}
    finest = 4 if quick else FINEST
    found[f"folded, {finest}"] = figure3(finest, coarsening=1.1)
    equal = {n: Stepping(first=1 / n, largest=1 / n) for n in (*steps, most)}
    return found | {f"steps, {n}": brain(2 if quick else 3, stepping) for n, stepping in equal.items()}


class Radial:
    """The growing disc in polynomials of the radius: its smooth state, and its stiffness against cos nθ.

    With a = r', b = r/(g R) and F = diag(a, b, 1), P = α F + β cof F as in `turingfold.mechanics.material`.
    """

    def __init__(self, growth, degree=20):
        x, weights = np.polynomial.legendre.leggauss(2 * degree)
        nodes = -np.cos(np.pi * np.arange(degree + 1) / degree)
        coefficients = np.linalg.inv(chebyshev.chebvander(nodes, degree))
        shapes = chebyshev.chebvander(x, degree) @ coefficients
        slopes = chebyshev.chebvander(x, degree - 1) @ chebyshev.chebder(coefficients)
        ends, self.nodes = (0.0, 1.0 - DISC, 1.0), []
        self.N, self.D = np.zeros((2, 4 * degree, 2 * degree + 1))
        self.R, self.weight, self.g = np.zeros((3, 4 * degree))
        for k in (0, 1):
            at, own = np.s_[2 * degree * k : 2 * degree * (k + 1)], np.s_[degree * k : degree * (k + 1) + 1]
            size = 0.5 * (ends[k + 1] - ends[k])
            self.R[at], self.weight[at] = ends[k] + size * (1 + x), size * weights
            self.N[at, own], self.D[at, own] = shapes, slopes / size
            self.g[at] = growth if k else 1.0
            self.nodes.append(ends[k] + size * (1 + nodes))
        self.weight *= self.R * self.g
        self.r = np.append(self.nodes[0], self.nodes[1][1:])
        self._balance()

    def _law(self):
        a, b = self.D @ self.r, self.N @ self.r / (self.g * self.R)
        J, trace = a * b, a * a + b * b + 1
        alpha = MU * J ** (-2 / 3)
        beta = KAPPA * (J - 1) - alpha * trace / (3 * J)
        c1, c2 = -2 * alpha / (3 * J), KAPPA + 5 * alpha * trace / (9 * J**2)
        aa, bb = alpha + 2 * c1 * J + c2 * b * b, alpha + 2 * c1 * J + c2 * a * a
        return a, b, alpha, beta, aa, beta + c1 * (a * a + b * b) + c2 * J, bb

    def _balance(self):
        around = self.N / (self.g * self.R)[:, None]
        for _ in range(12):  # Newton's method, far beyond what it needs
            a, b, alpha, beta, aa, ab, bb = self._law()
            force = self.D.T @ (self.weight * (alpha * a + beta * b))
            force += around.T @ (self.weight * (alpha * b + beta * a))
            K = _form(self.D, self.weight * aa) + _form(around, self.weight * bb)
            mixed = _form(self.D, self.weight * ab, around)
            self.r[1:] -= np.linalg.solve((K + mixed + mixed.T)[1:, 1:], force[1:])

    def radius(self, R):
        """Return where the radii R have gone."""
        degree = len(self.r) // 2
        core = self.r[degree] / (1.0 - DISC) * R  # a disc under even pressure keeps its shape
        cortex = BarycentricInterpolator(self.nodes[1], self.r[degree:])
        return np.where(R <= 1.0 - DISC, core, cortex(np.maximum(R, 1.0 - DISC)))

    def stiffness(self, n):
        """Return the lowest eigenvalue of the second variation for u_r = U cos nθ, u_θ = V sin nθ."""
        _, _, alpha, beta, aa, ab, bb = self._law()
        R, none = self.R[:, None], np.zeros_like(self.N)
        rr, tr = np.hstack([self.D, none]), np.hstack([none, self.D])
        tt = np.hstack([self.N, n * self.N]) / (R * self.g[:, None])
        rt = np.hstack([-n * self.N, -self.N]) / (R * self.g[:, None])
        w = self.weight
        mixed = _form(rr, w * ab, tt) - _form(rt, w * beta, tr)
        K = _form(rr, w * aa) + _form(tt, w * bb) + _form(rt, w * alpha) + _form(tr, w * alpha)
        K += mixed + mixed.T
        free = np.delete(np.arange(len(K)), [0, len(K) // 2])
        return np.linalg.eigvalsh(K[np.ix_(free, free)])[0]


def _form(left, weight, right=None):
    return left.T @ (weight[:, None] * (left if right is None else right))


def seconds(result, again=timed):
    """Return the time of a run; of a short one the median of three."""
    first = result.seconds
    return first if first > SHORT else median([first, *(again(result.scene).seconds for _ in range(2))])


def without_cholmod(scene):
    return timed(replace(scene, stepping=replace(scene.stepping, solver="superlu")))


def growth_error(result):
    """Return the largest error of a node's place over the largest displacement."""
    nodes, moved = result.scene.body.nodes, result.last["displacement"]
    R = np.hypot(*nodes)
    exact = nodes * (Radial(GROWTH).radius(R) / np.where(R > 0, R, 1.0))
    return np.hypot(*(nodes + moved - exact)).max() / np.hypot(*moved).max()


def onsets(across, **mesh):
    """Return times and growths at which discs buckle."""
    found = []
    for n in across:
        scene, began = disc(n, ONSET, Stepping(first=0.1, largest=0.1), **mesh), process_time()
        growth = buckling(scene).growth
        found.append((process_time() - began, growth))
    return np.array(found).T


def order(across, errors):
    """Return the order seen between the first and the last error."""
    return np.log(errors[0] / errors[-1]) / np.log(across[-1] / across[0])


def numbers(result):
    """Return energy, gyrification index and sulcal depth in units of the thickness."""
    summary = result.summary()
    depth = summary["sulcal_depth"] / result.scene.body.thickness
    return np.array([summary["energy"], summary["gyrification_index"], depth])


def draw_disc(axes, runs):
    across = list(runs)
    errors = [growth_error(result) for result in runs.values()]
    label = f"smooth growth, order {order(across, errors):.1f}"
    axes.loglog([seconds(result) for result in runs.values()], errors, "o-", label=label)
    exact = min(brentq(lambda g, n=n: Radial(g).stiffness(n), 1.5, 1.9, xtol=1e-9) for n in (12, 14, 16))
    for name, mesh in {"": {}, ", finer core": {"coarsening": 1.1}}.items():
        chosen = [n for n in across if n > 1 or not mesh]
        times, growths = onsets(chosen, **mesh)
        errors = np.abs(growths / exact - 1)
        label = f"onset of buckling{name}, order {order(chosen, errors):.1f}"
        axes.loglog(times, errors, "s-", label=label)
        for n, *at in zip(chosen, times, errors, strict=True):
            axes.annotate(n, at, xytext=(8, 3) if mesh else (-12, -8), textcoords="offset points", fontsize=8)
    axes.set_title(f"growing disc; it buckles at {exact:.5f}")
    axes.set_ylabel("relative error")


def draw_folded(axes, runs, slender):
    *across, finest = runs
    exact = numbers(runs[finest])

    def errors_of(result):
        return np.abs(numbers(result) / exact - 1)

    errors = np.array([errors_of(runs[n]) for n in across]).T
    times = [seconds(runs[n]) for n in across]
    for name, error in zip(("energy", "gyrification index", "sulcal depth"), errors, strict=True):
        axes.loglog(times, error, "o-", label=f"{name}, order {order(across, error):.1f}")
    for n, time, error in zip(across, times, errors.max(0), strict=True):
        axes.annotate(str(n), (time, error), xytext=(4, 5), textcoords="offset points", fontsize=8)
    times = [seconds(run) for run in slender.values()]
    worst = [errors_of(run).max() for run in slender.values()]
    label = f"the worst, {ALONG} times as many along the cortex"
    axes.loglog(times, worst, "ks--", markerfacecolor="none", label=label)
    for along, series in ((1, {n: runs[n] for n in across}), (ALONG, slender)):
        for n, run in series.items():
            shown = "   ".join(f"{error:.1e}" for error in errors_of(run))
            print(f"{n} across, {along * n} along: {seconds(run):.3g} s   {shown}")
    for n, time, error in zip(slender, times, worst, strict=True):
        words = f"{n}, the default" if n == DEFAULT else str(n)
        axes.annotate(
            words, (time, error), xytext=(-6, -12), textcoords="offset points", fontsize=8, ha="right"
        )
    folds = sorted({run.summary()["folds"] for run in runs.values()})
    words = f"energy {exact[0]:.4g} J/m, index {exact[1]:.3f}, depth {exact[2]:.3f} T"
    title = f"half of Figure 3, {' or '.join(map(str, folds))} sulci; {finest} elements:"
    axes.set_title(f"{title} {runs[finest].seconds:.0f} s,\n{words}")
    axes.set_ylabel(f"relative difference to {finest} elements")
    axes.margins(x=0.15)


def draw_steps(axes, runs):
    *steps, most = runs
    exact, unit = runs[most], runs[most].scene.body.thickness
    solvers = {"CHOLMOD": timed, "SuperLU": without_cholmod}
    for name, again in solvers.items() if find_spec("cvxopt") else [("SuperLU", timed)]:
        found = {n: runs[n] if again is timed else again(runs[n].scene) for n in steps}
        times = [seconds(found[n], again) for n in steps]
        energy = [abs(numbers(found[n])[0] / numbers(exact)[0] - 1) for n in steps]
        shape = [np.hypot(*(found[n].pial() - exact.pial())).max() / unit for n in steps]
        # no lines: paths end in the same equilibrium, to round-off, or in a neighbouring one
        style = "o" if again is timed else "x"
        for colour, errors, what in (("C0", energy, "energy"), ("C1", shape, "largest distance / T")):
            axes.semilogy(times, np.maximum(errors, 1e-16), style, color=colour, label=f"{what}, {name}")
        labelled = zip(steps, times, shape, strict=True) if again is timed else ()
        for n, time, error in labelled:
            above = steps.index(n) % 2 == 0
            axes.annotate(
                n, (time, error), xytext=(0, 5 if above else -12), textcoords="offset points", fontsize=8,
                ha="center",
            )  # fmt: skip
    axes.set_title(f"number of equal steps; {most}: {seconds(exact):.0f} s")
    axes.set_ylabel(f"difference to {most} steps")


def draw(results, figure):
    from matplotlib.ticker import LogLocator, NullFormatter

    figure.set_size_inches(15, 6)
    panels = figure.subplots(1, 3)
    drawn = {"disc": draw_disc, "folded": draw_folded, "steps": draw_steps}
    for axes, (kind, function) in zip(panels, drawn.items(), strict=True):
        names = {name.partition(", ")[::2]: result for name, result in results.items()}
        kinds = (kind, "slender") if kind == "folded" else (kind,)
        function(axes, *({int(n): r for (own, n), r in names.items() if own == one} for one in kinds))
        axes.set_xlabel("time of the processor (s)")
        axes.xaxis.set_minor_formatter(NullFormatter())
        if kind != "steps":
            axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axes.xaxis.set_major_formatter("{x:g}")
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, frameon=False)


if __name__ == "__main__":
    drawn(__file__, scenes, draw)
