"""Diagnostics: symbolic formulas."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, listed, nearest


@error(
    "BG094: {what} is too large for a formula: {measure}; the limit is {limit}",
    "compute numbers with `bgc equations FILE --linear` or `bgc bode FILE`, or choose an "
    "output and an input with fewer elements between them",
)
def too_large(what: str, measure: str, limit: str) -> None: ...
@error(
    "BG095: the {what} of `{output}` by `{input_}` have no closed form: a factor has degree "
    "{degree}",
    "compute numbers with `numeric_{what}()`, for any values of the symbols",
)
def no_closed_form(what: str, output: str, input_: str, degree: int) -> None: ...
@error(
    "BG096: the linear form does not determine its states{some}",
    "choose another operating point, or check the model's equations",
)
def undetermined(names: Sequence[str]) -> Values:
    return {"some": f" {listed(names)}" if names else ""}


@error(
    "BG097: {what} divides by zero at this operating point",
    "keep the states as symbols, or choose another operating point",
)
def undefined_at(what: str) -> None: ...
@error(
    "BG098: `{text}` is not of the form OUTPUT/INPUT",
    "name an output and an input, for example `--transfer capacitor.e/supply.e`",
)
def bad_pair(text: str) -> None: ...
@error(
    "BG099: no formula was found for the equilibrium of {names:listed}",
    'keep the states as symbols, and take their values from `model.linearise(at="steady").point`',
)
def no_formula_of_equilibrium(names: Sequence[str]) -> None: ...
@error(
    "BG079: the model has no parameter, state or input `{name}`",
    "use a name from `parameters`, `states` or `inputs`",
)
def unknown_letter(name: str, known: Sequence[str]) -> Values:
    return nearest(name, known)


@error(
    "BG076: `{name}` has no value", 'give it a value, for example `numeric_poles({"{name}": 0.2})`'
)
def no_number(name: str) -> None: ...
