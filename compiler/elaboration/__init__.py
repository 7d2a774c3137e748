"""Elaboration: expand a package and a scene into the flat bond graph."""
