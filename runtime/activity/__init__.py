"""Where the energy of a scene goes, and which parts it can do without."""
