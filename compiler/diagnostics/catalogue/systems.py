"""BG635-BG641: systems of FMUs."""

from __future__ import annotations

from collections.abc import Iterable

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic


def malformed_part(text: str) -> Diagnostic:
    """BG635: a part of a system that cannot be read"""
    return error(
        "BG635",
        f"`--part {text}` is not a part of a system",
        help="write a name and a scene, `--part NAME=FILE:SCENE`; without FILE it is another scene "
        "of the same file, without SCENE the first one",
    )


def malformed_connection(text: str) -> Diagnostic:
    """BG636: a connection of a system that cannot be read"""
    return error(
        "BG636",
        f"`--connect {text}` is not a connection",
        help='write `--connect "PART.OUTPUT -> PART.INPUT"`, with the quotes',
    )


def part_named_twice(name: str) -> Diagnostic:
    """BG637: two parts of a system with one name"""
    return error(
        "BG637",
        f"two parts of the system are named `{name}`",
        help="give one of them another name after `--part`",
    )


def no_such_part(text: str, name: str, known: Iterable[str]) -> Diagnostic:
    """BG638: a part that the system does not have"""
    known = list(known)
    listed = ", ".join(f"`{each}`" for each in known)
    return error(
        "BG638",
        f"the system has no part `{name}`, which `{text}` names",
        help=did_you_mean(name, known) or f"the system has {listed}",
    )


def no_such_signal(wire: str, part: str, name: str, kind: str, known: Iterable[str]) -> Diagnostic:
    """BG639: a part without that output or input"""
    known = list(known)
    listed = ", ".join(f"`{each}`" for each in known[:6])
    more = " and more" if len(known) > 6 else ""
    return error(
        "BG639",
        f"`{part}` has no {kind} `{name}`, which `{wire}` names",
        help=did_you_mean(name, known)
        or (f"its {kind}s are {listed}{more}" if known else f"it has no {kind}s"),
    )


def connection_mismatch(wire: str, output: str, input_: str) -> Diagnostic:
    """BG640: a connection of signals that differ in width or unit"""
    return error(
        "BG640",
        f"`{wire}` connects an output {output} with an input {input_}",
        help="connect one component, as `plant.tip[3]`, or signals of the same width and unit",
    )


def connected_twice(name: str, first: str) -> Diagnostic:
    """BG641: an input with two connections"""
    return error(
        "BG641",
        f"the input `{name}` is connected twice, first by `{first}`",
        help="remove one connection, or add the signals in a model",
    )
