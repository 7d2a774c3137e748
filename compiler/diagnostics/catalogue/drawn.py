"""Diagnostics of shapes, with which parts are drawn."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, respelt, warning
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def unknown_shape(span: Span, name: str, kinds: Iterable[str]) -> Diagnostic:
    """BG492: a shape that does not exist"""
    kinds = list(kinds)
    return error(
        "BG492",
        f"there is no shape `{name}`",
        span,
        help=did_you_mean(name, kinds) or f"the shapes are {', '.join(kinds)}",
        edits=respelt(span, name, kinds),
    )


def shape_arguments(span: Span, what: str, form: str) -> Diagnostic:
    """BG493: wrong arguments of a shape"""
    return error("BG493", what, span, help=f"write `shape {form}`")


def shape_place(span: Span, what: str, help: str) -> Diagnostic:
    """BG494: a shape in a place that is not a frame"""
    return error("BG494", what, span, help=help)


def unknown_colour(span: Span, text: str, known: Sequence[str]) -> Diagnostic:
    """BG495: a colour that cannot be read"""
    return error(
        "BG495",
        f'"{text}" is not a colour',
        span,
        help=did_you_mean(text, known)
        or 'write `"#rrggbb"` with six hexadecimal digits, or a name '
        f"such as {', '.join(known[:6])}",
    )


def mesh_file(span: Span, text: str, reason: str) -> Diagnostic:
    """BG496: a mesh that cannot be used"""
    return error(
        "BG496",
        f'the mesh "{text}" {reason}',
        span,
        help="give a `.glb`, `.gltf`, `.stl` or `.obj` file, by a path relative to this file",
    )


def axes_turn(span: Span) -> Diagnostic:
    """BG497: the axes of a shape are not a rotation"""
    return error(
        "BG497",
        "the axes of a shape have to be a rotation matrix",
        span,
        help="make them with `rot_x`, `rot_y`, `rot_z` or `basis(axis)` of `mechanics.frame`",
    )


def size_of_shape(span: Span, what: str, value: float) -> Diagnostic:
    """BG498: a shape of no size"""
    return error(
        "BG498",
        f"{what} must be positive, not {value:g} m",
        span,
        help="give a positive length",
    )


def shape_without_pose(span: Span, name: str) -> Diagnostic:
    """BG499: a shape whose pose is not known (a warning)"""
    return warning(
        "BG499",
        f"the shape `{name}` is not recorded: nothing gives its frame a position",
        span,
        help="write `r` and `A` of the port at the beginning of the chain, as `Ground` does",
    )
