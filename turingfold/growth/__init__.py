"""Growth of the tissue: laws, their course in time, regions, imperfections."""
