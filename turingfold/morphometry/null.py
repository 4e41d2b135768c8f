"""A measured value beside the values of the same measure that chance alone gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Null:
    """A value and its null distribution: `samples` (k,) of the measure where what it looks for is absent."""

    value: float
    samples: Array

    @property
    def p(self) -> float:
        """Share of the samples that are at least as large as the value, the p-value of the one-sided test."""
        return float(np.mean(self.samples >= self.value - 1e-12))

    def quantile(self, share: float) -> float:
        """Return the value that this share of the samples, from 0 to 1, does not exceed."""
        return float(np.quantile(self.samples, share))

    def __str__(self) -> str:
        """Return the value with the median of the null distribution, its 95 % quantile and p."""
        median, high = self.quantile(0.5), self.quantile(0.95)
        return f"{self.value:.3f} (by chance {median:.3f}, 95 % below {high:.3f}; p = {self.p:.3f})"
