"""An entry of the reference: what is known of one name, as data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from bgc.printing.text_tables import Table
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Text:
    """A paragraph, to be broken into lines where it is printed; `code` stands in backticks."""

    text: str


@dataclass(frozen=True, slots=True)
class Code:
    """Lines that keep their form: text of a `.bg` file, a command."""

    text: str


@dataclass(frozen=True, slots=True)
class Heading:
    """The title of a section within an entry."""

    text: str


Block: TypeAlias = Text | Code | Heading | Table


@dataclass(frozen=True, slots=True)
class Entry:
    """The documentation of one name.

    `kind` says what the name is, in the reader's words: `element`, `function`, `library part`.
    `summary` is one sentence without a full stop, or a few words. `see_also` are names of other
    entries.
    """

    kind: str
    name: str
    summary: str
    body: tuple[Block, ...] = ()
    see_also: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """Its paragraphs and code."""
        return "\n".join(block.text for block in self.body if not isinstance(block, Table))


@dataclass(frozen=True, slots=True)
class Group:
    """Entries of one sort.

    `name` finds the list of the group, as `units` does, and so do its `aliases`. `summaries` are
    one line for each entry, cheap to have; `entry` makes one of them. `intro` stands above the
    list; `listing` makes another list than that of all summaries. `other` makes entries of a name
    that is not listed, if it can. `texts` are the summaries and texts to be searched, by default
    those of the entries.
    """

    name: str
    title: str
    summaries: Callable[[], Mapping[str, str]]
    entry: Callable[[str], Entry]
    intro: tuple[Block, ...] = ()
    aliases: tuple[str, ...] = ()
    listing: Callable[[], Sequence[Block]] | None = None
    other: Callable[[str], Sequence[Entry]] | None = None
    texts: Callable[[], Mapping[str, tuple[str, str]]] | None = None

    def searched(self) -> Mapping[str, tuple[str, str]]:
        """Return the summary and the text of each name."""
        if self.texts is not None:
            return self.texts()
        return {
            name: (summary, self.entry(name).text) for name, summary in self.summaries().items()
        }

    def overview(self) -> Entry:
        """Return the list of the group as an entry of its own."""
        listed = self.listing() if self.listing is not None else (rows_of(self.summaries()),)
        return Entry("list", self.name, self.title, (*self.intro, *listed))


def rows_of(summaries: Mapping[str, str]) -> Table:
    """Make a table of names with their summaries."""
    return Table("", (), tuple(summaries.items()))


def paragraphs(text: str) -> tuple[Block, ...]:
    """Split a text into paragraphs at empty lines."""
    pieces = (" ".join(piece.split()) for piece in text.split("\n\n"))
    return tuple(Text(piece) for piece in pieces if piece)


def first_sentence(text: str) -> str:
    """Return the first sentence of a text without its full stop."""
    paragraph = " ".join(text.split("\n\n")[0].split())
    for at, character in enumerate(paragraph):
        after = paragraph[at + 1 : at + 3]
        ends = not after or (after[0] == " " and after[1:].isupper())
        if character == "." and ends and not paragraph[:at].endswith(_ABBREVIATIONS):
            return paragraph[:at]
    return paragraph


_ABBREVIATIONS = ("eq", "eqs", "Fig", "e.g", "i.e", "sec")
