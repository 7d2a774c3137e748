"""Stress maps: a scene at extreme parameters, steps and tolerances, judged by other methods."""
