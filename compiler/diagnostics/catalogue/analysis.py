"""Diagnostics: linear analysis."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import Values, error, nearest, quoted


@error("BG080: there is no input `{name}`", "{there}")
def unknown_input(name: str, candidates: Iterable[str]) -> Values:
    known = list(candidates)
    more = " and more" if len(known) > 6 else ""
    some = f"there are {quoted(known[:6])}{more}"
    return {
        "there": some if known else "the model has no sources and no parameters",
        **nearest(name, known),
    }


@error(
    "BG081: the input `{name}` multiplies a rate in an equation",
    "solve the equation for the rate, for example `der(v) = F/m;`",
)
def input_in_mass(name: str) -> None: ...
@error(
    "BG082: no equilibrium was found: `{name}` still changes by {per_second}",
    "linearise at a point in time, for example `--at 10 s`, or start nearer to the equilibrium",
)
def no_equilibrium(name: str, rate: float, unit: str) -> Values:
    return {
        "per_second": f"{rate:.3g} {unit}/s" if unit not in ("", "1") else f"{rate:.3g} per second"
    }


@error(
    "BG083: `{name}` is an integral over the run and cannot be an output of a linear model",
    "choose an effort, a flow or an expression of them",
)
def account_as_output(name: str) -> None: ...
@error("BG084: `{text}` has {count} components", "choose one: `--{option} {first}`")
def several_components(option: str, text: str, names: Sequence[str]) -> Values:
    return {"count": len(names), "first": names[0]}


@error(
    "BG086: `{output}` does not respond to `{input_}` at this operating point",
    "linearise at another point, for example `--at 10 s`, or choose an input behind the "
    "dead band or sampled part between them",
)
def no_response(input_: str, output: str) -> None: ...
@error(
    "BG660: one {kind} is needed, and the linear model has {some}",
    "name it in `model.linearise([input], [output])`{channel}",
)
def several_channels(kind: str, names: Sequence[str]) -> Values:
    more = " and more" if len(names) > 6 else ""
    some = f"{len(names)}: {quoted(names[:6])}{more}" if names else "none"
    return {
        "some": some,
        "channel": ", or take one by `linear.channel(output, input)`" if names else "",
    }


@error(
    "BG085: {low:g} to {high:g} rad/s is not a valid range of frequencies",
    "give `--from` below `--to`, both positive, in rad/s",
)
def no_range(low: float, high: float) -> None: ...
@error(
    "BG795: no `{input_}` solves the loop: `{output}` responds to it instantly with -1/{gain:.6g}",
    "choose another gain, or an output behind a storage element",
)
def no_loop(gain: float, input_: str, output: str) -> None: ...
@error(
    "BG796: the response of `{output}` is not computed: algebraic equations remain in the "
    "linear model",
    "`bgc bode` and `bgc run` accept such a model",
)
def no_time_response(output: str) -> None: ...
@error(
    "BG797: a step response needs a positive duration, not {duration:g} s",
    "without `--time`, six time constants of the slowest mode are taken",
)
def bad_duration(duration: float) -> None: ...
@error(
    "BG794: the mass matrix of this linear form is singular",
    "use `A`, `B`, `C`, `D` and `E` as a descriptor system",
)
def singular_mass() -> None: ...
@error(
    "BG798: the response of `{name}` leaves the range of double precision",
    "choose a gain nearer to 1, or a shorter `--time`",
)
def out_of_range(name: str) -> None: ...
