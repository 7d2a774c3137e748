"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from bgc.grammar.catalogue.machine import bad_assignment
from bgc.grammar.diagnostics import BgError

_Command = TypeVar("_Command", bound=Callable[..., Any])

MODEL_FILE = click.Path(path_type=Path)


def model_file(command: _Command) -> _Command:
    """Add the argument FILE."""
    return click.argument("file", type=MODEL_FILE)(command)


def scene_option(command: _Command) -> _Command:
    """Add `--scene`."""
    text = "Scene of the file; its first by default."
    return click.option("--scene", metavar="NAME", help=text)(command)


def set_option(command: _Command) -> _Command:
    """Add `--set NAME=VALUE`, any number of times."""
    text = 'Give a parameter another value: --set "crane.boom.mass=7 t".'
    return click.option("--set", "assignments", multiple=True, metavar="NAME=VALUE", help=text)(
        command
    )


def strict_option(command: _Command) -> _Command:
    """Add `--strict`."""
    text = "Make every warning an error, with status 1."
    return click.option("--strict", is_flag=True, help=text)(command)


def read_assignments(texts: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Read the values of `--set`; BG064 where one has no name or no value."""
    pairs = []
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise BgError([bad_assignment(text)])
        pairs.append((name, value))
    return tuple(pairs)
