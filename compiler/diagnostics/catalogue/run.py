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
    """BG701: no step is small enough

    What: the adaptive method did not meet the tolerance with any step that the time can resolve.

    Why: the solution goes to infinity or jumps, or the tolerance is tighter than rounding.

    Example: `der(x) = x^2` from 1, at t = 1.

    Way out: check the state named; loosen `rtol`, or correct an equation that has a pole.
    """
    return error(
        "BG701",
        f"at t = {time:.9g} s no step is small enough for the tolerance{_state(state)}",
        help=f"{_FASTEST}; loosen `rtol` if it is close to rounding (1e-15)",
    )


def too_many_steps(time: float, state: str | None) -> Diagnostic:
    """BG702: too many steps between two rows

    What: the run was stopped because it made too little progress.

    Why: an explicit method is used on a stiff model, or a fixed step is far too short.

    Example: `solver rk4` with an adaptive step on a crane with stiff joints.

    Way out: use `solver rodas5p`, a longer step, or a looser tolerance.
    """
    return error(
        "BG702",
        f"too many steps between two rows at t = {time:.9g} s{_state(state)}",
        help="use a stiff method (`solver rodas5p`), a longer step or a looser tolerance",
    )


def not_finite(time: float, state: str | None) -> Diagnostic:
    """BG703: a value is no longer finite

    What: an overflow, a division by zero or a function outside its domain occurred, in the rates,
    in a state, or in the energy accounts.

    Why: the model is unstable, a fixed step is too long, or a law is used where it is undefined.
    Energies grow with the squares of the states, and overflow first.

    Example: `sqrt(x)` with x below zero; an explicit method on a stiff spring.

    Way out: use a shorter step or a stiff method; guard the law, for example with `max(x, 0)`.
    """
    return error(
        "BG703",
        f"a value is not finite after t = {time:.9g} s{_state(state)}",
        help="shorten the step or use a stiff method; guard laws that are undefined for some "
        "values",
    )


def singular(time: float, state: str | None) -> Diagnostic:
    """BG704: the equations of a step are singular

    What: the matrix of an implicit step cannot be factorised.

    Why: an algebraic equation does not determine its unknown, or a modulus became zero.

    Example: `equation 0*z = x;`.

    Way out: check the state named and the equation or bond that determines it.
    """
    return error(
        "BG704",
        f"the equations have no unique solution at t = {time:.9g} s{_state(state)}",
        help="look for an equation that does not determine its unknown, or a ratio that is zero",
    )


def divisor_vanishes(
    time: float, what: str, states: Sequence[str] = (), place: Span | None = None
) -> Diagnostic:
    """BG725: a divisor of the equations vanishes

    What: a quantity by which the equations divide passed through zero, or nearly. The rates have a
    pole there, and the run cannot go on.

    Why: the modulus between a flow and all inertia that it moves became zero, or a coefficient of a
    law or of an algebraic loop became zero. At a dead centre of a mechanism nothing resists the
    force.

    Example: a force on an inertia behind `t : MTF(cos(angle))`, at angle = 90 deg.

    Way out: add the inertia of the parts between the force and the modulus (a crank, a shaft); real
    parts always have mass. Or keep the mechanism away from that position.
    """
    return error(
        "BG725",
        f"at t = {time:.6g} s {what} vanishes{_at(states)}: the equations divide by it",
        place,
        help="add the small inertia or compliance that the part has before its modulus, or keep "
        "the model away from this position",
    )


def assertion_failed(time: float, message: str, place: Span | None = None) -> Diagnostic:
    """BG705: an `assert` of the model failed

    What: a condition that the model requires for its validity is false.

    Why: the model was driven outside its range of validity.

    Example: `assert cos(theta) > 0.01, "pitch of 90 deg";`.

    Way out: change the inputs or parameters that lead there, or extend the model.
    """
    return error(
        "BG705",
        f"{message} (at t = {time:.9g} s)",
        place,
        help="change the inputs or parameters that lead there, or the model: this `assert` ended "
        "the run",
    )


def device_failed(time: float, devices: Sequence[str], reason: str = "") -> Diagnostic:
    """BG706: a device reported a fault

    What: reading from or writing to a device failed; its forces were set to zero.

    Why: the device is unplugged or switched off, or its data end in a form that cannot be
    continued.

    Example: the handle's cable was pulled.

    Way out: check the device, then run again.
    """
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
    """BG707: parameters without a valid model

    What: a quantity computed from the parameters has an impossible value. Parameters that were set
    and give that value each alone are named.

    Why: a mass, a compliance or another divisor is zero or negative, or a seed or index of `random`
    is not a whole number.

    Example: `--set m=0` where `m` is the parameter of an I.

    Way out: change the parameters that the message names.
    """
    named = ", ".join(f"`{source}`" for source in sources) or "the parameters that it depends on"
    return error("BG707", message, help=f"change {named}")


def no_memory() -> Diagnostic:
    """BG708: no memory for an instance of the model

    What: the operating system did not provide the memory.

    Why: the machine's memory is full, or its limits are tight.

    Example: `ulimit -v` below what the model needs.

    Way out: free some memory, or keep fewer models at once.
    """
    return error(
        "BG708",
        "there is no memory left for an instance of the model",
        help="free some memory, or keep fewer models at once",
    )


def interrupted(time: float) -> Diagnostic:
    """BG709: the run was interrupted

    What: Ctrl-C, SIGTERM or a call to `stop` ended the run.

    Why: the user asked for it.

    Example: Ctrl-C.

    Way out: nothing is needed: the rows up to this time are kept.
    """
    return error("BG709", f"interrupted at t = {time:.9g} s; the rows up to there are kept")


def not_explicit() -> Diagnostic:
    """BG710: an explicit method on equations that couple rates

    What: an equation of the model contains several rates, and the method cannot solve for them.

    Why: explicit methods need each derivative separately. They do solve for unknowns and algebraic
    loops, at each stage.

    Example: `solver rk4` with `equation der(x) + der(y) = -x;`.

    Way out: use an implicit method: `solver rodas5p`, or `ros34prw` with a step.
    """
    return error(
        "BG710",
        "an explicit solver cannot solve equations that couple rates",
        help="use `solver rodas5p`, or `ros34prw` with a step",
    )


def inconsistent(time: float, state: str | None, through: Sequence[str] = ()) -> Diagnostic:
    """BG711: no consistent values

    What: no solution of the algebraic equations was found: near the given values, along the way
    from them to the equations (a homotopy), or, at the start and after a switch, from others.

    Why: the starting values are far off, the equations contradict each other, or the solution
    ceased to exist during the run. Or the laws of a loop nearly leave it open: if ideal diodes all
    block, the voltage between them is arbitrary.

    Example: `unknown z = 0; equation z^2 = -1;`.

    Way out: give the unknown a better starting value, or correct its equation. Give a law that
    becomes flat a small slope: `f = Is*(exp(e/Vt) - 1) + leak*e`.
    """
    loop = f", in the algebraic loop through {listed(through)}" if through else ""
    return error(
        "BG711",
        f"at t = {time:.9g} s no values near the given ones satisfy the equations"
        f"{_state(state)}{loop}",
        help="give `unknown NAME = VALUE;` a better starting value, or correct its equation; give "
        "a law that becomes flat, such as a blocking diode, a small slope",
    )


def chattering(time: float, states: Sequence[str] = (), place: Span | None = None) -> Diagnostic:
    """BG715: a law that switches endlessly

    What: a law that jumps (`if .. then .. else`, `sign`) changes its mode again and again at the
    same time, so the run cannot advance.

    Why: on both sides of the switch the model is driven back to it. It would have to stay there
    with an intermediate value, which the law does not give.

    Example: dry friction written as `R { e = mu*N*sign(f); }`, when the body comes to rest.

    Way out: replace the jump by a steep slope (`e = mu*N*tanh(f/v0)`, with a small v0), or put a
    stiff spring (a C) in series with the friction.
    """
    return error(
        "BG715",
        f"at t = {time:.9g} s a law switches back and forth endlessly{_by(states)}",
        place,
        help="replace the jump by a steep slope, for example `sign(f)` by `tanh(f/v0)`, or put a "
        "stiff spring (a C) in series",
    )


def not_converged(time: float) -> Diagnostic:
    """BG714: an implicit step that did not converge

    What: a step of `midpoint`, `gauss4` or `radau5` solves a set of equations by Newton's method,
    which did not converge.

    Why: the step is too long for the nonlinearity of the equations, for example at an end stop or
    near an overflow.

    Example: `solver midpoint; step 1 s;` for a stiff nonlinear spring.

    Way out: use a smaller step, or a linearly implicit method such as `rodas5p`, which does not
    iterate.
    """
    return error(
        "BG714",
        f"at t = {time:.9g} s Newton's method did not converge in an implicit step",
        help="use a smaller step, or a method that does not iterate, such as `rodas5p`",
    )
