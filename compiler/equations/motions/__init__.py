"""Free motions, and the storage that is merged along them."""
