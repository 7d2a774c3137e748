"""Limits on the size of a model, which only a mistake or a model too large to compile exceeds."""

MAX_DEPTH = 60  # nesting of models
MAX_PARTS = 200_000  # parts of a scene; also iterations of all its `for` loops
MAX_TURNS = 100_000  # absolute value of a loop's bounds and of a part's index
MAX_WIDTH = 10_000  # components of a vector or a bond
