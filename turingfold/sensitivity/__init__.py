"""Sensitivities: how much what comes of a scene changes with its parameters."""

from . import callable_folder as callable_folder
