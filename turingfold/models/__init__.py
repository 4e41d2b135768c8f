"""What cases share: their parameters, and the tissue of the brains that they are about."""

from . import ferret as ferret
from . import human as human
from . import parameters as parameters
