"""Diagnostics: sampled ports."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, warning
from bgc.diagnostics.source import Span

_EXAMPLE = "port hand[3] out sampled 1 ms { position = x; stiffness = 800 N/m; mass = 0.25 kg; }"


@error(
    "BG470: the port `{name}` has a law and is not sampled",
    f"write `{_EXAMPLE}`, or put the law into a part behind the port",
)
def law_of_plain_port(span: Span, name: str) -> None: ...
# BG470, of a sampled port without something that it needs.
@error("BG470: the sampled port `{name}` needs {what}", f"write `{_EXAMPLE}`")
def incomplete(span: Span, name: str, what: str) -> None: ...
# BG470, of a quantity that a sampled port does not have.
@error("BG470: a sampled port has no quantity `{name}`", "it has {have:listed}")
def unknown_quantity(span: Span, name: str, have: Sequence[str]) -> None: ...
@error(
    "BG471: nothing behind the sampled port `{name}` takes its effort: {why}",
    "bond it to a mass; a wall that stands still is `Sf(0)`",
)
def nothing_behind(span: Span | None, name: str, why: str) -> None: ...
@error(
    "BG472: the stiffness {stiffness:.4g} N/m of the sampled port `{name}` is above {most:.4g} "
    "N/m, the largest with a device of {mass:.3g} kg against {load}, {lag:g} periods of "
    "lag and {ms:.3g} ms",
    "lower the stiffness, sample faster, or shorten the lag",
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
) -> Values:
    return {
        "load": "a wall" if behind == float("inf") else f"{behind:.3g} kg",
        "ms": 1000.0 * period,
    }


@warning(
    "BG473: one step of the position changes the force of the sampled port `{name}` by "
    "{noise:.2g} N ({damping:.3g} N*s/m, {us:.3g} um, {ms:.3g} ms)",
    "lower the damping, or use a device of a finer resolution",
)
def noisy(
    span: Span | None, name: str, noise: float, damping: float, resolution: float, period: float
) -> Values:
    return {"us": 1000000.0 * resolution, "ms": 1000.0 * period}


@error(
    "BG474: the sampled port `{name}` has a period of {ms:.6g} ms, the devices of the scene are "
    "read every {ms_step:.6g} ms",
    "give both the same period: the scene's `step`, or that of the port",
)
def other_samples(span: Span | None, name: str, period: float, step: float) -> Values:
    return {"ms": 1000.0 * period, "ms_step": 1000.0 * step}
