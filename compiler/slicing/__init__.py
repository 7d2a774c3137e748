"""Reduction to what the scene requires: folded parameters, cone of influence, invariant states."""
