"""BG100-BG199: what cannot be read as the language."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def unexpected(
    span: Span, found: str, expected: Sequence[str], after: str, form: str
) -> Diagnostic:
    """BG101: something else was expected here

    What: the text cannot go on as it does; the message says what may stand in its place.
    Why: every statement has a fixed form, so that a slip is found where it was made.
    Example: `param = 2 ohm;`
    Way out: write what is expected: `param R = 2 ohm;`.
    """
    wanted = _either(expected)
    message = f"expected {wanted} after {after}" if after else f"expected {wanted}"
    return error("BG101", f"{message}, found {found}", span, help=form)


def missing_semicolon(span: Span, after: str) -> Diagnostic:
    """BG102: a `;` is missing

    What: a statement ends without its `;`.
    Why: line ends mean nothing in the language, only a `;` or a `}` ends a statement.
    Example: `param R = 2 ohm`
    Way out: `param R = 2 ohm;`
    """
    return error("BG102", f"expected `;` after {after}", span, help="end the statement with `;`")


def unclosed_bracket(span: Span, opened: Span, closer: str, found: str) -> Diagnostic:
    """BG103: a bracket that is not closed

    What: a `(` or `[` is open where the statement ends or another bracket closes.
    Why: without it, what belongs together is a guess.
    Example: `coil : I(3;`
    Way out: `coil : I(3);`
    """
    return error(
        "BG103",
        f"expected `{closer}`, found {found}",
        span,
        labels=(Label(opened, f"this `{opened.text}` is not closed"),),
        help=f"close it with `{closer}`",
    )


def unmatched_closer(span: Span) -> Diagnostic:
    """BG104: a bracket or brace that closes nothing

    What: there is a `)`, `]` or `}` that no `(`, `[` or `{` before it belongs to.
    Why: usually one was closed twice, or the opening one was lost.
    Example: `model A { } }`
    Way out: remove it, or write the one it should close.
    """
    return error(
        "BG104",
        f"this `{span.text}` closes nothing",
        span,
        help="remove it, or write the one that it should close",
    )


def unclosed_block(span: Span, opened: Span, found: str) -> Diagnostic:
    """BG105: a block that is not closed

    What: a `{` is still open at the end of the file, or where the next model or scene begins.
    Why: models stand side by side in a file, never within each other.
    Example: `model A { param k = 1; model B { }`
    Way out: `model A { param k = 1; } model B { }`
    """
    return error(
        "BG105",
        f"expected `}}` before {found}",
        span,
        labels=(Label(opened, "this block is not closed"),),
        help="close it with `}`",
    )


def misspelt_number(span: Span, message: str, help: str) -> Diagnostic:
    """BG106: a number or its unit is not spelt as it must be

    What: a number is `1`, `.5`, `1.5` or `1e-3`; a unit follows after exactly one blank and has
    none inside: `8 t`, `2 kg*m/s`, `10 s^-1`.
    Why: `3 m * l` is a product of a length and `l`, and `3 m*l` would be a unit; the blanks
    tell them apart.
    Example: `5V`, `2x`, `3 kN.m`, `10 /s`, `1.`
    Way out: `5 V`, `2*x`, `3 kN*m`, `10 s^-1`, `1`
    """
    return error("BG106", message, span, help=help)


def unknown_character(span: Span, shown: str, help: str) -> Diagnostic:
    """BG107: a character the language does not use

    What: outside of comments and quoted texts only the ASCII letters, digits, `_` and
    the signs of the language occur.
    Why: names end up in C code and in the columns of tables.
    Example: `param ω = 3;`
    Way out: `param omega = 3;`
    """
    return error(
        "BG107",
        f"the character {shown} has no meaning here",
        span,
        help=help or "names are made of a to z, A to Z, 0 to 9 and `_`",
    )


def foreign_operator(span: Span, help: str) -> Diagnostic:
    """BG108: an operator of another language

    What: the sign is known from another language and is written otherwise here.
    Why: there is one spelling of each operator.
    Example: `x**2`, `a && b`, `!a`
    Way out: `x^2`, `a and b`, `not a`
    """
    return error("BG108", f"there is no operator `{span.text}`", span, help=help)


def transposition_mark(span: Span, matrix: str) -> Diagnostic:
    """BG109: a matrix transposed by a mark

    What: `'` does not transpose; `transpose` does.
    Why: the mark is too easily lost in a formula, and quotes hold texts.
    Example: `J'*F`
    Way out: `transpose(J)*F`
    """
    return error(
        "BG109", "a matrix is not transposed by `'`", span, help=f"write `transpose({matrix})`"
    )


def unclosed_comment(span: Span) -> Diagnostic:
    """BG110: a comment that is not closed

    What: a `/*` has no `*/` after it.
    Why: everything to the end of the file would be comment.
    Example: `/* the boom`
    Way out: `/* the boom */`, or `// the boom` up to the end of the line.
    """
    return error("BG110", "this comment is not closed", span, help="close it with `*/`")


def unclosed_text(span: Span) -> Diagnostic:
    """BG111: a quoted text that is not closed

    What: a `"` has no second one on its line.
    Why: a text ends on the line it begins on.
    Example: `import "joints.bg;`
    Way out: `import "joints.bg";`
    """
    return error(
        "BG111", 'expected a closing `"` on this line', span, help="a text ends on its line"
    )


def reserved_word(span: Span, word: str) -> Diagnostic:
    """BG112: a word of the language as a name

    What: words such as `in`, `port` or `time` have a meaning of their own and name nothing
    else; `observe run solver device drive require deadline step` are reserved in a scene only.
    Why: a statement is known by its first word.
    Example: `param in = 3;`
    Way out: another name: `param inflow = 3;`.
    """
    return error(
        "BG112",
        f"`{word}` is a word of the language and cannot be a name",
        span,
        help=f"choose another name, such as `{word}_` or `{word}1`",
    )


def chained_comparison(span: Span) -> Diagnostic:
    """BG113: two comparisons in a row

    What: `a < b < c` is not a comparison of three values.
    Why: read from the left it would compare a truth value with `c`.
    Example: `if 0 < x < 1 then ..`
    Way out: `if 0 < x and x < 1 then ..`
    """
    return error(
        "BG113",
        "comparisons cannot be chained",
        span,
        help="compare twice and join with `and`: `a < b and b < c`",
    )


def missing_operator(span: Span, before: str, found: str) -> Diagnostic:
    """BG114: two values without an operator between

    What: a value follows another directly.
    Why: there is no implicit multiplication: `k x` might be a slip for one name.
    Example: `2 (a + b)`, `k x`
    Way out: `2*(a + b)`, `k*x`
    """
    return error(
        "BG114",
        f"expected an operator between {before} and {found}",
        span,
        help="a product is written with `*`",
    )


def equals_in_condition(span: Span) -> Diagnostic:
    """BG115: `=` where two values are compared

    What: `=` defines; `==` compares.
    Why: the one must not be taken for the other.
    Example: `if n = 3 { .. }`
    Way out: `if n == 3 { .. }`
    """
    return error("BG115", "`=` does not compare", span, help="write `==`")


def misplaced_statement(span: Span, word: str, place: str) -> Diagnostic:
    """BG116: a statement in the wrong kind of block

    What: the statement belongs in another kind of block.
    Why: a model says what there is; a scene says which model, driven and observed how.
    Example: `model A { run 10 s; }`
    Way out: `scene s of A { run 10 s; }`
    """
    return error("BG116", f"`{word}` does not belong here", span, help=f"it stands {place}")


def unknown_statement(span: Span, word: str, near: str, form: str) -> Diagnostic:
    """BG117: a statement that begins with no known word

    What: the first word is none of those a statement begins with.
    Why: usually it is misspelt, or taken from another language.
    Example: `parameter R = 2 ohm;`
    Way out: `param R = 2 ohm;`
    """
    return error("BG117", f"no statement begins with `{word}`", span, help=near or form)


def too_deep(span: Span) -> Diagnostic:
    """BG118: nested too deep

    What: brackets, blocks or operators are nested more than some 200 deep.
    Why: a computer can write such a text, but nobody can read it.
    Example: a sum of 300 terms written with `+`
    Way out: name parts of it with `let`, or use `sum([a, b, c])`.
    """
    return error(
        "BG118",
        "this is nested too deep",
        span,
        help="name parts of it with `let`; a long sum is `sum([a, b, c])`",
    )


def number_out_of_range(span: Span) -> Diagnostic:
    """BG119: a number that no machine number can hold

    What: the number is larger than 1.8e308, or has more than 1,000 digits.
    Why: the compiled model computes in double precision.
    Example: `param k = 1e400;`
    Way out: a smaller number; a rigid connection is not an infinite stiffness.
    """
    return error("BG119", "this number is out of range", span, help="the largest is 1.8e308")


def long_line(span: Span, limit: int) -> Diagnostic:
    """BG120: a line that is too long

    What: a line has more than 100,000 characters.
    Why: it is most likely not a model, and no message about it could be read.
    Example: a data file given in place of a model
    Way out: give the right file, or break the line.
    """
    return error(
        "BG120", f"this line is longer than {limit:,} characters", span, help="break the line"
    )


def too_many_errors(span: Span, limit: int) -> Diagnostic:
    """BG121: too many errors

    What: from here on errors are not reported any more: there were 50 before.
    Why: by then most of them follow from others, or the file is not a model.
    Example: a text in another language
    Way out: correct the first ones and try again.
    """
    return error(
        "BG121",
        f"there are more than {limit} errors; the others are not shown",
        span,
        help="correct the first ones and try again",
    )


def late_import(span: Span) -> Diagnostic:
    """BG122: an import after a declaration

    What: imports stand before everything else of a file.
    Why: what a file depends on is seen at its top.
    Example: `model A { } import "b.bg";`
    Way out: move the import to the top.
    """
    return error("BG122", "imports stand at the top of the file", span, help="move it up")


def name_of_part(span: Span, name: str) -> Diagnostic:
    """BG123: a part's name that is not a plain one

    What: a part is declared as `name : Type;` or `name[i] : Type;`.
    Why: a part belongs to the model it is declared in, not to another part.
    Example: `crane.hook : I(3 t);`
    Way out: `hook : I(3 t);`
    """
    return error(
        "BG123",
        "a part is declared with a plain name",
        span,
        help=f"write `{name} : Type;` or `{name}[i] : Type;`",
    )


def slot_with_law(span: Span, name: str) -> Diagnostic:
    """BG124: a slot with a law

    What: a part with `= Type(..)` after its type is a slot, and a slot has no law.
    Why: what fills the slot brings its own laws.
    Example: `lock : Lock[5] = R { e = f; }`
    Way out: a model with the law within, as the slot's default.
    """
    return error(
        "BG124",
        f"the slot `{name}` cannot have a law",
        span,
        help="put the law into a model, and name that as the default of the slot",
    )


def list_within_chain(span: Span) -> Diagnostic:
    """BG125: a list between two arrows

    What: only the first and the last stop of a chain of bonds may be lists.
    Why: `a -> b, c -> d` may mean two bonds or four.
    Example: `a -> b, c -> d;`
    Way out: `a -> b, c; b, c -> d;`
    """
    return error(
        "BG125",
        "a list may stand only at an end of a chain",
        span,
        help="write two chains: one that ends with the list, one that begins with it",
    )


def empty_vector(span: Span) -> Diagnostic:
    """BG126: a vector without components

    What: `[]` has no width.
    Why: every value has a fixed number of components, one at least.
    Example: `let v = [];`
    Way out: `let v = [0, 0, 0];`, or leave the argument out.
    """
    return error(
        "BG126", "a vector has at least one component", span, help="write its components: `[0, 0]`"
    )


def not_callable(span: Span, product: str = "") -> Diagnostic:
    """BG127: parentheses behind something that is not a function's name

    What: only a plain name can be called: `sin(x)`.
    Why: there is no implicit multiplication, so `2(x + 1)` is no product; and a unit goes on to
    the next blank, so that `10 V*sin(x)` would be in volts times `sin`.
    Example: `2(x + 1)`, `a.b(3)`, `10 V*sin(x)`
    Way out: `2*(x + 1)`, `10 V * sin(x)`
    """
    way_out = (
        f"a unit ends at a blank: write `{product}(..)`"
        if product
        else "a product is written with `*`; a function is called by its plain name"
    )
    return error(
        "BG127",
        f"`{_clipped(span.text)}` cannot be called",
        span,
        help=way_out,
    )


def derivative_of_nothing(span: Span) -> Diagnostic:
    """BG128: `der` without its one state

    What: `der` is written as `der(x)`, of one state.
    Why: it stands for the state's derivative with respect to time.
    Example: `der x = v;`, `der(x, y)`
    Way out: `der(x) = v;`
    """
    return error("BG128", "`der` takes one state", span, help="write `der(x)`")


def default_of_function(span: Span, name: str) -> Diagnostic:
    """BG129: an argument of a function with a default

    What: the arguments of a function have no defaults.
    Why: a function is called with all its arguments, by position.
    Example: `function gain(x, k = 2) = k*x;`
    Way out: `function gain(x, k) = k*x;`
    """
    return error(
        "BG129",
        f"the argument `{name}` cannot have a default",
        span,
        help="give the value where the function is called",
    )


def range_of_widths(span: Span) -> Diagnostic:
    """BG130: a range where one number is meant

    What: `first..last` picks components of what there is; it is no width and declares nothing.
    Why: parts are declared one by one, in a `for` when they are many.
    Example: `mass[1..3] : I(m);`
    Way out: `for i in 1..3 { mass[i] : I(m); }`
    """
    return error(
        "BG130",
        "a range cannot stand here",
        span,
        help="many parts are declared in a loop: `for i in 1..3 { .. }`",
    )


def empty_statement(span: Span) -> Diagnostic:
    """BG131: a `;` without a statement

    What: there is nothing between this `;` and what ends before it.
    Why: a block ends with its `}`; only a law's may be followed by a `;`.
    Example: `model A { };`
    Way out: `model A { }`
    """
    return error("BG131", "this `;` ends nothing", span, help="remove it")


def part_of_literal(span: Span, literal: str) -> Diagnostic:
    """BG132: a component or member of a single value

    What: a `.name` or an index stands behind a number, a text or `time`.
    Why: these have no components; after a number it may be a misspelt decimal point.
    Example: `3 .x`, `time[1]`
    Way out: remove it.
    """
    return error("BG132", f"`{_clipped(literal)}` has no parts", span, help="remove this")


def _either(words: Sequence[str]) -> str:
    """`a`, `a or b`, `a, b or c`."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} or {words[-1]}"


def _clipped(text: str) -> str:
    """The start of a text, on one line."""
    line = " ".join(text[:60].split())
    return line if len(text) <= 40 else f"{line[:37]}..."
