"""Diagnostics of symbolic formulas: transfer functions, equilibria."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed
from bgc.diagnostics.diagnostic import Diagnostic


def too_large(what: str, measure: str, limit: str) -> Diagnostic:
    """BG094: a formula that is too large

    What: a symbolic formula would take more time or memory than bgc allows.
    Why: the number of terms of a determinant grows exponentially with the coupled states and
    parameters, and a formula with thousands of terms is useless.
    Example: `bgc equations two_beam_crane.bg --transfer "tip_height/hand.position[3]"`
    Way out: compute numbers (`bgc equations FILE --linear`, `bgc bode FILE`); or choose an output
    and an input with fewer elements between them, or a simpler variant of a part (`--use`, for
    example `Rigid` for a compliant lock).
    """
    return error(
        "BG094",
        f"{what} is too large for a formula: {measure}; the limit is {limit}",
        help="compute numbers with `bgc equations FILE --linear` or `bgc bode FILE`, or choose an "
        "output and an input with fewer elements between them",
    )


def no_closed_form(what: str, output: str, input_: str, degree: int) -> Diagnostic:
    """BG095: poles or zeros without a closed form

    What: formulas are requested for the poles or zeros of a transfer function, and a factor of its
    denominator or numerator has no short formula for its roots.
    Why: only factors of degree one and two (also in s^2) have short formulas for their roots; from
    degree five there is no general formula.
    Example: `G.poles()` for three masses and three springs with dampers.
    Way out: compute numbers with `G.numeric_poles()`, for any values of the symbols.
    """
    return error(
        "BG095",
        f"the {what} of `{output}` by `{input_}` have no closed form: a factor has degree {degree}",
        help=f"compute numbers with `numeric_{what}()`, for any values of the symbols",
    )


def undetermined(names: Sequence[str]) -> Diagnostic:
    """BG096: a linear form that does not determine the states

    What: `s M - A` is singular for every s, so there is no transfer function.
    Why: at the operating point the algebraic equations no longer determine their unknowns: one
    has become zero, or two have become the same.
    Example: `equation z^3 = u;` about z = 0.
    Way out: choose another operating point, or write the equations so that each determines an
    unknown.
    """
    some = f" {listed(names)}" if names else ""
    return error(
        "BG096",
        f"the linear form does not determine its states{some}",
        help="choose another operating point, or check the model's equations",
    )


def undefined_at(what: str) -> Diagnostic:
    """BG097: a formula that is undefined at its operating point

    What: at the operating point a formula divides by zero.
    Why: the derivative of a law is infinite there: a square root at zero, or a quotient by a state
    that is zero.
    Example: the flow out of a tank, `c*sqrt(h)`, about the empty tank.
    Way out: keep the states as symbols, or choose another operating point.
    """
    return error(
        "BG097",
        f"{what} divides by zero at this operating point",
        help="keep the states as symbols, or choose another operating point",
    )


def bad_pair(text: str) -> Diagnostic:
    """BG098: a transfer function that is not written OUTPUT/INPUT

    What: the value of `--transfer` is not an output and an input with a slash between them.
    Why: a transfer function leads from one input to one output. The last slash separates them,
    since an output may be an expression that contains a slash.
    Example: `bgc equations rlc.bg --transfer capacitor.e`
    Way out: `bgc equations rlc.bg --transfer capacitor.e/supply.e`
    """
    return error(
        "BG098",
        f"`{text}` is not of the form OUTPUT/INPUT",
        help="name an output and an input, for example `--transfer capacitor.e/supply.e`",
    )


def no_formula_of_equilibrium(names: Sequence[str]) -> Diagnostic:
    """BG099: an equilibrium without a formula

    What: no formula was found for the equilibrium of the model.
    Why: the equations of these states are nonlinear in several unknowns, cannot be solved for their
    unknown, or have no unique solution (such as an angle that nothing holds).
    Example: `model.symbolic(at="steady")` for three tanks with valves that depend on each other.
    Way out: keep the states as symbols and substitute numbers afterwards:
    `model.linearise(at="steady").point` has those of the equilibrium.
    """
    return error(
        "BG099",
        f"no formula was found for the equilibrium of {listed(names)}",
        help="keep the states as symbols, and take their values from "
        '`model.linearise(at="steady").point`',
    )


def unknown_letter(name: str, known: Sequence[str]) -> Diagnostic:
    """BG079: an unknown symbol

    What: the name is not a parameter, state or input of the model.
    Why: a sensitivity is a derivative with respect to a parameter; an operating point gives values
    to states, parameters and inputs.
    Example: `model.symbolic().rates_by("resistor.R")` where the parameter is called `R`.
    Way out: use a name from `parameters`, `states` or `inputs`.
    """
    return error(
        "BG079",
        f"the model has no parameter, state or input `{name}`",
        help=did_you_mean(name, known) or "use a name from `parameters`, `states` or `inputs`",
    )


def no_number(name: str) -> Diagnostic:
    """BG076: a symbol without a value

    What: a formula is evaluated numerically, but contains a symbol to which the scene gives no
    value.
    Why: the operating point was given with a symbol of the user's own.
    Example: `sym.at({"tank.q": sympy.Symbol("V0")}).transfer_function(..).numeric_poles()`
    Way out: give its value: `numeric_poles({"V0": 0.2})`.
    """
    return error(
        "BG076",
        f"`{name}` has no value",
        help=f'give it a value, for example `numeric_poles({{"{name}": 0.2}})`',
    )
