"""Compiled models loaded and run."""
