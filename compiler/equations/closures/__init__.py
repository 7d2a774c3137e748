"""Closed chains: multipliers of the rows that close them, and the manifold that they hold."""
