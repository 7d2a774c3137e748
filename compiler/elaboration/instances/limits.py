"""Limits on the size of a model: beyond them it is a mistake, or too large to compile."""

MAX_DEPTH = 60  # models inside models
MAX_PARTS = 200_000  # parts of a scene
MAX_TURNS = 100_000  # of all `for` loops
MAX_WIDTH = 10_000  # of a vector, a bond or an array of parts
