"""Diagnostics: failures during a run."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, listed, quoted
from bgc.diagnostics.source import Span

_FASTEST = "check the parameters and the initial value of the state at fault"
_NAMED = 3  # states at most


def _state(name: str | None) -> str:
    return f"; state `{name}` is at fault" if name else ""


def _few(words: str, states: Sequence[str]) -> str:
    """Name the states that a law switches on or a quantity depends on, if they are few."""
    return f"{words} {quoted(states)}" if 0 < len(states) <= _NAMED else ""


@error(
    "BG701: at t = {time:.9g} s no step is small enough for the tolerance{state}",
    _FASTEST + "; loosen `rtol` if it is close to rounding (1e-15), or shorten `min_step` "
    "if it is given",
)
def step_too_small(time: float, state: str | None) -> Values:
    return {"state": _state(state)}


@error(
    "BG702: too many steps between two rows at t = {time:.9g} s{state}",
    "use a stiff method (`solver rodas5p`), a longer step or a looser tolerance",
)
def too_many_steps(time: float, state: str | None) -> Values:
    return {"state": _state(state)}


@error(
    "BG703: a value is not finite after t = {time:.9g} s{state}",
    "shorten the step or use a stiff method; guard laws that are undefined for some values",
)
def not_finite(time: float, state: str | None) -> Values:
    return {"state": _state(state)}


@error(
    "BG704: the equations have no unique solution at t = {time:.9g} s{state}",
    "look for an equation that does not determine its unknown, or a ratio that is zero",
)
def singular(time: float, state: str | None) -> Values:
    return {"state": _state(state)}


@error(
    "BG725: at t = {time:.6g} s {what} vanishes{at}: the equations divide by it",
    "add the small inertia or compliance that the part has before its modulus, or keep "
    "the model away from this position",
)
def divisor_vanishes(
    time: float, what: str, states: Sequence[str] = (), span: Span | None = None
) -> Values:
    return {"at": _few(", which depends on", states)}


@error(
    "BG705: {message} (at t = {time:.9g} s)",
    "change the inputs or parameters that lead there, or the model: this `assert` ended the run",
)
def assertion_failed(time: float, message: str, span: Span | None = None) -> None: ...
@error(
    "BG706: {device} reported a fault at t = {time:.9g} s; its forces are zero{why}",
    "check the device, then run again",
)
def device_failed(time: float, devices: Sequence[str], reason: str = "") -> Values:
    return {"device": _device(devices), "why": f": {reason}" if reason else ""}


def _device(names: Sequence[str]) -> str:
    """The device at fault where the scene has one only, else all of its devices."""
    return f"device `{names[0]}`" if len(names) == 1 else f"one of the devices {listed(names)}"


@error("BG707: {message}", "change {named}")
def parameters_refused(message: str, sources: Sequence[str] = ()) -> Values:
    return {"named": quoted(sources) or "the parameters that it depends on"}


@error(
    "BG708: there is no memory left for an instance of the model",
    "free some memory, or keep fewer models at once",
)
def no_memory() -> None: ...
@error("BG709: interrupted at t = {time:.9g} s; the rows up to there are kept")
def interrupted(time: float) -> None: ...
@error(
    "BG710: an explicit solver cannot solve equations that couple rates",
    "use `solver rodas5p`, or `ros34prw` with a step",
)
def not_explicit() -> None: ...
@error(
    "BG711: at t = {time:.9g} s no values near the given ones satisfy the equations{state}{loop}",
    "give `unknown NAME = VALUE;` a better starting value, or correct its equation; give "
    "a law that becomes flat, such as a blocking diode, a small slope",
)
def inconsistent(time: float, state: str | None, through: Sequence[str] = ()) -> Values:
    return {
        "state": _state(state),
        "loop": f", in the algebraic loop through {listed(through)}" if through else "",
    }


@error(
    "BG715: at t = {time:.9g} s a law switches back and forth endlessly{by}",
    "replace the jump by a steep slope, for example `sign(f)` by `tanh(f/v0)`, or put a "
    "stiff spring (a C) in series",
)
def chattering(time: float, states: Sequence[str] = (), span: Span | None = None) -> Values:
    return {"by": _few(", on", states)}


@error(
    "BG714: at t = {time:.9g} s Newton's method did not converge in an implicit step",
    "use a smaller step, or a method that does not iterate, such as `rodas5p`",
)
def not_converged(time: float) -> None: ...
