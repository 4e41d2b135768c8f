"""Time integration of reaction and diffusion."""
