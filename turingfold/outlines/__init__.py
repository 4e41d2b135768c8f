"""Bodies from closed curves: planar sets, repaired, offset and meshed."""

from .build import RefinementDisc as RefinementDisc
from .build import outline as outline
from .section import Section as Section
from .skull import skull_around as skull_around
