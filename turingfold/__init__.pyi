from .body import Body as Body
from .geometry import half as half
from .geometry import semicircle as semicircle
from .geometry import semiellipse as semiellipse
from .scene import InadmissibleStateError as InadmissibleStateError
from .scene import MissingFieldError as MissingFieldError
from .scene import NotConvergedError as NotConvergedError
from .scene import Scene as Scene
from .scene import State as State
from .scene import Stepping as Stepping

__version__: str
