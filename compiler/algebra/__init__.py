"""Scalar expressions as a graph, and what is done with them: numbers, derivatives, text."""
