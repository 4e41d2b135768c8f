"""Turing systems on the cortical band: kinetics, instability, integrators, steady states."""
