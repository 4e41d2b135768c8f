"""Commands beside running: stability of kinetics, comparison of results."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from .cli_figure import save_figure


def stability(kinetics: str, parameters: Iterable[str], ratio: float | None) -> str:
    """Return the Turing conditions of a kinetics as text; raises ValueError for unknown names."""
    from .checks import positive
    from .turing import concentrations, deviations
    from .turing.kinetics import Kinetics
    from .turing.stability import conditions

    known = {
        name: item
        for module in (concentrations, deviations)
        for name, item in vars(module).items()
        if isinstance(item, type) and issubclass(item, Kinetics) and item is not Kinetics
    }
    if kinetics not in known:
        raise ValueError(f"there are no kinetics {kinetics!r}; known are {', '.join(sorted(known))}.")
    made = known[kinetics]
    default = made()
    values = {}
    for text in parameters:
        name, _, value = text.partition("=")
        if name not in default.parameters:
            raise ValueError(f"{kinetics} has no parameter {name!r}; it has {', '.join(default.parameters)}.")
        try:
            values[name] = float(value)
        except ValueError as error:
            raise ValueError(f"--param {text} is not of the form NAME=VALUE with a number.") from error
    chosen = made(**values)
    d = positive("ratio", made.published_ratio if ratio is None else ratio)
    found = conditions(chosen, 1.0, d)
    return str(conditions(chosen, d, 1.0) if found.activator == "v" else found)


def compare(a: Path, b: Path, figure: Path | None) -> str:
    """Return the morphometry of two stored results as a table; draw one on the other on request."""
    from .morphometry.compare import compare as compared
    from .morphometry.compare import draw_comparison
    from .results import load

    names = (a.name, b.name) if a.name != b.name else (str(a), str(b))
    one, other = (load(path).pial() for path in (a, b))
    table = compared(one, other, names=names).text()
    if figure is None:
        return table
    with save_figure(figure) as canvas:
        draw_comparison(one, other, canvas.add_subplot(), names=names)
    return f"{table}\nfigure: {figure}"
