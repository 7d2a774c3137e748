"""Diagnostics of linear analysis: inputs, outputs, operating points."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic


def unknown_input(name: str, candidates: Iterable[str]) -> Diagnostic:
    """BG080: an input that does not exist

    What: the name given for an input is no source, parameter or device channel of the scene.
    Why: a model is linearised by what may be varied from outside: the effort or flow that a
    source sets, the value of a parameter, what a device gives.
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
        help=did_you_mean(name, known) or some or "the model has no source and no parameter",
    )


def input_in_mass(name: str) -> Diagnostic:
    """BG081: an input that changes a mass matrix

    What: a parameter chosen as an input is a factor of a rate in an `equation`.
    Why: what follows from a change of it then depends on the rates, not on the state alone.
    Example: `equation m*der(v) = F;` with `--input m`
    Way out: write the equation solved for the rate: `der(v) = F/m;`
    """
    return error(
        "BG081",
        f"the input `{name}` is a factor of a rate in an equation",
        help="write the equation solved for the rate, as `der(v) = F/m;`",
    )


def no_equilibrium(name: str, rate: float, unit: str) -> Diagnostic:
    """BG082: no equilibrium was found

    What: no state was found, on from the initial one, in which nothing changes.
    Why: the model may have none (a charge or an angle that a source drives on and on), or the
    initial state is too far from it.
    Example: `bgc equations motor.bg --linear --steady` of a motor whose shaft angle is a state.
    Way out: linearise about the state at some time (`--at 10 s`), or start nearer to the
    equilibrium.
    """
    per_second = f"{rate:.3g} {unit}/s" if unit not in ("", "1") else f"{rate:.3g} per second"
    return error(
        "BG082",
        f"no equilibrium was found: `{name}` still changes by {per_second}",
        help="linearise about the state at some time, as `--at 10 s`, or start nearer to it",
    )


def account_as_output(name: str) -> Diagnostic:
    """BG083: an energy account as an output of a linear model

    What: an energy account is asked for as an output.
    Why: the accounts add up over a run; they are no function of the present state.
    Example: `bgc equations rlc.bg --linear --output energy.stored`
    Way out: choose an effort, a flow, or any expression of them: `--output "loop.f*supply.e"`.
    """
    return error(
        "BG083",
        f"`{name}` adds up over a run, so it is no output of a linear model",
        help="choose an effort, a flow or an expression of them",
    )


def several_components(option: str, text: str, names: Sequence[str]) -> Diagnostic:
    """BG084: one scalar was wanted, a vector was given

    What: a Bode plot is of one input and one output, and the name given has several components.
    Why: each pair of components has a curve of its own.
    Example: `bgc bode crane.bg --input hand.position --output tip_height`
    Way out: name one component: `--input hand.position[3]`
    """
    return error(
        "BG084",
        f"`{text}` has {len(names)} components",
        help=f"choose one: `--{option} {names[0]}`",
    )


def no_response(input_: str, output: str) -> Diagnostic:
    """BG086: an output that does not respond to the input

    What: at the operating point the output does not change with the input, at any frequency.
    Why: nothing leads from one to the other, or what does is flat there: a dead band, a stop, a
    valve that is shut.
    Example: the tip of a crane by a lever that rests in its dead band.
    Way out: linearise elsewhere (`--at 10 s`), or choose an input behind the dead band.
    """
    return error(
        "BG086",
        f"`{output}` does not respond to `{input_}` at this operating point",
        help="linearise elsewhere, as `--at 10 s`, or choose an input behind a dead band or stop",
    )


def no_range(low: float, high: float) -> Diagnostic:
    """BG085: a range of frequencies that is none

    What: the frequencies between which to compute a response do not rise from a positive value.
    Why: the axis of frequencies is logarithmic.
    Example: `bgc bode f.bg --input F --output x --from 100 --to 1`
    Way out: `--from` below `--to`, both positive, in rad/s.
    """
    return error(
        "BG085",
        f"{low:g} to {high:g} rad/s is no range of frequencies",
        help="give `--from` below `--to`, both positive",
    )
