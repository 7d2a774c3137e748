"""BG3xx: units, functions and constants of expressions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, respelt
from bgc.diagnostics.diagnostic import Diagnostic, Edit, Label
from bgc.diagnostics.source import Span

# --- units ------------------------------------------------------------------------------


def unknown_unit(
    span: Span, text: str, suggestion: str, product: str = "", conversion: str = ""
) -> Diagnostic:
    """BG301: an unknown unit"""
    way_out = "write a unit such as `kg*m/s`, `s^-1` or `kN*m`"
    edits: list[Edit] = []
    if conversion:
        way_out = conversion
    elif product:
        instead = f"{span.text.removesuffix(text)}{product}"
        way_out = f"a unit ends at a blank: write `{instead}`"
        edits = [Edit(span, instead)] if span.text.endswith(text) else []
    elif suggestion:
        way_out = f"write `{suggestion}`"
        edits = [Edit(span, suggestion)] if span.text == text else []
    return error("BG301", f"`{text}` is not a unit", span, help=way_out, edits=edits)


def unit_with_parentheses(span: Span, spelled: str) -> Diagnostic:
    """BG268: a unit with parentheses"""
    return error(
        "BG268",
        "a unit has no parentheses",
        span,
        help=f"write `{spelled}`: each `/` divides by one word",
        edits=[Edit(span, spelled)],
    )


def cannot_combine(
    operator: str,
    context: str,
    left: tuple[Span, str],
    right: tuple[Span, str],
    component: str = "",
) -> Diagnostic:
    """BG303: quantities of different kinds"""
    one, two = left[1], right[1]
    match operator:
        case "+":
            message = f"cannot add {two} to {one}"
        case "-":
            message = f"cannot subtract {two} from {one}"
        case "<" | "<=" | ">" | ">=" | "==" | "!=":
            message = f"cannot compare {one} with {two}"
        case _:
            message = f"{one} and {two} are different kinds of quantity in {context}"
    return error(
        "BG303",
        message + (f", in component {component}" if component else ""),
        right[0],
        labels=(Label(left[0], one),),
        help="give both quantities units of the same kind",
    )


def needs_plain_number(span: Span, what: str, found: str) -> Diagnostic:
    """BG304: a quantity where a plain number belongs"""
    return error(
        "BG304",
        f"{what} must be a plain number or an angle, not {found}",
        span,
        help="divide it by a reference of the same kind",
    )


def needs_constant_exponent(span: Span, base: str) -> Diagnostic:
    """BG305: the unit of a power is not known"""
    return error(
        "BG305",
        f"the exponent of {base} must be a constant of at most 100",
        span,
        help="use a number, or divide the base by a reference of its kind to make it a plain "
        "number",
    )


def wrong_unit(span: Span, what: str, expected: str, found: str) -> Diagnostic:
    """BG306: a value of the wrong kind"""
    return error(
        "BG306",
        f"{what} must be {expected}, not {found}",
        span,
        help="give a value in a matching unit; a number without a unit is taken in SI units",
    )


def mixed_terms(span: Span, one: str, two: str) -> Diagnostic:
    """BG307: products of different kinds in one sum"""
    return error(
        "BG307",
        f"the terms of this product are of different kinds: {one} and {two}",
        span,
        help="check the order of the components, and their units",
    )


# --- shapes -----------------------------------------------------------------------------


# --- indices and components -------------------------------------------------------------


# --- constants --------------------------------------------------------------------------


def not_constant(span: Span, what: str) -> Diagnostic:
    """BG330: not known at compile time"""
    return error(
        "BG330",
        f"{what} must be known at compile time",
        span,
        help="declare it with `const`, or as a dimension of the model",
    )


def not_whole(span: Span, what: str, least: int, most: int, found: str) -> Diagnostic:
    """BG331: not a whole number"""
    message = f"{what} must be a whole number from {least} to {most}, not {found}"
    return error(
        "BG331", message, span, help="use `floor` or `ceil` to round, and a value in that range"
    )


def varies(span: Span, what: str, allowed: str, found: str, help: str = "") -> Diagnostic:
    """BG332: a value that varies where it must not"""
    message = f"{what} must be {allowed}, but this {found}"
    return error(
        "BG332", message, span, help=help or "declare the varying value with `let` or `signal`"
    )


def out_of_range(span: Span) -> Diagnostic:
    """BG333: a number outside the range of doubles"""
    return error(
        "BG333",
        "this number is out of range",
        span,
        help="check exponents and units: numbers lie between about 4.9e-324 and 1.8e308",
    )


def division_by_zero(span: Span) -> Diagnostic:
    """BG334: division by zero"""
    way_out = "correct the divisor; the branch of a constant `if` that is not taken is ignored"
    return error("BG334", "this divides by zero", span, help=way_out)


def not_a_number(span: Span) -> Diagnostic:
    """BG335: a constant that is not a number"""
    return error(
        "BG335",
        "the value of this constant is not a number",
        span,
        help="correct the argument of the function or power",
    )


# --- parts and functions ----------------------------------------------------------------


def not_a_value(span: Span, what: str) -> Diagnostic:
    """BG340: a part where a value belongs"""
    return error(
        "BG340", f"{what} is not a value", span, help="name one of its values, for example `coil.p`"
    )


def unknown_function(span: Span, name: str, near: Iterable[str], instead: str = "") -> Diagnostic:
    """BG341: an unknown function"""
    # `instead` is the answer to a function of another tool, such as pow.
    near = list(near)
    way_out = instead or did_you_mean(name, near) or f"declare it: `function {name}(x) = ..;`"
    edits = (
        []
        if instead
        else respelt(Span(span.source, span.start, span.start + len(name)), name, near)
    )
    return error("BG341", f"there is no function called `{name}`", span, help=way_out, edits=edits)


def called_value(span: Span, name: str) -> Diagnostic:
    """BG342: a value called like a function"""
    return error(
        "BG342",
        f"`{name}` is a value, not a function",
        span,
        help=f"write `{name}*(..)` for a product, `{name}[..]` for a component",
    )


def wrong_argument_count(span: Span, function: str, expected: str, found: int) -> Diagnostic:
    """BG343: too many or too few arguments"""
    message = f"`{function}` takes {expected}, not {found}"
    return error("BG343", message, span, help="give all arguments, by position")


def recursive_function(span: Span, name: str, calls: Sequence[str]) -> Diagnostic:
    """BG344: a function that calls itself"""
    through = f", through {' -> '.join(f'`{call}`' for call in calls)}" if len(calls) > 1 else ""
    message = f"the function `{name}` calls itself{through}"
    return error("BG344", message, span, help="write the repetition as a sum, or with `for`")


def misplaced_derivative(span: Span) -> Diagnostic:
    """BG345: der(x) where it is not allowed"""
    return error(
        "BG345",
        "`der(x)` is allowed only in `der(x) = ..;` and in an `equation`",
        span,
        help="use the right-hand side of its equation, or write an `equation`; in elements "
        "`p' = e` and `q' = f`: the acceleration of `body : I(m)` is `body.e/m`",
    )


def derivative_of_expression(span: Span) -> Diagnostic:
    """BG346: the derivative of an expression"""
    message = "`der` takes a declared state, or a component of one"
    return error("BG346", message, span, help="write the derivative out, for example `2*der(x)`")


# --- matrices ---------------------------------------------------------------------------


def singular_matrix(span: Span) -> Diagnostic:
    """BG350: a matrix without an inverse"""
    message = "this matrix is singular and has no inverse"
    way_out = "give a singular matrix as `C(stiffness = ..)` or `R(conductance = ..)`"
    return error("BG350", message, span, help=way_out)


def varying_inverse(span: Span) -> Diagnostic:
    """BG351: the inverse of a varying matrix"""
    return error(
        "BG351",
        "`inv` takes a matrix of constants and parameters only",
        span,
        help="use an `unknown` and an `equation`, or `transpose` of a rotation",
    )
