"""Studies of what a scene requires: leave out what its requirements do not need, and prove it."""
