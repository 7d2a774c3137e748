"""Results of runs: named columns, their plots and their files."""
