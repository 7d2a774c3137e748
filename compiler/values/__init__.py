"""Expressions of the language: units, shapes, operators and functions, down to nodes."""
