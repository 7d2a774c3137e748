"""A command made from the signature of a function, whose parameters declare its options.

A parameter says all of its option: `high: float | None = option("Help.", "--to")`. The name is the
parameter's unless flags are given; `bool` is a flag, a tuple may be repeated, `None` and a
`default` may be left out, and a `Literal` is a choice. An option of several commands is a type in
`options.py`, `Annotated[float | None, option("Help.")]`, and options that belong together are an
`OptionGroup`. The function receives converted values, and returns the exit status if it is not 0.
"""

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin

import click

from bgc.diagnostics.catalogue.machine import cannot_write, unknown_file_kind
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.record_class import dataclass
from bgc.runtime.running.quantity import read_quantity


class OptionGroup:
    """Base of classes whose arguments are options of a command: a parameter of that type."""


@dataclass(frozen=True)
class Declared:
    """What a parameter of the command line has besides its type."""

    kind: Callable[..., click.Parameter]
    flags: tuple[str, ...]
    settings: Mapping[str, Any]


def option(
    text: str,
    *flags: str,
    within: tuple[int, int | None] | None = None,
    choices: Iterable[str] = (),
    **settings: Any,
) -> Any:
    """Declare an option.

    Parameters
    ----------
    text
        Its help.
    flags
        Its flags; by default `--name`.
    within
        The least and the largest value of a number.
    choices
        The texts among which to choose, where the type is no `Literal`.
    settings
        Further arguments of `click.Option`.
    """
    if within is not None:
        is_real = isinstance(settings.get("default"), float)
        settings["type"] = click.FloatRange(*within) if is_real else click.IntRange(*within)
    if choices:
        settings["type"] = click.Choice(tuple(choices))
    return Declared(click.Option, flags, {"help": text, **settings})


def argument(**settings: Any) -> Any:
    """Declare an argument, with settings of `click.Argument`."""
    return Declared(click.Argument, (), settings)


def command(**settings: Any) -> Callable[[Callable[..., int | None]], click.Command]:
    """Make a decorator: from a function its command, with settings of `click.Command`."""

    def make(function: Callable[..., int | None]) -> click.Command:
        given = {"name": function.__name__, "help": function.__doc__, **settings}
        call = partial(_call, function)
        return click.Command(callback=call, params=list(_parameters(function)), **given)

    return make


def require(condition: object, problem: str | Diagnostic) -> None:
    """Refuse the arguments of a command unless a condition holds.

    A text is a wrong usage (exit status 2), a diagnostic an error of the user's files (1).
    """
    if not condition:
        raise click.UsageError(problem) if isinstance(problem, str) else BgError([problem])


def signature(rows: Mapping[str, tuple[Any, Declared]]) -> inspect.Signature:
    """Make the signature of an `OptionGroup` from a table: types and declarations by name."""
    kind = inspect.Parameter.KEYWORD_ONLY
    parameters = (
        inspect.Parameter(name, kind, annotation=Annotated[row]) for name, row in rows.items()
    )
    return inspect.Signature(list(parameters))


def _call(target: Callable[..., Any], /, **given: Any) -> Any:
    """Call a function with the values of its options, a group with those of its own."""
    arguments = {}
    for field in _fields(target):
        if _is_group(field):
            arguments[field.name] = _call(field.annotation, **given)
        else:
            arguments[field.name] = given[field.name]
    return target(**arguments)


def _parameters(target: Callable[..., Any]) -> Iterator[click.Parameter]:
    for field in _fields(target):
        if _is_group(field):
            yield from _parameters(field.annotation)
        else:
            yield _parameter(field)


def _fields(target: Callable[..., Any]) -> tuple[inspect.Parameter, ...]:
    return tuple(inspect.signature(target).parameters.values())


def _is_group(field: inspect.Parameter) -> bool:
    return isinstance(field.annotation, type) and issubclass(field.annotation, OptionGroup)


def _parameter(field: inspect.Parameter) -> click.Parameter:
    """Make the option or the argument that a parameter declares."""
    kind = field.annotation
    declared: Declared = field.default
    if field.default is field.empty:
        kind, declared = get_args(kind)
    parts = get_args(kind)
    settings: dict[str, Any] = {"required": "default" not in declared.settings}
    if kind is bool:
        settings = {"is_flag": True}
    elif get_origin(kind) is tuple:
        several = {"nargs": -1} if declared.kind is click.Argument else {"multiple": True}
        settings = {"type": _click_type(parts[0]), **several}
    elif NoneType in parts:
        settings = {"type": _click_type(parts[0]), "required": False}
    else:
        settings["type"] = _click_type(kind)
    flags = declared.flags or (f"--{field.name.rstrip('_').replace('_', '-')}",)
    names = (field.name, *flags) if declared.kind is click.Option else (field.name,)
    return declared.kind(names, **{**settings, **declared.settings})


def _click_type(kind: Any) -> Any:
    if get_origin(kind) is Literal:
        return click.Choice(get_args(kind))
    return click.Path(path_type=Path) if kind is Path else kind


class Value(click.ParamType):  # type: ignore[type-arg]  # generic since click 8.4 alone
    """A number with or without a unit, as an SI value of a given unit."""

    def __init__(self, unit: str) -> None:
        self._unit = unit
        self.name = {"s": "time", "Hz": "frequency"}.get(unit, "value")

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read a text; BG062 or BG063 where it is none of that unit."""
        assert param is not None
        return read_quantity(value, param.opts[0], self._unit) if isinstance(value, str) else value


class Values(Value):
    """Such values, separated by commas."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read a text; None where it has no values."""
        parts = (part.strip() for part in value.split(","))
        return [super(Values, self).convert(part, param, ctx) for part in parts if part] or None


class Pair(click.ParamType):  # type: ignore[type-arg]  # generic since click 8.4 alone
    """Two texts with a sign between them; `refused` says what is wrong where one is missing."""

    def __init__(self, refused: Callable[[str], Diagnostic], sign: str = "=") -> None:
        self.name = f"name{sign}value"
        self._refused, self._sign = refused, sign

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Separate a text at the first equals sign, or at the last sign of another kind."""
        found = value.partition("=") if self._sign == "=" else value.rpartition(self._sign)
        first, _, second = (part.strip() for part in found)
        require(first and second, self._refused(value))
        return first, second


class Target(click.ParamType):  # type: ignore[type-arg]  # generic since click 8.4 alone
    """A file to write, of one of the given kinds; `-` among these is standard output."""

    name = "file"

    def __init__(self, *kinds: str) -> None:
        self._kinds = kinds

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse a file of another kind, or in a missing directory, before any work is done."""
        path = Path(value)
        is_known = value in self._kinds or path.suffix.lower() in self._kinds
        is_special = path.exists() and not path.is_file()
        require(is_known or is_special, unknown_file_kind(value, self._kinds))
        is_placed = path.absolute().parent.is_dir()
        require(is_placed, cannot_write(value, "there is no such directory"))
        return value
