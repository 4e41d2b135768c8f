"""Bodies: their curves, meshes, layers and shapes."""
