"""What the compiler made, as people read it: tables, text, LaTeX."""
