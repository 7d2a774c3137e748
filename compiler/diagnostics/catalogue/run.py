"""BG7xx: what may go wrong while a compiled model runs."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span

_FASTEST = "see which state is at fault, and whether its parameters and initial value make sense"
_NAMED = 3  # states at most


def _state(name: str | None) -> str:
    return f"; state `{name}` is at fault" if name else ""


def _by(states: Sequence[str]) -> str:
    """The states that a law switches on, where they are few enough to help."""
    named = ", ".join(f"`{name}`" for name in states)
    return f", on {named}" if 0 < len(states) <= _NAMED else ""


def step_too_small(time: float, state: str | None) -> Diagnostic:
    """BG701: the error control asked for a step that is too small

    What: the adaptive method could not meet the tolerance with any step the clock resolves.

    Why: the solution runs to infinity or jumps, or the tolerance is tighter than rounding.

    Example: `der(x) = x^2` from 1, at t = 1.

    Way out: look at the state named; loosen `rtol`, or mend the equation that has a pole.
    """
    return error(
        "BG701",
        f"at t = {time:.9g} s no step is small enough for the tolerance{_state(state)}",
        help=f"{_FASTEST}; a looser `rtol` helps where it is close to rounding (1e-15)",
    )


def too_many_steps(time: float, state: str | None) -> Diagnostic:
    """BG702: too many steps between two rows

    What: the run was ended because it made no visible progress.

    Why: an explicit method on a stiff model, or a fixed step far too short.

    Example: `solver rk4` with an adaptive step on a crane with stiff joints.

    Way out: `solver rodas5p`, a longer step, or a looser tolerance.
    """
    return error(
        "BG702",
        f"too many steps between two rows at t = {time:.9g} s{_state(state)}",
        help="use a stiff method (`solver rodas5p`), a longer step or a looser tolerance",
    )


def not_finite(time: float, state: str | None) -> Diagnostic:
    """BG703: a value is no longer finite

    What: an overflow, a division by zero or a function outside its domain.

    Why: an unstable model, a fixed step that is too long, or a law used where it is undefined.

    Example: `sqrt(x)` with x below zero; an explicit method on a stiff spring.

    Way out: a shorter step or a stiff method; guard the law, for instance with `max(x, 0)`.
    """
    return error(
        "BG703",
        f"a value is not finite after t = {time:.9g} s{_state(state)}",
        help="shorten the step or use a stiff method; guard laws that are undefined somewhere",
    )


def singular(time: float, state: str | None) -> Diagnostic:
    """BG704: the equations of a step are singular

    What: the matrix of the linearly implicit step cannot be factorised.

    Why: an algebraic equation does not determine its unknown, or a modulus became zero.

    Example: `equation 0*z = x;`.

    Way out: look at the state named and at the equation or bond that determines it.
    """
    return error(
        "BG704",
        f"the equations have no unique solution at t = {time:.9g} s{_state(state)}",
        help="look for an equation that does not determine its unknown, or a ratio that is zero",
    )


def assertion_failed(time: float, message: str, place: Span | None = None) -> Diagnostic:
    """BG705: an `assert` of the model failed

    What: a condition that the model states for its own validity is false.

    Why: the model was driven beyond what it describes.

    Example: `assert cos(theta) > 0.01, "pitch of 90 deg";`.

    Way out: as the message says.
    """
    return error(
        "BG705",
        f"{message} (at t = {time:.9g} s)",
        place,
        help="the model ends the run by an `assert`: change what leads there, or the model",
    )


def device_failed(time: float) -> Diagnostic:
    """BG706: a device reported a fault

    What: reading from or writing to a device failed; its forces were set to zero.

    Why: unplugged, switched off, or the end of its data in a form it cannot continue from.

    Example: the handle's cable was pulled.

    Way out: check the device, then run again.
    """
    return error(
        "BG706",
        f"a device reported a fault at t = {time:.9g} s; its forces are zero",
        help="check the device, then run again",
    )


def parameters_refused(message: str) -> Diagnostic:
    """BG707: parameters that give no valid model

    What: a quantity that follows from the parameters has a value that makes no sense.

    Why: a mass, a compliance or another divisor is zero or negative.

    Example: `--set m=0` where `m` is the parameter of an I.

    Way out: change the parameters that the message names.
    """
    return error("BG707", message, help="change the parameters that it depends on")


def no_memory() -> Diagnostic:
    """BG708: no memory for an instance of the model

    What: the operating system gave no memory.

    Why: the machine is full, or its limits are tight.

    Example: `ulimit -v` below what the model needs.

    Way out: free some memory.
    """
    return error(
        "BG708",
        "there is no memory left for an instance of the model",
        help="free some memory, or keep fewer models at once",
    )


def interrupted(time: float) -> Diagnostic:
    """BG709: the run was interrupted

    What: Ctrl-C, SIGTERM, or a call to `stop`, ended the run.

    Why: somebody asked for it.

    Example: Ctrl-C.

    Way out: none needed: the rows up to this time are kept.
    """
    return error("BG709", f"interrupted at t = {time:.9g} s; the rows up to there are kept")


def not_explicit() -> Diagnostic:
    """BG710: an explicit method on equations that couple rates

    What: an equation of the model holds several rates, and the method cannot solve for them.

    Why: explicit methods need every derivative by itself. Unknowns and
    algebraic loops they do solve, at every stage.

    Example: `solver rk4` with `equation der(x) + der(y) = -x;`.

    Way out: an implicit method: `solver rodas5p`, or `ros34prw` with a step.
    """
    return error(
        "BG710",
        "an explicit solver cannot solve equations that couple rates",
        help="use `solver rodas5p`, or `ros34prw` with a step",
    )


def inconsistent(time: float, state: str | None) -> Diagnostic:
    """BG711: no consistent values were found

    What: the algebraic equations have no solution near the values given.

    Why: starting values that are far off, equations that contradict each other, a solution
    that has ceased to exist during the run, or one that the laws of a loop all but leave open:
    ideal diodes that all block let the voltage between them be anything.

    Example: `unknown z = 0; equation z^2 = -1;`.

    Way out: give the unknown a better starting value, or mend its equation. Give a law that
    becomes flat a small slope: `f = Is*(exp(e/Vt) - 1) + leak*e`.
    """
    return error(
        "BG711",
        f"at t = {time:.9g} s no values near the given ones satisfy the equations{_state(state)}",
        help="give `unknown NAME = VALUE;` a better starting value, or mend its equation; give a "
        "law that becomes flat, as that of a diode that blocks, a small slope",
    )


def chattering(time: float, states: Sequence[str] = (), place: Span | None = None) -> Diagnostic:
    """BG715: a law switches to and fro without end

    What: a law that jumps (`if .. then .. else`, `sign`) changes its mode again as soon as it has
    changed it, again and again, and time stands still.

    Why: on both sides of the switch the model is driven back to it. It would have to stick there
    with a value in between, which the law does not give.

    Example: dry friction written as `R { e = mu*N*sign(f); }`, when the body comes to rest.

    Way out: give the law a steep slope instead of the jump (`e = mu*N*tanh(f/v0)`, with a small
    v0), or let it stick on a stiff spring (a C in series with the friction).
    """
    return error(
        "BG715",
        f"at t = {time:.9g} s a law switches to and fro without end{_by(states)}",
        place,
        help="give it a steep slope instead of a jump, such as `tanh(f/v0)` for `sign(f)`, or let "
        "it stick on a stiff spring",
    )


def value_not_finite(name: str, time: float, to_the_end: bool) -> Diagnostic:
    """BG712: a value in the rows is not finite

    What: an observed value is infinite or not a number in some rows; the run went on.

    Why: nothing that the states depend on uses the value, so the method did not meet it: mostly
    a division by zero, or a function outside its domain.

    Example: `observe y;` where `let y = 1 / (time - 1 s);`, at 1 s.

    Way out: check the division or the function; an `assert` in the model ends the run there.
    """
    when = f"from {time:.9g} s on" if to_the_end else f"at {time:.9g} s"
    return warning(
        "BG712",
        f"`{name}` is not finite {when}",
        help="check its divisions and the domains of its functions; an `assert` in the model "
        "ends the run there",
    )


def out_of_balance(time: float, share: float) -> Diagnostic:
    """BG716: the energies of a run do not balance

    What: stored energy differs from what was supplied less what was dissipated by more than half a
    per cent of all that was exchanged.

    Why: a bond graph conserves energy, whatever its laws. What is missing was lost or made by the
    integration: its step is too long, or its tolerance too wide, and the rows are as far off.

    Example: `solver heun; step 10 ms;` of a mass on a stiff spring.

    Way out: a smaller step or tolerance, or another method; `bgc trade` finds the cheapest that
    will do.
    """
    return warning(
        "BG716",
        f"from t = {time:.9g} s on the energies do not balance: the residual comes to "
        f"{share:.2g} of what was exchanged",
        help="take a smaller step or tolerance, or another method; `bgc trade` finds one",
    )


def step_too_long(time: float, state: str, part: float, step: float) -> Diagnostic:
    """BG719: a fixed step is too long for the equations

    What: within one step the method's own stages disagree by a good part of a state's whole range.
    The rows from there on are not to be trusted.

    Why: the step does not resolve what happens in it: it jumps over a pole or a wall, an explicit
    method is beyond the limit of its stability, or a mode is much faster than the step and moves
    more than a little. Where that is a stiff spring that starts out of balance, an L-stable method
    damps it within a few steps, and what is slow is right.

    Example: `solver rk4; step 10 ms;` of a spring that swings at 100 Hz.

    Way out: a shorter step, or a method with error control such as `rodas5p`; `settle` where
    springs start out of balance.
    """
    return warning(
        "BG719",
        f"the step of {step:g} s is too long at t = {time:.9g} s: within it the method corrects "
        f"itself by {part:.2g} of the range of `{state}`",
        help="take a shorter step, or a method with error control (`solver rodas5p`); "
        "`bgc explain BG719` tells more",
    )


def not_converged(time: float) -> Diagnostic:
    """BG714: the iteration of an implicit step found no solution

    What: a step of `midpoint`, `gauss4` or `radau5` is a set of equations, which is solved by
    Newton's method; it did not converge.

    Why: the step is too long for how sharply the equations bend, as at a stop or an overflow.

    Example: `solver midpoint; step 1 s;` of a stiff nonlinear spring.

    Way out: a smaller step, or a linearly implicit method such as `rodas5p`, which iterates not.
    """
    return error(
        "BG714",
        f"at t = {time:.9g} s the iteration of an implicit step found no solution",
        help="take a smaller step, or a method that does not iterate, such as `rodas5p`",
    )


def not_settled(frequency: float) -> Diagnostic:
    """BG717: fast modes do not come to rest near the start

    What: a run is to start with its fast modes at rest, but Newton's method found no such state
    near the initial one.

    Why: there may be none: a fast mode that grows, or a spring that is far from its rest; or modes
    that the frequency does not part well, as many lie near it.

    Example: `solver rodas5p(settle = 20 Hz);` where a stiff spring starts stretched by a metre.

    Way out: another frequency, well between the slow modes and the fast ones (`bgc equations
    --linear` lists them), or better initial values.
    """
    return error(
        "BG717",
        f"the modes faster than {frequency:g} Hz do not come to rest near the initial state",
        help="give a frequency between the slow and the fast modes: "
        "`bgc equations --linear` lists them",
    )


def not_separable() -> Diagnostic:
    """BG718: a consistent start of equations whose rates cannot be solved for

    What: `settle` is asked for where the model's `equation`s couple rates in a way that leaves
    some of them undetermined.

    Why: fast and slow modes are told apart by the rates of all states.

    Example: `solver rodas5p(settle = 20 Hz);` with `equation der(a) - der(b) = a;` and
    `equation der(b) - der(a) = b;`.

    Way out: leave `settle` away, or write `der(x) = ..;`.
    """
    return error(
        "BG718",
        "fast modes cannot be told from slow ones: some rates are not determined",
        help="leave `settle` away, or write each rate as `der(x) = ..;`",
    )
