"""Diagnostics of linear analysis: inputs, outputs, operating points."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic


def unknown_input(name: str, candidates: Iterable[str]) -> Diagnostic:
    """BG080: an input that does not exist"""
    known = list(candidates)
    listed = ", ".join(f"`{candidate}`" for candidate in known[:6])
    some = f"there are {listed}{' and more' if len(known) > 6 else ''}" if known else ""
    return error(
        "BG080",
        f"there is no input `{name}`",
        help=did_you_mean(name, known) or some or "the model has no sources and no parameters",
    )


def input_in_mass(name: str) -> Diagnostic:
    """BG081: an input that multiplies a rate"""
    return error(
        "BG081",
        f"the input `{name}` multiplies a rate in an equation",
        help="solve the equation for the rate, for example `der(v) = F/m;`",
    )


def no_equilibrium(name: str, rate: float, unit: str) -> Diagnostic:
    """BG082: no equilibrium was found"""
    per_second = f"{rate:.3g} {unit}/s" if unit not in ("", "1") else f"{rate:.3g} per second"
    return error(
        "BG082",
        f"no equilibrium was found: `{name}` still changes by {per_second}",
        help="linearise at a point in time, for example `--at 10 s`, or start nearer to the "
        "equilibrium",
    )


def account_as_output(name: str) -> Diagnostic:
    """BG083: an energy account as an output of a linear model"""
    return error(
        "BG083",
        f"`{name}` is an integral over the run and cannot be an output of a linear model",
        help="choose an effort, a flow or an expression of them",
    )


def several_components(option: str, text: str, names: Sequence[str]) -> Diagnostic:
    """BG084: a vector where one scalar is needed"""
    return error(
        "BG084",
        f"`{text}` has {len(names)} components",
        help=f"choose one: `--{option} {names[0]}`",
    )


def no_response(input_: str, output: str) -> Diagnostic:
    """BG086: an output that does not respond to the input"""
    return error(
        "BG086",
        f"`{output}` does not respond to `{input_}` at this operating point",
        help="linearise at another point, for example `--at 10 s`, or choose an input behind the "
        "dead band or sampled part between them",
    )


def several_channels(kind: str, names: Sequence[str]) -> Diagnostic:
    """BG660: a linear model with several inputs or outputs, or none"""
    listed = ", ".join(f"`{name}`" for name in names[:6])
    some = f"{listed}{' and more' if len(names) > 6 else ''}" if names else "none"
    return error(
        "BG660",
        f"one {kind} is needed, and the linear model has {len(names)}: {some}" if names
        else f"one {kind} is needed, and the linear model has none",
        help="name it in `model.linearise([input], [output])`"
        + (", or take one by `linear.channel(output, input)`" if names else ""),
    )  # fmt: skip


def no_range(low: float, high: float) -> Diagnostic:
    """BG085: an invalid range of frequencies"""
    return error(
        "BG085",
        f"{low:g} to {high:g} rad/s is not a valid range of frequencies",
        help="give `--from` below `--to`, both positive, in rad/s",
    )


def no_loop(gain: float, input_: str, output: str) -> Diagnostic:
    """BG795: a feedback loop without a solution"""
    return error(
        "BG795",
        f"no `{input_}` solves the loop: `{output}` responds to it instantly with -1/{gain:.6g}",
        help="choose another gain, or an output behind a storage element",
    )


def no_time_response(output: str) -> Diagnostic:
    """BG796: algebraic equations that remain in a linear model"""
    return error(
        "BG796",
        f"the response of `{output}` is not computed: algebraic equations remain in the "
        "linear model",
        help="`bgc bode` and `bgc run` accept such a model",
    )


def bad_duration(duration: float) -> Diagnostic:
    """BG797: a step response of no duration"""
    return error(
        "BG797",
        f"a step response needs a positive duration, not {duration:g} s",
        help="without `--time`, six time constants of the slowest mode are taken",
    )


def singular_mass() -> Diagnostic:
    """BG794: a linear form without a state space"""
    return error(
        "BG794",
        "the mass matrix of this linear form is singular",
        help="use `A`, `B`, `C`, `D` and `E` as a descriptor system",
    )


def out_of_range(name: str) -> Diagnostic:
    """BG798: numbers of a linear model beyond double precision"""
    return error(
        "BG798",
        f"the response of `{name}` leaves the range of double precision",
        help="choose a gain nearer to 1, or a shorter `--time`",
    )
