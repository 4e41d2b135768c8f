"""Samples of parameters: one in every stratum, the known moments, the same for the same seed."""

import numpy as np
import pytest
from scipy.stats import norm

from turingfold import latin_hypercube
from turingfold.studies.sampling import sampled

MODULI = {"gray": (1389.0, 289.0), "white": (1895.0, 592.0)}


def test_every_part_of_equal_probability_holds_one_sample():
    found = latin_hypercube(MODULI, 40, seed=3)
    low, high = norm.cdf([-3.0, 3.0])
    for name, (mean, deviation) in MODULI.items():
        shares = (norm.cdf((found[name] - mean) / deviation) - low) / (high - low)
        assert sorted(np.floor(40 * shares).astype(int)) == list(range(40))


def test_moments_and_independence():
    found = latin_hypercube(MODULI, 400)
    # a normal distribution cut at 3: the variance loses 2·3 φ(3)/(Φ(3) - Φ(-3))
    left = np.sqrt(1 - 6 * norm.pdf(3.0) / (norm.cdf(3.0) - norm.cdf(-3.0)))
    for name, (mean, deviation) in MODULI.items():
        assert found[name].mean() == pytest.approx(mean, abs=0.01 * deviation)
        assert found[name].std() == pytest.approx(left * deviation, rel=0.01)
        assert found[name].min() > 0
    assert abs(np.corrcoef(found["gray"], found["white"])[0, 1]) < 4 / np.sqrt(400)


def test_a_seed_gives_the_same_samples_and_another_seed_others():
    again = [latin_hypercube(MODULI, 5, seed=seed)["gray"] for seed in (1, 1, 2)]
    assert again[0].tobytes() == again[1].tobytes()
    assert np.abs(again[0] - again[2]).max() > 1


@pytest.mark.parametrize(
    ("parameters", "count", "words"),
    [
        ({}, 5, "names none"),
        ({"gray": (1.0, 0.0)}, 5, "gray, standard deviation=0"),
        ({"gray": (1.0, 0.4)}, 5, "gray=1 ± 0.4 would be sampled at or below zero"),
        (MODULI, 0, "count=0 must be a whole number"),
    ],
)
def test_what_cannot_be_sampled_is_refused(parameters, count, words):
    with pytest.raises(ValueError, match=words):
        latin_hypercube(parameters, count)


RANGES = {"thickness": (2e-3, 4e-3), "cortex": (1.5, 2.5)}


def shares(found):
    return {name: (found[name] - low) / (high - low) for name, (low, high) in RANGES.items()}


def test_every_part_of_a_range_holds_one_sample_of_a_latin_hypercube():
    for own in shares(sampled(RANGES, 30, method="lhs", seed=2)).values():
        assert sorted(np.floor(30 * own).astype(int)) == list(range(30))


def test_a_longer_sobol_sequence_begins_with_the_shorter_and_fills_every_square():
    few, many = (shares(sampled(RANGES, count, method="sobol", seed=2)) for count in (11, 16))
    for name in RANGES:
        assert few[name].tobytes() == many[name][:11].tobytes()
    # sixteen points of a (0, 2)-sequence: one in each square of a 4 x 4 grid
    squares = {tuple(place) for place in np.floor(4 * np.transpose(list(many.values()))).astype(int)}
    assert len(squares) == 16


@pytest.mark.parametrize(
    ("ranges", "method", "words"),
    [
        ({}, "lhs", "names no parameter"),
        ({"cortex": (2.0, 2.0)}, "lhs", "cortex=2:2 must be LOW:HIGH"),
        (RANGES, "halton", "method='halton'"),
    ],
)
def test_ranges_that_cannot_be_sampled_are_refused(ranges, method, words):
    with pytest.raises(ValueError, match=words):
        sampled(ranges, 4, method=method)
