"""Diagnostics: accuracy of results."""

from __future__ import annotations

from bgc.diagnostics.catalogue import Values, warning


@warning(
    "BG712: `{name}` is not finite {when}",
    "check its divisions and the domains of its functions; an `assert` in the model ends "
    "the run there",
)
def value_not_finite(name: str, time: float, to_the_end: bool) -> Values:
    return {"when": f"from {time:.9g} s onwards" if to_the_end else f"at {time:.9g} s"}


@warning(
    "BG716: from t = {time:.9g} s onwards the energies do not balance: the residual is "
    "{share:.2g} of the energy exchanged",
    "use a smaller step or tolerance, or another method; `bgc trade` finds one",
)
def out_of_balance(time: float, share: float) -> None: ...
@warning(
    "BG719: the step of {step:g} s is too long at t = {time:.9g} s: the stages of the method "
    "differ by {part:.2g} of the range of `{state}`",
    "use a shorter step, or a method with error control (`solver rodas5p`); see `bgc doc BG719`",
)
def step_too_long(time: float, state: str, part: float, step: float) -> None: ...
@warning(
    "BG730: {samples:counted step} of {step:g} s exceeded the tolerance although divided into "
    "{substeps} parts: the error was {excess:.2g} times the tolerance at t = {time:.9g} s",
    "allow more `substeps`, shorten `step`, or use a method with error control (`solver rodas5p`)",
)
def samples_over_budget(
    samples: int, step: float, substeps: int, time: float, excess: float
) -> None: ...
@warning(
    "BG720: the scene requires `{text}`, which does not hold: it is {value} at t = {time:.6g} s",
    "change the parameters or the limit; `bgc optimise` finds values that meet limits",
)
def limit_missed(text: str, value: str, time: float) -> None: ...
@warning(
    "BG721: the scene requires `{text}`, but the estimated error is {error}",
    "use a smaller step or tolerance, or another method; `bgc trade` finds one",
)
def not_accurate(text: str, error: str) -> None: ...
@warning(
    "BG726: rounding decides `{state}`: it was below its tolerance of {tolerance:.2g} at t = "
    "{fell:.6g} s, had grown again by t = {grown:.6g} s, and ends at {end:.4g}; a change "
    "of the size of that tolerance leads elsewhere"
)
def rounding_decides(
    state: str,
    tolerance: float,
    times: tuple[float, float],
    end: float,
    cure: tuple[float, float] | None,
) -> Values:
    fell, grown = times
    help_ = _cure(cure, "add the imperfection that decides it in reality")
    return {"fell": fell, "grown": grown, "help": help_}


def _cure(cure: tuple[float, float] | None, otherwise: str) -> str:
    if cure is None:
        return f"no absolute tolerance cures it: {otherwise}"
    atol, right = cure
    return f"give `atol = {atol:g}` (`--atol {atol:g}`), with which it ends at {right:.4g}"


@warning(
    "BG733: `{state}` moves below its tolerance of {tolerance:.2g}: error control does not see it, "
    "and what is observed depends on it"
)
def moves_below(state: str, tolerance: float, cure: tuple[float, float] | None) -> Values:
    return {"help": _cure(cure, "write the model in units in which its motion is larger")}


@warning(
    "BG731: rounding errors of the equations limit the steps: in {affected} of {examined} steps "
    "that were examined they make up the error estimate",
    "loosen `rtol` by a factor of 10 or 100, or write the equations without differences "
    "of large terms; see `bgc doc BG731`",
)
def limited_by_rounding(affected: int, examined: int) -> None: ...
