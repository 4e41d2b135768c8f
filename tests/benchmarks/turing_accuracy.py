"""Error against time of every integrator of the Turing system, with scipy and py-pde as peers. About 5 min.

    python tests/benchmarks/turing_accuracy.py [--quick]      draws its figure

Band problem A: Schnakenberg's kinetics on the band of the semi-circle, 12 half waves, from
u = 1 + 0.05 cos 12θ to t = 50. Errors in time: largest over the nodes, relative, against a run at tolerance
1e-8 on the same linear elements with lumped mass, which make the system an ordinary one that scipy can take,
with its sparse Jacobian. Times: of the processor, medians of three runs. Errors in space: steady states
against a spectral solution, on structured meshes.

py-pde (optional) takes no curved band, so it has the same kinetics on a straight strip as long and as thick,
zero flux, 144 x 3 cells; ours 145 x 4 nodes. Each is compared with its own equations solved to 1e-8. py-pde's
time is without the minute or more that it spends on compiling.
"""

from functools import partial
from importlib.util import find_spec
from statistics import median
from time import process_time

import numpy as np
from common import drawn
from scipy.integrate import solve_ivp
from scipy.sparse import diags_array
from skfem import MeshTri, MeshTri2

from turingfold import Elastic, NeoHookean, Scene, Schnakenberg, Stepping, Turing, semicircle
from turingfold.turing.integrators.bdf import march_bdf
from turingfold.turing.integrators.imex import SCHEMES, fastest_reaction, march_imex
from turingfold.turing.integrators.rosenbrock import RODAS4, ROS34PW2, march
from turingfold.turing.reaction_diffusion import ReactionDiffusion, discretise
from turingfold.turing.steady import settle

RADIUS, THICKNESS = 0.0404, 2.5e-3
D_U = 0.00207680687228251 * RADIUS**2  # makes 12 half waves the fastest mode
# spectral steady state: u at a peak and a trough of the pial surface, then of the interface
STEADY = (1.43889924415, 0.57606079403, 1.43621625583, 0.57840272116)
END, REPEATS = 50.0, 3
LENGTH, CELLS = np.pi * (RADIUS - THICKNESS / 2), (144, 3)  # of the straight strip
MESHES = {"elements of T/3": 3, "elements of T/8": 8}
QUICK = {"elements of T/1": 1, "elements of T/2": 2}


def scenes(quick=False):
    gray = NeoHookean.from_young(1389.0, 0.4583)
    found = {}
    for name, across in (QUICK if quick else MESHES).items():
        body = semicircle(radius=RADIUS, thickness=THICKNESS, size=THICKNESS / across)
        found[name] = Scene(
            body=body,
            processes=(Turing(Schnakenberg(), half_waves=12),),
            terms=(Elastic(gray=gray, white=gray),),
            stepping=Stepping(first=1.0, largest=1.0),
        )
    return found


def problem(mesh, degree, **options):
    """Return band problem A on a mesh of the band, and its start."""
    space = discretise(mesh, degree, **options)
    system = ReactionDiffusion(space, Schnakenberg(), D_U, 10 * D_U)
    start = system.uniform(1.0, 0.9)
    start[0] += 0.05 * np.cos(12 * np.arctan2(space.nodes[1], space.nodes[0]))
    return system, start


def last(moments):
    for moment in moments:
        end = moment
    return end.state


def peer(method, system, start, tolerance):
    """Return the end of scipy's run of the same system, M⁻¹ applied, which is possible for a lumped mass."""
    inverse = 1 / system.space.weights
    scale = diags_array(-np.repeat(inverse, 2))

    def rate(time, y):
        return (system.rate(y.reshape(-1, 2).T) * inverse).T.ravel()

    def jacobian(time, y):
        return scale @ system.matrix(y.reshape(-1, 2).T)

    found = solve_ivp(rate, (0, END), start.T.ravel(), method, jac=jacobian, rtol=tolerance, atol=tolerance)
    return found.y[:, -1].reshape(-1, 2).T


def methods(system, start, end):
    """Return for each method the runs to measure, from coarse to fine."""
    fastest = max(fastest_reaction(system, state) for state in (start, end))  # the pattern reacts faster
    tolerances = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
    longest = {name: 0.4 * s.reaction_limit / fastest for name, s in SCHEMES.items()}
    imex = {
        name: [partial(march_imex, until=END, scheme=scheme, step=longest[name] / 3.0**k) for k in range(3)]
        for name, scheme in SCHEMES.items()
    }
    adaptive = {
        "RODAS4 (default)": [partial(march, until=END, tolerance=t, tableau=RODAS4) for t in tolerances],
        "ROS34PW2": [partial(march, until=END, tolerance=t, tableau=ROS34PW2) for t in tolerances[:4]],
        "BDF": [partial(march_bdf, until=END, tolerance=t) for t in (*tolerances[1:], 1e-7)],
    }
    ours = {
        name: [lambda run=run: last(run(system, start)) for run in runs]
        for name, runs in (adaptive | imex).items()
    }
    peers = {
        f"scipy {name}": [partial(peer, name, system, start, t) for t in limits]
        for name, limits in {"BDF": (1e-4, 1e-5, 1e-6, 1e-7), "Radau": (1e-3, 1e-4)}.items()
    }
    return ours | peers


def measure(run, exact, repeats):
    """Return the median time of a run and its relative error."""
    times = []
    for _ in range(repeats):
        before = process_time()
        end = run()
        times.append(process_time() - before)
    return median(times), np.abs(end - exact).max() / np.abs(exact).max()


def band(along):
    """Return a structured, exactly curved mesh of the band with elements that are nearly square."""
    radii = np.linspace(RADIUS - THICKNESS, RADIUS, along // 48 + 1)
    curved = MeshTri2.from_mesh(MeshTri.init_tensor(np.linspace(0, np.pi, along + 1), radii))
    angle, r = curved.doflocs
    return MeshTri2(np.stack([r * np.cos(angle), r * np.sin(angle)]), curved.t[[0, 2, 1]], validate=False)


def spatial_errors(degree, sizes):
    """Return nodes and errors of the steady state at a peak and a trough away from the ends."""
    nodes, errors = [], []
    for along in sizes:
        system, start = problem(band(along), degree)
        u = settle(system, start).state[0]
        x, y = system.space.nodes
        found = [
            u[np.hypot(x - r * np.cos(angle), y - r * np.sin(angle)).argmin()]
            for r in (RADIUS, RADIUS - THICKNESS)
            for angle in (np.pi / 3, np.pi / 3 + np.pi / 12)
        ]
        nodes.append(system.space.size)
        errors.append(np.abs(np.array(found) - STEADY).max())
    return nodes, errors


def along(x):
    return 1 + 0.05 * np.cos(12 * np.pi * x / LENGTH)


def strip_ours():
    """Return the points of our adaptive integrators on the strip."""
    x, y = np.linspace(0, LENGTH, CELLS[0] + 1), np.linspace(0, THICKNESS, CELLS[1] + 1)
    space = discretise(MeshTri.init_tensor(x, y), 1, lumped=True)
    system = ReactionDiffusion(space, Schnakenberg(), D_U, 10 * D_U)
    start = system.uniform(1.0, 0.9)
    start[0] = along(space.nodes[0])
    exact = last(march(system, start, until=END, tolerance=1e-8))
    runs = {"RODAS4 (default)": march, "BDF": march_bdf}
    return {
        name: [
            measure(lambda t=t, run=run: last(run(system, start, until=END, tolerance=t)), exact, REPEATS)
            for t in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
        ]
        for name, run in runs.items()
    }


def strip_py_pde():
    """Return the time and error of py-pde's adaptive Runge-Kutta-Fehlberg method on the strip."""
    import pde

    grid = pde.CartesianGrid([[0, LENGTH], [0, THICKNESS]], CELLS, periodic=False)
    u = pde.ScalarField(grid, along(grid.cell_coords[..., 0]))
    start = pde.FieldCollection([u, pde.ScalarField(grid, 0.9)])
    rates = {
        "u": f"{D_U} * laplace(u) + 0.1 - u + u**2 * v",
        "v": f"{10 * D_U} * laplace(v) + 0.9 - u**2 * v",
    }
    equations = pde.PDE(rates, bc={"derivative": 0})
    solver = pde.RungeKuttaSolver(equations, adaptive=True, tolerance=1e-4)
    stepper = solver.make_stepper(start, dt=1e-3)

    def run():
        state = start.copy()
        stepper(state, 0.0, END)
        return state.data

    run()  # compiles
    exact = cells(grid.axes_coords[0])
    return measure(run, exact[:, :, None], REPEATS)


def cells(x):
    """Return u and v of py-pde's equations, which do not vary across the strip, at the centres of cells."""
    kinetics, width = Schnakenberg(), LENGTH / len(x)

    def rate(time, y):
        w = y.reshape(2, -1)
        flux = np.diff(w, axis=1, prepend=w[:, :1], append=w[:, -1:])
        spread = np.diff(flux, axis=1) / width**2 * [[D_U], [10 * D_U]]
        return (spread + kinetics.rates(*w)).ravel()

    start = np.concatenate([along(x), np.full_like(x, 0.9)])
    return solve_ivp(rate, (0, END), start, "BDF", rtol=1e-9, atol=1e-10).y[:, -1].reshape(2, -1)


def draw_strip(axes, peers):
    """Draw our integrators and, where it is installed, py-pde on the straight strip."""
    for name, points in strip_ours().items():
        axes.loglog(*np.transpose(points), "o-", label=name)
    if peers and find_spec("pde"):
        axes.loglog(*strip_py_pde(), "kx", markersize=9, label="py-pde, adaptive Runge-Kutta, compiled")
        words = "py-pde, explicit, takes the steps that\nstability allows, whatever its tolerance"
    else:
        words = "py-pde: not installed" if peers else "py-pde: left out of quick runs"
    axes.text(0.03, 0.03, words, transform=axes.transAxes, fontsize=8)
    axes.set_title(f"straight strip, {CELLS[0]} x {CELLS[1]} cells: error in time")
    axes.set_xlabel("processor time (s)")
    axes.set_ylabel("relative error at t = 50")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7)


def draw(results, figure):
    from matplotlib.ticker import NullFormatter

    figure.set_size_inches(13, 10)
    panels = figure.subplots(2, 2).ravel()
    for axes, (name, result) in zip(panels[:2], results.items(), strict=True):
        body = result.scene.body
        system, start = problem(body.cortex.mesh, 1, lumped=True)
        exact = last(march(system, start, until=END, tolerance=1e-8))
        for k, (label, runs) in enumerate(methods(system, start, exact).items()):
            repeats = REPEATS if system.space.size > 500 else 1
            points = np.array([measure(run, exact, repeats) for run in runs])
            style = "o-" if k < 3 else {"scipy BDF": "x--", "scipy Radau": "+-."}.get(label, ".:")
            axes.loglog(*points.T, style, color=f"C{k % 10}" if k < 10 else "k", label=label, markersize=6)
        axes.set_title(f"{name}, {system.space.size} nodes: error in time")
        axes.set_xlabel("processor time (s)")
        axes.set_ylabel("relative error at t = 50")
        axes.grid(alpha=0.3)
    panels[0].legend(fontsize=7, ncol=2)
    for degree, colour in ((1, "#d55e00"), (2, "#0072b2")):
        nodes, errors = spatial_errors(degree, (48, 96, 192) if degree == 2 else (96, 192, 384))
        panels[2].loglog(nodes, errors, "o-", color=colour, label=f"P{degree}")
        rate = 2 * np.log(errors[-2] / errors[-1]) / np.log(nodes[-1] / nodes[-2])
        words, at = f"order {rate:.1f}", (nodes[-1], errors[-1])
        panels[2].annotate(words, at, xytext=(-40, 8), textcoords="offset points")
    panels[2].set_title("error of the steady state in space")
    panels[2].set_xlabel("nodes")
    panels[2].set_ylabel("largest error at a peak and a trough")
    panels[2].grid(alpha=0.3)
    panels[2].legend()
    draw_strip(panels[3], system.space.size > 500)
    for axes in panels:
        axes.xaxis.set_minor_formatter(NullFormatter())


if __name__ == "__main__":
    drawn(__file__, scenes, draw)
