"""Inertias that rigid connections make dependent, merged into one momentum for each free flow."""
