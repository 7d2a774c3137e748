"""Formulas in a model's own letters: equations, linear forms and transfer functions for SymPy.

Importing this package imports SymPy, which takes 0.3 s; nothing on the way from text to C does.
"""
