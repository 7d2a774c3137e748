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

    What: an overflow, a division by zero or a function outside its domain occurred.

    Why: the model is unstable, a fixed step is too long, or a law is used where it is undefined.

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

    Why: all inertia on a flow is behind a modulus that became zero, or a law or an algebraic loop
    has a coefficient that did. At a dead centre of a mechanism nothing resists the force.

    Example: a force on an inertia behind `t : MTF(cos(angle))`, at angle = 90 deg.

    Way out: add the inertia of the parts that are between the force and the modulus (a crank, a
    shaft), which are never without mass, or keep the mechanism away from that position.
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


def device_failed(time: float, devices: Sequence[str]) -> Diagnostic:
    """BG706: a device reported a fault

    What: reading from or writing to a device failed; its forces were set to zero.

    Why: the device is unplugged or switched off, or its data end in a form that cannot be
    continued.

    Example: the handle's cable was pulled.

    Way out: check the device, then run again.
    """
    return error(
        "BG706",
        f"{_device(devices)} reported a fault at t = {time:.9g} s; its forces are zero",
        help="check the device, then run again",
    )


def _device(names: Sequence[str]) -> str:
    """The device at fault where the scene has one only, else all of its devices."""
    return f"device `{names[0]}`" if len(names) == 1 else f"one of the devices {listed(names)}"


def parameters_refused(message: str) -> Diagnostic:
    """BG707: parameters without a valid model

    What: a quantity computed from the parameters has an impossible value.

    Why: a mass, a compliance or another divisor is zero or negative.

    Example: `--set m=0` where `m` is the parameter of an I.

    Way out: change the parameters that the message names.
    """
    return error("BG707", message, help="change the parameters that it depends on")


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


def endless_jumps(time: float, place: Span | None = None) -> Diagnostic:
    """BG770: jumps that follow each other ever faster

    What: a `when` becomes true again and again in ever shorter intervals, or two jumps cause each
    other without end at one instant, so the run cannot advance. The intervals have sunk to a part
    of 1e-9 of the time. The rows up to there are right.

    Why: a jump ends a contact at once, however often it returns; a ball that loses part of its
    speed at each bounce makes infinitely many bounces in a finite time. At rest it needs a force of
    the floor, which a jump does not give.

    Example: `when height < 0 m { reset ball.p = -0.8*ball.p; }` once the ball has come to rest.

    Way out: end the run before; let the last jump start a rest, `when height < 0 m and speed <
    1 mm/s { reset resting = 1; }`, where `resting` switches the weight off; or model the contact by
    a spring and a damper.
    """
    return error(
        "BG770",
        f"at t = {time:.9g} s jumps follow each other ever faster, without end",
        place,
        help="end the run before, or model the contact by a spring (C) and a damper (R)",
    )


def bad_sample(time: float, names: Sequence[str], place: Span | None = None) -> Diagnostic:
    """BG771: a sampled value that is not finite

    What: at an instant of a sampled part, an output or the next value of a state is infinite or
    undefined. The rows up to there are right.

    Why: a value that is held would carry it into everything that reads it.

    Example: `sample 1 s { state n = 2; next(n) = n - 1; output u = 1/n; }` at the third instant.

    Way out: guard the expression, for example by `if abs(n) > 0 then 1/n else 0`.
    """
    name = f" `{names[0]}`" if names else ""
    return error(
        "BG771",
        f"at t = {time:.9g} s the sampled value{name} is not finite",
        place,
        help="guard the expression that gives it, for example by an `if`",
    )


def singular_chain(time: float, parts: str) -> Diagnostic:
    """BG735: a closed chain at a singular position

    What: a closed chain of rigid connections has reached a position at which its constraints depend
    on each other, and the run cannot go on.

    Why: at a change point the chain could continue in more than one way; at a dead centre the
    efforts in it have no bound. Which way it goes depends on play and elasticity, which a rigid
    model does not have.

    Example: a parallelogram linkage of rigid bars whose bars come to lie in one line.

    Way out: make one joint of the chain compliant, or keep the motion away from the position.
    """
    chain = f" through {listed(parts.split(', '))}" if parts else ""
    return error(
        "BG735",
        f"at t = {time:.9g} s the closed chain{chain} is at a singular position",
        help="make one of its joints compliant, or keep the motion away from this position",
    )


def open_chain(condition: str) -> Diagnostic:
    """BG736: parameters for which a chain does not close at the start

    What: with these parameters the initial values leave a gap in a closed chain of rigid
    connections, and those that are not given cannot close it.

    Why: the connection is rigid, so a gap at the start would remain.

    Example: a four-bar linkage whose coupler is set longer than the others can reach.

    Way out: give other lengths or initial values; leave as many initial values ungiven as the chain
    has constraints (an `angle0` that nothing sets).
    """
    return error(
        "BG736",
        f"the chain is not closed at the start: no initial values satisfy `{condition}`",
        help="give other lengths or initial values, or leave more initial values ungiven",
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
    a speed, a pump fills a tank without an outlet. Sources and inputs have their first values.

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

    Why: the state of rest near the initial values is another one than the held values allow, or
    there is none at all: `start rest;` alone shows which (BG760).

    Example: `start rest hold spring.q;` of a spring that carries a weight.

    Way out: hold less, or free a parameter: `start rest hold spring.q vary spring_force;`
    """
    return error(
        "BG761",
        "no state of rest near the initial values keeps what `hold` names",
        help="hold less, or free a parameter by `vary`",
    )
