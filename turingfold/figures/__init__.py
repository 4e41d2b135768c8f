"""Pictures of results, on matplotlib axes and figures that the caller gives."""

from .bars import tornado as tornado
from .grids import before as before
from .grids import grid as grid
from .grids import layers as layers
from .grids import nearest_step as nearest_step
from .grids import numbers as numbers
from .grids import tissue as tissue
from .sections import activator as activator
from .sections import areas as areas
from .sections import field_limits as field_limits
from .sections import folding as folding
from .sections import load_arrows as load_arrows
from .sections import measures as measures
from .sections import outline as outline
from .sections import peaks as peaks
from .sections import pial_history as pial_history
from .sections import scale_bar as scale_bar
from .sections import section as section
from .sections import section_grid as section_grid
from .style import INK as INK
from .style import sulci as sulci
