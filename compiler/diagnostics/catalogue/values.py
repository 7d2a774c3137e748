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
    """BG301: an unknown unit

    What: the text after a number, or after the colon of a declaration, is not a unit.

    Why: each unit has one spelling: SI symbols with prefixes, and `t min h day deg rev rpm knot nmi
    bar L Wh`. Factors are joined by `*` and `/`, powers written with `^`. A unit extends to the
    next blank, so in `5 V*gain` the unit would be volts times `gain`.

    Example: `param torque = 5 Nm;`

    Way out: write `5 N*m`, and `5 V * gain`. Convert feet and pounds to SI units. For a temperature
    in degrees Celsius, which has an offset, add 273.15 and write `K`.
    """
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
    """BG268: a unit with parentheses

    What: a product of units in the denominator stands in parentheses.

    Why: a unit is a chain of words from the left, in which each `/` divides by the next word
    alone. Parentheses belong to expressions, and the words in them would be names of values.

    Example: `param h = 3 W/(m^2*K);`

    Way out: write a `/` before each word of the denominator: `3 W/m^2/K`.
    """
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
    """BG303: quantities of different kinds

    What: two quantities with units of different kinds are added, subtracted or compared.

    Why: a length and a mass have no sum.

    Example: `let x = 3 m + 2 kg;`

    Way out: check which of the two is wrong; a number without a unit fits any unit.
    """
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
    """BG304: a quantity where a plain number belongs

    What: the argument of a function such as `sin` or `exp`, an exponent, or a condition has a unit.

    Why: the result would depend on the unit of measurement.

    Example: `let y = sin(3 m);`

    Way out: divide by a reference of the same kind, for example `sin(x/wavelength)`. Angles, in
    radians or degrees, are plain numbers.
    """
    return error(
        "BG304",
        f"{what} must be a plain number or an angle, not {found}",
        span,
        help="divide it by a reference of the same kind",
    )


def needs_constant_exponent(span: Span, base: str) -> Diagnostic:
    """BG305: the unit of a power is not known

    What: a quantity with a unit is raised to a power that is not a constant or is very large.

    Why: the unit of the result would not be known at compile time.

    Example: `param n = 2; let area = (3 m)^n;`

    Way out: use a number, as in `length^2`, or make the base a plain number: `(length/(1 m))^n`.
    """
    return error(
        "BG305",
        f"the exponent of {base} must be a constant of at most 100",
        span,
        help="use a number, or divide the base by a reference of its kind to make it a plain "
        "number",
    )


def wrong_unit(span: Span, what: str, expected: str, found: str) -> Diagnostic:
    """BG306: a value of the wrong kind

    What: the unit of a value does not match the declared unit.

    Why: the value or the declaration is wrong.

    Example: `param mass : kg = 3 m;`

    Way out: give a value in the declared unit or a multiple of it, such as `t` for `kg`. A number
    without a unit is taken in SI units.
    """
    return error(
        "BG306",
        f"{what} must be {expected}, not {found}",
        span,
        help="give a value in a matching unit; a number without a unit is taken in SI units",
    )


def mixed_terms(span: Span, one: str, two: str) -> Diagnostic:
    """BG307: products of different kinds in one sum

    What: the terms of a matrix product, `dot`, `cross` or `norm` have units of different kinds.

    Why: these functions add products, and a sum needs quantities of one kind.

    Example: `let d = norm([3 m, 4 m, 2 rad]);`

    Way out: check the order of the components; a number without a unit fits any unit.
    """
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
    """BG330: not known at compile time

    What: a dimension, an index, an end of a `for`, or the condition of a compile-time `if` depends
    on a parameter, on time or on a state.

    Why: the structure of the model is fixed at compile time; parameters can change later.

    Example: `param n = 3; let v = zeros(n);`

    Way out: declare the value with `const`, or as a dimension of the model: `model M[n]`.
    """
    return error(
        "BG330",
        f"{what} must be known at compile time",
        span,
        help="declare it with `const`, or as a dimension of the model",
    )


def not_whole(span: Span, what: str, least: int, most: int, found: str) -> Diagnostic:
    """BG331: not a whole number

    What: a dimension, an index or an end of a `for` is a fraction, negative, or far too large.

    Why: parts and components are counted in whole numbers.

    Example: `let v = zeros(2.5);`

    Way out: round it: `floor(n/2)`.
    """
    message = f"{what} must be a whole number from {least} to {most}, not {found}"
    return error(
        "BG331", message, span, help="use `floor` or `ceil` to round, and a value in that range"
    )


def varies(span: Span, what: str, allowed: str, found: str, help: str = "") -> Diagnostic:
    """BG332: a value that varies where it must not

    What: a `const` depends on a parameter, or a parameter on time or on a state.

    Why: a `const` is fixed at compile time, a `param` before the run.

    Example: `param area = 2*pi*time;`

    Way out: declare a varying value with `let` or `signal`. If a part's `param` is given a varying
    value, declare it as an `input` in the part's model.
    """
    message = f"{what} must be {allowed}, but this {found}"
    return error(
        "BG332", message, span, help=help or "declare the varying value with `let` or `signal`"
    )


def out_of_range(span: Span) -> Diagnostic:
    """BG333: a number outside the range of doubles

    What: a constant is larger than about 1.8e308, infinite, or nonzero but smaller than about
    4.9e-324.

    Why: the model computes in double precision.

    Example: `const big = 9^9^9^9;`

    Way out: check the exponents and the units.
    """
    return error(
        "BG333",
        "this number is out of range",
        span,
        help="check exponents and units: numbers lie between about 4.9e-324 and 1.8e308",
    )


def division_by_zero(span: Span) -> Diagnostic:
    """BG334: division by zero

    What: the divisor is zero for all parameters, or zero is raised to a negative power.

    Why: the result would not be a number.

    Example: `let x = 1/(2 - 2);`

    Way out: correct the divisor. The branch of a constant `if` that is not taken is ignored.
    """
    way_out = "correct the divisor; the branch of a constant `if` that is not taken is ignored"
    return error("BG334", "this divides by zero", span, help=way_out)


def not_a_number(span: Span) -> Diagnostic:
    """BG335: a constant that is not a number

    What: a function has no real value for a constant argument: `log(-1)`, `sqrt(-1)`, `(-8)^(1/3)`.

    Why: no value that depends on it could be computed.

    Example: `const root = sqrt(-1);`

    Way out: correct the argument; for the cube root of a negative number use `cbrt(x)`.
    """
    return error(
        "BG335",
        "the value of this constant is not a number",
        span,
        help="correct the argument of the function or power",
    )


# --- parts and functions ----------------------------------------------------------------


def not_a_value(span: Span, what: str) -> Diagnostic:
    """BG340: a part where a value belongs

    What: the path ends at a part, a port or an array, or the expression is a text or a type.

    Why: a part has many values; only numbers, vectors and matrices can be used in a calculation.

    Example: `supply : Se(1); coil : I(1); supply -> coil; let x = 2*coil;`

    Way out: name one of its values, for example `coil.p` or `boom.length`.
    """
    return error(
        "BG340", f"{what} is not a value", span, help="name one of its values, for example `coil.p`"
    )


def unknown_function(span: Span, name: str, near: Iterable[str], instead: str = "") -> Diagnostic:
    """BG341: an unknown function

    What: neither the language nor this file and its imports have a function of that name.

    Why: functions have their C names: `asin`, `fmod`, `tanh`. A power is written `x^y`, and
    rounding `floor(x + 0.5)`.

    Example: `let a = arcsin(0.5);`

    Way out: correct the spelling, or declare it: `function f(x) = x^2;`.
    """
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
    """BG342: a value called like a function

    What: parentheses follow the name of a value.

    Why: `k(x)` calls a function `k`; a product needs `*`.

    Example: `param k = 2; let f = k(3 + 4);`

    Way out: write `k*(3 + 4)`, or `v[2]` for a component.
    """
    return error(
        "BG342",
        f"`{name}` is a value, not a function",
        span,
        help=f"write `{name}*(..)` for a product, `{name}[..]` for a component",
    )


def wrong_argument_count(span: Span, function: str, expected: str, found: int) -> Diagnostic:
    """BG343: too many or too few arguments

    What: a function is called with the wrong number of arguments.

    Why: arguments are given by position, and all are required.

    Example: `let a = atan2(1);`

    Way out: give as many arguments as the message states.
    """
    message = f"`{function}` takes {expected}, not {found}"
    return error("BG343", message, span, help="give all arguments, by position")


def recursive_function(span: Span, name: str, calls: Sequence[str]) -> Diagnostic:
    """BG344: a function that calls itself

    What: the evaluation of a function calls the same function again.

    Why: calls are replaced by the function's definition, which would never end.

    Example: `function f(n) = n*f(n - 1); let x = f(3);`

    Way out: write it without the call, for example as a sum or with a `for` over a state array.
    """
    through = f", through {' -> '.join(f'`{call}`' for call in calls)}" if len(calls) > 1 else ""
    message = f"the function `{name}` calls itself{through}"
    return error("BG344", message, span, help="write the repetition as a sum, or with `for`")


def misplaced_derivative(span: Span) -> Diagnostic:
    """BG345: der(x) where it is not allowed

    What: `der(x)` appears in a definition, an argument or a law.

    Why: derivatives follow from the equations; a definition cannot use them.

    Example: `state x = 1; der(x) = -x; let v = der(x);`

    Way out: define the state by `der(x) = ..;`, or use `der(x)` on either side of an implicit
    `equation left = right;`. The rate of a momentum is the effort of its element, and the rate of
    a displacement its flow: the acceleration of a mass `body : I(m)` is `body.e/m`.
    """
    return error(
        "BG345",
        "`der(x)` is allowed only in `der(x) = ..;` and in an `equation`",
        span,
        help="use the right-hand side of its equation, or write an `equation`; in elements "
        "`p' = e` and `q' = f`: the acceleration of `body : I(m)` is `body.e/m`",
    )


def derivative_of_expression(span: Span) -> Diagnostic:
    """BG346: the derivative of an expression

    What: the argument of `der` is not a declared `state` or a component of one.

    Why: only states have a derivative.

    Example: `state x = 1; equation der(2*x) = 1;`

    Way out: write the derivative out: `2*der(x)`.
    """
    message = "`der` takes a declared state, or a component of one"
    return error("BG346", message, span, help="write the derivative out, for example `2*der(x)`")


# --- matrices ---------------------------------------------------------------------------


def singular_matrix(span: Span) -> Diagnostic:
    """BG350: a matrix without an inverse

    What: the matrix given to `inv` is singular for all parameters.

    Why: it has no inverse.

    Example: `let W = inv([[1, 2], [2, 4]]);`

    Way out: correct the matrix. Give a singular stiffness as `stiffness` and a singular conductance
    as `conductance`: then it is not inverted.
    """
    message = "this matrix is singular and has no inverse"
    way_out = "give a singular matrix as `C(stiffness = ..)` or `R(conductance = ..)`"
    return error("BG350", message, span, help=way_out)


def varying_inverse(span: Span) -> Diagnostic:
    """BG351: the inverse of a varying matrix

    What: the matrix given to `inv` depends on time or on a state.

    Why: an inverse is computed once, before the run; a varying matrix may become singular later.

    Example: `let W = inv([[time, 0], [0, 1]]);`

    Way out: solve for the unknown: `unknown z[2] = [0, 0]; equation A*z = b;`, or write the inverse
    of a rotation as `transpose(A)`.
    """
    return error(
        "BG351",
        "`inv` takes a matrix of constants and parameters only",
        span,
        help="use an `unknown` and an `equation`, or `transpose` of a rotation",
    )
