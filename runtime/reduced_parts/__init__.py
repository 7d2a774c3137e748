"""Reduce parts with linear laws, as passive parts of fewer states with the same ports."""
