"""Diagnostics of shapes, with which parts are drawn."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, respelt, warning
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def unknown_shape(span: Span, name: str, kinds: Iterable[str]) -> Diagnostic:
    """BG492: a shape that does not exist

    What: the word after `shape` is not the name of a shape.

    Why: a viewer can draw `box cylinder sphere capsule mesh rope arrow sea handle`.

    Example: `shape cube(1 m, 1 m, 1 m);`

    Way out: `shape box(1 m, 1 m, 1 m);`
    """
    kinds = list(kinds)
    return error(
        "BG492",
        f"there is no shape `{name}`",
        span,
        help=did_you_mean(name, kinds) or f"the shapes are {', '.join(kinds)}",
        edits=respelt(span, name, kinds),
    )


def shape_arguments(span: Span, what: str, form: str) -> Diagnostic:
    """BG493: wrong arguments of a shape

    What: an argument of a shape is missing, unknown, given twice, or one too many.

    Why: each shape has its own arguments. A cylinder or capsule `from a to b` is as long as its
    ends are apart, so it takes no length.

    Example: `shape sphere(1 m, 2 m);`

    Way out: `shape sphere(1 m);`. `bgc doc shapes` lists the arguments.
    """
    return error("BG493", what, span, help=f"write `shape {form}`")


def shape_place(span: Span, what: str, help: str) -> Diagnostic:
    """BG494: a shape in a place that is not a frame

    What: a shape stands at something that has no position, or needs `from .. to` and lacks it.

    Why: a shape stands at a frame (a port, a 1-junction or a part whose domain carries `r[3]` and
    `A[3, 3]`) or at an offset from the frame of its part. A rope needs two ends.

    Example: `shape rope(20 mm);`

    Way out: `shape rope(20 mm) from boom.tip to hook;`
    """
    return error("BG494", what, span, help=help)


def unknown_colour(span: Span, text: str, known: Sequence[str]) -> Diagnostic:
    """BG495: a colour that cannot be read

    What: the text after `colour` is neither the name of a colour nor `#rrggbb`.

    Why: all viewers draw the same colours.

    Example: `shape sphere(1 m) colour "#f00";`

    Way out: `shape sphere(1 m) colour "#ff0000";`, or `colour "red"`.
    """
    return error(
        "BG495",
        f'"{text}" is not a colour',
        span,
        help=did_you_mean(text, known)
        or 'write `"#rrggbb"` with six hexadecimal digits, or a name '
        f"such as {', '.join(known[:6])}",
    )


def mesh_file(span: Span, text: str, reason: str) -> Diagnostic:
    """BG496: a mesh that cannot be used

    What: the file of a mesh does not exist beside the model, or is of another kind.

    Why: a viewer reads the formats `.glb`, `.gltf`, `.stl` and `.obj`. The path is relative to the
    file with the shape.

    Example: `shape mesh("hull.blend");`

    Way out: export the mesh as `hull.glb`, and write `shape mesh("hull.glb");`
    """
    return error(
        "BG496",
        f'the mesh "{text}" {reason}',
        span,
        help="give a `.glb`, `.gltf`, `.stl` or `.obj` file, by a path relative to this file",
    )


def axes_turn(span: Span) -> Diagnostic:
    """BG497: the axes of a shape are not a rotation

    What: the matrix after `at offset,` is not a rotation matrix.

    Why: it turns the axes of the shape into those of its frame: its columns are unit vectors at
    right angles, and right-handed. Another matrix would stretch or mirror the shape.

    Example: `shape box(1 m, 1 m, 2 m) at [0, 0, 0], diag([1, 1, 2]);`

    Way out: make it with `rot_x`, `rot_y`, `rot_z` or `basis(axis)` of `mechanics.frame`.
    """
    return error(
        "BG497",
        "the axes of a shape have to be a rotation matrix",
        span,
        help="make them with `rot_x`, `rot_y`, `rot_z` or `basis(axis)` of `mechanics.frame`",
    )


def size_of_shape(span: Span, what: str, value: float) -> Diagnostic:
    """BG498: a shape of no size

    What: a length of a shape is zero or negative.

    Why: the shape would be invisible or turned inside out.

    Example: `shape sphere(-0.5 m);`

    Way out: give a positive length.
    """
    return error(
        "BG498",
        f"{what} must be positive, not {value:g} m",
        span,
        help="give a positive length",
    )


def shape_without_pose(span: Span, name: str) -> Diagnostic:
    """BG499: a shape whose pose is not known (a warning)

    What: a shape is left out of the recorded shapes.

    Why: no part upstream on the bond writes the position and orientation of its frame. The powers
    of the model do not need them, but a picture does.

    Example: a `Beam` whose `base` hangs on a source of twist instead of a `Ground`.

    Way out: let the part at the beginning of the chain write `r` and `A` of its port.
    """
    return warning(
        "BG499",
        f"the shape `{name}` is not recorded: nothing gives its frame a position",
        span,
        help="write `r` and `A` of the port at the beginning of the chain, as `Ground` does",
    )
