"""Storage: which elements are integrated, their initial values and their energies."""
