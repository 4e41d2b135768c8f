"""Bodies from measured outlines: read, repair, offset, mesh."""

from .any_file import read_section as read_section
from .build import RefinementDisc as RefinementDisc
from .build import outline as outline
from .mask import mask_outline as mask_outline
from .mask import sections as sections
from .read import Contours as Contours
from .read import read_outline as read_outline
from .section import Section as Section
from .skull import skull_around as skull_around
from .surface import surface_section as surface_section
