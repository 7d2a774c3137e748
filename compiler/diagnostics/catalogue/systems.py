"""Diagnostics: systems of FMUs."""

from __future__ import annotations

from collections.abc import Iterable

from bgc.diagnostics.catalogue import Values, error, nearest, quoted


@error(
    "BG635: `--part {text}` is not a part of a system",
    "write a name and a scene, `--part NAME=FILE:SCENE`; without FILE it is another "
    "scene of the same file, without SCENE the first one",
)
def malformed_part(text: str) -> None: ...
@error(
    "BG636: `--connect {text}` is not a connection",
    'write `--connect "PART.OUTPUT -> PART.INPUT"`, with the quotes',
)
def malformed_connection(text: str) -> None: ...
@error(
    "BG637: two parts of the system are named `{name}`",
    "give one of them another name after `--part`",
)
def part_named_twice(name: str) -> None: ...
@error(
    "BG638: the system has no part `{name}`, which `{text}` names", "the system has {parts:quoted}"
)
def no_such_part(text: str, name: str, known: Iterable[str]) -> Values:
    parts = list(known)
    return {"parts": parts, **nearest(name, parts)}


@error("BG639: `{part}` has no {kind} `{name}`, which `{wire}` names", "{there}")
def no_such_signal(wire: str, part: str, name: str, kind: str, known: Iterable[str]) -> Values:
    names = list(known)
    more = " and more" if len(names) > 6 else ""
    there = f"its {kind}s are {quoted(names[:6])}{more}" if names else f"it has no {kind}s"
    return {"there": there, **nearest(name, names)}


@error(
    "BG640: `{wire}` connects an output {output} with an input {input_}",
    "connect one component, as `plant.tip[3]`, or signals of the same width and unit",
)
def connection_mismatch(wire: str, output: str, input_: str) -> None: ...
@error(
    "BG641: the input `{name}` is connected twice, first by `{first}`",
    "remove one connection, or add the signals in a model",
)
def connected_twice(name: str, first: str) -> None: ...
