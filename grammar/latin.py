"""ASCII letters for the names of files and things, which become names in the language or in C."""

from __future__ import annotations

import unicodedata

_DIGRAPHS = {
    "ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "æ": "ae", "œ": "oe", "ø": "oe", "å": "aa",
    "ð": "d", "đ": "d", "þ": "th", "ł": "l", "ı": "i",
}  # fmt: skip


def latin(text: str) -> str:
    """Write letters without ASCII form as ASCII letters: `käse` becomes `kaese`, `café` `cafe`.

    Letters of other scripts become their code point, `u4e2d`, so that two names stay two names.
    All other characters stay.
    """
    return "".join(_ascii(char) for char in unicodedata.normalize("NFC", text))


def _ascii(char: str) -> str:
    if char.isascii() or not char.isalnum():
        return char
    found = _DIGRAPHS.get(char.lower(), "")
    if not found:
        plain = unicodedata.normalize("NFKD", char)
        found = "".join(part for part in plain if part.isascii() and part.isalnum())
        return found or f"u{ord(char):x}"
    return found.capitalize() if char.isupper() else found
