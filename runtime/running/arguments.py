"""Arguments of a run as SI numbers."""

from __future__ import annotations

from bgc.runtime.running.quantity import Quantity, in_si


def seconds_of(value: Quantity | None, name: str = "duration") -> float | None:
    """Return a time in s; None for None."""
    return in_si(value, name, "s")


def method_options(
    rtol: Quantity | None,
    atol: Quantity | None,
    step: Quantity | None,
    max_step: Quantity | None,
    substeps: int | None,
    settle: Quantity | None,
) -> dict[str, float | None]:
    """The options of a method by name, SI."""
    return {
        "rtol": in_si(rtol, "rtol", ""),
        "atol": in_si(atol, "atol", ""),
        "step": in_si(step, "step", "s"),
        "max_step": in_si(max_step, "max_step", "s"),
        "substeps": substeps,
        "settle": in_si(settle, "settle", "Hz"),
    }
