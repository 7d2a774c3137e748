"""Import of hydrodynamic data: readers of programs' files, checks, and the ship that is written."""
