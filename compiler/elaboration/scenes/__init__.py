"""Scenes: read their changes to a model, observations, devices and requirements."""
