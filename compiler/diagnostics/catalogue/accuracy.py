"""BG7xx: warnings that the results of a run may be inaccurate."""

from __future__ import annotations

from bgc.diagnostics.catalogue import warning
from bgc.diagnostics.diagnostic import Diagnostic


def value_not_finite(name: str, time: float, to_the_end: bool) -> Diagnostic:
    """BG712: a value in the rows that is not finite"""
    when = f"from {time:.9g} s onwards" if to_the_end else f"at {time:.9g} s"
    return warning(
        "BG712",
        f"`{name}` is not finite {when}",
        help="check its divisions and the domains of its functions; an `assert` in the model "
        "ends the run there",
    )


def out_of_balance(time: float, share: float) -> Diagnostic:
    """BG716: the energies of a run do not balance"""
    return warning(
        "BG716",
        f"from t = {time:.9g} s onwards the energies do not balance: the residual is "
        f"{share:.2g} of the energy exchanged",
        help="use a smaller step or tolerance, or another method; `bgc trade` finds one",
    )


def step_too_long(time: float, state: str, part: float, step: float) -> Diagnostic:
    """BG719: a fixed step is too long for the equations"""
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
    """BG730: fixed steps with an error above the tolerance"""
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
    """BG726: rounding decides a state"""
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
    """BG731: rounding limits the steps"""
    return warning(
        "BG731",
        f"rounding errors of the equations limit the steps: in {affected} of {examined} steps "
        "that were examined they make up the error estimate",
        help="loosen `rtol` by a factor of 10 or 100, or write the equations without differences "
        "of large terms; see `bgc doc BG731`",
    )
