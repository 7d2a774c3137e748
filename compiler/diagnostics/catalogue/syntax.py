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
    """BG101: unexpected text

    What: the text does not continue as the grammar requires; the message lists the possible
    continuations.
    Why: every statement has a fixed form.
    Example: `param = 2 ohm;`
    Way out: write one of the listed forms: `param R = 2 ohm;`.
    """
    wanted = _either(expected)
    message = f"expected {wanted} after {after}" if after else f"expected {wanted}"
    return error("BG101", f"{message}, found {found}", span, help=form)


def missing_semicolon(span: Span, after: str) -> Diagnostic:
    """BG102: a `;` is missing

    What: a statement does not end with `;`.
    Why: line ends have no meaning in the language; only `;` or `}` ends a statement.
    Example: `param R = 2 ohm`
    Way out: write `param R = 2 ohm;`.
    """
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
    """BG103: a bracket that is not closed

    What: a `(` or `[` is still open where the statement ends or another bracket closes.
    Why: it is not clear where the contents of the bracket end.
    Example: `coil : I(3;`
    Way out: write `coil : I(3);`.
    """
    return error(
        "BG103",
        f"expected `{closer}`, found {found}",
        span,
        labels=(Label(opened, f"this `{opened.text}` is not closed"),),
        help=help or f"close it with `{closer}`",
        edits=[] if help else [Edit(Span(span.source, span.start, span.start), closer)],
    )


def unmatched_closer(span: Span) -> Diagnostic:
    """BG104: an unmatched closing bracket

    What: a `)`, `]` or `}` has no matching `(`, `[` or `{` before it.
    Why: usually one is closed twice, or the opening bracket is missing.
    Example: `model A { } }`
    Way out: remove it, or write the opening bracket.
    """
    return error(
        "BG104",
        f"this `{span.text}` has no matching opening bracket",
        span,
        help="remove it, or write the opening bracket",
        edits=[Edit(span, "")],
    )


def unclosed_block(span: Span, opened: Span, found: str) -> Diagnostic:
    """BG105: a block that is not closed

    What: a `{` is still open at the end of the file, or where the next model or scene begins.
    Why: models are declared one after another, never inside each other.
    Example: `model A { param k = 1; model B { }`
    Way out: write `model A { param k = 1; } model B { }`.
    """
    return error(
        "BG105",
        f"expected `}}` before {found}",
        span,
        labels=(Label(opened, "this block is not closed"),),
        help="close it with `}`",
    )


def misspelt_number(span: Span, message: str, help: str) -> Diagnostic:
    """BG106: a misspelt number or unit

    What: a number has the form `1`, `.5`, `1.5` or `1e-3`. A unit follows after exactly one blank
    and contains none: `8 t`, `2 kg*m/s`, `10 s^-1`.
    Why: the blanks separate units from values: `3 m * l` is 3 m times `l`, and in `3 m*l` the unit
    would be `m*l`.
    Example: `5V`, `2x`, `3 kN.m`, `10 /s`, `1.`
    Way out: write `5 V`, `2*x`, `3 kN*m`, `10 s^-1`, `1`.
    """
    return error("BG106", message, span, help=help)


def unknown_character(span: Span, shown: str, help: str) -> Diagnostic:
    """BG107: a character that the language does not use

    What: only ASCII letters, digits, `_` and the operators of the language may appear outside
    comments and quoted texts.
    Why: names are used in C code and as column names in tables.
    Example: `param ω = 3;`
    Way out: write `param omega = 3;`.
    """
    return error(
        "BG107",
        f"the character {shown} has no meaning here",
        span,
        help=help or "use only a to z, A to Z, 0 to 9 and `_` in names",
    )


_SPELT = {"&&": "and", "||": "or", "**": "^", "==": "=", "<>": "!=", "~=": "!=", ":=": "="}


def foreign_operator(span: Span, help: str) -> Diagnostic:
    """BG108: an operator of another language

    What: the operator comes from another language and is spelt differently here.
    Why: each operator has one spelling.
    Example: `x**2`, `a && b`, `!a`
    Way out: write `x^2`, `a and b`, `not a`.
    """
    spelt = _SPELT.get(span.text)
    edits = [Edit(span, spelt)] if spelt else []
    return error("BG108", f"there is no operator `{span.text}`", span, help=help, edits=edits)


def transposition_mark(span: Span, name: str, derived: bool) -> Diagnostic:
    """BG109: a matrix transposed, or a derivative marked, with a quote mark

    What: `'` neither transposes a matrix nor marks a derivative; `transpose` and `der` do.
    Why: the mark is easily overlooked in a formula.
    Example: `J'*F`
    Way out: write `transpose(J)*F`, and `der(x) = -x;` for `x' = -x;`.
    """
    instead = f"der({name})" if derived else f"transpose({name})"
    fault = "does not mark a derivative" if derived else "does not transpose a matrix"
    whole = Span(span.source, span.start - len(name), span.end)
    edits = [Edit(whole, instead)] if whole.text == f"{name}'" else []
    return error("BG109", f"`'` {fault}", span, help=f"write `{instead}`", edits=edits)


def unclosed_comment(span: Span) -> Diagnostic:
    """BG110: a comment that is not closed

    What: a `/*` has no matching `*/`.
    Why: the rest of the file would be a comment.
    Example: `/* the boom`
    Way out: write `/* the boom */`, or `// the boom` for the rest of a line.
    """
    return error("BG110", "this comment is not closed", span, help="close it with `*/`")


def unclosed_text(span: Span) -> Diagnostic:
    """BG111: a quoted text that is not closed

    What: a `"` has no closing `"` on its line.
    Why: a quoted text ends on the line where it begins.
    Example: `import "joints.bg;`
    Way out: write `import "joints.bg";`.
    """
    return error(
        "BG111",
        'expected a closing `"` on this line',
        span,
        help="close the text on the line where it begins",
    )


def reserved_word(span: Span, word: str) -> Diagnostic:
    """BG112: a word of the language as a name

    What: words such as `in`, `port` or `time` are reserved and cannot be names; `observe run solver
    device drive require deadline step` are reserved only in a scene.
    Why: the first word identifies a statement.
    Example: `param in = 3;`
    Way out: choose another name: `param inflow = 3;`.
    """
    return error(
        "BG112",
        f"`{word}` is a reserved word and cannot be a name",
        span,
        help=f"choose another name, such as `{word}_` or `{word}1`",
    )


def chained_comparison(span: Span) -> Diagnostic:
    """BG113: two comparisons in a row

    What: `a < b < c` does not compare three values.
    Why: it would compare the truth value of `a < b` with `c`.
    Example: `if 0 < x < 1 then ..`
    Way out: write `if 0 < x and x < 1 then ..`.
    """
    return error(
        "BG113",
        "comparisons cannot be chained",
        span,
        help="compare twice and join with `and`: `a < b and b < c`",
    )


def missing_operator(
    span: Span, before: str, found: str, unit: str = "", instead: str = ""
) -> Diagnostic:
    """BG114: two values without an operator between

    What: a value directly follows another value.
    Why: multiplication is never implicit: `k x` might be a misspelt name.
    Example: `2 (a + b)`, `k x`
    Way out: write `2*(a + b)`, `k*x`. A unit after a number begins with a name: `40 m^-1`, not
    `40 1/m`.
    """
    return error(
        "BG114",
        f"expected an operator between {before} and {found}",
        span,
        help=instead
        or (f"write the unit as `{unit}`, or a product with `*`" if unit else "")
        or "write a product with `*`",
    )


def equals_in_condition(span: Span) -> Diagnostic:
    """BG115: `=` in a comparison

    What: `=` defines a value; `==` compares two values.
    Why: a typing error must not turn a comparison into a definition.
    Example: `if n = 3 { .. }`
    Way out: write `if n == 3 { .. }`.
    """
    edits = [Edit(span, "==")] if span.text == "=" else []
    return error("BG115", "`=` does not compare", span, help="write `==`", edits=edits)


def misplaced_statement(span: Span, word: str, place: str) -> Diagnostic:
    """BG116: a statement in the wrong kind of block

    What: the statement belongs in another kind of block.
    Why: a model declares parts and equations; a scene names a model, its inputs and its observed
    quantities.
    Example: `model A { run 10 s; }`
    Way out: write `scene s of A { run 10 s; }`.
    """
    return error(
        "BG116", f"`{word}` does not belong here", span, help=f"move it: it belongs {place}"
    )


def unknown_statement(
    span: Span, word: str, near: str, form: str, known: Sequence[str]
) -> Diagnostic:
    """BG117: an unknown statement

    What: no statement begins with this word.
    Why: usually the word is misspelt, or comes from another language.
    Example: `parameter R = 2 ohm;`
    Way out: write `param R = 2 ohm;`.
    """
    message, edits = f"no statement begins with `{word}`", respelt(span, word, known)
    return error("BG117", message, span, help=near or form, edits=edits)


def too_deep(span: Span) -> Diagnostic:
    """BG118: text nested too deeply

    What: brackets, blocks, powers or `if` are nested more than about 200 deep.
    Why: the parser limits the depth to protect its memory. Sums and products may be of any length.
    Example: `((( .. x .. )))` in 300 brackets.
    Way out: name parts of the expression with `let`.
    """
    return error(
        "BG118",
        "this is nested too deeply",
        span,
        help="name parts of it with `let`",
    )


def number_out_of_range(span: Span) -> Diagnostic:
    """BG119: a number that is too large

    What: the number is larger than 1.8e308, or has more than 1,000 digits.
    Why: the compiled model computes in double precision.
    Example: `param k = 1e400;`
    Way out: write a smaller number. Do not model a rigid connection by an infinite stiffness.
    """
    return error("BG119", "this number is out of range", span, help="write a number below 1.8e308")


def long_line(span: Span, limit: int) -> Diagnostic:
    """BG120: a line that is too long

    What: a line has more than 100,000 characters.
    Why: such a file is most likely not a model, and a message about the line would be unreadable.
    Example: a data file in place of a model.
    Way out: give the right file, or break the line.
    """
    return error(
        "BG120", f"this line is longer than {limit:,} characters", span, help="break the line"
    )


def too_many_errors(span: Span, limit: int) -> Diagnostic:
    """BG121: too many errors

    What: after 50 errors no further errors are reported.
    Why: most of them would follow from others, or the file is not a model.
    Example: a text in another language.
    Way out: correct the first errors and try again.
    """
    return error(
        "BG121",
        f"there are more than {limit} errors; the others are not shown",
        span,
        help="correct the first ones and try again",
    )


def late_import(span: Span) -> Diagnostic:
    """BG122: an import after a declaration

    What: imports must come before all declarations of a file.
    Why: the dependencies of a file are listed at its top.
    Example: `model A { } import "b.bg";`
    Way out: move the import to the top.
    """
    return error(
        "BG122",
        "this import comes after a declaration",
        span,
        help="move it to the top of the file",
    )


def name_of_part(span: Span, name: str) -> Diagnostic:
    """BG123: a part name with a dot

    What: a part is declared as `name : Type;` or `name[i] : Type;`.
    Why: a part belongs to the model that declares it, not to another part.
    Example: `crane.hook : I(3 t);`
    Way out: write `hook : I(3 t);`.
    """
    return error(
        "BG123",
        "a part must be declared with a plain name",
        span,
        help=f"write `{name} : Type;` or `{name}[i] : Type;`",
    )


def slot_with_law(span: Span, name: str) -> Diagnostic:
    """BG124: a slot with a law

    What: a part with `= Type(..)` after its type is a slot, and a slot has no law.
    Why: the model in the slot has its own laws.
    Example: `lock : Lock[5] = R { e = f; }`
    Way out: put the law into a model, and name that model as the slot's default.
    """
    return error(
        "BG124",
        f"the slot `{name}` cannot have a law",
        span,
        help="put the law into a model, and name that model as the slot's default",
    )


def list_within_chain(span: Span) -> Diagnostic:
    """BG125: a list between two arrows

    What: only the first and the last item of a chain of bonds may be a list.
    Why: `a -> b, c -> d` could mean two bonds or four.
    Example: `a -> b, c -> d;`
    Way out: write `a -> b, c; b, c -> d;`.
    """
    return error(
        "BG125",
        "only the ends of a chain may be lists",
        span,
        help="write two chains: one that ends with the list, one that begins with it",
    )


def empty_vector(span: Span) -> Diagnostic:
    """BG126: a vector without components

    What: `[]` has no components.
    Why: every value has a fixed number of components, at least one.
    Example: `let v = [];`
    Way out: write `let v = [0, 0, 0];`, or omit the argument.
    """
    return error(
        "BG126",
        "a vector must have at least one component",
        span,
        help="write its components: `[0, 0]`",
    )


def not_callable(span: Span, product: str = "") -> Diagnostic:
    """BG127: parentheses after something that is not a function

    What: only a function's plain name can be called: `sin(x)`.
    Why: multiplication is never implicit, so `2(x + 1)` is not a product. A unit extends to the
    next blank, so in `10 V*sin(x)` the unit would be volts times `sin`.
    Example: `2(x + 1)`, `a.b(3)`, `10 V*sin(x)`
    Way out: write `2*(x + 1)`, `10 V * sin(x)`.
    """
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
    """BG128: `der` without a single state

    What: `der` takes exactly one state, in parentheses: `der(x)`.
    Why: it is the time derivative of that state.
    Example: `der x = v;`, `der(x, y)`
    Way out: write `der(x) = v;`.
    """
    return error("BG128", "`der` takes one state", span, help="write `der(x)`")


def default_of_function(span: Span, name: str) -> Diagnostic:
    """BG129: a default in a function

    What: an argument of a function has a default.
    Why: a function is called with all its arguments, by position.
    Example: `function gain(x, k = 2) = k*x;`
    Way out: write `function gain(x, k) = k*x;`.
    """
    return error(
        "BG129",
        f"the argument `{name}` cannot have a default",
        span,
        help="give the value where the function is called",
    )


def range_of_widths(span: Span) -> Diagnostic:
    """BG130: a range where one number is meant

    What: `first..last` selects components of a value; it is not a width and does not declare parts.
    Why: parts are declared one by one, or in a `for`.
    Example: `mass[1..3] : I(m);`
    Way out: write `for i in 1..3 { mass[i] : I(m); }`.
    """
    return error(
        "BG130",
        "a range is not allowed here",
        span,
        help="declare several parts in a loop: `for i in 1..3 { .. }`",
    )


def empty_statement(span: Span) -> Diagnostic:
    """BG131: a `;` without a statement

    What: there is no statement before this `;`.
    Why: a block ends with its `}`; only the block of a law may be followed by `;`.
    Example: `model A { };`
    Way out: write `model A { }`.
    """
    return error("BG131", "this `;` has no statement before it", span, help="remove it")


def part_of_literal(span: Span, literal: str) -> Diagnostic:
    """BG132: a component of a single value

    What: a `.name` or an index follows a number, a text or `time`.
    Why: these have no components. After a number it may be a misspelt decimal point.
    Example: `3 .x`, `time[1]`
    Way out: remove it.
    """
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
