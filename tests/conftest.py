"""Loud tests: floating-point errors raise, figures are closed, no window is opened."""

import os
import sys

os.environ.setdefault("MPLBACKEND", "Agg")
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before numpy: two runs must give the same bytes

import numpy as np  # noqa: E402
import pytest  # noqa: E402


@pytest.fixture(autouse=True)
def loud():
    """Turn invalid operations, divisions by zero and overflows into errors."""
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.fixture(scope="session")
def folded():
    """Return the result of the scene with everything in it; to be read only."""
    from small import folding_scene

    from turingfold import simulate

    return simulate(folding_scene())
