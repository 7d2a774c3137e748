"""Tables of the language that the compiler reads and `bgc doc` prints: one row a thing."""
