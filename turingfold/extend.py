"""What a part of a user's own is made of; `turingfold.testing` examines it.

A process changes fields between equilibria: derive from `Process`, return an `Evolution` from `on(body)`.
A growth law that is a function of time derives from `GrowthLaw`. A term has an energy: derive from `Term`
(`Load` where several may act at once), return an `Operator` from `on(body)`, whose `Potential` gives an
`Evaluation`; a quadratic energy is a `Quadratic` of a `SymmetricMatrix`. Reactions derive from `Kinetics`.
"""

from .arrays import Array as Array
from .geometry.body import Body as Body
from .geometry.layers import cortex_indicator as cortex_indicator
from .growth.laws import GrowthLaw as GrowthLaw
from .parts import Condensed as Condensed
from .parts import Entries as Entries
from .parts import Evaluation as Evaluation
from .parts import Evolution as Evolution
from .parts import Fields as Fields
from .parts import Hessian as Hessian
from .parts import Load as Load
from .parts import Operator as Operator
from .parts import Potential as Potential
from .parts import Process as Process
from .parts import SearchLine as SearchLine
from .parts import Solid as Solid
from .parts import Term as Term
from .parts import TimeStep as TimeStep
from .state import State as State
from .terms.quadratic_energy import Quadratic as Quadratic
from .terms.quadratic_energy import SymmetricMatrix as SymmetricMatrix
from .turing.kinetics.base import Kinetics as Kinetics
