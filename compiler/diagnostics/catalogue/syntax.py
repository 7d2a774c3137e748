"""Diagnostics: syntax."""

from __future__ import annotations

import re
from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, respelt
from bgc.diagnostics.diagnostic import Edit
from bgc.diagnostics.source import Span


@error("BG101: expected {wanted}{place}, found {found}", "{form}")
def unexpected(span: Span, found: str, expected: Sequence[str], after: str, form: str) -> Values:
    return {"wanted": _either(expected), "place": f" after {after}" if after else ""}


@error("BG102: expected `;` after {after}", "end the statement with `;`")
def missing_semicolon(span: Span, after: str) -> Values:
    return {"edits": [Edit(Span(span.source, span.start, span.start), ";")]}


@error(
    "BG103: expected `{closer}`, found {found}",
    "close it with `{closer}`",
    labels={"opened": "this `{bracket}` is not closed"},
)
def unclosed_bracket(span: Span, opened: Span, closer: str, found: str, help: str = "") -> Values:
    edits = [] if help else [Edit(Span(span.source, span.start, span.start), closer)]
    return {"bracket": opened.text, "edits": edits}


@error(
    "BG104: this `{text}` has no matching opening bracket",
    "remove it, or write the opening bracket",
)
def unmatched_closer(span: Span) -> Values:
    return {"text": span.text, "edits": [Edit(span, "")]}


@error(
    "BG105: expected `}` before {found}",
    "close it with `}`",
    labels={"opened": "this block is not closed"},
)
def unclosed_block(span: Span, opened: Span, found: str) -> None: ...
@error("BG106: {message}")
def misspelt_number(span: Span, message: str, help: str) -> None: ...
@error(
    "BG107: the character {shown} has no meaning here",
    "use only a to z, A to Z, 0 to 9 and `_` in names",
)
def unknown_character(span: Span, shown: str, help: str) -> None: ...


_SPELT = {"&&": "and", "||": "or", "**": "^", "==": "=", "<>": "!=", "~=": "!=", ":=": "="}


@error("BG108: there is no operator `{text}`")
def foreign_operator(span: Span, help: str) -> Values:
    spelt = _SPELT.get(span.text)
    return {"text": span.text, "edits": [Edit(span, spelt)] if spelt else []}


@error("BG109: `'` {fault}", "write `{instead}`")
def transposition_mark(span: Span, name: str, derived: bool) -> Values:
    instead = f"der({name})" if derived else f"transpose({name})"
    fault = "does not mark a derivative" if derived else "does not transpose a matrix"
    whole = Span(span.source, span.start - len(name), span.end)
    return {
        "fault": fault,
        "instead": instead,
        "edits": [Edit(whole, instead)] if whole.text == f"{name}'" else [],
    }


@error("BG110: this comment is not closed", "close it with `*/`")
def unclosed_comment(span: Span) -> None: ...
@error('BG111: expected a closing `"` on this line', "close the text on the line where it begins")
def unclosed_text(span: Span) -> None: ...
@error(
    "BG112: `{word}` is a reserved word and cannot be a name",
    "choose another name, such as `{word}_` or `{word}1`",
)
def reserved_word(span: Span, word: str) -> None: ...
@error(
    "BG113: comparisons cannot be chained", "compare twice and join with `and`: `a < b and b < c`"
)
def chained_comparison(span: Span) -> None: ...
@error("BG114: expected an operator between {before} and {found}", "write a product with `*`")
def missing_operator(
    span: Span, before: str, found: str, unit: str = "", instead: str = ""
) -> Values:
    return {
        "help": instead or (f"write the unit as `{unit}`, or a product with `*`" if unit else "")
    }


@error("BG115: `=` does not compare", "write `==`")
def equals_in_condition(span: Span) -> Values:
    return {"edits": [Edit(span, "==")] if span.text == "=" else []}


@error("BG116: `{word}` does not belong here", "move it: it belongs {place}")
def misplaced_statement(span: Span, word: str, place: str) -> None: ...
@error("BG117: no statement begins with `{word}`", "{form}")
def unknown_statement(span: Span, word: str, near: str, form: str, known: Sequence[str]) -> Values:
    return {"help": near, "edits": respelt(span, word, known)}


@error("BG118: this is nested too deeply", "name parts of it with `let`")
def too_deep(span: Span) -> None: ...
@error("BG119: this number is out of range", "write a number below 1.8e308")
def number_out_of_range(span: Span) -> None: ...
@error("BG120: this line is longer than {limit:,} characters", "break the line")
def long_line(span: Span, limit: int) -> None: ...
@error(
    "BG121: there are more than {limit} errors; the others are not shown",
    "correct the first ones and try again",
)
def too_many_errors(span: Span, limit: int) -> None: ...
@error("BG122: this import comes after a declaration", "move it to the top of the file")
def late_import(span: Span) -> None: ...
@error(
    "BG123: a part must be declared with a plain name",
    "write `{name} : Type;` or `{name}[i] : Type;`",
)
def name_of_part(span: Span, name: str) -> None: ...
@error(
    "BG124: the slot `{name}` cannot have a law",
    "put the law into a model, and name that model as the slot's default",
)
def slot_with_law(span: Span, name: str) -> None: ...
@error(
    "BG125: only the ends of a chain may be lists",
    "write two chains: one that ends with the list, one that begins with it",
)
def list_within_chain(span: Span) -> None: ...
@error("BG126: a vector must have at least one component", "write its components: `[0, 0]`")
def empty_vector(span: Span) -> None: ...
@error(
    "BG127: `{text}` cannot be called",
    "write a product with `*`; call a function by its plain name",
)
def not_callable(span: Span, product: str = "") -> Values:
    text = _clipped(span.text)
    if product:
        way_out = f"a unit ends at a blank: write `{product}(..)`"
        return {"text": text, "help": way_out, "edits": [Edit(span, product)]}
    *_, plain = span.text.split(".")
    named = plain != span.text and plain.isidentifier()
    return {
        "text": text,
        "help": f"call a function by its plain name: `{plain}(..)`" if named else "",
    }


@error("BG128: `der` takes one state", "write `der(x)`")
def derivative_of_nothing(span: Span) -> None: ...
@error(
    "BG129: the argument `{name}` cannot have a default",
    "give the value where the function is called",
)
def default_of_function(span: Span, name: str) -> None: ...
@error(
    "BG130: a range is not allowed here", "declare several parts in a loop: `for i in 1..3 { .. }`"
)
def range_of_widths(span: Span) -> None: ...
@error("BG131: this `;` has no statement before it", "remove it")
def empty_statement(span: Span) -> None: ...
@error("BG132: `{shown}` has no components")
def part_of_literal(span: Span, literal: str) -> Values:
    unit = re.fullmatch(r"\[\s*([A-Za-z][\w*/^-]*)\s*\]", span.text)
    return {
        "shown": _clipped(literal),
        "help": f"write a unit behind its number: `{literal} {unit[1]}`" if unit else "remove this",
    }


def _either(words: Sequence[str]) -> str:
    """Join words: `a`, `a or b`, `a, b or c`."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} or {words[-1]}"


def _clipped(text: str) -> str:
    """Return the start of a text on one line."""
    line = " ".join(text[:60].split())
    return line if len(text) <= 40 else f"{line[:37]}..."
