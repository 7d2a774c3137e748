"""What slicing left out, in words: whole parts where it took all of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from bgc.program import Dropped, Reason

_STEP = re.compile(r"\.|(?=\[)")


def dropped_lines(dropped: Sequence[Dropped], left: Iterable[str]) -> tuple[str, ...]:
    """One line for each part or value that is left out, with the reason.

    `left` are the names of the states that are still there: of a part that lost only some of
    its states, these are named.
    """
    partly = {prefix for name in left for prefix in _prefixes(name)}
    reasons: dict[str, set[Reason]] = {}
    for item in dropped:
        for prefix in _prefixes(item.name):
            reasons.setdefault(prefix, set()).add(item.reason)
    groups: dict[tuple[str, Reason], list[str]] = {}
    for item in dropped:
        whole = [p for p in _prefixes(item.name) if p not in partly and len(reasons[p]) == 1]
        groups.setdefault((whole[0] if whole else item.name, item.reason), []).append(item.name)
    return tuple(_line(name, reason, names) for (name, reason), names in groups.items())


def _line(name: str, reason: Reason, names: list[str]) -> str:
    count = "" if names == [name] else f" ({len(names)} state{'s' * (len(names) > 1)})"
    return f"`{name}`{count}: {reason.value}"


def _prefixes(name: str) -> list[str]:
    """The parts that a name leads through, outermost first, and the name itself."""
    return [name[: found.start()] for found in _STEP.finditer(name)] + [name]
