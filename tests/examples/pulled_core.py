"""White matter that grows where it is pulled, under gray matter whose growth is prescribed."""
from dataclasses import dataclass

import numpy as np

from turingfold.extend import Evolution, Process, cortex_indicator


@dataclass(frozen=True)
class PulledCore(Process):
    """g_n = c with ċ = (1 - θ) rate c (σ_xx + σ_yy)/2, g_t = (1 + θ (cortex - 1) t) c, g_z = 1."""
    cortex: float = 1.8
    rate: float = 1e-4  # 1/(Pa · time); steps have to be shorter than 1/(rate κ)
    reads, writes, remembers = ("cauchy_stress",), ("growth",), True
    def on(self, body):
        return PulledOnBody(self, cortex_indicator(body))

class PulledOnBody(Evolution):
    def __init__(self, law, gray):
        self.rate, self.gain, self.none = law.rate * (1 - gray), (law.cortex - 1) * gray, np.ones_like(gray)
    def start(self, state, seed):
        return {"growth": np.stack([self.none] * 3)}
    def advance(self, before, now, dt):  # stress and growth of `before` belong together, the time is of `now`
        core = before["growth"][1] * np.exp(self.rate * dt * before["cauchy_stress"][:2].mean(0))
        return {"growth": np.stack([(1 + self.gain * now.time) * core, core, self.none])}
