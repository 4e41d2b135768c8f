"""A scene that runs in a fraction of a second, and one with everything in it."""

from turingfold import (
    AxonalTension,
    Elastic,
    NeoHookean,
    Scene,
    Schnakenberg,
    SelfContact,
    Stepping,
    TangentialGrowth,
    Turing,
    semicircle,
)

RADIUS, THICKNESS, GROWTH = 1.0, 0.25, 1.3
GRAY = NeoHookean(mu=1.0, kappa=5.0)


def elastic_scene(*processes, body=None, **options):
    body = body or semicircle(radius=RADIUS, thickness=THICKNESS, size=0.25)
    processes = processes or (TangentialGrowth(cortex=GROWTH),)
    options = {"stepping": Stepping(first=0.1, largest=0.2)} | options
    return Scene(body=body, terms=(Elastic(gray=GRAY),), processes=processes, **options)


def folding_scene():
    """Eight half waves on a thick cortex: pattern, tension, growth; walls touch in the last steps."""
    body = semicircle(radius=0.04, thickness=0.006, size=0.003)
    gray, white = NeoHookean.from_young(1389.0, 0.4583), NeoHookean.from_young(1895.0, 0.4583)
    processes = (Turing(Schnakenberg(), half_waves=8), TangentialGrowth(cortex=2.0))
    terms = (Elastic(gray=gray, white=white), AxonalTension(strength=0.5), SelfContact())
    return Scene(body=body, terms=terms, processes=processes, stepping=Stepping(first=0.05, largest=0.1))
