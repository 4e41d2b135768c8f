"""Problems whose answers are known, and what the program finds for them."""

from .check import Check as Check
from .check import Quantity as Quantity
from .registry import checks as checks
