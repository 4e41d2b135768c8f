"""A bed of springs that holds every point of the pial surface at its place."""
from dataclasses import dataclass

import numpy as np
from scipy.sparse import diags

from turingfold.extend import Quadratic, SymmetricMatrix, Term


@dataclass(frozen=True)
class Springs(Term):
    """Energy ½ k ∫ |u|² ds along the pial surface, lumped to its nodes; stiffness k in Pa/m."""
    stiffness: float

    def on(self, body):
        nodes, arc, closed = body.pial, body.pial_arc, body.pial_curve.closed
        if closed:
            nodes, arc = np.append(nodes, nodes[0]), np.append(arc, body.pial_curve.length)
        length = self.stiffness * np.diff(arc[::2])  # of the quadratic edges; Simpson's rule shares it out
        k = np.zeros(body.nodes.shape[1])
        for at, share in ((nodes[:-2:2], 1 / 6), (nodes[1::2], 4 / 6), (nodes[2::2], 1 / 6)):
            np.add.at(k, at, share * length)
        return Quadratic(SymmetricMatrix.of(diags(np.repeat(k, 2))), np.zeros(2 * len(k)))
