"""What is asked of a model besides its run: its linear form about an operating point."""
