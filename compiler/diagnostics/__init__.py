"""Diagnostics: values with a code, a place and a way out; their catalogue and rendering."""
