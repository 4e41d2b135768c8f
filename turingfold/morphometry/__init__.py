"""Measures of folded curves: pure functions of points (2, n), in m, along a pial surface or an outline."""
