"""Linear systems of the morphogens."""
