"""Algebraic loops and implicit equations, and the definitions resolved in order."""
