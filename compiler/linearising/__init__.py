"""Linearising: differentiate a scene by its states and by chosen inputs."""
