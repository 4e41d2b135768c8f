"""Finite-strain elasticity of the two layers."""
