"""Matching of state and parameter names against `keep`."""

from __future__ import annotations

from collections.abc import Iterable


def is_kept(name: str, kept: Iterable[str]) -> bool:
    """Return whether `keep` names it, a part that holds it, or the vector that it belongs to."""
    return any(name == k or name.startswith((f"{k}.", f"{k}[")) for k in kept)
