"""Reaction kinetics of two morphogens."""
