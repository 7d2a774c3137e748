"""BG7xx: a run that finds no start, at rest or with its fast modes settled."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed
from bgc.diagnostics.diagnostic import Diagnostic


def no_start(names: Sequence[str]) -> Diagnostic:
    """BG732: no state with the given initial values

    What: with the present parameters, no state was found at which the initial values hold.

    Why: the values are beyond what the laws of rigidly connected elements reach, or so far from
    those at the parameters' defaults that Newton's method does not find them.

    Example: `f0 = i0` of a coil whose law `f = tanh(p)` stays below 1, and `--set i0=2`.

    Way out: give values that the laws reach, or defaults near the values that are used.
    """
    of = f" of {listed(names)}" if names else ""
    return error(
        "BG732",
        f"no state was found at which the initial values{of} hold",
        help="give values that the laws reach, or defaults near the values that are used",
    )


def not_settled(frequency: float) -> Diagnostic:
    """BG717: no start with the fast modes at rest

    What: the run is to start with its fast modes at rest (`settle`), but Newton's method found no
    such state near the initial one.

    Why: there may be none: a fast mode is unstable, or a spring is far from its rest position. Or
    many modes lie near the frequency, so it does not separate fast from slow.

    Example: `solver rodas5p(settle = 20 Hz);` with a stiff spring stretched by a metre at the
    start.

    Way out: give another frequency, well between the slow and the fast modes (`bgc equations
    --linear` lists them), or better initial values.
    """
    return error(
        "BG717",
        f"the modes faster than {frequency:g} Hz do not come to rest near the initial state",
        help="give a frequency between the slow and the fast modes: "
        "`bgc equations --linear` lists them",
    )


def not_separable() -> Diagnostic:
    """BG718: `settle` with undetermined rates

    What: `settle` is used, and the model's `equation`s couple rates so that some of them are
    undetermined.

    Why: fast and slow modes are separated by the rates of all states.

    Example: `solver rodas5p(settle = 20 Hz);` with `equation der(a) - der(b) = a;` and
    `equation der(b) - der(a) = b;`.

    Way out: omit `settle`, or write `der(x) = ..;`.
    """
    return error(
        "BG718",
        "fast and slow modes cannot be separated: some rates are undetermined",
        help="omit `settle`, or write each rate as `der(x) = ..;`",
    )


def no_rest(rates: Sequence[tuple[str, float, str]]) -> Diagnostic:
    """BG760: a start at rest where there is none

    What: the run is to start at rest (`start rest`, `--rest`), and no state near the initial one
    makes all rates zero. The rates that remain are named, largest first.

    Why: something moves whatever the state: a body falls or drifts with a current, a source drives
    a speed, a pump fills a tank without an outlet, a sampled part counts its instants, a drive that
    follows a rate creeps under a load. Or the forces balance only where a spring is not as long as
    its ends are apart: then the rates are those of a state near the initial values, at which such
    relations hold. Sources and inputs have their first values.

    Example: `start rest;` in a scene of a ball in free fall.

    Way out: hold what the named states belong to (a spring, a mooring, a closed valve), free a
    parameter that can balance them (`start rest vary drive.torque;`), start nearer to the
    equilibrium, or start from the initial values as they are given.
    """
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
    """BG761: no start at rest that keeps what is to be kept

    What: no state near the initial one makes all rates zero while the values after `hold` stay.

    Why: the state of rest near the initial values contradicts the held values, or no state of rest
    exists: `start rest;` alone shows which (BG760).

    Example: `start rest hold spring.q;` of a spring that carries a weight.

    Way out: hold less, or free a parameter: `start rest hold spring.q vary spring_force;`
    """
    return error(
        "BG761",
        "no state of rest near the initial values keeps what `hold` names",
        help="hold less, or free a parameter by `vary`",
    )


def rest_too_far() -> Diagnostic:
    """BG773: a state of rest that is too far away to follow the positions to it

    What: the state of rest was found, but the relations between positions could not be followed
    from the initial values to it. The poses of bodies, the lengths of ropes and the stretches of
    springs may therefore contradict each other in it.

    Why: no motion changes such a relation, so it is followed from the initial values in small
    steps. The number of steps is limited; a position that is far away in terms of its scale, such
    as many turns of a shaft, needs more.

    Example: `start rest;` of a load on a rope that is a thousand turns from the winch's balance.

    Way out: start nearer to the state of rest, by initial values, or run the model to rest and
    continue from there.
    """
    return error(
        "BG773",
        "the way from the initial values to the state of rest is too long to follow",
        help="give initial values that are nearer to it",
    )
