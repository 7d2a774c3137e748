"""Words for the texts of diagnostics: lists of names, articles, numbers with nouns, near names."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from bgc.diagnostics.diagnostic import Edit, Label
from bgc.diagnostics.source import Span

# Words, then numbers; shorter names of elements are spelled by their letters.
_AFTER_AN = re.compile(
    r"(?=\w*[a-z]{2})(?!(?i:uni|use|eu|one))[AEIOUaeiou]|8|1[18]\b|(?!\w*[a-z]{2})[AEFHILMNORSX]"
)
_COMPARED = 1_000  # candidates for a name that was misspelt
_UNDERLINED = 4  # labels shown at each end of a longer list


def listed(names: Sequence[str], limit: int = 8) -> str:
    """Join names: `a`, `b` and `c`; a long list is cut after `limit` names."""
    shown = [f"`{name}`" for name in names[:limit]]
    if len(names) > limit:
        return f"{', '.join(shown)} and {len(names) - limit} more"
    return " and ".join([", ".join(shown[:-1]), shown[-1]] if len(shown) > 1 else shown)


def quoted(names: Iterable[str]) -> str:
    """Join all names, each in backticks: `a`, `b`, `c`."""
    return ", ".join(f"`{name}`" for name in names)


def either(names: Sequence[str]) -> str:
    """Join alternatives, each in backticks: `a` or `b`."""
    return " or ".join(f"`{name}`" for name in names)


def counted(number: int, noun: str) -> str:
    """A number with its noun: `1 run`, `1,200 runs`."""
    return f"{number:,} {noun}" if number == 1 else f"{number:,} {noun}s"


def with_article(kind: str) -> str:
    """Put `a` or `an` before a kind, as spoken: `an Se`, `a C`, `an Arm`, `an 8 x 3 ..`."""
    return f"an {kind}" if _AFTER_AN.match(kind) else f"a {kind}"


def underlined(labels: Iterable[Label]) -> list[Label]:
    """Merge labels on the same place; keep the first and last ones of more than eight.

    Parts that share a declaration put several labels on one place; these become one label.
    """
    texts: dict[tuple[str, int, int], list[Label]] = {}
    for label in labels:
        place = (label.span.source.name, label.span.start, label.span.end)
        texts.setdefault(place, []).append(label)
    gathered = [_together(found) for found in texts.values()]
    if len(gathered) > 2 * _UNDERLINED:
        head, tail = gathered[:_UNDERLINED], gathered[-_UNDERLINED:]
        hidden = len(gathered) - 2 * _UNDERLINED
        head[-1] = Label(head[-1].span, f"{head[-1].text}; {hidden} more follow")
        gathered = head + tail
    return gathered


def _together(labels: Sequence[Label]) -> Label:
    different = list(dict.fromkeys(label.text for label in labels))
    more = f", and so on for {len(different) - 1} more" if len(different) > 2 else ""
    shown = different[:1] if more else different
    return Label(labels[0].span, "; ".join(shown) + more)


def did_you_mean(name: str, candidates: Iterable[str]) -> str:
    """Return a help text with up to three candidates close to `name`, or an empty text.

    The closest comes first; letter case is ignored.
    """
    near = _near(name, candidates)
    if not near:
        return ""
    *first, last = (f"`{candidate}`" for candidate in near)
    return f"did you mean {', '.join(first)} or {last}?" if first else f"did you mean {last}?"


def nearest(name: str, candidates: Iterable[str], span: Span | None = None) -> dict[str, Any]:
    """Return what a row needs to propose the candidates close to `name`.

    This is `help`, empty where there are none, and `edits` of a span that holds the name.
    """
    known = list(candidates)
    edits = [] if span is None else respelt(span, name, known)
    return {"help": did_you_mean(name, known), "edits": edits}


def respelt(span: Span, name: str, candidates: Iterable[str]) -> list[Edit]:
    """Return the edits that put the candidates of `did_you_mean` in the place of `name`.

    The name is the span, or stands at one of its ends, as in a path or an argument.
    """
    if span.text.endswith(name):
        place = Span(span.source, span.end - len(name), span.end)
    elif span.text.startswith(name):
        place = Span(span.source, span.start, span.start + len(name))
    else:
        return []
    return [Edit(place, candidate) for candidate in _near(name, candidates)]


def _near(name: str, candidates: Iterable[str]) -> list[str]:
    by_folded: dict[str, str] = {}
    for candidate in candidates:
        if candidate != name:
            by_folded.setdefault(candidate.casefold(), candidate)
    if len(by_folded) > _COMPARED:  # each comparison takes microseconds
        length, letter = len(name), name[:1].casefold()
        alike = [n for n in by_folded if n[:1] == letter and abs(len(n) - length) < 3]
        by_folded = {n: by_folded[n] for n in alike[:_COMPARED]}
    near = get_close_matches(name.casefold(), by_folded, n=3, cutoff=0.7)
    # Letters in another order leave little of a short name for the comparison: RCL for RLC.
    letters = sorted(name.casefold())
    anagrams = [n for n in by_folded if len(n) > 2 and n not in near and sorted(n) == letters]
    return [by_folded[folded] for folded in (*near, *anagrams)][:3]


FORMS: Mapping[str, Callable[[Any], str]] = {
    "listed": listed,
    "quoted": quoted,
    "either": either,
    "path": " -> ".join,
    "scene": lambda name: f"scene `{name}`" if name else "the model",
    "an": with_article,
}
"""The forms of values in the texts of rows, by name."""
