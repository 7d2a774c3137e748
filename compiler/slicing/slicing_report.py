"""The list of states and parameters that slicing and folding removed, by part where possible."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from bgc.ir.program import Dropped, Reason

_STEP = re.compile(r"\.|(?=\[)")
_MOST_NAMED = 4
_COMPONENT = re.compile(r"\[[^\[\]]*\]")


def dropped_lines(dropped: Sequence[Dropped], left: Iterable[str]) -> tuple[str, ...]:
    """One line for each removed part or value, with the reason.

    `left` are the names of the remaining states. Where a part lost only some of its states, these
    are listed by name, components of one vector together.
    """
    partly = {prefix for name in left for prefix in _prefixes(name)}
    reasons: dict[str, set[Reason]] = {}
    for item in dropped:
        for prefix in _prefixes(item.name):
            reasons.setdefault(prefix, set()).add(item.reason)
    groups: dict[tuple[str, Reason], list[str]] = {}
    for item in dropped:
        parts = (p for p in _prefixes(item.name) if p not in partly and len(reasons[p]) == 1)
        part = next(parts, item.name)
        group = _vector(part) if part == item.name else part
        groups.setdefault((group, item.reason), []).append(item.name)
    return tuple(_line(name, reason, names) for (name, reason), names in groups.items())


def folded_lines(folded: Sequence[tuple[str, float]]) -> tuple[str, ...]:
    """One line for each folded parameter and value: some components by name, or their number."""
    groups: dict[tuple[str, float], list[str]] = {}
    for name, value in folded:
        groups.setdefault((_vector(name), value), []).append(name)
    return tuple(
        f"{len(names)} components of `{group}` = {value:g}"
        if len(names) > _MOST_NAMED
        else f"{', '.join(f'`{name}`' for name in names)} = {value:g}"
        for (group, value), names in groups.items()
    )


def _line(name: str, reason: Reason, names: list[str]) -> str:
    components = [n.removeprefix(name) for n in names if _COMPONENT.fullmatch(n.removeprefix(name))]
    if len(components) == len(names):
        which = ", ".join(c[1:-1] for c in components)
        return f"`{name}[{which}]`: {reason.value}"
    count = "" if names == [name] else f" ({len(names)} state{'s' * (len(names) > 1)})"
    return f"`{name}`{count}: {reason.value}"


def _vector(name: str) -> str:
    """The vector or matrix that a name is a component of; else the name itself."""
    return name.rpartition("[")[0] if name.endswith("]") else name


def _prefixes(name: str) -> list[str]:
    """The parts that a name leads through, outermost first, and the name itself."""
    return [name[: found.start()] for found in _STEP.finditer(name)] + [name]
