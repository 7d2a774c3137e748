"""Read a file with its imports, and resolve the names that are visible in each."""
