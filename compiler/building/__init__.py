"""Compile C to a shared object, and cache the results."""
