"""Loss of stability: buckling, and paths of equilibria through limit points."""
