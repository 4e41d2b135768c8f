"""Integrators: each at its order on band problem A, limits refused, factors reused, stiff systems solved."""

from time import process_time

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.sparse import diags_array
from turing_problems import initial_a, probes, problem_a, semi_annulus, trajectory_a

from turingfold.errors import InadmissibleStateError, NotConvergedError
from turingfold.turing.integrators.bdf import march_bdf
from turingfold.turing.integrators.imex import SBDF2, SCHEMES, fastest_reaction, march_imex
from turingfold.turing.integrators.rosenbrock import RODAS4, ROS34PW2, ErrorNorm, march, rosenbrock_step
from turingfold.turing.kinetics.chemical import GrayScott, Thomas
from turingfold.turing.kinetics.user import UserKinetics
from turingfold.turing.linear.direct import Sparsity
from turingfold.turing.reaction_diffusion import ReactionDiffusion, discretise
from turingfold.turing.stability import turing_unstable_at

END = 4.0


def final(moments):
    for moment in moments:
        last = moment
    return last


@pytest.fixture(scope="module")
def problem():
    system = problem_a(semi_annulus(48, 1), 2)
    start = initial_a(system, 0.2)
    return system, start, final(march(system, start, until=END, tolerance=1e-11)).state


def fixed_rosenbrock(tableau):
    def run(system, state, step):
        for _ in range(round(END / step)):
            state, _ = rosenbrock_step(system, state, step, tableau, ErrorNorm(0.5))
        return state

    return run


def imex(scheme):
    return lambda system, state, step: (
        final(march_imex(system, state, until=END, step=step, scheme=scheme)).state
    )


# a fine enough pair of steps for the order to show; stiff diffusion hides it at long ones
METHODS = {name: (imex(scheme), scheme.order, 0.02) for name, scheme in SCHEMES.items()} | {
    "ROS34PW2": (fixed_rosenbrock(ROS34PW2), 3, 0.08),
    "RODAS4": (fixed_rosenbrock(RODAS4), 4, 0.08),
}


@pytest.mark.parametrize("name", METHODS)
def test_every_integrator_keeps_its_order(name, problem):
    run, order, step = METHODS[name]
    system, start, exact = problem
    errors = [np.abs(run(system, start, h) - exact).max() for h in (step, step / 2)]
    observed = np.log2(errors[0] / errors[1])
    assert order - 0.3 < observed < order + 0.6  # RODAS4 comes down to its order from above


@pytest.mark.parametrize("method", [march, march_bdf])
def test_the_error_of_adaptive_methods_follows_the_tolerance(method, problem):
    system, start, exact = problem
    tolerances = np.array([1e-3, 1e-5, 1e-7])
    ends = [final(method(system, start, until=END, tolerance=tolerance)) for tolerance in tolerances]
    errors = np.array([np.abs(end.state - exact).max() for end in ends])
    assert (errors < 30 * tolerances).all()
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert 0.6 < slope < 1.4
    assert {end.time for end in ends} == {END}


def test_bdf_keeps_its_factors(problem):
    system, start, _ = problem
    end = final(march_bdf(system, start, until=END, tolerance=1e-6))
    assert end.factorizations < 0.6 * end.steps


def test_the_trajectory_of_problem_a():
    # differences from the spectral solution are those of the mesh: 3e-5 for these quadratic elements
    system = problem_a(semi_annulus(96, 2), 2)
    for time in (10.0, 50.0):
        end = final(march(system, initial_a(system), until=time, tolerance=1e-6))
        assert np.allclose(probes(system, end.state), trajectory_a(time), atol=6e-5)


def test_reaction_limits_of_the_schemes():
    # where ζ² 3/2 − (2 + 2z) ζ + 1/2 + z has the root −1: z = −4/3; Adams-Bashforth: −1; Euler and Heun: −2
    limits = {name: scheme.reaction_limit for name, scheme in SCHEMES.items()}
    expected = {"SBDF1": 2.0, "SBDF2": 4 / 3, "CNAB2": 1.0, "MCNAB2": 1.0, "ARS222": 2.0}
    for name, value in expected.items():
        assert limits[name] == pytest.approx(value, abs=2e-3)


def test_a_step_beyond_the_limit_is_refused_with_the_number(problem):
    system, start, _ = problem
    fastest = fastest_reaction(system, start)
    jacobian = [system.kinetics.jacobian((u, v)) for u, v in start.T]
    assert fastest == pytest.approx(max(np.abs(np.linalg.eigvals(j)).max() for j in jacobian))
    largest = SBDF2.reaction_limit / fastest
    with pytest.raises(ValueError, match=rf"must be at most {largest:.4g}: SBDF2"):
        next(march_imex(system, start, until=1.01 * largest, step=1.01 * largest))
    next(march_imex(system, start, until=0.99 * largest, step=0.99 * largest))


def test_uniform_states_stay_uniform(problem):
    system, _, _ = problem
    for method in (march, march_bdf):
        end = final(method(system, system.uniform(1.2, 0.7), until=30.0, tolerance=1e-4)).state
        assert np.ptp(end, axis=1).max() < 1e-12
    end = final(march_imex(system, system.uniform(1.2, 0.7), until=30.0, step=0.1)).state
    assert np.ptp(end, axis=1).max() < 1e-12


def test_the_sum_law_of_schnakenberg_holds_along_the_run(problem):
    # d⟨u + v⟩/dt = a + b − ⟨u⟩ = 0 at every moment, as ⟨u⟩ = 1 at the start makes ⟨u + v⟩ relax exactly
    system, start, _ = problem
    mean = system.space.mean
    rate = system.rate(start).sum(axis=1) / system.space.area
    assert rate.sum() == pytest.approx(1.0 - mean(start)[0], abs=1e-14)


def test_pure_diffusion_conserves_to_round_off():
    nothing = UserKinetics(p=lambda u, v: 0 * u, q=lambda u, v: 0 * v, guesses=((1.0, 1.0),))
    space = discretise(semi_annulus(48, 1), 2)
    system = ReactionDiffusion(space, nothing, 1e-3, 1e-2)
    start = 1 + 0.5 * np.random.default_rng(0).random((2, space.size))
    end = final(march_imex(system, start, until=1.0, step=0.05)).state
    assert np.allclose(space.mean(end), space.mean(start), rtol=1e-13)


def test_scaled_kinetics_only_scale_time(problem):
    system, start, exact = problem
    k = 1e6
    fast = UserKinetics(
        p=lambda u, v: k * system.kinetics.rates(u, v)[0],
        q=lambda u, v: k * system.kinetics.rates(u, v)[1],
        partial_derivatives=lambda u, v: tuple(k * slope for slope in system.kinetics.derivatives(u, v)),
        guesses=((1.0, 0.9),),
    )
    scaled = ReactionDiffusion(system.space, fast, k * system.d_u, k * system.d_v)
    end = final(march(scaled, start, until=END / k, tolerance=1e-6)).state
    assert np.allclose(end, exact, atol=1e-5)


def test_imex_refuses_a_reaction_that_becomes_too_fast_with_time_and_step():
    # the eigenvalues are −v and 1, and v = exp(t): at t = 4.9 = 490 steps it has passed 4/3 / step
    stiff = UserKinetics(p=lambda u, v: -u * v, q=lambda u, v: v, guesses=((1.0, 1.0),))
    system = ReactionDiffusion(discretise(semi_annulus(12, 1), 1), stiff, 1.0, 1.0)
    start = system.uniform(1.0, 1.0)
    with pytest.raises(InadmissibleStateError, match=r"at time 4\.9 step=0\.01 must be at most 0\.00993"):
        final(march_imex(system, start, until=5.0, step=1e-2))
    final(march_imex(system, start, until=4.85, step=1e-2))


def test_a_blow_up_is_stopped_with_its_time():
    # w' = w² from 1 blows up at t = 1
    blow = UserKinetics(p=lambda u, v: u * u, q=lambda u, v: -v, guesses=((0.1, 0.1),))
    system = ReactionDiffusion(discretise(semi_annulus(12, 1), 1), blow, 1.0, 1.0)
    with pytest.raises(NotConvergedError, match="blow up") as caught:
        final(march(system, system.uniform(1.0, 1.0), until=2.0, tolerance=1e-3))
    assert caught.value.time == pytest.approx(1.0, abs=1e-2)
    # its eigenvalue 2u passes what SBDF2 holds, 4/3, over the step at u = 67, t = 0.985
    with pytest.raises(InadmissibleStateError, match=r"at time 1 step=0\.01 must be at most"):
        final(march_imex(system, system.uniform(1.0, 1.0), until=2.0, step=1e-2))


def test_a_state_that_is_no_number_is_an_error_with_its_time():
    # w' = 1 from 0, with a rate that exists up to w = 1.5 only
    ends = UserKinetics(
        p=lambda u, v: 1 + 0 * np.sqrt(1.5 - u), q=lambda u, v: -v, guesses=((0.1, 0.1),),
        partial_derivatives=lambda u, v: (0 * u, 0 * u, 0 * u, 0 * u - 1),
    )  # fmt: skip
    system = ReactionDiffusion(discretise(semi_annulus(12, 1), 1), ends, 1.0, 1.0)
    with pytest.raises(InadmissibleStateError, match="left the finite numbers at time 2"):
        final(march_imex(system, system.uniform(0.0, 1.0), until=5.0, step=0.5, scheme=SCHEMES["SBDF1"]))


@pytest.mark.parametrize("share", [0.9, 0.999])
def test_a_step_at_the_limit_of_the_start_is_stopped_before_the_solution_leaves_it(share, problem):
    # the pattern that forms reacts faster than the start; beyond the limit every step multiplies errors
    system, start, _ = problem
    scheme = SCHEMES["SBDF1"]
    step = share * scheme.reaction_limit / fastest_reaction(system, start)
    seen = []
    with pytest.raises(InadmissibleStateError, match=r"step=1\.\d+ must be at most"):
        seen.extend(march_imex(system, start, until=400.0, step=step, scheme=scheme))
    for moment in seen:
        assert np.abs(moment.state).max() < 1.5  # the steady pattern reaches 1.44
        assert step * fastest_reaction(system, moment.state) < 1.1 * scheme.reaction_limit


@pytest.mark.parametrize("method", [march, march_bdf])
def test_loose_tolerances_do_not_step_across_the_pole_of_a_rate(method):
    # Thomas' uptake has a pole at u = -1.06; across it steps of 1e-8 went on for ever
    mesh = semi_annulus(96, 2)
    space = discretise(mesh, 1)
    found = turing_unstable_at(Thomas()).scaled_to(256.0)
    system = ReactionDiffusion(space, Thomas(), found.d_u, found.d_v)
    angle = np.arctan2(space.nodes[1], space.nodes[0])
    noise = np.random.default_rng(0).standard_normal(48) @ np.cos(np.outer(np.arange(1, 49), angle))
    start = np.array(found.steady_state)[:, None] + 2.0 * np.outer(
        found.fastest_direction, noise / np.abs(noise).max()
    )
    for moment in method(system, start, until=400.0, tolerance=1e-2):
        assert moment.steps < 600
        assert (moment.state.min(axis=1) > -0.01 * moment.state.max(axis=1)).all()
    assert moment.time == 400.0


@pytest.mark.parametrize("method", [march, march_bdf])
def test_the_undershoot_of_a_coarse_mesh_beside_a_front_does_not_stop_a_run(method):
    # without reaction of v but decay, and as much diffusion as on a fine mesh: the mean of v decays exactly
    system = problem_a(semi_annulus(60, 2), 1)
    fading = ReactionDiffusion(system.space, GrayScott(F=0.035, k=0.065), system.d_u, system.d_v)
    state = fading.uniform(0.0, 0.0)
    state[1] = 0.01 * (system.space.nodes[0] > 0)
    end = final(method(fading, state, until=5.0, tolerance=1e-3))
    assert end.steps < 200
    reaction = np.exp(-0.1 * 5.0)
    assert system.space.mean(end.state)[1] == pytest.approx(reaction * system.space.mean(state)[1], rel=0.01)


@pytest.mark.parametrize("method", [march, march_bdf])
def test_steps_that_become_tiny_beyond_a_pole_end_with_the_reason(method):
    # Thomas' uptake has poles at u = -1.06 and -18.9; from between them u runs into the lower one
    system = ReactionDiffusion(discretise(semi_annulus(12, 1), 1), Thomas(), 1e-3, 3e-2)
    start = system.uniform(-5.0, 20.0)
    start[0] += 0.1 * system.space.nodes[0]
    with pytest.raises(NotConvergedError, match=r"negative at time .*, down to -1\d\.\d"):
        final(method(system, start, until=100.0, tolerance=1e-2))


def test_banded_and_sparse_solves_agree():
    rng = np.random.default_rng(0)
    for mesh in (semi_annulus(40, 2), semi_annulus(12, 60)):
        system = problem_a(mesh, 2)
        state = system.uniform(1.0, 0.9) + 0.1 * rng.standard_normal((2, system.space.size))
        right = rng.standard_normal(state.shape)
        found = system.solver(state, 2.0)(right)
        back = (system.matrix(state, 2.0) @ found.T.ravel()).reshape(-1, 2).T
        assert np.allclose(back, right, atol=1e-10)
        sparsity = system.space.sparsity
        values = system.space.mass.data + system.space.stiffness.data
        one = sparsity.scalar_solver(values)(right[0])
        assert np.allclose(sparsity.matrix(values) @ one, right[0], atol=1e-11)
    assert not sparsity.narrow
    assert problem_a(semi_annulus(40, 2), 2).space.sparsity.narrow


def test_a_singular_matrix_is_an_error():
    space = discretise(semi_annulus(12, 1), 1)
    assert isinstance(space.sparsity, Sparsity)
    with pytest.raises(np.linalg.LinAlgError, match="not positive definite"):
        space.sparsity.scalar_solver(-space.mass.data)


def test_lumped_mass_keeps_concentrations_positive_where_the_consistent_one_does_not():
    # diffusion of a spot, one short step: no triangle of this mesh is obtuse
    nothing = UserKinetics(p=lambda u, v: 0 * u, q=lambda u, v: -v, guesses=((1.0, 1.0),))
    lowest = {}
    for lumped in (True, False):
        space = discretise(semi_annulus(200, 4), 1, lumped=lumped)
        system = ReactionDiffusion(space, nothing, 1.0, 1.0)
        state = system.uniform(0.0, 0.0)
        state[0, space.size // 2] = 1.0
        short = space.edge**2 / 100
        lowest[lumped] = final(
            march_imex(system, state, until=short, step=short, scheme=SCHEMES["SBDF1"])
        ).state.min()
    assert lowest[True] >= 0.0
    assert lowest[False] < -1e-3


def scipy_bdf(system, start, until, tolerance):
    """Return the end of scipy's run of the same lumped system, with its sparse Jacobian."""
    inverse = 1 / system.space.weights
    scale = diags_array(-np.repeat(inverse, 2))
    found = solve_ivp(
        lambda t, y: (system.rate(y.reshape(-1, 2).T) * inverse).T.ravel(),
        (0, until), start.T.ravel(), "BDF", rtol=tolerance, atol=tolerance,
        jac=lambda t, y: scale @ system.matrix(y.reshape(-1, 2).T),
    )  # fmt: skip
    return found.y[:, -1].reshape(-1, 2).T


@pytest.mark.slow
@pytest.mark.timing
def test_the_default_integrator_beats_scipy_on_5409_nodes():
    system = problem_a(semi_annulus(600, 8), 1, lumped=True)
    assert system.space.size == 5409
    start, until = initial_a(system), 50.0
    exact = final(march(system, start, until=until, tolerance=1e-8)).state

    def measured(run):
        times = []
        for _ in range(3):
            before = process_time()
            end = run()
            times.append(process_time() - before)
        return sorted(times)[1], np.abs(end - exact).max() / np.abs(exact).max()

    for error, share, mine, theirs in ((1e-4, 1.0, 1e-3, 1e-4), (1e-6, 0.5, 1e-6, 1.5e-7)):
        time, reached = measured(lambda t=mine: final(march(system, start, until=until, tolerance=t)).state)
        peer_time, peer_reached = measured(lambda t=theirs: scipy_bdf(system, start, until, t))
        assert reached < error
        assert peer_reached < 1.2 * error
        assert time < share * peer_time
