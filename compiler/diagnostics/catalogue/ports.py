"""BG470-BG474: sampled ports."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed, warning
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span

_EXAMPLE = "port hand[3] out sampled 1 ms { position = x; stiffness = 800 N/m; mass = 0.25 kg; }"


def law_of_plain_port(span: Span, name: str) -> Diagnostic:
    """BG470: a sampled port is not complete"""
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
    """BG471: a sampled port with nothing behind it that takes its effort"""
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
    """BG472: a sampled port that is too stiff for its masses, its period and its lag"""
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
    """BG473: a sampled port whose damping makes the steps of the position felt"""
    return warning(
        "BG473",
        f"one step of the position changes the force of the sampled port `{name}` by {noise:.2g} N "
        f"({damping:.3g} N*s/m, {1e6 * resolution:.3g} um, {1e3 * period:.3g} ms)",
        span,
        help="lower the damping, or use a device of a finer resolution",
    )


def other_samples(span: Span | None, name: str, period: float, step: float) -> Diagnostic:
    """BG474: a sampled port with another period than the devices"""
    return error(
        "BG474",
        f"the sampled port `{name}` has a period of {1e3 * period:.6g} ms, the devices of the "
        f"scene are read every {1e3 * step:.6g} ms",
        span,
        help="give both the same period: the scene's `step`, or that of the port",
    )
