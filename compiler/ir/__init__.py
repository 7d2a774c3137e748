"""Intermediate representations: the immutable results that the passes hand on."""
