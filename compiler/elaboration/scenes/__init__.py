"""Scenes: what a scene and the command line change, observe, drive and require."""
