"""From a name to its entries."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from bgc.diagnostics.catalogue import did_you_mean
from bgc.diagnostics.catalogue.pages import near_codes
from bgc.diagnostics.catalogue.reference import unknown_topic
from bgc.diagnostics.diagnostic import BgError
from bgc.printing.text_tables import Table
from bgc.reference import (
    chapters,
    codes,
    element_entries,
    function_entries,
    library_entries,
    topics,
    unit_entries,
    word_entries,
)
from bgc.reference.entry import Entry, Group, Text, rows_of

GROUPS: tuple[Group, ...] = (
    element_entries.GROUP,
    word_entries.WORDS,
    word_entries.SCENE_NAMES,
    function_entries.GROUP,
    unit_entries.GROUP,
    library_entries.GROUP,
    codes.GROUP,
)
"""All groups of the language and the library; other packages add theirs."""

GUIDES: tuple[Group, ...] = (topics.GROUP, chapters.GROUP)
"""Topics and chapters of the manual, which are found where no other group has the name."""

_IN_NAME, _IN_SUMMARY = 16.0, 4.0  # what a word counts there; in a text, less than 2
_CAPITAL = re.compile(r"(?<=[a-z])(?=[A-Z])")  # where a word of a part's name begins
_SHORTEST_WORD = 3  # letters of words that are searched for
_MOST_NAMED = 100  # names of a group in the list of all
_MOST_FOUND = 30  # names that mention some words


def contents(groups: Sequence[Group], intro: str, end: str) -> Entry:
    """List the names of all groups between two texts."""
    tables = (_names_of(group) for group in groups if group.summaries())
    return Entry("list", "bgc doc", "", (Text(intro), *tables, Text(end)))


def _names_of(group: Group) -> Table:
    """List the names of a group in a few lines, or say how to list them."""
    listed = group.summaries()
    text = f"{len(listed)} names, listed by `bgc doc {group.name}`"
    note = "  ".join(listed) if len(listed) <= _MOST_NAMED else text
    return Table(f"{group.name}: {group.title}", (), (), note)


def answer(name: str, groups: Sequence[Group], guides: Sequence[Group] = ()) -> tuple[Entry, ...]:
    """Return the entries of a name, else a list of those that mention it.

    The guides are searched where no group has the name, and named where one has it. Raises
    BgError (BG040), with names that are near, where nothing is found.
    """
    if found := find(name, groups):
        *others, last = found
        folded = name.casefold()
        also = (f"{g.name} {name}" for g in guides if folded in map(str.casefold, g.summaries()))
        return (*others, replace(last, see_also=(*last.see_also, *also)))
    if found := tuple(entry for guide in guides for entry in find(name, [guide])):
        return found
    searched = (*groups, *guides)
    known = names(searched)
    listed, closely = search(name, searched) if len(name) >= _SHORTEST_WORD else ({}, False)
    if listed and (closely or not did_you_mean(name, known)):
        title = f"names that mention `{name}`, the closest first"
        return (Entry("list", title, "", (rows_of(listed),)),)
    near = ", ".join(near_codes(name))
    raise BgError([unknown_topic(name, near and f"near it are {near}", known)])


def find(name: str, groups: Sequence[Group]) -> tuple[Entry, ...]:
    """Return the entries of a name: as it is written, else in other case, else by other means.

    The list of a group counts as an entry of the group's name. Empty where there is none.
    """
    folded = name.casefold()
    return (
        tuple(_exact(name, groups))
        or tuple(e for group in groups if group.other is not None for e in group.other(name))
        or tuple(
            group.entry(known)
            for group in groups
            for known in group.summaries()
            if folded in (known.casefold(), known.casefold().rpartition(".")[2])
        )
    )


def _exact(name: str, groups: Sequence[Group]) -> Iterator[Entry]:
    for group in groups:
        if name in (group.name, *group.aliases):
            yield group.overview()
        if name in group.summaries():
            yield group.entry(name)


def search(text: str, groups: Sequence[Group]) -> tuple[dict[str, str], bool]:
    """Find the names, with their summaries, of entries that mention all words of a text.

    A word counts most in a name, less in a summary, least in the text of an entry. It may begin
    a longer one, unless it has digits. Returns the best 30, the best first, and whether a name or
    a summary mentions them all.
    """
    words = [_pattern(word) for word in text.casefold().split()]
    weights: dict[str, float] = {}
    summaries: dict[str, str] = {}
    for group in groups:
        for name, (summary, body) in group.searched().items():
            counts = [_weight(word, name, summary, body) for word in words]
            if words and all(counts):
                weights.setdefault(name, min(counts) * 100 + sum(counts))
                summaries.setdefault(name, summary)
    best = sorted(weights, key=weights.__getitem__, reverse=True)[:_MOST_FOUND]
    closely = any(weights[name] >= 100 * _IN_SUMMARY for name in best)
    return {name: summaries[name] for name in best}, closely


def _pattern(word: str) -> re.Pattern[str]:
    end = r"(?!\w)" if any(map(str.isdigit, word)) else ""
    return re.compile(rf"(?<![^\W_]){re.escape(word)}{end}", re.IGNORECASE)


def _weight(word: re.Pattern[str], name: str, summary: str, body: str) -> float:
    """The score of an entry for a word, 0 where the entry does not mention it."""
    if word.search(_CAPITAL.sub(" ", name)):
        return _IN_NAME
    if word.search(summary):
        return _IN_SUMMARY
    count = len(word.findall(body))
    return 2.0 * count / (count + 1)


def names(groups: Sequence[Group]) -> tuple[str, ...]:
    """Return all names that can be looked up, full and short, for suggestions."""
    found: dict[str, None] = {}
    for group in groups:
        for name in (group.name, *group.aliases, *group.summaries()):
            found[name] = None
            if "." in name:
                found[name.rpartition(".")[2]] = None
    return tuple(found)
