"""Linearisation of a scene about an operating point."""
