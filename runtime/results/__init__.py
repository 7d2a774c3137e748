"""Results: rows as named columns, their plots and their files."""
