"""Matching of state and parameter names against `keep`."""

from __future__ import annotations

from collections.abc import Iterable


def is_kept(name: str, kept: Iterable[str]) -> bool:
    """Whether `keep` names it, a part that it belongs to, or the vector of which it is an entry."""
    return any(name == k or name.startswith((f"{k}.", f"{k}[")) for k in kept)
