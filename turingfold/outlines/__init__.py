"""Bodies from measured outlines: read, repair, offset, mesh."""

from .build import Fine as Fine
from .build import outline as outline
from .mask import mask_outline as mask_outline
from .read import read_outline as read_outline
