"""The ferret brain of Choi et al. 2025 in units of its radius and of its shear modulus.

One material; the cortex is a tenth of the radius, grows at the rate 1.9 and thins to T (1 - t/2). P32 is
t = 0.44, where it has grown by e^{0.84} = 2.3 along its surface.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..growth.zones import HalfPlane, Zone
from ..terms.elastic.material import NeoHookean
from ..terms.elastic.term import Elastic

P32 = 0.44
BOTTOM = Zone(region=HalfPlane(point=(0, -0.4), normal=(0, 1), edge=0.2, ramp="straight"), growth=0.0)
"""No growth at the bottom (y < -0.4), with a ramp of 0.2."""


def tissue(*, bulk: float = 5.0) -> Elastic:
    """Return the material of cortex and core: shear modulus 1, bulk modulus `bulk`."""
    return Elastic(gray=NeoHookean(mu=1.0, kappa=bulk))


def circle(count: int = 240) -> Array:
    """Return points of the unit circle, (2, count)."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle)])
