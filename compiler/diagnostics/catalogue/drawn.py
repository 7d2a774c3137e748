"""Diagnostics: shapes that a viewer draws."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import Values, error, nearest, warning
from bgc.diagnostics.source import Span


@error("BG492: there is no shape `{name}`", "the shapes are {all}")
def unknown_shape(span: Span, name: str, kinds: Iterable[str]) -> Values:
    return {"all": ", ".join(kinds), **nearest(name, kinds, span)}


@error("BG493: {what}", "write `shape {form}`")
def shape_arguments(span: Span, what: str, form: str) -> None: ...
@error("BG494: {what}")
def shape_place(span: Span, what: str, help: str) -> None: ...
@error(
    'BG495: "{text}" is not a colour',
    'write `"#rrggbb"` with six hexadecimal digits, or a name such as {some}',
)
def unknown_colour(span: Span, text: str, known: Sequence[str]) -> Values:
    return {"some": ", ".join(known[:6]), **nearest(text, known)}


@error(
    'BG496: the mesh "{text}" {reason}',
    "give a `.glb`, `.gltf`, `.stl` or `.obj` file, by a path relative to this file",
)
def mesh_file(span: Span, text: str, reason: str) -> None: ...
@error(
    "BG497: the axes of a shape have to be a rotation matrix",
    "make them with `rot_x`, `rot_y`, `rot_z` or `basis(axis)` of `mechanics.frame`",
)
def axes_turn(span: Span) -> None: ...
@error("BG498: {what} must be positive, not {value:g} m", "give a positive length")
def size_of_shape(span: Span, what: str, value: float) -> None: ...
@warning(
    "BG499: the shape `{name}` is not recorded: nothing gives its frame a position",
    "write `r` and `A` of the port at the beginning of the chain, as `Ground` does",
)
def shape_without_pose(span: Span, name: str) -> None: ...
