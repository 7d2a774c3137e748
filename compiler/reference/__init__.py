"""Documentation as data, gathered from the sources that the compiler itself reads."""
