"""Emission: optimise, differentiate and lower the state equations, and print them as C."""
