"""How a scene is marched through time."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec

from .checks import finite_array, one_of, positive, whole

SOLVERS = ("auto", "cholmod", "superlu")
LOOSEST = 1e-3
LOOSE = "a larger residual is no equilibrium; to save time use larger elements or steps"
EULER, MIDPOINT = "euler", "midpoint"


@dataclass(frozen=True, kw_only=True)
class Stepping:
    """How the march chooses its steps, in units of the scene's time.

    first, largest, smallest: step sizes as fractions of `until`. After a step that took at most two fifths of
    the allowed iterations the next is 1.3 times longer, after more than three fifths 1.3 times shorter;
    one that fails is halved and starts again from the untouched state.
    tolerance: residual at which an equilibrium counts, relative to the forces that balance in it; at most
    LOOSEST.
    iterations: Newton iterations allowed in one step.  seconds: limit on the run time, of the start and the
    march: what is under way, such as a factorisation, is ended first. It counts neither making the body nor,
    of a run that reaches its end, estimates of its errors.
    stops: times of the scene at which a step ends, and whose states are kept; no later than `until`.
    scheme: of scenes with inertia or drag: "euler", in which forces balance at the end of each step (first
    order, never gains energy), or "midpoint", in which they do in its middle (second order, loses none).
    local_error: of scenes with inertia or drag: how far one step may move a node off the motion, in
    m; None for any. Longer steps are taken again, shorter; see `solve.step_control`.
    solver: of linear systems, "cholmod" (the extra `fast`), "superlu", or "auto", the faster one installed.
    """

    first: float = 1 / 20
    largest: float = 1 / 20
    smallest: float = 1e-5
    tolerance: float = 1e-8
    iterations: int = 60
    seconds: float = float("inf")
    scheme: str = EULER
    stops: tuple[float, ...] = ()
    local_error: float | None = None
    solver: str = "auto"

    def __post_init__(self) -> None:
        for name in ("first", "largest", "smallest"):
            positive(name, getattr(self, name), at_most=1.0)
        positive("tolerance", self.tolerance, at_most=LOOSEST, remedy=LOOSE)
        if not self.smallest <= self.first <= self.largest:
            raise ValueError(
                f"Stepping: smallest={self.smallest:g} <= first={self.first:g} <= largest={self.largest:g} "
                "does not hold; put the three in this order."
            )
        whole("iterations", self.iterations, at_least=1)
        if self.seconds != float("inf"):
            positive("seconds", self.seconds, remedy="leave it out for no limit")
        one_of("scheme", self.scheme, (EULER, MIDPOINT))
        stops = finite_array("stops", self.stops, (None,)).tolist()
        if min(stops, default=0.0) < 0:
            raise ValueError(f"stops holds {min(stops):g}; the times of a scene are not negative.")
        object.__setattr__(self, "stops", tuple(sorted(stops)))
        if self.local_error is not None:
            positive("local_error", self.local_error, remedy="leave it out for steps of any error")
        one_of("solver", self.solver, SOLVERS)
        if self.solver == "cholmod" and find_spec("cvxopt") is None:
            raise ValueError("solver='cholmod' needs cvxopt: pip install 'turingfold[fast]', or drop it.")

    @property
    def balance(self) -> float:
        """The share of a step after which forces balance."""
        return 1.0 if self.scheme == EULER else 0.5
