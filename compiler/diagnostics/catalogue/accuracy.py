"""BG7xx: warnings that the results of a run may be inaccurate."""

from __future__ import annotations

from bgc.diagnostics.catalogue import warning
from bgc.diagnostics.diagnostic import Diagnostic


def value_not_finite(name: str, time: float, to_the_end: bool) -> Diagnostic:
    """BG712: a value in the rows that is not finite

    What: an observed value is infinite or not a number in some rows; the run continued.

    Why: no state depends on the value, so the solver did not see it. Usually it is a division by
    zero, or a function outside its domain.

    Example: `observe y;` with `let y = 1 / (time - 1 s);`, at 1 s.

    Way out: check the division or the function; an `assert` in the model ends the run there.
    """
    when = f"from {time:.9g} s onwards" if to_the_end else f"at {time:.9g} s"
    return warning(
        "BG712",
        f"`{name}` is not finite {when}",
        help="check its divisions and the domains of its functions; an `assert` in the model "
        "ends the run there",
    )


def out_of_balance(time: float, share: float) -> Diagnostic:
    """BG716: the energies of a run do not balance

    What: the change of stored energy differs from supplied minus dissipated energy by more than
    half a per cent of all energy exchanged.

    Why: a bond graph conserves energy, so the difference is an integration error: the step is too
    long or the tolerance too loose. The rows are likely to be as inaccurate.

    Example: `solver heun; step 10 ms;` for a mass on a stiff spring.

    Way out: use a smaller step or tolerance, or another method; `bgc trade` finds the cheapest one
    that is accurate enough.
    """
    return warning(
        "BG716",
        f"from t = {time:.9g} s onwards the energies do not balance: the residual is "
        f"{share:.2g} of the energy exchanged",
        help="use a smaller step or tolerance, or another method; `bgc trade` finds one",
    )


def step_too_long(time: float, state: str, part: float, step: float) -> Diagnostic:
    """BG719: a fixed step is too long for the equations

    What: within one step the stages of the method disagree by a large part of a state's range. The
    rows from there on are unreliable.

    Why: the step does not resolve the motion: it jumps over a pole or a wall, an explicit method is
    beyond its stability limit, or a mode with a noticeable amplitude is much faster than the step.
    If that mode is a stiff spring that starts out of balance, an L-stable method damps it within a
    few steps, and the slow motion is right.

    Example: `solver rk4; step 10 ms;` for a spring that oscillates at 100 Hz.

    Way out: use a shorter step, or a method with error control such as `rodas5p`; use `settle` if
    springs start out of balance.
    """
    return warning(
        "BG719",
        f"the step of {step:g} s is too long at t = {time:.9g} s: the stages of the method differ "
        f"by {part:.2g} of the range of `{state}`",
        help="use a shorter step, or a method with error control (`solver rodas5p`); "
        "see `bgc doc BG719`",
    )


def samples_over_budget(
    samples: int, step: float, substeps: int, time: float, excess: float
) -> Diagnostic:
    """BG730: fixed steps with an error above the tolerance

    What: some fixed steps were divided into as many parts as `substeps` allows, and the error
    estimate of a part was still above `rtol`. The run went on with that error.

    Why: the budget bounds the time that a step takes, which a real-time run needs. The motion
    within these steps is faster than the budget resolves: an impact, a valve that opens, stiff
    springs that start out of balance, an explicit method beyond its stability limit.

    Example: `solver ros34prw(substeps = 2); step 10 ms;` for a pressure that settles within 0.1 ms.

    Way out: allow more `substeps`, shorten `step`, or choose a method with error control; use
    `settle` if springs start out of balance. A few such steps at the start or at an impact may be
    acceptable: compare with a run of `rodas5p`.
    """
    steps = "1 step" if samples == 1 else f"{samples:,} steps"
    return warning(
        "BG730",
        f"{steps} of {step:g} s exceeded the tolerance although divided into {substeps} parts: the "
        f"error was {excess:.2g} times the tolerance at t = {time:.9g} s",
        help="allow more `substeps`, shorten `step`, or use a method with error control "
        "(`solver rodas5p`)",
    )


def rounding_decides(
    state: str,
    tolerance: float,
    times: tuple[float, float],
    end: float,
    cure: tuple[float, float] | None,
) -> Diagnostic:
    """BG726: rounding decides a state

    What: a state fell below its absolute tolerance and grew again by orders of magnitude. The run
    was repeated with the state moved by its tolerance when it was smallest, and ended at a
    different value.

    Why: error control cannot see a state below its tolerance, so a decay over many decades may end
    at any small value, of either sign. If the state is then unstable (a bifurcation that is passed
    slowly, a population that recovers, a column that buckles), it grows from that remainder, and
    rounding determines its sign or the time of its growth. Every method and every relative
    tolerance may give the same wrong answer.

    Example: `der(x) = (s*x - x^3)/0.02` with s from -1 to 1.5 and x = 0.1 at the start: x falls to
    1e-12, and ends at +1.22 or -1.22.

    Way out: give the absolute tolerance that the message names: it was tried, and the result no
    longer depends on it. If no tolerance helps, rounding decides the answer of the model itself:
    add the imperfection that decides it in reality.
    """
    fell, grown = times
    if cure is None:
        help_ = "no absolute tolerance cures it: add the imperfection that decides it in reality"
    else:
        atol, right = cure
        help_ = f"give `atol = {atol:g}` (`--atol {atol:g}`), with which it ends at {right:.4g}"
    return warning(
        "BG726",
        f"rounding decides `{state}`: it was below its tolerance of {tolerance:.2g} at "
        f"t = {fell:.6g} s, had grown again by t = {grown:.6g} s, and ends at {end:.4g}; a change "
        "of the size of that tolerance leads elsewhere",
        help=help_,
    )


def limited_by_rounding(affected: int, examined: int) -> Diagnostic:
    """BG731: rounding limits the steps

    What: the error estimate, by which the method chooses its steps, consists of rounding errors of
    the equations in a large part of the run.

    Why: the equations subtract large terms that almost cancel, as the finite differences of a fine
    mesh do: their rounding errors grow with 1/dx^2, in a beam with 1/dx^4. These do not fall with
    the step as the error of the method does, so error control takes many more steps than the motion
    needs, without a better result.

    Example: a beam of 600 elements at `rtol = 1e-10` takes 93,000 steps, one of 100 elements 1,500.

    Way out: loosen `rtol` by a factor of 10 or 100: the accuracy is the same. Or write the
    equations in differences that are states themselves (deflections of springs), or use a coarser
    mesh.
    """
    return warning(
        "BG731",
        f"rounding errors of the equations limit the steps: in {affected} of {examined} steps "
        "that were examined they make up the error estimate",
        help="loosen `rtol` by a factor of 10 or 100, or write the equations without differences "
        "of large terms; see `bgc doc BG731`",
    )
