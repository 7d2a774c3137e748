"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar

import click

from bgc.diagnostics.catalogue.arguments import bad_assignment, bad_option
from bgc.diagnostics.catalogue.devices import bad_device_option
from bgc.diagnostics.catalogue.machine import cannot_write, unknown_file_kind
from bgc.diagnostics.catalogue.symbolic import bad_pair
from bgc.diagnostics.diagnostic import BgError
from bgc.language.records import Option, Where, options_of
from bgc.language.solver import Solver
from bgc.runtime.cli.completion import scenes_of
from bgc.runtime.running.quantity import read_quantity

_Command = TypeVar("_Command", bound=Callable[..., Any])

MODEL_FILE = click.Path(path_type=Path)

_METAVARS = {"s": "TIME", "Hz": "FREQUENCY"}  # options with a unit, read by `read_quantity`


def model_file(command: _Command) -> _Command:
    """Add the argument FILE."""
    return click.argument("file", type=MODEL_FILE)(command)


def scene_option(
    command: _Command, text: str = "Scene to take; by default the first of the file."
) -> _Command:
    """Add `--scene`."""
    return click.option("--scene", metavar="NAME", help=text, shell_complete=scenes_of)(command)


def set_option(command: _Command) -> _Command:
    """Add `--set NAME=VALUE`, any number of times."""
    text = 'Set a parameter: --set "crane.boom.mass=7 t". May be repeated.'
    return click.option("--set", "assignments", multiple=True, metavar="NAME=VALUE", help=text)(
        command
    )


def use_option(command: _Command) -> _Command:
    """Add `--use`, any number of times."""
    text = 'Fill a slot: --use "crane.elbow.lock=Rigid[5]". May be repeated.'
    return click.option("--use", "uses", multiple=True, metavar="SLOT=TYPE", help=text)(command)


def device_option(command: _Command) -> _Command:
    """Add `--device NAME=DRIVER`, any number of times."""
    text = "Driver in place of the scene's: hand=./mine.so, hand=motion.csv. May be repeated."
    return click.option("--device", "devices", multiple=True, metavar="NAME=DRIVER", help=text)(
        command
    )


def read_devices(texts: tuple[str, ...]) -> dict[str, str]:
    """Read the values of `--device`; BG013 where one has no name or no driver."""
    pairs = [text.partition("=") for text in texts]
    for text, (name, _, driver) in zip(texts, pairs, strict=True):
        if not (name.strip() and driver.strip()):
            raise BgError([bad_device_option(text)])
    return {name.strip(): driver for name, _, driver in pairs}


def whole_option(command: _Command) -> _Command:
    """Add `--whole`."""
    text = "Compile the whole model, not only what the scene observes."
    return click.option("--whole", is_flag=True, help=text)(command)


def preview_option(command: _Command) -> _Command:
    """Add `--preview`."""
    text = "Compile quickly without optimisation (tcc if installed, otherwise -O0)."
    return click.option("--preview", is_flag=True, help=text)(command)


def strict_option(command: _Command) -> _Command:
    """Add `--strict`."""
    text = "Treat warnings as errors (exit status 1)."
    return click.option("--strict", is_flag=True, help=text)(command)


def solver_options(**texts: str) -> Callable[[_Command], _Command]:
    """Add all options of `Solver` that commands have; `texts` replace help texts by name.

    They arrive under their keywords; `read_solver` converts them.
    """

    def add(command: _Command) -> _Command:
        for name, known in reversed([*options_of(Solver, Where.COMMAND).items()]):
            command = _click_option(known, texts.get(name, known.help))(command)
        return command

    return add


def _click_option(known: Option, text: str) -> Callable[[_Command], _Command]:
    if known.kind is bool:
        return click.option(known.flag, known.keyword, is_flag=True, help=text)
    metavar = "NAME" if known.kind is str else _METAVARS.get(known.unit or "")
    kind = None if metavar else known.kind
    return click.option(known.flag, known.keyword, type=kind, metavar=metavar, help=text)


def read_solver(given: Mapping[str, Any]) -> dict[str, Any]:
    """Convert the values of `solver_options` to arguments of `Model.simulate`, in SI units."""
    found: dict[str, Any] = {}
    for known in options_of(Solver, Where.COMMAND).values():
        value = given[known.keyword]
        if isinstance(value, str) and known.unit in _METAVARS:
            value = read_quantity(value, known.flag, known.unit)
        found[known.keyword] = ("rest" if value else None) if known.kind is bool else value
    return found


def method_options(command: _Command) -> _Command:
    """Add the options of the solver, the interval between rows and the duration.

    They arrive under the keywords of `Solver`, and as `every` and `duration`; `read_method`
    converts them.
    """
    every = click.option("--every", metavar="TIME", help='Interval between rows: "10 ms".')
    text = 'Simulated time: "60 s"; by default that of the scene.'
    duration = click.option("--time", "duration", metavar="TIME", help=text)
    return solver_options()(every(duration(command)))


def verify_option(command: _Command) -> _Command:
    """Add `--verify`."""
    text = "Check all intermediate results of the compiler (for work on bgc)."
    return click.option("--verify", is_flag=True, help=text)(command)


def input_option(*, multiple: bool) -> Callable[[_Command], _Command]:
    """Add `--input`, once or any number of times."""
    text = "Input: a source (supply.e), a parameter, an input, or a channel (hand.position[3])."
    return _named("--input", "inputs" if multiple else "input_", text, multiple)


def output_option(*, multiple: bool) -> Callable[[_Command], _Command]:
    """Add `--output`, once or any number of times."""
    text = "Output: an observed name, or any expression."
    return _named("--output", "outputs" if multiple else "output", text, multiple)


def _named(option: str, argument: str, text: str, multiple: bool) -> Callable[[_Command], _Command]:
    def add(command: _Command) -> _Command:
        return click.option(
            option, argument, multiple=multiple, required=not multiple, metavar="NAME", help=text
        )(command)

    return add


def point_options(command: _Command) -> _Command:
    """Add `--at` and `--steady`, which exclude each other."""
    steady = click.option(
        "--steady", is_flag=True, help="Linearise in the equilibrium found from the initial state."
    )
    at = click.option(
        "--at", metavar="TIME", help="Linearise at the state after a simulation to this time."
    )
    return at(steady(command))


def read_point(at: str | None, steady: bool) -> float | Literal["steady"] | None:
    """Read where to linearise: a time in s, in equilibrium, or None for the initial state."""
    if at is not None and steady:
        raise click.UsageError("--at and --steady exclude each other")
    if at is not None:
        time = read_quantity(at, "--at", "s")
        if time < 0:
            raise BgError([bad_option("--at", time, "a time in seconds from the start on")])
        return time or None
    return "steady" if steady else None


def read_assignments(
    texts: tuple[str, ...], example: str = '--set "boom.mass=7 t"'
) -> tuple[tuple[str, str], ...]:
    """Read the values of `--set` or a like option; BG064 where one has no name or no value."""
    return _read_pairs(texts, example)


def read_uses(texts: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Read the values of `--use`; BG064 where one has no slot or no type."""
    return _read_pairs(texts, '--use "elbow.lock=Rigid[5]"')


def read_pair(text: str) -> tuple[str, str]:
    """Read OUTPUT/INPUT, separated by the last slash; BG098 where one of them is missing."""
    output, slash, input_ = (part.strip() for part in text.rpartition("/"))
    if not (output and slash and input_):
        raise BgError([bad_pair(text)])
    return output, input_


def read_times(**texts: str | None) -> dict[str, float | None]:
    """Read options that are times, s, by their names; None for an option that is not given."""
    return {
        name: None if text is None else read_quantity(text, f"--{name.replace('_', '-')}", "s")
        for name, text in texts.items()
    }


def read_method(given: Mapping[str, Any]) -> dict[str, Any]:
    """Convert the values of `method_options` to arguments of `Model.simulate`, in SI units."""
    times = read_times(time=given["duration"], every=given["every"])
    return {"duration": times["time"], "every": times["every"], **read_solver(given)}


def _read_pairs(texts: tuple[str, ...], example: str) -> tuple[tuple[str, str], ...]:
    pairs = []
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise BgError([bad_assignment(text, example)])
        pairs.append((name, value))
    return tuple(pairs)


def check_target(path: str | None, kinds: tuple[str, ...]) -> None:
    """Refuse a file of an unknown kind, or in a missing directory, before any work is done.

    `-` among the kinds stands for standard output.
    """
    if path is None or path in kinds:
        return
    if Path(path).suffix.lower() not in kinds and not _is_special(Path(path)):
        raise BgError([unknown_file_kind(path, kinds)])
    if not Path(path).absolute().parent.is_dir():
        raise BgError([cannot_write(path, "there is no such directory")])


def _is_special(path: Path) -> bool:
    return path.exists() and not path.is_file()
