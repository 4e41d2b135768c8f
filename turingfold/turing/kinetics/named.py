"""The kinetics of the package by name."""

from __future__ import annotations

from ...checks import one_of
from .activator_inhibitor import FitzHughNagumo, GiererMeinhardt, KochMeinhardt
from .base import Kinetics
from .bvam import BVAM, BVAM2012
from .chemical import Brusselator, GrayScott, LengyelEpstein, Schnakenberg, Thomas

KINETICS: dict[str, type[Kinetics]] = {
    kind.__name__: kind
    for kind in (
        Schnakenberg, GiererMeinhardt, KochMeinhardt, Brusselator, Thomas, GrayScott, LengyelEpstein, BVAM,
        BVAM2012, FitzHughNagumo,
    )
}  # fmt: skip


def kinetics_named(name: str, **parameters: float) -> Kinetics:
    """Return the kinetics of a name, such as "Schnakenberg", at its published parameters or at others.

    Raises ValueError for names that are not known, of kinetics and of their parameters.
    """
    made = KINETICS[one_of("kinetics", name, tuple(KINETICS))]()
    if unknown := [word for word in parameters if word not in made.parameters]:
        raise ValueError(f"{name} has no parameter {unknown[0]!r}; it has {', '.join(made.parameters)}.")
    return type(made)(**parameters)
