"""Print the results of the compiler for people: tables, text, LaTeX, drawings."""
