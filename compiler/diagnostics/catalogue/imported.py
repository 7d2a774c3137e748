"""Diagnostics of `bgc import`: files of other tools."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def not_importable(what: str, span: Span | None = None, help: str = "") -> Diagnostic:
    """BG137: a file that `bgc import` cannot read

    What: the file is not well-formed, does not have the format that its name indicates, uses a form
    that is not read (macros of xacro, entities of XML, tags and anchors of YAML), or is an FMU.

    Why: the text of a robot is read as XML without a document type, that of BondGraphTools as plain
    YAML. An entity can name other files, or expand to gigabytes. An FMU hides its equations, from
    which causality, Jacobians and energy accounts are made.

    Example: `bgc import arm.urdf.xacro`, a URDF without `<robot>`, a file cut off in the middle.

    Way out: expand macros first (`xacro arm.urdf.xacro > arm.urdf`), and write entities out. Run an
    FMU beside a model: `bgc build FILE.bg --target ssp` writes a system of FMUs.
    """
    return error("BG137", what, span, help=help)


def wrong_value(span: Span | None, what: str, help: str) -> Diagnostic:
    """BG138: a value in an imported file that is missing or wrong

    What: an attribute or value that the model needs is absent, is not a number, or is out of range.

    Why: a guessed value would describe another machine than the file.

    Example: `<mass value="-1"/>`, `<origin xyz="0 0"/>`, `<joint name="elbow" type="hinge">`.

    Way out: correct the value in the file.
    """
    return error("BG138", what, span, help=help)


def left_out(span: Span | None, what: str, help: str) -> Diagnostic:
    """BG139: something in an imported file that is left out or changed

    What: a part of the file has no counterpart in the generated model, or could not be found.

    Why: the rest of the model is right without it, or with the assumption that the message states.

    Example: a mesh in a format that the viewer cannot show, a tendon of MuJoCo, a joint that moves
    no mass.

    Way out: as the message says; the generated file can be edited.
    """
    return warning("BG139", what, span, help=help)


def wrong_structure(
    span: Span | None, what: str, help: str, labels: tuple[Label, ...] = ()
) -> Diagnostic:
    """BG270: links and joints that do not form a tree

    What: a joint names a link that does not exist, a link has two parents, there are several roots,
    or the links form a loop; or two elements have one name.

    Why: links and joints of a robot description form one tree, which begins at one root.

    Example: `<parent link="bsae"/>` where the link is `base`.

    Way out: correct the names; close a loop in the generated file with a `Weld`.
    """
    return error("BG270", what, span, labels=labels, help=help)


def odd_inertia(span: Span | None, what: str) -> Diagnostic:
    """BG549: an inertia that no body can have

    What: a moment of inertia about the centre of mass is negative, or larger than the sum of the
    other two.

    Why: the moments of a body are sums over its mass, so that each is at most the sum of the
    others. Such numbers come from products of inertia with the wrong sign, from moments about
    another point than the centre of mass, and from rounding. With a negative moment a motion can
    have negative energy.

    Example: `<inertia ixx="1" iyy="1" izz="3" ../>`

    Way out: check the inertia; the model is written with the numbers as they are.
    """
    return warning("BG549", what, span, help="check the inertia: it is imported as it is")
