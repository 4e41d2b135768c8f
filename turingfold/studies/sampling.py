"""Samples of uncertain parameters: measured means with standard deviations, spread by a Latin hypercube."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import Array
from ..checks import finite, positive, whole

REACH = 3.0  # standard deviations beyond which normal distributions are cut


def latin_hypercube(
    parameters: Mapping[str, tuple[float, float]], count: int, *, seed: int = 0
) -> dict[str, Array]:
    """Return `count` samples of each parameter, (count,), from independent normal distributions.

    Each distribution is cut at 3 standard deviations and divided into `count` parts of equal probability, of
    which every one holds one sample; the parts of different parameters meet at random. Means and percentiles
    then have smaller errors than those of as many independent samples.
    parameters: mean and standard deviation by name.
    Raises ValueError where a mean is less than 3 standard deviations above zero: such a parameter, that has
    to be positive, is not normal.
    Source: McKay, Beckman, Conover (1979) Technometrics 21:239; `scipy.stats.qmc`.
    """
    from scipy.stats import qmc, truncnorm

    whole("count", count, at_least=1)
    whole("seed", seed, at_least=0)
    if not parameters:
        raise ValueError("parameters={} names none; give mean and standard deviation of each by its name.")
    for name, (mean, deviation) in parameters.items():
        positive(f"{name}, standard deviation", deviation)
        if finite(f"{name}, mean", mean) <= REACH * deviation:
            raise ValueError(
                f"{name}={mean:g} ± {deviation:g} would be sampled at or below zero; its mean must be more "
                f"than {REACH:g} standard deviations, or sample its logarithm."
            )
    shares = qmc.LatinHypercube(d=len(parameters), seed=np.random.default_rng(seed)).random(count)
    return {
        name: mean + deviation * truncnorm.ppf(own, -REACH, REACH)
        for (name, (mean, deviation)), own in zip(parameters.items(), shares.T, strict=True)
    }
