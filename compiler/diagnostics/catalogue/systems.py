"""BG635-BG641: systems of FMUs."""

from __future__ import annotations

from collections.abc import Iterable

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic


def malformed_part(text: str) -> Diagnostic:
    """BG635: a part of a system that cannot be read

    What: the text after `--part` does not name a part and its scene.

    Why: a part has a name of letters, digits and underscores, by which connections find it.

    Example: `bgc build plant.bg --target ssp --part loop`.

    Way out: write `--part loop=control.bg`, `--part loop=control.bg:fast` for one of its scenes, or
    `--part loop=:fast` for another scene of the same file.
    """
    return error(
        "BG635",
        f"`--part {text}` is not a part of a system",
        help="write a name and a scene, `--part NAME=FILE:SCENE`; without FILE it is another scene "
        "of the same file, without SCENE the first one",
    )


def malformed_connection(text: str) -> Diagnostic:
    """BG636: a connection of a system that cannot be read

    What: the text after `--connect` does not name an output of one part and an input of another.

    Why: a connection leads from an output to an input.

    Example: `bgc build plant.bg --target ssp --part loop=:loop --connect "plant.angle"`.

    Way out: write `--connect "plant.angle -> loop.measured"`, with the quotes.
    """
    return error(
        "BG636",
        f"`--connect {text}` is not a connection",
        help='write `--connect "PART.OUTPUT -> PART.INPUT"`, with the quotes',
    )


def part_named_twice(name: str) -> Diagnostic:
    """BG637: two parts of a system with one name

    What: two parts of a system have the same name.

    Why: connections find a part by its name. The first part has the name of its file, and of its
    scene if `--scene` is given: `plant`, `plant_start`.

    Example: `bgc build plant.bg --target ssp --part plant=:other`.

    Way out: give the part another name.
    """
    return error(
        "BG637",
        f"two parts of the system are named `{name}`",
        help="give one of them another name after `--part`",
    )


def no_such_part(text: str, name: str, known: Iterable[str]) -> Diagnostic:
    """BG638: a part that the system does not have

    What: a connection or an input names a part that the system does not have.

    Why: the first part has the name of its file, and of its scene if `--scene` is given; the others
    have those after `--part`. With several parts, `--input` names the part too.

    Example: `bgc build plant.bg --target ssp --part loop=:loop --connect "plnt.angle -> loop.x"`.

    Way out: write the name of one of the parts, and `--input PART.NAME`.
    """
    known = list(known)
    listed = ", ".join(f"`{each}`" for each in known)
    return error(
        "BG638",
        f"the system has no part `{name}`, which `{text}` names",
        help=did_you_mean(name, known) or f"the system has {listed}",
    )


def no_such_signal(wire: str, part: str, name: str, kind: str, known: Iterable[str]) -> Diagnostic:
    """BG639: a part without that output or input

    What: a connection names an output or an input that its part does not have.

    Why: outputs of a part are the quantities that its scene observes and the commands to its
    devices; its inputs are inputs of models, sources, parameters and the channels of its devices.

    Example: `--connect "plant.angle -> loop.measured"`, and the scene does not observe `angle`.

    Way out: observe the quantity in the scene, or correct the name.
    """
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
    """BG640: a connection of signals that differ in width or unit

    What: the output and the input of a connection have different numbers of components, or units
    of different kinds.

    Why: each component of the output becomes the component of the input at the same place, and
    its value is not converted.

    Example: `--connect "plant.tip -> loop.height"`, a vector of 3 and a number.

    Way out: connect a component, `plant.tip[3] -> loop.height`, or change the unit of the input.
    """
    return error(
        "BG640",
        f"`{wire}` connects an output {output} with an input {input_}",
        help="connect one component, as `plant.tip[3]`, or signals of the same width and unit",
    )


def connected_twice(name: str, first: str) -> Diagnostic:
    """BG641: an input with two connections

    What: two connections lead to one input.

    Why: an input has one value.

    Example: `--connect "a.x -> loop.u" --connect "b.x -> loop.u"`.

    Way out: remove one, or add the signals in a model.
    """
    return error(
        "BG641",
        f"the input `{name}` is connected twice, first by `{first}`",
        help="remove one connection, or add the signals in a model",
    )
