"""Running a scene, what comes of it, and how that is stored."""
