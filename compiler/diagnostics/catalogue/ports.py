"""BG470-BG474: sampled ports."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed, warning
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span

_EXAMPLE = "port hand[3] out sampled 1 ms { position = x; stiffness = 800 N/m; mass = 0.25 kg; }"


def law_of_plain_port(span: Span, name: str) -> Diagnostic:
    """BG470: a sampled port is not complete

    What: a port with a law in braces is not `sampled`, or a sampled port lacks its width, one of
    `position`, `stiffness` and `mass`, or a domain with one unit of effort and one of flow, or its
    law gives a quantity that it does not have.

    Why: a sampled port is a spring and a damper between a device and a bond. It needs the position
    of the device and the stiffness; the mass of the device decides whether that is stable.

    Example: `port hand[3] out sampled 1 ms { stiffness = 800 N/m; }`

    Way out: `port hand[3] out sampled 1 ms { position = x; stiffness = 800 N/m; mass = 0.25 kg; }`.
    """
    return error(
        "BG470",
        f"the port `{name}` has a law and is not sampled",
        span,
        help=f"write `{_EXAMPLE}`, or put the law into a part behind the port",
    )


def incomplete(span: Span, name: str, what: str) -> Diagnostic:
    """BG470, of a sampled port without something that it needs."""
    return error(
        "BG470", f"the sampled port `{name}` needs {what}", span, help=f"write `{_EXAMPLE}`"
    )


def unknown_quantity(span: Span, name: str, have: Sequence[str]) -> Diagnostic:
    """BG470, of a quantity that a sampled port does not have."""
    return error(
        "BG470",
        f"a sampled port has no quantity `{name}`",
        span,
        help=f"it has {listed(have)}",
    )


def nothing_behind(span: Span | None, name: str, why: str) -> Diagnostic:
    """BG471: a sampled port with nothing behind it that takes its effort

    What: behind a sampled port is no mass, and no resistance that is large enough: a compliance, or
    a source that gives the flow.

    Why: the port holds an effort over a sample, and its bond moves under it. A mass moves little in
    a period. A compliance without one follows at once, and the samples alternate; a flow source
    moves whatever the effort is, and would give any energy.

    Example: `port hand[1] out sampled 1 ms { .. }` bonded to a `C`, or to a moving `Sf`.

    Way out: put a mass (the end of the mechanism, or a small `I`) between; a wall that stands still
    is `Sf(0)`, or a port with `one_sided = 1`.
    """
    return error(
        "BG471",
        f"nothing behind the sampled port `{name}` takes its effort: {why}",
        span,
        help="bond it to a mass; a wall that stands still is `Sf(0)`",
    )


def too_stiff(
    span: Span | None,
    name: str,
    stiffness: float,
    most: float,
    mass: float,
    behind: float,
    lag: float,
    period: float,
) -> Diagnostic:
    """BG472: a sampled port that is too stiff for its masses, its period and its lag

    What: the stiffness K of a sampled port is above m/(4 T^2 (d + 1)(d + 1/2)): half of the limit
    of stability. m is the reduced mass m1 m2/(m1 + m2) of the device and of what is behind the
    port, T the period, d the lag in periods.

    Why: the port is passive at any K, but above the limit the energy that its damping takes is
    that of a motion that grows from sample to sample: both masses are too light for it.

    Example: `stiffness = 20000 N/m` with a device of 0.25 kg at 1 ms and a lag of 5 periods: the
    largest is 1894 N/m.

    Way out: lower the stiffness, sample faster, or shorten the lag. A heavier device or load helps.
    """
    load = "a wall" if behind == float("inf") else f"{behind:.3g} kg"
    return error(
        "BG472",
        f"the stiffness {stiffness:.4g} N/m of the sampled port `{name}` is above {most:.4g} N/m, "
        f"the largest with a device of {mass:.3g} kg against {load}, {lag:g} periods of lag and "
        f"{1e3 * period:.3g} ms",
        span,
        help="lower the stiffness, sample faster, or shorten the lag",
    )


def noisy(
    span: Span | None, name: str, noise: float, damping: float, resolution: float, period: float
) -> Diagnostic:
    """BG473: a sampled port whose damping makes the steps of the position felt

    What: damping times resolution over period, the change of the force by one step of the measured
    position, is above 0.1 N.

    Why: velocity is a difference of positions, so that each step of the resolution counts as a
    velocity of resolution/period. A hand feels 0.1 N.

    Example: `damping = 20 N*s/m; resolution = 10 um` at 1 ms: 0.2 N.

    Way out: lower the damping (K T (lag + 1) pays for what sampling creates), or use a finer
    device.
    """
    return warning(
        "BG473",
        f"one step of the position changes the force of the sampled port `{name}` by {noise:.2g} N "
        f"({damping:.3g} N*s/m, {1e6 * resolution:.3g} um, {1e3 * period:.3g} ms)",
        span,
        help="lower the damping, or use a device of a finer resolution",
    )


def other_samples(span: Span | None, name: str, period: float, step: float) -> Diagnostic:
    """BG474: a sampled port with another period than the devices

    What: a scene reads its devices every `step` (1 ms without one), and a sampled port of its model
    has another period.

    Why: the energy of a sample is the force that the device held times its displacement. With two
    periods the force would change within a sample of the other.

    Example: `port hand[3] out sampled 1 ms { .. }` in a scene with `step 2 ms;`.

    Way out: give both the same period, for example by a parameter of the model.
    """
    return error(
        "BG474",
        f"the sampled port `{name}` has a period of {1e3 * period:.6g} ms, the devices of the "
        f"scene are read every {1e3 * step:.6g} ms",
        span,
        help="give both the same period: the scene's `step`, or that of the port",
    )
