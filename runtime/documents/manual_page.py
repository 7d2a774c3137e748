"""The page of `man bgc`, from the help of the commands."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

import click

_STATUSES = {
    "0": "Done. Warnings do not change the status.",
    "1": "The model, the machine or a device is at fault; a diagnostic names the remedy. "
    "Results so far are written.",
    "2": "The command was called with wrong arguments.",
    "70": "A fault of bgc itself.",
    "130": "Interrupted by Ctrl-C. Results so far are written.",
}
_VARIABLES = {
    "BGC_CACHE_DIR": "Folder of compiled models; by default bgc in XDG_CACHE_HOME or ~/.cache.",
    "BGC_DRIVERS": "Folders in which scenes look for drivers of devices, separated as in PATH.",
    "BGC_DEBUG": "Print the traceback of a fault of bgc.",
    "NO_COLOR": "Print without colours.",
}
_CODE = re.compile(r"`([^`]+)`")


def manual_page(application: click.Group, groups: Mapping[str, Mapping[str, str]]) -> str:
    """Write the manual page of all commands in the man(7) macros.

    Parameters
    ----------
    application
        The command `bgc`, which loads its commands by name.
    groups
        Short texts of the commands by name, in titled groups.
    """
    return "\n".join(_lines(application, groups)) + "\n"


def _lines(application: click.Group, groups: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    yield '.TH BGC 1 "" bgc "User commands"'
    yield from (".SH NAME", r"bgc \- compile bond graphs to C, and run them")
    yield from (".SH SYNOPSIS", r"\fBbgc\fR \fICOMMAND\fR [\fIOPTIONS\fR] [\fIARGUMENTS\fR]")
    yield ".SH DESCRIPTION"
    yield from _paragraphs(application.help or "")
    yield ".SH COMMANDS"
    for title, commands in groups.items():
        yield f".SS {title}"
        yield from _items({rf"\fB{_text(name)}\fR": text for name, text in commands.items()})
    context = click.Context(application, info_name="bgc")
    for commands in groups.values():
        for name in commands:
            command = application.get_command(context, name)
            assert command is not None
            yield from _section(command, click.Context(command, context, info_name=name))
    yield ".SH EXIT STATUS"
    yield from _items({rf"\fB{status}\fR": text for status, text in _STATUSES.items()})
    yield ".SH ENVIRONMENT"
    yield from _items({rf"\fB{name}\fR": text for name, text in _VARIABLES.items()})


def _section(command: click.Command, context: click.Context) -> Iterator[str]:
    pieces = " ".join(command.collect_usage_pieces(context))
    yield f'.SH "bgc {context.info_name}"'
    yield rf"\fBbgc {_text(context.info_name or '')}\fR {_text(pieces)}"
    yield from _paragraphs(command.help or "")
    records = (parameter.get_help_record(context) for parameter in command.params)
    yield from _items({rf"\fB{_text(r[0])}\fR": r[1] for r in records if r and r[1]})


def _paragraphs(text: str) -> Iterator[str]:
    """Write the paragraphs of a help text; those after `\\b` keep their lines."""
    for paragraph in text.strip().split("\n\n"):
        lines = [line.strip() for line in paragraph.splitlines()]
        if lines[0] == "\b":
            yield from (".PP", ".nf", *map(_line, lines[1:]), ".fi")
        else:
            yield from (".PP", _line(" ".join(lines)))


def _items(items: Mapping[str, str]) -> Iterator[str]:
    for name, text in items.items():
        yield from (".TP 12", name, _line(" ".join(text.split())))


def _line(text: str) -> str:
    """Write a line of text; one that begins as a request would gets a mark of no width."""
    marked = _CODE.sub(r"\\fB\1\\fR", _text(text))
    return rf"\&{marked}" if marked[:1] in (".", "'") else marked


def _text(text: str) -> str:
    return text.replace("\\", r"\e").replace("-", r"\-")
