"""Calls and lists of a text, broken into lines of at most 100 characters."""

from __future__ import annotations

from collections.abc import Sequence

_WIDTH = 96  # with the indentation that `bgc fmt` adds


def call(head: str, arguments: Sequence[str], end: str = ";") -> str:
    """Write `head(a, b);` on one line, or broken at its arguments."""
    if not arguments:
        return f"{head}{end}"
    return _broken(f"{head}(", arguments, f"){end}")


def bracketed(head: str, items: Sequence[str], end: str = "];") -> str:
    """Write `head[a, b];` in the same way."""
    return _broken(f"{head}[", items, end)


def chained(items: Sequence[str], end: str) -> str:
    """Write `a, b -> c;` in the same way."""
    return _broken("", items, end)


def _broken(head: str, items: Sequence[str], end: str) -> str:
    whole = f"{head}{', '.join(items)}{end}"
    if len(whole) <= _WIDTH:
        return whole
    lines, line = ([head] if head else []), ""
    for count, item in enumerate(items):
        comma = "," if count < len(items) - 1 else end
        if line and len(line) + len(item) + 2 > _WIDTH:
            lines.append(line)
            line = ""
        line = f"{line} {item}{comma}".strip()
    return "\n".join([*lines, line])
