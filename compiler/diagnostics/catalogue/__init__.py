"""Every diagnostic of the compiler, by topic: a row in Python, and its page in Markdown.

`laws.md` holds the pages of the rows in `laws.py`: below the heading `## CODE: title` the
paragraphs What, Why, Example and Way out, which `bgc doc CODE` prints. A message is lower case,
without a full stop, and in the user's terms; `help` is the way out, an imperative.
"""

from __future__ import annotations

from bgc.diagnostics.row import Values, error, info, warning
from bgc.diagnostics.words import (
    counted,
    did_you_mean,
    either,
    listed,
    nearest,
    quoted,
    respelt,
    underlined,
    with_article,
)

__all__ = [
    "Values",
    "counted",
    "did_you_mean",
    "either",
    "error",
    "info",
    "listed",
    "nearest",
    "quoted",
    "respelt",
    "underlined",
    "warning",
    "with_article",
]
