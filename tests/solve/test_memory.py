"""Too little memory: said before the solver fails, with the last state kept."""

import subprocess
import sys

import numpy as np
import pytest
from small import elastic_scene

from turingfold import StoppedError, load, simulate
from turingfold.errors import OutOfMemoryError
from turingfold.solve import memory
from turingfold.solve.inertia import Indefinite
from turingfold.solve.linear import Cholmod
from turingfold.solve.newton import Minimiser
from turingfold.solve.sparsity import Sparsity

LITTLE = """
import resource
from turingfold import Elastic, NeoHookean, Scene, StoppedError, Stepping, TangentialGrowth
from turingfold import semicircle, simulate

body = semicircle(radius=1.0, thickness=0.06, elements=4)
solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
stepping = Stepping(solver={solver!r})
scene = Scene(body=body, terms=(solid,), processes=(TangentialGrowth(cortex=1.2),), stepping=stepping)
size = 4096 * int(open("/proc/self/statm").read().split()[0])
resource.setrlimit(resource.RLIMIT_AS, (size + {more} * 10**6, resource.RLIM_INFINITY))
try:
    simulate(scene)
except StoppedError as error:
    print(len(error.result.states), error)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of address space are told by /proc")
@pytest.mark.parametrize("solver", ["cholmod", "superlu"])
@pytest.mark.parametrize("more", [90, 150])
def test_a_limit_of_memory_is_said_and_the_start_is_kept(solver, more):
    if solver == "cholmod":
        pytest.importorskip("cvxopt")
    code = LITTLE.format(solver=solver, more=more)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("1 The march stopped at t = 0 of 1: ")
    assert "use larger elements" in done.stdout


@pytest.mark.parametrize("solver", [Cholmod, Indefinite])
@pytest.mark.parametrize("left", ["address_space_left", "memory_left"])
def test_what_does_not_fit_is_refused_before_it_is_tried(solver, left, monkeypatch):
    n = 1000
    sparsity = Sparsity(n, np.arange(n) * n + np.arange(n))
    solver(sparsity)
    monkeypatch.setattr(memory, left, lambda: 1e4)
    with pytest.raises(OutOfMemoryError, match=r"factorisation of 1000 unknowns needs about .* MB"):
        solver(sparsity)


def test_memory_that_is_over_on_the_way_leaves_the_last_state(tmp_path, monkeypatch):
    """A full memory at the third step; the run goes on from there when there is more."""
    scene = elastic_scene()
    whole = simulate(scene)
    original, calls = Minimiser.minimise, []

    def hungry(own, *given):
        calls.append(given)
        if len(calls) == 3:
            raise MemoryError("Unable to allocate 3 TiB")
        return original(own, *given)

    monkeypatch.setattr(Minimiser, "minimise", hungry)
    with pytest.raises(StoppedError, match="memory is over"):
        simulate(scene, out=tmp_path / "out")
    monkeypatch.undo()
    with pytest.warns(UserWarning, match="memory is over"):
        kept = load(tmp_path / "out")
    assert kept.last.time == whole.history[1]["time"]
    again = simulate(scene, out=tmp_path / "out", resume=True)
    assert again.last["displacement"].tobytes() == whole.last["displacement"].tobytes()
