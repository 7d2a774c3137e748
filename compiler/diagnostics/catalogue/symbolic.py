"""Diagnostics of formulas in a model's own letters: transfer functions, equilibria."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed
from bgc.diagnostics.diagnostic import Diagnostic


def too_large(what: str, measure: str, limit: str) -> Diagnostic:
    """BG094: a formula that is too large

    What: a formula in the model's own letters takes more work, or more space, than bgc spends.
    Why: the terms of a determinant grow exponentially with the number of states and parameters
    that it couples. Formulas of thousands of terms cannot be read.
    Example: `bgc equations two_beam_crane.bg --transfer "tip_height/hand.position[3]"`
    Way out: take the numbers (`bgc equations FILE --linear`, `bgc bode FILE`); or choose an output
    and an input with less between them, or a simpler variant of a part (`--use`, `Rigid` for a
    compliant lock).
    """
    return error(
        "BG094",
        f"{what} is too large for a formula: {measure}; the limit is {limit}",
        help="take numbers, with `bgc equations FILE --linear` or `bgc bode FILE`, or an output "
        "and an input with less between them",
    )


def no_closed_form(what: str, output: str, input_: str, degree: int) -> Diagnostic:
    """BG095: poles or zeros without a closed form

    What: the poles or zeros of a transfer function are asked for as formulas, and a factor of its
    denominator or numerator has none of reasonable size.
    Why: only factors of degree one and two, and such in s^2, have short formulas for their roots;
    from degree five on there is none at all.
    Example: `G.poles()` of three masses and three springs with dampers.
    Way out: take the numbers (`G.numeric_poles()`), for any values of the letters.
    """
    return error(
        "BG095",
        f"the {what} of `{output}` by `{input_}` have no closed form: a factor has degree {degree}",
        help=f"take numbers with `numeric_{what}()`, for any values of the letters",
    )


def undetermined(names: Sequence[str]) -> Diagnostic:
    """BG096: a linear form that does not determine the states

    What: `s M - A` is singular for every s, so there is no transfer function.
    Why: at the operating point the algebraic equations no longer determine their unknowns: one
    has become zero, or two have become the same.
    Example: `equation z^3 = u;` about z = 0.
    Way out: choose another operating point, or write the equations so that each unknown counts.
    """
    some = f" {listed(names)}" if names else ""
    return error(
        "BG096",
        f"the linear form does not determine its states{some}",
        help="choose another operating point, or check the model's equations",
    )


def undefined_at(what: str) -> Diagnostic:
    """BG097: a formula that is not defined at its operating point

    What: with the operating point put in, a formula divides by zero.
    Why: the derivative of a law is infinite there: a square root at zero, a quotient by a state
    that is zero.
    Example: the flow out of a tank, `c*sqrt(h)`, about the empty tank.
    Way out: leave the states as letters, or choose an operating point off the singular one.
    """
    return error(
        "BG097",
        f"{what} divides by zero at this operating point",
        help="leave the states as letters, or choose another point",
    )


def bad_pair(text: str) -> Diagnostic:
    """BG098: a transfer function that is not written OUTPUT/INPUT

    What: `--transfer` wants an output and an input with a slash between them.
    Why: a transfer function leads from one input to one output. The last slash separates them,
    since an output may be an expression with a slash of its own.
    Example: `bgc equations rlc.bg --transfer capacitor.e`
    Way out: `bgc equations rlc.bg --transfer capacitor.e/supply.e`
    """
    return error(
        "BG098",
        f"`{text}` names no output and input",
        help="write OUTPUT/INPUT, as `--transfer capacitor.e/supply.e`",
    )


def no_formula_of_equilibrium(names: Sequence[str]) -> Diagnostic:
    """BG099: an equilibrium without a formula

    What: the equilibrium of a model is asked for in its own letters, and none was found.
    Why: the equations of these states together are nonlinear in several unknowns, or in one in a
    way that cannot be solved for it, or they have no unique solution (an angle that nothing
    holds).
    Example: `model.symbolic(at="steady")` of three tanks whose valves depend on each other.
    Way out: leave the states as letters and give them numbers afterwards:
    `model.linearise(at="steady").point` has those of the equilibrium.
    """
    return error(
        "BG099",
        f"no formula was found for the equilibrium of {listed(names)}",
        help="leave the states as letters, and take their numbers from "
        '`model.linearise(at="steady").point`',
    )


def unknown_letter(name: str, known: Sequence[str]) -> Diagnostic:
    """BG079: a letter that does not exist

    What: a formula is asked about a name that is no parameter, state or input of the model.
    Why: sensitivities are derivatives by a parameter, and an operating point gives values to
    states, parameters and inputs.
    Example: `model.symbolic().rates_by("resistor.R")` where the parameter is called `R`.
    Way out: use a name from `parameters`, `states` or `inputs`.
    """
    return error(
        "BG079",
        f"there is no `{name}` to vary or to give a value",
        help=did_you_mean(name, known),
    )


def no_number(name: str) -> Diagnostic:
    """BG076: a letter without a number

    What: numbers are asked of a formula that holds a letter to which the scene gives none.
    Why: the operating point was given in letters of one's own.
    Example: `sym.at({"tank.q": sympy.Symbol("V0")}).transfer_function(..).numeric_poles()`
    Way out: give the number: `numeric_poles({"V0": 0.2})`
    """
    return error(
        "BG076",
        f"`{name}` has no number",
        help=f'give it one, as `numeric_poles({{"{name}": 0.2}})`',
    )
