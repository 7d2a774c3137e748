"""Names of states and parameters as `keep` and the list of what was dropped read them."""

from __future__ import annotations

from collections.abc import Iterable


def is_kept(name: str, kept: Iterable[str]) -> bool:
    """Whether `keep` names this: itself, a part it belongs to, or the whole of a component."""
    return any(name == k or name.startswith((f"{k}.", f"{k}[")) for k in kept)
