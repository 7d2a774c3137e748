"""BG7xx: faults during a run."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span

_FASTEST = "check the parameters and the initial value of the state at fault"
_NAMED = 3  # states at most


def _state(name: str | None) -> str:
    return f"; state `{name}` is at fault" if name else ""


def _by(states: Sequence[str]) -> str:
    """Name the states that a law switches on, if they are few."""
    named = ", ".join(f"`{name}`" for name in states)
    return f", on {named}" if 0 < len(states) <= _NAMED else ""


def _at(states: Sequence[str]) -> str:
    """Name the states that a quantity depends on, if they are few."""
    named = ", ".join(f"`{name}`" for name in states)
    return f", which depends on {named}" if 0 < len(states) <= _NAMED else ""


def step_too_small(time: float, state: str | None) -> Diagnostic:
    """BG701: no step is small enough"""
    return error(
        "BG701",
        f"at t = {time:.9g} s no step is small enough for the tolerance{_state(state)}",
        help=f"{_FASTEST}; loosen `rtol` if it is close to rounding (1e-15)",
    )


def too_many_steps(time: float, state: str | None) -> Diagnostic:
    """BG702: too many steps between two rows"""
    return error(
        "BG702",
        f"too many steps between two rows at t = {time:.9g} s{_state(state)}",
        help="use a stiff method (`solver rodas5p`), a longer step or a looser tolerance",
    )


def not_finite(time: float, state: str | None) -> Diagnostic:
    """BG703: a value is no longer finite"""
    return error(
        "BG703",
        f"a value is not finite after t = {time:.9g} s{_state(state)}",
        help="shorten the step or use a stiff method; guard laws that are undefined for some "
        "values",
    )


def singular(time: float, state: str | None) -> Diagnostic:
    """BG704: the equations of a step are singular"""
    return error(
        "BG704",
        f"the equations have no unique solution at t = {time:.9g} s{_state(state)}",
        help="look for an equation that does not determine its unknown, or a ratio that is zero",
    )


def divisor_vanishes(
    time: float, what: str, states: Sequence[str] = (), place: Span | None = None
) -> Diagnostic:
    """BG725: a divisor of the equations vanishes"""
    return error(
        "BG725",
        f"at t = {time:.6g} s {what} vanishes{_at(states)}: the equations divide by it",
        place,
        help="add the small inertia or compliance that the part has before its modulus, or keep "
        "the model away from this position",
    )


def assertion_failed(time: float, message: str, place: Span | None = None) -> Diagnostic:
    """BG705: an `assert` of the model failed"""
    return error(
        "BG705",
        f"{message} (at t = {time:.9g} s)",
        place,
        help="change the inputs or parameters that lead there, or the model: this `assert` ended "
        "the run",
    )


def device_failed(time: float, devices: Sequence[str], reason: str = "") -> Diagnostic:
    """BG706: a device reported a fault"""
    return error(
        "BG706",
        f"{_device(devices)} reported a fault at t = {time:.9g} s; its forces are zero"
        + (f": {reason}" if reason else ""),
        help="check the device, then run again",
    )


def _device(names: Sequence[str]) -> str:
    """The device at fault where the scene has one only, else all of its devices."""
    return f"device `{names[0]}`" if len(names) == 1 else f"one of the devices {listed(names)}"


def parameters_refused(message: str, sources: Sequence[str] = ()) -> Diagnostic:
    """BG707: parameters without a valid model"""
    named = ", ".join(f"`{source}`" for source in sources) or "the parameters that it depends on"
    return error("BG707", message, help=f"change {named}")


def no_memory() -> Diagnostic:
    """BG708: no memory for an instance of the model"""
    return error(
        "BG708",
        "there is no memory left for an instance of the model",
        help="free some memory, or keep fewer models at once",
    )


def interrupted(time: float) -> Diagnostic:
    """BG709: the run was interrupted"""
    return error("BG709", f"interrupted at t = {time:.9g} s; the rows up to there are kept")


def not_explicit() -> Diagnostic:
    """BG710: an explicit method on equations that couple rates"""
    return error(
        "BG710",
        "an explicit solver cannot solve equations that couple rates",
        help="use `solver rodas5p`, or `ros34prw` with a step",
    )


def inconsistent(time: float, state: str | None, through: Sequence[str] = ()) -> Diagnostic:
    """BG711: no consistent values"""
    loop = f", in the algebraic loop through {listed(through)}" if through else ""
    return error(
        "BG711",
        f"at t = {time:.9g} s no values near the given ones satisfy the equations"
        f"{_state(state)}{loop}",
        help="give `unknown NAME = VALUE;` a better starting value, or correct its equation; give "
        "a law that becomes flat, such as a blocking diode, a small slope",
    )


def chattering(time: float, states: Sequence[str] = (), place: Span | None = None) -> Diagnostic:
    """BG715: a law that switches endlessly"""
    return error(
        "BG715",
        f"at t = {time:.9g} s a law switches back and forth endlessly{_by(states)}",
        place,
        help="replace the jump by a steep slope, for example `sign(f)` by `tanh(f/v0)`, or put a "
        "stiff spring (a C) in series",
    )


def not_converged(time: float) -> Diagnostic:
    """BG714: an implicit step that did not converge"""
    return error(
        "BG714",
        f"at t = {time:.9g} s Newton's method did not converge in an implicit step",
        help="use a smaller step, or a method that does not iterate, such as `rodas5p`",
    )
