"""Equilibria: Newton's method, the march through time, linear algebra."""
