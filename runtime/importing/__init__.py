"""Import of robots (URDF, MJCF) and of BondGraphTools' models: text in, `.bg` text out."""
