"""Bonds: resolve chains of names to scalar bonds with widths, units and domains."""
