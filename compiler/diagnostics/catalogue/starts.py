"""BG7xx: a run that finds no start, at rest or with its fast modes settled."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed
from bgc.diagnostics.diagnostic import Diagnostic


def no_start(names: Sequence[str]) -> Diagnostic:
    """BG732: no state with the given initial values"""
    of = f" of {listed(names)}" if names else ""
    return error(
        "BG732",
        f"no state was found at which the initial values{of} hold",
        help="give values that the laws reach, or defaults near the values that are used",
    )


def not_settled(frequency: float) -> Diagnostic:
    """BG717: no start with the fast modes at rest"""
    return error(
        "BG717",
        f"the modes faster than {frequency:g} Hz do not come to rest near the initial state",
        help="give a frequency between the slow and the fast modes: "
        "`bgc equations --linear` lists them",
    )


def not_separable() -> Diagnostic:
    """BG718: `settle` with undetermined rates"""
    return error(
        "BG718",
        "fast and slow modes cannot be separated: some rates are undetermined",
        help="omit `settle`, or write each rate as `der(x) = ..;`",
    )


def no_rest(rates: Sequence[tuple[str, float, str]]) -> Diagnostic:
    """BG760: a start at rest where there is none"""
    shown = ", ".join(
        f"`{name}` changes by {rate:.4g} {_rate_unit(unit)}" for name, rate, unit in rates[:3]
    )
    more = f" and {len(rates) - 3} more" if len(rates) > 3 else ""
    return error(
        "BG760",
        f"there is no state of rest near the initial values: {shown}{more}",
        help="hold what these states belong to, or free a parameter that balances them: "
        "`start rest vary drive.torque;`",
    )


def _rate_unit(unit: str) -> str:
    return f"{unit}/s" if unit and "/" not in unit else f"{unit} per second".strip()


def rest_not_found() -> Diagnostic:
    """BG761: no start at rest that keeps what is to be kept"""
    return error(
        "BG761",
        "no state of rest near the initial values keeps what `hold` names",
        help="hold less, or free a parameter by `vary`",
    )


def rest_too_far() -> Diagnostic:
    """BG773: a state of rest that is too far away to follow the positions to it"""
    return error(
        "BG773",
        "the way from the initial values to the state of rest is too long to follow",
        help="give initial values that are nearer to it",
    )
