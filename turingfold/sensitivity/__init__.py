"""Sensitivities: how much what comes of a scene changes with its parameters."""
