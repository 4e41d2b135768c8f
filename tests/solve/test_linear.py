"""Assembly of entries against scipy's assembly, and the two direct solvers against dense algebra."""

import subprocess
import sys
import weakref

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csc_matrix, tril
from small import elastic_scene

from turingfold import Stepping, simulate, stepping
from turingfold.parts import Entries, Hessian
from turingfold.solve import linear
from turingfold.solve.linear import Cholmod, NotPositiveDefinite, SuperLu, solver_for
from turingfold.solve.sparsity import Assembler, Sparsity
from turingfold.testing import dense

SOLVERS = [SuperLu, pytest.param(Cholmod, id="Cholmod")]


@pytest.fixture(autouse=True)
def cholmod_is_there(request):
    if "Cholmod" in request.node.name:
        pytest.importorskip("cvxopt")


def entries(n, count, seed, constant=False, expected=None):
    """Return a Hessian of random lower entries with repeated places."""
    rng = np.random.default_rng(seed)
    one, other = rng.integers(0, n, (2, count))
    rows, columns = np.maximum(one, other), np.minimum(one, other)
    return Hessian(Entries(rows, columns), rng.standard_normal(count), constant, expected)


def full(pattern, values):
    lower = pattern.lower(values)
    return (lower + tril(lower, -1).T).toarray()


def stencil(n, seed=0):
    """Return pattern and values of a random sparse symmetric positive definite matrix, and the matrix."""
    rng = np.random.default_rng(seed)
    B = rng.standard_normal((n, n)) * (rng.random((n, n)) < 4 / n)
    A = B @ B.T + 0.1 * np.eye(n)
    lower = csc_matrix(np.tril(A))
    columns = np.repeat(np.arange(n), np.diff(lower.indptr))
    keys = columns.astype(np.int64) * n + lower.indices
    order = np.argsort(keys)
    return Sparsity(n, keys[order]), lower.data[order], A


@settings(derandomize=True, max_examples=25, deadline=None)
@given(n=st.integers(3, 30), count=st.integers(1, 200), fixed=st.integers(0, 2), seed=st.integers(0, 999))
def test_assembled_entries_are_the_assembled_matrix(n, count, fixed, seed):
    held = np.random.default_rng(seed).choice(n, fixed, replace=False)
    hessians = [entries(n, count, seed, constant=True), entries(n, 2 * count, seed + 1)]
    assembler = Assembler(n, held)
    pattern, values = assembler.assemble(hessians)
    free = np.setdiff1d(np.arange(n), held)
    assert np.array_equal(assembler.free, free)
    expected = sum(dense(h, n) for h in hessians)[np.ix_(free, free)]
    np.testing.assert_allclose(full(pattern, values), expected, atol=1e-13)
    assert (np.diff(pattern.keys) > 0).all()
    x = np.random.default_rng(seed).standard_normal(len(free))
    np.testing.assert_allclose(pattern.product(values)(x), expected @ x, atol=1e-11)


def test_a_pattern_is_kept_until_it_lacks_a_place():
    n = 12
    lasting = entries(n, 60, 0, constant=True)
    soon = Entries(np.array([11, 10]), np.array([1, 0]))
    near = Hessian(Entries(np.array([11]), np.array([0])), np.array([1.0]), False, lambda: soon)
    assembler = Assembler(n, np.array([3]))
    first, _ = assembler.assemble([lasting, near])
    # same places with other values; nothing to add at all; the places made room for
    for passing in (
        Hessian(near.entries, np.array([7.0]), False),
        Hessian(Entries(near.entries.rows[:0], near.entries.columns[:0]), np.zeros(0), False),
        Hessian(soon, np.ones(2), False),
        Hessian(Entries(np.array([3, 5]), np.array([0, 3])), np.ones(2), False),  # fixed unknowns need none
    ):
        again = Hessian(lasting.entries, 2 * lasting.values)
        pattern, values = assembler.assemble([again, passing])
        assert pattern is first
        free = assembler.free
        expected = (dense(again, n) + dense(passing, n))[np.ix_(free, free)]
        np.testing.assert_allclose(full(pattern, values), expected, atol=1e-13)
    taken = set(zip(*(dense(lasting, n) != 0).nonzero(), strict=True))
    new = next(
        (i, j)
        for i in range(n)
        for j in range(i)
        if (i, j) not in taken and 3 not in (i, j) and (i, j) not in {(11, 0), (11, 1), (10, 0)}
    )
    lacking = Hessian(Entries(np.array([new[0]]), np.array([new[1]])), np.array([2.0]), False)
    pattern, values = assembler.assemble([lasting, lacking])
    assert pattern is not first
    expected = (dense(lasting, n) + dense(lacking, n))[np.ix_(free, free)]
    np.testing.assert_allclose(full(pattern, values), expected, atol=1e-13)


def test_a_lasting_hessian_that_comes_later_gets_its_places():
    n = 10
    first, second = entries(n, 30, 0, constant=True), entries(n, 30, 1, constant=True)
    assembler = Assembler(n, np.zeros(0, dtype=np.int64))
    assembler.assemble([first])
    pattern, values = assembler.assemble([first, second])
    np.testing.assert_allclose(full(pattern, values), dense(first, n) + dense(second, n), atol=1e-13)
    # and one that stays away leaves its places empty
    pattern, values = assembler.assemble([second])
    np.testing.assert_allclose(full(pattern, values), dense(second, n), atol=1e-13)


def test_both_halves_of_a_matrix_are_refused():
    rows, columns = np.array([0, 1, 0, 1]), np.array([0, 0, 1, 1])
    full = Hessian(Entries(rows, columns), np.array([2.0, -1.0, -1.0, 2.0]))
    with pytest.raises(ValueError, match="entries above the diagonal, which would count twice"):
        Assembler(2, np.zeros(0, dtype=np.int64)).assemble([full])


def test_restored_places_give_the_same_pattern():
    n = 10
    lasting, passing = entries(n, 20, 0, constant=True), entries(n, 5, 1)
    assembler = Assembler(n, np.array([0]))
    pattern, _ = assembler.assemble([lasting, passing])
    other = Assembler(n, np.array([0]), assembler.changing)
    restored, values = other.assemble([entries(n, 20, 0, constant=True)])
    assert np.array_equal(restored.keys, pattern.keys)
    np.testing.assert_allclose(full(restored, values), dense(lasting, n)[1:, 1:], atol=1e-13)


@pytest.mark.parametrize("kind", SOLVERS)
def test_solvers_solve(kind):
    pattern, values, A = stencil(60)
    solver = kind(pattern)
    b = np.random.default_rng(1).standard_normal(60)
    for factor in (1.0, 3.0):  # the ordering is kept, the values change
        solver.factorize(factor * values)
        np.testing.assert_allclose(solver.solve(b), np.linalg.solve(factor * A, b), rtol=1e-8)
    assert np.array_equal(b, np.random.default_rng(1).standard_normal(60))  # not overwritten


@pytest.mark.parametrize("kind", SOLVERS)
def test_solvers_need_no_full_diagonal(kind):
    # the first unknown has no diagonal entry at all, so that the matrix cannot be positive definite
    pattern = Sparsity(2, np.array([1, 3]))
    solver = kind(pattern)
    with pytest.raises(NotPositiveDefinite):
        solver.factorize(np.array([1.0, 2.0]))


@pytest.mark.parametrize("kind", SOLVERS)
@pytest.mark.parametrize("gap", [1e-3, 1e-6])
def test_positivity_is_the_sign_of_the_smallest_eigenvalue(kind, gap):
    pattern, values, A = stencil(60)
    lowest = np.linalg.eigvalsh(A)[0]
    diagonal = pattern.rows == pattern.columns
    solver = kind(pattern)
    solver.factorize(values - diagonal * (lowest - gap))
    with pytest.raises(NotPositiveDefinite):
        solver.factorize(values - diagonal * (lowest + gap))
    # a refusal leaves the solver usable
    solver.factorize(values)
    b = np.ones(60)
    np.testing.assert_allclose(solver.solve(b), np.linalg.solve(A, b), rtol=1e-8)


@settings(derandomize=True, max_examples=20, deadline=None)
@given(seed=st.integers(0, 999), shift=st.floats(-0.5, 3.0))
def test_both_solvers_agree_on_what_is_positive(seed, shift):
    pytest.importorskip("cvxopt")
    pattern, values, A = stencil(20, seed)
    lowest = np.linalg.eigvalsh(A)[0] - shift
    if abs(lowest) < 1e-9:
        return
    shifted = values - shift * (pattern.rows == pattern.columns)
    for kind in (SuperLu, Cholmod):
        try:
            kind(pattern).factorize(shifted)
        except NotPositiveDefinite:
            assert lowest < 0
        else:
            assert lowest > 0


def test_the_fastest_installed_solver_is_taken(monkeypatch):
    pattern, values, A = stencil(5)
    monkeypatch.setattr("turingfold.solve.linear.find_spec", lambda name: None)
    solver = solver_for(pattern)
    assert isinstance(solver, SuperLu)
    solver.factorize(values)
    np.testing.assert_allclose(solver.solve(np.ones(5)), np.linalg.solve(A, np.ones(5)), rtol=1e-10)
    pytest.importorskip("cvxopt")
    monkeypatch.undo()
    assert isinstance(solver_for(pattern), Cholmod)


@pytest.mark.parametrize("solver", ["cholmod", "superlu"])
def test_a_scene_names_its_solver(solver, monkeypatch):
    if solver == "cholmod":
        pytest.importorskip("cvxopt")
    used = []
    for kind in (Cholmod, SuperLu):
        monkeypatch.setattr(linear, kind.__name__, lambda p, kind=kind: used.append(kind.__name__) or kind(p))
    steps = Stepping(first=0.5, largest=0.5, solver=solver)
    energy = simulate(elastic_scene(stepping=steps)).summary()["energy"]
    assert {name.lower() for name in used} == {solver}
    automatic = simulate(elastic_scene(stepping=Stepping(first=0.5, largest=0.5))).summary()["energy"]
    assert energy == pytest.approx(automatic, rel=1e-10)


def test_a_solver_that_is_missing_says_what_to_install(monkeypatch):
    with pytest.raises(ValueError, match="solver='lapack'"):
        Stepping(solver="lapack")
    monkeypatch.setattr(stepping, "find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r"turingfold\[fast\]"):
        Stepping(solver="cholmod")


@pytest.mark.skipif(sys.platform != "linux", reason="asks glibc")
def test_solvers_let_freed_memory_be_used_again():
    program = """
import resource, numpy
from turingfold.solve.linear import solver_for
from turingfold.solve.sparsity import Sparsity
solver_for(Sparsity(2, numpy.array([0, 1, 3])))
def blocks():
    return [b"1" * 12_000_000 for _ in range(3)]
blocks()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(10):
    blocks()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""
    faults = int(subprocess.run([sys.executable, "-c", program], check=True, capture_output=True).stdout)
    assert faults < 1000  # of 4 kB each; 90 000 where freed memory goes back to the system


def test_a_matrix_made_anew_takes_the_places_of_the_last_one_and_leaves_nothing_behind():
    n = 10
    lasting = entries(n, 30, 0, constant=True)
    assembler = Assembler(n, np.zeros(0, dtype=np.int64))
    patterns = []
    for k in range(5):
        anew = entries(n, 30, 1, constant=True)
        anew = Hessian(anew.entries, (k + 1.0) * anew.values)
        pattern, values = assembler.assemble([lasting, anew])
        patterns.append(pattern)
        np.testing.assert_allclose(full(pattern, values), dense(lasting, n) + dense(anew, n), atol=1e-13)
        gone = weakref.ref(anew.entries)
    del anew
    assert gone() is None
    assert all(pattern is patterns[0] for pattern in patterns)
