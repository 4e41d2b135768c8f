"""A window to change a scene's parameters by hand and watch what happens; built on matplotlib alone."""

from .window import App as App
