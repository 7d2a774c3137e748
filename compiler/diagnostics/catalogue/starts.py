"""Diagnostics: starts at rest."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, listed
from bgc.diagnostics.source import Span

_LISTED = 6  # elements that a message names


@error(
    "BG732: no state was found at which the initial values{of} hold",
    "give values that the laws reach, or defaults near the values that are used",
)
def no_start(names: Sequence[str]) -> Values:
    return {"of": f" of {listed(names)}" if names else ""}


# Make BG732 for one given value that the start misses; see `no_start`.
@error(
    "BG732: no state was found at which `{variable}` of `{name}` has its value",
    "give one that agrees with the other initial values and that the laws reach",
)
def missed_start(span: Span | None, variable: str, name: str) -> None: ...
@error(
    "BG732: `{name}` does not start at its initial value: `project {name}` moves it",
    "give it an initial value that the projection keeps",
)
def projected_start(span: Span | None, name: str) -> None: ...
@error(
    "BG717: the modes faster than {frequency:g} Hz do not come to rest near the initial state",
    "give a frequency between the slow and the fast modes: `bgc equations --linear` lists them",
)
def not_settled(frequency: float) -> None: ...
@error(
    "BG718: fast and slow modes cannot be separated: some rates are undetermined",
    "omit `settle`, or write each rate as `der(x) = ..;`",
)
def not_separable() -> None: ...
@error(
    "BG760: there is no state of rest near the initial values: {shown}{more}",
    "hold what these states belong to, or free a parameter that balances them: `start "
    "rest vary drive.torque;`",
)
def no_rest(rates: Sequence[tuple[str, float, str, str]], tipped: Sequence[str]) -> Values:
    """Name what remains: states with their rates, units and kinds, `p`, `q` or other.

    `tipped` are elements whose laws have switches that change on the way there.
    """
    why = {"p": " (nothing balances it)", "q": " (it flows on)"}
    shown = [
        f"`{name}` changes by {rate:.4g} {_rate_unit(unit)}{why.get(kind, '')}"
        for name, rate, unit, kind in rates[:3]
    ]
    more = f" and {len(rates) - 3} more" if len(rates) > 3 else ""
    cause = "has given way on the way there: it opens, slips or touches"
    note = f"{listed(tipped[:_LISTED])} {cause}"
    return {"shown": ", ".join(shown), "more": more, "note": note if tipped else ""}


def _rate_unit(unit: str) -> str:
    if unit.endswith("*s"):
        return unit.removesuffix("*s")
    return f"{unit}/s" if unit and "/" not in unit else f"{unit} per second".strip()


@error(
    "BG761: no state of rest near the initial values keeps what `hold` names",
    "hold less, or free a parameter by `vary`",
)
def rest_not_found() -> None: ...
@error(
    "BG773: the way from the initial values to the state of rest is too long to follow",
    "give initial values that are nearer to it",
)
def rest_too_far() -> None: ...
