"""Which parameters made this shape? Gauss-Newton on the distance between target outlines and pial surface.

At each age the points y_j of the target have the signed distances d_j from the pial surface along its normal
n_j, at their feet x_j (orthogonal distance regression): no correspondence of points is needed. Their
derivatives are -n_j · dx_j/dp, and dx/dp = -K⁻¹ ∂g/∂p is nearly free at an equilibrium. So the errors of the
points count, and not the slopes that they give the target. Equilibria of new parameters start from the best
ones, moved along dx/dp. The sum of squares is minimised by scipy's trust region method with bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from scipy.optimize import least_squares

from ..checks import finite, instance, positive
from ..scene import Scene
from ..solve.threads import one_thread
from .fit_setup import begun_with, check_fitted, keep_best, make_folder
from .inverse import Fit, Inverse
from .landmarks import checked_landmarks
from .remarks import remarks
from .smoothing import misfit, second_differences, smoothest
from .targets import checked_targets

STALLED = 1e-7  # relative decrease of the sum of squares that ends a fit: far less than noise moves it by
EVALUATIONS = 100  # of the residuals, at most
ENDS = {
    0: f"ended after {EVALUATIONS} evaluations, not converged: begin again from there, or tell it more",
    2: "the misfit falls no further",
    3: "the parameters change no further",
    4: "neither misfit nor parameters change further",
}


@one_thread
def fit(
    scene: Scene,
    targets: Mapping[float, Any],
    to: Sequence[str],
    *,
    bounds: tuple[float, float] | Mapping[str, tuple[float, float]] | None = None,
    landmarks: Mapping[float, Sequence[tuple[Any, Any]]] | None = None,
    smoothness: float | Literal["auto"] = 0.0,
    noise: float | None = None,
    tolerance: float = 1e-8,
    out: str | Path | None = None,
    resume: bool = False,
    progress: Callable[[float], object] | None = None,
) -> Fit:
    """Return the parameters with which the scene's pial surface comes closest to target outlines.

    targets: by age (the scene's time), points (2, n) in m, in order; open ones reach as far as the pial
    surface; those of a body that nothing supports are laid on it first.  to: parameters, such as
    "GrowthMap.cortex.0", "TangentialGrowth.core", "Elastic.gray.mu".
    bounds: least and largest value of all, or by parameter or map ("GrowthMap.cortex") of those named.
    landmarks: by age, pairs of a place on the undeformed surface, a share of its length or a point in m, and
    the point, m, where it is at that age; each counts as much as a point of the outline.
    smoothness: weight of the second differences of values that are neighbours in one map, against distances
    in units of the cortical thickness; "auto": as much as the noise allows, or by the L-curve (see
    `smoothing.smoothest`).  noise: standard deviation of the targets, m, for the standard errors; else they
    follow from the misfit.
    tolerance: relative change of the parameters that ends the fit.
    out: a folder in which fit.json always holds the best so far, of one that runs, and at the end what was
    found; one of an earlier fit is replaced.  resume: begin with that, if it is there.
    progress: is called with each root mean square distance of the outlines, m.
    Raises ValueError for targets that cross themselves or are far off, ages outside the scene, and scenes
    whose state depends on the way to it; NotConvergedError where the scene itself does not reach the ages.
    """
    instance("scene", scene, Scene, "Scene(body=semicircle(...), terms=(Elastic(...),))")
    check_fitted(to)
    if noise is not None:
        positive("noise", noise, remedy="it is the standard deviation of the targets' points, in m")
    if smoothness == "auto":
        if not len(second_differences(to)):
            raise ValueError('smoothness="auto" needs three neighbours of one map among the parameters.')
        return _smoothest(
            lambda begun, weight, again: fit(
                begun, targets, to, bounds=bounds, landmarks=landmarks, smoothness=weight, noise=noise,
                tolerance=tolerance, out=out, resume=resume and not again, progress=progress,
            ),
            scene, noise, None if out is None else Path(out),
        )  # fmt: skip
    if isinstance(smoothness, str) or finite("smoothness", smoothness) < 0:
        raise ValueError(f'smoothness={smoothness!r} must be 0 or more, or "auto".')
    positive("tolerance", tolerance)
    curves = checked_targets(scene, targets)
    marks = checked_landmarks(scene.body, curves, landmarks or {})
    folder = None if out is None else Path(out)
    values, low, high = begun_with(scene, tuple(to), bounds, folder, resume=resume)
    if folder is not None:
        make_folder(folder)
    problem = Inverse(scene, tuple(to), curves, marks, smoothness, folder, progress)
    solved = least_squares(
        problem.residuals, values, jac=problem.jacobian, bounds=(low, high), x_scale="jac",
        xtol=tolerance, ftol=STALLED, gtol=None, max_nfev=EVALUATIONS,
    )  # fmt: skip
    found = problem.result(np.asarray(solved.x), ENDS.get(solved.status, str(solved.message)), noise)
    return replace(found, remarks=tuple(remarks(found, low, high, noise)))


def _smoothest(
    fitted: Callable[[Scene, float, bool], Fit], scene: Scene, noise: float | None, out: Path | None
) -> Fit:
    """Return the fit of the smoothest map; fitted: by the scene it begins with, the weight, whether again."""

    def with_weight(weight: float, last: Fit | None) -> Fit:
        return fitted(scene if last is None else last.scene, weight, last is not None)

    found, how = smoothest(with_weight, noise)
    if out is not None:
        keep_best(out, found.parameters, found.values, misfit(found), found.smoothness, found.solves)
    return replace(found, message=f"{found.message}; {how}")
