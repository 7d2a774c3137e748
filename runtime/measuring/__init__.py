"""Timed runs, errors against a reference, and costs: shared by trade, stress and activity."""
