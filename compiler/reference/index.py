"""From a name to its entries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bgc.reference import chapters, codes, elements, functions, library, units, words
from bgc.reference.entry import Entry, Group

GROUPS: tuple[Group, ...] = (
    elements.GROUP,
    words.WORDS,
    words.SCENE_NAMES,
    functions.GROUP,
    units.GROUP,
    library.GROUP,
    codes.GROUP,
)
"""All groups of the language and the library; other packages add theirs."""

MANUAL = chapters.GROUP
"""The manual, whose chapters are found where no other group has the name."""


def find(name: str, groups: Sequence[Group]) -> tuple[Entry, ...]:
    """Return the entries of a name: as it is written, else in other case, else by other means.

    The list of a group counts as an entry of the group's name. Empty where there is none.
    """
    found = tuple(_exact(name, groups))
    if found:
        return found
    found = tuple(e for group in groups if group.other is not None for e in group.other(name))
    if found:
        return found
    folded = name.casefold()
    return tuple(
        group.entry(known)
        for group in groups
        for known in group.summaries()
        if folded in (known.casefold(), known.casefold().rpartition(".")[2])
    )


def _exact(name: str, groups: Sequence[Group]) -> Iterator[Entry]:
    for group in groups:
        if name in (group.name, *group.aliases):
            yield group.overview()
        if name in group.summaries():
            yield group.entry(name)


def mentions(word: str, groups: Sequence[Group]) -> dict[str, str]:
    """Return the names, with their summaries, whose name or summary holds a word."""
    folded = word.casefold()
    return {
        name: summary
        for group in groups
        for name, summary in group.summaries().items()
        if folded in name.casefold() or folded in summary.casefold()
    }


def names(groups: Sequence[Group]) -> tuple[str, ...]:
    """Return all names that can be looked up, full and short, for suggestions."""
    found: dict[str, None] = {}
    for group in groups:
        for name in (group.name, *group.aliases, *group.summaries()):
            found[name] = None
            if "." in name:
                found[name.rpartition(".")[2]] = None
    return tuple(found)
