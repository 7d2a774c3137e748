"""From a file to all files it imports and the names that each of them sees."""
