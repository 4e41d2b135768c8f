"""Bodies from measured outlines: read, repair, offset, mesh."""

from .build import Fine as Fine
from .build import outline as outline
from .read import read_outline as read_outline
