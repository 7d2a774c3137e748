"""Runs under a clock, and how far they are from others: what trade, stress and activity share."""
