"""Diagnostics: units, functions and constants."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import Values, error, nearest
from bgc.diagnostics.diagnostic import Edit, Label
from bgc.diagnostics.source import Span

# --- units ------------------------------------------------------------------------------


@error("BG301: `{text}` is not a unit")
def unknown_unit(
    span: Span, text: str, suggestion: str, product: str = "", conversion: str = ""
) -> Values:
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
    return {"edits": edits, "help": way_out}


@error("BG268: a unit has no parentheses", "write `{spelled}`: each `/` divides by one word")
def unit_with_parentheses(span: Span, spelled: str) -> Values:
    return {"edits": [Edit(span, spelled)]}


@error("BG303: {problem}{place}", "give both quantities units of the same kind")
def cannot_combine(
    operator: str,
    context: str,
    left: tuple[Span, str],
    right: tuple[Span, str],
    component: str = "",
) -> Values:
    one, two = left[1], right[1]
    match operator:
        case "+":
            problem = f"cannot add {two} to {one}"
        case "-":
            problem = f"cannot subtract {two} from {one}"
        case "<" | "<=" | ">" | ">=" | "==" | "!=":
            problem = f"cannot compare {one} with {two}"
        case _:
            problem = f"{one} and {two} are different kinds of quantity in {context}"
    return {
        "problem": problem,
        "place": f", in component {component}" if component else "",
        "span": right[0],
        "labels": [Label(left[0], one)],
    }


@error(
    "BG304: {what} must be a plain number or an angle, not {found}",
    "divide it by a reference of the same kind",
)
def needs_plain_number(span: Span, what: str, found: str) -> None: ...
@error(
    "BG305: the exponent of {base} must be a constant of at most 100",
    "use a number, or divide the base by a reference of its kind to make it a plain number",
)
def needs_constant_exponent(span: Span, base: str) -> None: ...
@error(
    "BG306: {what} must be {expected}, not {found}",
    "give a value in a matching unit; a number without a unit is taken in SI units",
)
def wrong_unit(span: Span, what: str, expected: str, found: str) -> None: ...
@error(
    "BG307: the terms of this product are of different kinds: {one} and {two}",
    "check the order of the components, and their units",
)
def mixed_terms(span: Span, one: str, two: str) -> None: ...


# --- shapes -----------------------------------------------------------------------------


# --- indices and components -------------------------------------------------------------


# --- constants --------------------------------------------------------------------------


@error(
    "BG330: {what} must be known at compile time",
    "declare it with `const`, or as a dimension of the model",
)
def not_constant(span: Span, what: str) -> None: ...
@error(
    "BG331: {what} must be a whole number from {least} to {most}, not {found}",
    "use `floor` or `ceil` to round, and a value in that range",
)
def not_whole(span: Span, what: str, least: int, most: int, found: str) -> None: ...
@error(
    "BG332: {what} must be {allowed}, but this {found}",
    "declare the varying value with `let` or `signal`",
)
def varies(span: Span, what: str, allowed: str, found: str, help: str = "") -> None: ...
@error(
    "BG333: this number is out of range",
    "check exponents and units: numbers lie between about 4.9e-324 and 1.8e308",
)
def out_of_range(span: Span) -> None: ...
@error(
    "BG334: this divides by zero",
    "correct the divisor; the branch of a constant `if` that is not taken is ignored",
)
def division_by_zero(span: Span) -> None: ...
@error(
    "BG335: the value of this constant is not a number",
    "correct the argument of the function or power",
)
def not_a_number(span: Span) -> None: ...


# --- parts and functions ----------------------------------------------------------------


@error("BG340: {what} is not a value", "name one of its values, for example `coil.p`")
def not_a_value(span: Span, what: str) -> None: ...
@error("BG341: there is no function called `{name}`", "declare it: `function {name}(x) = ..;`")
def unknown_function(span: Span, name: str, near: Iterable[str], instead: str = "") -> Values:
    # `instead` is the answer to a function of another tool, such as pow.
    if instead:
        return {"help": instead}
    return nearest(name, near, Span(span.source, span.start, span.start + len(name)))


@error(
    "BG342: `{name}` is a value, not a function",
    "write `{name}*(..)` for a product, `{name}[..]` for a component",
)
def called_value(span: Span, name: str) -> None: ...
@error("BG343: `{function}` takes {expected}, not {found}", "give all arguments, by position")
def wrong_argument_count(span: Span, function: str, expected: str, found: int) -> None: ...
@error(
    "BG344: the function `{name}` calls itself{through}",
    "write the repetition as a sum, or with `for`",
)
def recursive_function(span: Span, name: str, calls: Sequence[str]) -> Values:
    path = " -> ".join(f"`{call}`" for call in calls)
    return {"through": f", through {path}" if len(calls) > 1 else ""}


@error(
    "BG345: `der(x)` is allowed only in `der(x) = ..;` and in an `equation`",
    "use the right-hand side of its equation, or write an `equation`; in elements `p' = "
    "e` and `q' = f`: the acceleration of `body : I(m)` is `body.e/m`",
)
def misplaced_derivative(span: Span) -> None: ...
@error(
    "BG346: `der` takes a declared state, or a component of one",
    "write the derivative out, for example `2*der(x)`",
)
def derivative_of_expression(span: Span) -> None: ...


# --- matrices ---------------------------------------------------------------------------


@error(
    "BG350: this matrix is singular and has no inverse",
    "give a singular matrix as `C(stiffness = ..)` or `R(conductance = ..)`",
)
def singular_matrix(span: Span) -> None: ...
@error(
    "BG351: `inv` takes a matrix of constants and parameters only",
    "use an `unknown` and an `equation`, or `transpose` of a rotation",
)
def varying_inverse(span: Span) -> None: ...
