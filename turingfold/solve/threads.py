"""One thread for the products of dense matrices, which numpy, scipy and cvxopt leave to their BLAS.

Those of the elements are small: shared among threads that wait for each other they take several times as long
on a busy machine, and sums whose order depends on the threads do not repeat bit for bit.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from functools import wraps
from threading import Lock
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

CHOSEN = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # the first that is set counts
_lock = Lock()  # of what follows: scenes may run side by side in threads of Python
_works = 0
_limits = ExitStack()


def one_thread(work: Callable[P, R]) -> Callable[P, R]:
    """Return the function with one BLAS thread while it works, or as many as the environment says."""

    @wraps(work)
    def alone(*args: P.args, **kwargs: P.kwargs) -> R:
        global _works
        with _lock:
            _works += 1
            if _works == 1:
                _limit()
        try:
            return work(*args, **kwargs)
        finally:
            with _lock:
                _works -= 1
                if _works == 0:
                    _limits.close()

    return alone


def limit_loaded() -> None:
    """Limit a BLAS that was loaded just now, too, until all works under way have ended."""
    with _lock:
        if _works:
            _limit()


def _limit() -> None:
    from threadpoolctl import threadpool_limits

    said = next((value for name in CHOSEN if (value := os.environ.get(name, "")).isdecimal()), "1")
    _limits.enter_context(threadpool_limits(max(1, int(said)), user_api="blas"))
