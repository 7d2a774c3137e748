"""The language: its grammar, syntax tree, formatter and diagnostics."""
