"""Checks that element laws are passive: stored energies exist, and resistors only dissipate."""
