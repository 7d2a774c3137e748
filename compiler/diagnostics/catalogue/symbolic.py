"""Diagnostics of symbolic formulas: transfer functions, equilibria."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed
from bgc.diagnostics.diagnostic import Diagnostic


def too_large(what: str, measure: str, limit: str) -> Diagnostic:
    """BG094: a formula that is too large"""
    return error(
        "BG094",
        f"{what} is too large for a formula: {measure}; the limit is {limit}",
        help="compute numbers with `bgc equations FILE --linear` or `bgc bode FILE`, or choose an "
        "output and an input with fewer elements between them",
    )


def no_closed_form(what: str, output: str, input_: str, degree: int) -> Diagnostic:
    """BG095: poles or zeros without a closed form"""
    return error(
        "BG095",
        f"the {what} of `{output}` by `{input_}` have no closed form: a factor has degree {degree}",
        help=f"compute numbers with `numeric_{what}()`, for any values of the symbols",
    )


def undetermined(names: Sequence[str]) -> Diagnostic:
    """BG096: a linear form that does not determine the states"""
    some = f" {listed(names)}" if names else ""
    return error(
        "BG096",
        f"the linear form does not determine its states{some}",
        help="choose another operating point, or check the model's equations",
    )


def undefined_at(what: str) -> Diagnostic:
    """BG097: a formula that is undefined at its operating point"""
    return error(
        "BG097",
        f"{what} divides by zero at this operating point",
        help="keep the states as symbols, or choose another operating point",
    )


def bad_pair(text: str) -> Diagnostic:
    """BG098: a transfer function that is not written OUTPUT/INPUT"""
    return error(
        "BG098",
        f"`{text}` is not of the form OUTPUT/INPUT",
        help="name an output and an input, for example `--transfer capacitor.e/supply.e`",
    )


def no_formula_of_equilibrium(names: Sequence[str]) -> Diagnostic:
    """BG099: an equilibrium without a formula"""
    return error(
        "BG099",
        f"no formula was found for the equilibrium of {listed(names)}",
        help="keep the states as symbols, and take their values from "
        '`model.linearise(at="steady").point`',
    )


def unknown_letter(name: str, known: Sequence[str]) -> Diagnostic:
    """BG079: an unknown symbol"""
    return error(
        "BG079",
        f"the model has no parameter, state or input `{name}`",
        help=did_you_mean(name, known) or "use a name from `parameters`, `states` or `inputs`",
    )


def no_number(name: str) -> Diagnostic:
    """BG076: a symbol without a value"""
    return error(
        "BG076",
        f"`{name}` has no value",
        help=f'give it a value, for example `numeric_poles({{"{name}": 0.2}})`',
    )
