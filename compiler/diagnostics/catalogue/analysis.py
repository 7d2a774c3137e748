"""Diagnostics of linear analysis: inputs, outputs, operating points."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic


def unknown_input(name: str, candidates: Iterable[str]) -> Diagnostic:
    """BG080: an input that does not exist

    What: the name after `--input` is not a source, a parameter or a device channel of the scene.
    Why: a linear model responds to quantities set from outside: the effort or flow of a source, a
    parameter, or a device channel.
    Example: `bgc bode rlc.bg --input resistor.e --output loop.f`
    Way out: name a source with its variable (`supply.e`, `feed.f`), a parameter (`mass`), or a
    device's channel (`hand.position[3]`).
    """
    known = list(candidates)
    listed = ", ".join(f"`{candidate}`" for candidate in known[:6])
    some = f"there are {listed}{' and more' if len(known) > 6 else ''}" if known else ""
    return error(
        "BG080",
        f"there is no input `{name}`",
        help=did_you_mean(name, known) or some or "the model has no sources and no parameters",
    )


def input_in_mass(name: str) -> Diagnostic:
    """BG081: an input that multiplies a rate

    What: a parameter chosen as an input multiplies a rate in an `equation`.
    Why: the response to such a parameter depends on the rates, not on the state alone, so it has no
    place in A, B, C, D.
    Example: `equation m*der(v) = F;` with `--input m`
    Way out: solve the equation for the rate: `der(v) = F/m;`
    """
    return error(
        "BG081",
        f"the input `{name}` multiplies a rate in an equation",
        help="solve the equation for the rate, for example `der(v) = F/m;`",
    )


def no_equilibrium(name: str, rate: float, unit: str) -> Diagnostic:
    """BG082: no equilibrium was found

    What: starting from the initial state, no state was found in which nothing changes.
    Why: the model may not have an equilibrium (a source may drive a charge or an angle forever), or
    the initial state is too far from it.
    Example: `bgc equations motor.bg --linear --steady` for a motor whose shaft angle is a state.
    Way out: linearise at a point in time (`--at 10 s`), or start nearer to the equilibrium.
    """
    per_second = f"{rate:.3g} {unit}/s" if unit not in ("", "1") else f"{rate:.3g} per second"
    return error(
        "BG082",
        f"no equilibrium was found: `{name}` still changes by {per_second}",
        help="linearise at a point in time, for example `--at 10 s`, or start nearer to the "
        "equilibrium",
    )


def account_as_output(name: str) -> Diagnostic:
    """BG083: an energy account as an output of a linear model

    What: an output of the linear model is an energy account.
    Why: energy accounts are integrals over a run, not functions of the present state.
    Example: `bgc equations rlc.bg --linear --output energy.stored`
    Way out: choose an effort, a flow, or an expression of them: `--output "loop.f*supply.e"`.
    """
    return error(
        "BG083",
        f"`{name}` is an integral over the run and cannot be an output of a linear model",
        help="choose an effort, a flow or an expression of them",
    )


def several_components(option: str, text: str, names: Sequence[str]) -> Diagnostic:
    """BG084: a vector where one scalar is needed

    What: a loop has one input and one output, but the name given has several components.
    Why: a gain closes a loop around one output and one input.
    Example: `bgc margins crane.bg --input hand.position --output tip_height`
    Way out: name one component: `--input hand.position[3]`.
    """
    return error(
        "BG084",
        f"`{text}` has {len(names)} components",
        help=f"choose one: `--{option} {names[0]}`",
    )


def no_response(input_: str, output: str) -> Diagnostic:
    """BG086: an output that does not respond to the input

    What: at the operating point the output does not change with the input at any frequency.
    Why: the input does not affect the output, or an element between them has zero slope there: a
    dead band, an end stop, a shut valve. A sampled part holds its values in a linear form, so
    that nothing passes through it.
    Example: the tip of a crane as the output and a lever in its dead band as the input.
    Way out: linearise at another point (`--at 10 s`), or choose an input behind the dead band or
    the sampled part: that of the valve which a sampled controller commands.
    """
    return error(
        "BG086",
        f"`{output}` does not respond to `{input_}` at this operating point",
        help="linearise at another point, for example `--at 10 s`, or choose an input behind the "
        "dead band or sampled part between them",
    )


def several_channels(kind: str, names: Sequence[str]) -> Diagnostic:
    """BG660: a linear model with several inputs or outputs, or none

    What: a function of `bgc.runtime.control` that follows one signal to another was given a linear
    model with another number of inputs or outputs.
    Why: margins, loci and gains belong to one loop.
    Example: `control.margins(model.linearise())` of a scene that observes three quantities.
    Way out: name both, `model.linearise(["supply.e"], ["angle"])`, or take one pair of a larger
    model by their places, `linear.channel(0, 2)`.
    """
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
    """BG085: an invalid range of frequencies

    What: the frequency range does not increase from a positive value.
    Why: the frequency axis is logarithmic.
    Example: `bgc bode f.bg --input F --output x --from 100 --to 1`
    Way out: give `--from` below `--to`, both positive, in rad/s.
    """
    return error(
        "BG085",
        f"{low:g} to {high:g} rad/s is not a valid range of frequencies",
        help="give `--from` below `--to`, both positive, in rad/s",
    )


def no_loop(gain: float, input_: str, output: str) -> Diagnostic:
    """BG795: a feedback loop without a solution

    What: with this gain, no value of the input solves the loop.
    Why: the output responds to the input instantly, with the factor -1/gain. The input
    `gain*(reference - output)` would have to equal itself plus the reference.
    Example: `bgc step amplifier.bg --input supply.e --output inverted --closed --gain 1`, for an
    output equal to -supply.e
    Way out: choose another gain, or an output behind a storage element.
    """
    return error(
        "BG795",
        f"no `{input_}` solves the loop: `{output}` responds to it instantly with -1/{gain:.6g}",
        help="choose another gain, or an output behind a storage element",
    )


def no_time_response(output: str) -> Diagnostic:
    """BG796: algebraic equations that remain in a linear model

    What: a step response or a root locus is asked of a linear model whose algebraic equations
    cannot be eliminated at the operating point.
    Why: the response would hold impulses, or its initial values would not be determined.
    Example: a mass matrix that is singular without a row of zeros.
    Way out: `bgc bode` and `bgc run` accept such a model.
    """
    return error(
        "BG796",
        f"the response of `{output}` is not computed: algebraic equations remain in the "
        "linear model",
        help="`bgc bode` and `bgc run` accept such a model",
    )


def bad_duration(duration: float) -> Diagnostic:
    """BG797: a step response of no duration

    What: the duration of a step response is not positive.
    Why: the response would have no points.
    Example: `bgc step rlc.bg --input supply.e --output loop.f --time "0 s"`
    Way out: a positive time, or none: six time constants of the slowest mode are taken then.
    """
    return error(
        "BG797",
        f"a step response needs a positive duration, not {duration:g} s",
        help="without `--time`, six time constants of the slowest mode are taken",
    )


def singular_mass() -> Diagnostic:
    """BG794: a linear form without a state space

    What: `to_ss` was asked for the state space of `E x' = A x + B u` with a singular E.

    Why: the model has hidden constraints, which the states of a state space cannot have.

    Example: a linear form with `is_explicit` False.

    Way out: use `A`, `B`, `C`, `D` and `E` in a descriptor system, or give the model the compliance
    that the constraint neglects.
    """
    return error(
        "BG794",
        "the mass matrix of this linear form is singular",
        help="use `A`, `B`, `C`, `D` and `E` as a descriptor system",
    )


def out_of_range(name: str) -> Diagnostic:
    """BG798: numbers of a linear model beyond double precision

    What: a gain or a duration makes numbers that double precision cannot hold.
    Why: a loop with such a gain, or a response over such a time, would be rounding or infinite.
    Example: `bgc step servo.bg --input supply.e --output turn --gain 1e300 --closed`
    Way out: a smaller gain or a shorter `--time`, a few time constants of an unstable loop.
    """
    return error(
        "BG798",
        f"the response of `{name}` leaves the range of double precision",
        help="choose a gain nearer to 1, or a shorter `--time`",
    )
