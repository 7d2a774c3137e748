"""Intermediate representations: the immutable results that one pass hands to the next."""
