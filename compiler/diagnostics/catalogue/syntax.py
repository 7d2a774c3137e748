"""BG100-BG199: syntax errors."""

from __future__ import annotations

import re
from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, respelt
from bgc.diagnostics.diagnostic import Diagnostic, Edit, Label
from bgc.diagnostics.source import Span


def unexpected(
    span: Span, found: str, expected: Sequence[str], after: str, form: str
) -> Diagnostic:
    """BG101: unexpected text"""
    wanted = _either(expected)
    message = f"expected {wanted} after {after}" if after else f"expected {wanted}"
    return error("BG101", f"{message}, found {found}", span, help=form)


def missing_semicolon(span: Span, after: str) -> Diagnostic:
    """BG102: a `;` is missing"""
    return error(
        "BG102",
        f"expected `;` after {after}",
        span,
        help="end the statement with `;`",
        edits=[Edit(Span(span.source, span.start, span.start), ";")],
    )


def unclosed_bracket(
    span: Span, opened: Span, closer: str, found: str, help: str = ""
) -> Diagnostic:
    """BG103: a bracket that is not closed"""
    return error(
        "BG103",
        f"expected `{closer}`, found {found}",
        span,
        labels=(Label(opened, f"this `{opened.text}` is not closed"),),
        help=help or f"close it with `{closer}`",
        edits=[] if help else [Edit(Span(span.source, span.start, span.start), closer)],
    )


def unmatched_closer(span: Span) -> Diagnostic:
    """BG104: an unmatched closing bracket"""
    return error(
        "BG104",
        f"this `{span.text}` has no matching opening bracket",
        span,
        help="remove it, or write the opening bracket",
        edits=[Edit(span, "")],
    )


def unclosed_block(span: Span, opened: Span, found: str) -> Diagnostic:
    """BG105: a block that is not closed"""
    return error(
        "BG105",
        f"expected `}}` before {found}",
        span,
        labels=(Label(opened, "this block is not closed"),),
        help="close it with `}`",
    )


def misspelt_number(span: Span, message: str, help: str) -> Diagnostic:
    """BG106: a misspelt number or unit"""
    return error("BG106", message, span, help=help)


def unknown_character(span: Span, shown: str, help: str) -> Diagnostic:
    """BG107: a character that the language does not use"""
    return error(
        "BG107",
        f"the character {shown} has no meaning here",
        span,
        help=help or "use only a to z, A to Z, 0 to 9 and `_` in names",
    )


_SPELT = {"&&": "and", "||": "or", "**": "^", "==": "=", "<>": "!=", "~=": "!=", ":=": "="}


def foreign_operator(span: Span, help: str) -> Diagnostic:
    """BG108: an operator of another language"""
    spelt = _SPELT.get(span.text)
    edits = [Edit(span, spelt)] if spelt else []
    return error("BG108", f"there is no operator `{span.text}`", span, help=help, edits=edits)


def transposition_mark(span: Span, name: str, derived: bool) -> Diagnostic:
    """BG109: a matrix transposed, or a derivative marked, with a quote mark"""
    instead = f"der({name})" if derived else f"transpose({name})"
    fault = "does not mark a derivative" if derived else "does not transpose a matrix"
    whole = Span(span.source, span.start - len(name), span.end)
    edits = [Edit(whole, instead)] if whole.text == f"{name}'" else []
    return error("BG109", f"`'` {fault}", span, help=f"write `{instead}`", edits=edits)


def unclosed_comment(span: Span) -> Diagnostic:
    """BG110: a comment that is not closed"""
    return error("BG110", "this comment is not closed", span, help="close it with `*/`")


def unclosed_text(span: Span) -> Diagnostic:
    """BG111: a quoted text that is not closed"""
    return error(
        "BG111",
        'expected a closing `"` on this line',
        span,
        help="close the text on the line where it begins",
    )


def reserved_word(span: Span, word: str) -> Diagnostic:
    """BG112: a word of the language as a name"""
    return error(
        "BG112",
        f"`{word}` is a reserved word and cannot be a name",
        span,
        help=f"choose another name, such as `{word}_` or `{word}1`",
    )


def chained_comparison(span: Span) -> Diagnostic:
    """BG113: two comparisons in a row"""
    return error(
        "BG113",
        "comparisons cannot be chained",
        span,
        help="compare twice and join with `and`: `a < b and b < c`",
    )


def missing_operator(
    span: Span, before: str, found: str, unit: str = "", instead: str = ""
) -> Diagnostic:
    """BG114: two values without an operator between"""
    return error(
        "BG114",
        f"expected an operator between {before} and {found}",
        span,
        help=instead
        or (f"write the unit as `{unit}`, or a product with `*`" if unit else "")
        or "write a product with `*`",
    )


def equals_in_condition(span: Span) -> Diagnostic:
    """BG115: `=` in a comparison"""
    edits = [Edit(span, "==")] if span.text == "=" else []
    return error("BG115", "`=` does not compare", span, help="write `==`", edits=edits)


def misplaced_statement(span: Span, word: str, place: str) -> Diagnostic:
    """BG116: a statement in the wrong kind of block"""
    return error(
        "BG116", f"`{word}` does not belong here", span, help=f"move it: it belongs {place}"
    )


def unknown_statement(
    span: Span, word: str, near: str, form: str, known: Sequence[str]
) -> Diagnostic:
    """BG117: an unknown statement"""
    message, edits = f"no statement begins with `{word}`", respelt(span, word, known)
    return error("BG117", message, span, help=near or form, edits=edits)


def too_deep(span: Span) -> Diagnostic:
    """BG118: text nested too deeply"""
    return error(
        "BG118",
        "this is nested too deeply",
        span,
        help="name parts of it with `let`",
    )


def number_out_of_range(span: Span) -> Diagnostic:
    """BG119: a number that is too large"""
    return error("BG119", "this number is out of range", span, help="write a number below 1.8e308")


def long_line(span: Span, limit: int) -> Diagnostic:
    """BG120: a line that is too long"""
    return error(
        "BG120", f"this line is longer than {limit:,} characters", span, help="break the line"
    )


def too_many_errors(span: Span, limit: int) -> Diagnostic:
    """BG121: too many errors"""
    return error(
        "BG121",
        f"there are more than {limit} errors; the others are not shown",
        span,
        help="correct the first ones and try again",
    )


def late_import(span: Span) -> Diagnostic:
    """BG122: an import after a declaration"""
    return error(
        "BG122",
        "this import comes after a declaration",
        span,
        help="move it to the top of the file",
    )


def name_of_part(span: Span, name: str) -> Diagnostic:
    """BG123: a part name with a dot"""
    return error(
        "BG123",
        "a part must be declared with a plain name",
        span,
        help=f"write `{name} : Type;` or `{name}[i] : Type;`",
    )


def slot_with_law(span: Span, name: str) -> Diagnostic:
    """BG124: a slot with a law"""
    return error(
        "BG124",
        f"the slot `{name}` cannot have a law",
        span,
        help="put the law into a model, and name that model as the slot's default",
    )


def list_within_chain(span: Span) -> Diagnostic:
    """BG125: a list between two arrows"""
    return error(
        "BG125",
        "only the ends of a chain may be lists",
        span,
        help="write two chains: one that ends with the list, one that begins with it",
    )


def empty_vector(span: Span) -> Diagnostic:
    """BG126: a vector without components"""
    return error(
        "BG126",
        "a vector must have at least one component",
        span,
        help="write its components: `[0, 0]`",
    )


def not_callable(span: Span, product: str = "") -> Diagnostic:
    """BG127: parentheses after something that is not a function"""
    *_, plain = span.text.split(".")
    way_out = (
        f"a unit ends at a blank: write `{product}(..)`"
        if product
        else f"call a function by its plain name: `{plain}(..)`"
        if plain != span.text and plain.isidentifier()
        else "write a product with `*`; call a function by its plain name"
    )
    return error(
        "BG127",
        f"`{_clipped(span.text)}` cannot be called",
        span,
        help=way_out,
        edits=(Edit(span, product),) if product else (),
    )


def derivative_of_nothing(span: Span) -> Diagnostic:
    """BG128: `der` without a single state"""
    return error("BG128", "`der` takes one state", span, help="write `der(x)`")


def default_of_function(span: Span, name: str) -> Diagnostic:
    """BG129: a default in a function"""
    return error(
        "BG129",
        f"the argument `{name}` cannot have a default",
        span,
        help="give the value where the function is called",
    )


def range_of_widths(span: Span) -> Diagnostic:
    """BG130: a range where one number is meant"""
    return error(
        "BG130",
        "a range is not allowed here",
        span,
        help="declare several parts in a loop: `for i in 1..3 { .. }`",
    )


def empty_statement(span: Span) -> Diagnostic:
    """BG131: a `;` without a statement"""
    return error("BG131", "this `;` has no statement before it", span, help="remove it")


def part_of_literal(span: Span, literal: str) -> Diagnostic:
    """BG132: a component of a single value"""
    unit = re.fullmatch(r"\[\s*([A-Za-z][\w*/^-]*)\s*\]", span.text)
    way_out = f"write a unit behind its number: `{literal} {unit[1]}`" if unit else "remove this"
    return error("BG132", f"`{_clipped(literal)}` has no components", span, help=way_out)


def _either(words: Sequence[str]) -> str:
    """Join words: `a`, `a or b`, `a, b or c`."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} or {words[-1]}"


def _clipped(text: str) -> str:
    """Return the start of a text on one line."""
    line = " ".join(text[:60].split())
    return line if len(text) <= 40 else f"{line[:37]}..."
