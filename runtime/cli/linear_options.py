"""Options that the commands on linear models share, and the model that these name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

import click

from bgc.diagnostics.catalogue.analysis import several_components
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.cli.options import (
    input_option,
    model_file,
    output_option,
    point_options,
    read_assignments,
    read_point,
    read_uses,
    scene_option,
    set_option,
    use_option,
)
from bgc.runtime.linear.feedback import close_loop, gain_unit, with_gain
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.linearising.operating import OpenedModel
from bgc.runtime.running.quantity import read_quantity

PICTURES = (".png", ".svg", ".pdf")

_Command = TypeVar("_Command", bound=Callable[..., Any])


def scene_options(command: _Command) -> _Command:
    """Add FILE, `--scene`, `--set`, `--use`, `--at` and `--steady`."""
    return model_file(scene_option(set_option(use_option(point_options(command)))))


def open_linear(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    at: str | None,
    steady: bool,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
) -> Linearisation:
    """Linearise a scene as the options of `scene_options` say, and print its warnings."""
    point = read_point(at, steady)
    options = Options(scene, read_assignments(assignments), uses=read_uses(uses))
    opened = OpenedModel(file, options, inputs, outputs)
    linear = opened.linearise(opened.operating_point(point))
    print_diagnostics(linear.warnings)
    return linear


def channel_command(*, closable: bool) -> Callable[[_Command], Callable[..., Any]]:
    """Make a command of one input and one output, whose linear model is its argument `linear`.

    The options are those of a scene, `--input`, `--output` and `--gain`; with `closable` also
    `--closed`, for which `linear` is the closed loop.
    """

    def decorate(command: _Command) -> Callable[..., Any]:
        @wraps(command)
        def run(
            input_: str, output: str, gain: str | None, closed: bool = False, **given: Any
        ) -> Any:
            names = ("file", "scene", "assignments", "uses", "at", "steady")
            scene = {name: given.pop(name) for name in names}
            linear = open_linear(**scene, inputs=[input_], outputs=[output])
            require_one("input", input_, linear.inputs)
            require_one("output", output, linear.outputs)
            return command(linear=in_loop(linear, gain, closed), **given)

        decorated = gain_option(run)
        if closable:
            decorated = closed_option(decorated)
        return scene_options(input_option(multiple=False)(output_option(multiple=False)(decorated)))

    return decorate


def in_loop(linear: Linearisation, gain: str | None, closed: bool) -> Linearisation:
    """Put the controller's gain before a model, and close the loop where that is asked for."""
    if gain is None and not closed:
        return linear
    factor = 1.0 if gain is None else read_quantity(gain, "--gain", gain_unit(linear))
    return close_loop(linear, factor) if closed else with_gain(linear, factor)


def gain_option(command: _Command) -> _Command:
    """Add `--gain`."""
    text = 'Gain of a controller before the input: 20, or "5 V*s/rad"; by default 1 in SI units.'
    return click.option("--gain", metavar="GAIN", help=text)(command)


def closed_option(command: _Command) -> _Command:
    """Add `--closed`."""
    text = "Take the closed loop: input = gain*(reference - output)."
    return click.option("--closed", is_flag=True, help=text)(command)


def range_options(command: _Command) -> _Command:
    """Add `--from` and `--to`, which arrive as `low` and `high`."""
    low = click.option(
        "--from", "low", type=float, help="Lowest frequency, rad/s; by default from the modes."
    )
    high = click.option(
        "--to", "high", type=float, help="Highest frequency, rad/s; by default from the modes."
    )
    return low(high(command))


def plot_option(text: str) -> Callable[[_Command], _Command]:
    """Add `--plot`, which draws `text`."""
    return click.option("--plot", metavar="FILE", help=f"Draw {text}: .png, .svg or .pdf.")


def require_one(option: str, text: str, names: Sequence[str]) -> None:
    """Refuse a vector where one scalar is needed (BG084)."""
    if len(names) != 1:
        raise BgError([several_components(option, text, names)])
