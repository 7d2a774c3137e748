"""Targets of `bgc build`: what a scene is compiled to, one module each."""
