"""The record of a word of the language."""

from __future__ import annotations

from enum import Enum

from bgc.record_class import dataclass


class Reserved(Enum):
    """The places in which a word cannot be a name."""

    EVERYWHERE = "everywhere"
    IN_SCENES = "in scenes"
    NOWHERE = "nowhere"


@dataclass(frozen=True, slots=True)
class Word:
    """A word of the language.

    `begins` are the kinds of blocks in which it begins a statement. `form` says how the statement
    is written, as messages quote it. `summary` is one sentence, `doc` are further paragraphs,
    `example` is text of a `.bg` file.
    """

    word: str
    summary: str
    begins: tuple[str, ...] = ()
    form: str = ""
    doc: tuple[str, ...] = ()
    example: str = ""
    related: tuple[str, ...] = ()
    reserved: Reserved = Reserved.EVERYWHERE
