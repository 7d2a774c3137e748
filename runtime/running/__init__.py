"""Compiled models: load them, set their parameters, run them."""
