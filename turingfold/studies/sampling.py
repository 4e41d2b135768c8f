"""Samples of parameters: of ranges, by a Latin hypercube or Sobol's sequence; of means with deviations."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import Array
from ..checks import finite, one_of, positive, whole

REACH = 3.0  # standard deviations beyond which normal distributions are cut
METHODS = "lhs", "sobol"


def sampled(
    ranges: Mapping[str, tuple[float, float]], count: int, *, method: str = "lhs", seed: int = 0
) -> dict[str, Array]:
    """Return `count` samples of each parameter, (count,), spread evenly over their ranges.

    method: "lhs", a Latin hypercube: each range is divided into `count` equal parts, of which every one holds
    one sample; "sobol", the scrambled sequence of Sobol: the samples of a larger count begin with those of a
    smaller one, and powers of two fill the ranges most evenly.
    ranges: lowest and highest value by name.
    Raises ValueError for no range, and for one whose lowest value is not below its highest.
    Source: McKay, Beckman, Conover (1979) Technometrics 21:239; Owen (1998) J. Complexity 14:466.
    """
    from scipy.stats import qmc

    whole("count", count, at_least=1)
    whole("seed", seed, at_least=0)
    one_of("method", method, METHODS)
    if not ranges:
        raise ValueError("ranges={} names no parameter; give the lowest and the highest value by name.")
    for name, (low, high) in ranges.items():
        if not finite(f"{name}, lowest", low) < finite(f"{name}, highest", high):
            raise ValueError(f"{name}={low:g}:{high:g} must be LOW:HIGH, the lowest value below the highest.")
    random = np.random.default_rng(seed)
    if method == "lhs":
        shares = qmc.LatinHypercube(d=len(ranges), seed=random).random(count)
    else:  # of the next power of two, the beginning: other counts would warn
        power = max(0, count - 1).bit_length()
        shares = qmc.Sobol(d=len(ranges), seed=random).random_base2(power)[:count]
    return {
        name: low + (high - low) * own
        for (name, (low, high)), own in zip(ranges.items(), shares.T, strict=True)
    }


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
