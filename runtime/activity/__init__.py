"""Activities of elements, and the simplifications of a scene that they suggest."""
