"""One thread for the products of dense matrices, which numpy, scipy and cvxopt leave to their BLAS.

Those of the elements are small: shared among threads that wait for each other they take several times as long
on a busy machine, and sums whose order depends on the threads do not repeat bit for bit.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

CHOSEN = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # by whom the number is not left open
_working: list[ExitStack] = []


def one_thread(work: Callable[P, R]) -> Callable[P, R]:
    """Return the function with one BLAS thread while it works, unless the environment gives their number."""

    @wraps(work)
    def alone(*args: P.args, **kwargs: P.kwargs) -> R:
        if any(name in os.environ for name in CHOSEN):
            return work(*args, **kwargs)
        with ExitStack() as stack:
            _working.append(stack)
            stack.callback(_working.remove, stack)
            limit_loaded()
            return work(*args, **kwargs)

    return alone


def limit_loaded() -> None:
    """Give one thread to every BLAS that is loaded by now, until the present work ends."""
    if _working:
        from threadpoolctl import threadpool_limits

        _working[-1].enter_context(threadpool_limits(1, user_api="blas"))
