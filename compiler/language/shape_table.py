"""Shapes that parts are drawn with: their arguments, and the names of colours."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum

from bgc.record_class import dataclass


class Takes(Enum):
    """The value that an argument of a shape takes."""

    LENGTH = "a length"
    NUMBER = "a scalar"
    POINT = "a vector of 3 lengths"
    VECTOR = "a vector of 3"
    WAVES = "a matrix with rows [amplitude, angular frequency, direction, phase]"
    FILE = "the name of a file in quotes"


class Ends(Enum):
    """Return whether a shape stands between two frames: `from a to b`."""

    NEVER = "never"
    MAY = "may"
    MUST = "must"


@dataclass(frozen=True, slots=True)
class ShapeArgument:
    """An argument of a shape; `default` is None where it has to be given."""

    name: str
    takes: Takes
    default: float | None = None
    optional: bool = False


@dataclass(frozen=True, slots=True)
class ShapeKind:
    """A kind of shape. Between two frames it is as long as they are apart, without `length`."""

    arguments: tuple[ShapeArgument, ...]
    ends: Ends
    doc: str

    def arguments_of(self, between: bool) -> tuple[ShapeArgument, ...]:
        """The arguments that it takes, between two frames or at one."""
        return tuple(a for a in self.arguments if not (between and a.name == "length"))

    def form(self, name: str, between: bool = False) -> str:
        """The way in which it is written: `cylinder(radius, length)`, `rope(..) from a to b`."""
        listed = ", ".join(
            f"{a.name} = {a.default:g}" if a.default is not None else a.name
            for a in self.arguments_of(between)
        )
        ends = " from a to b" if between or self.ends is Ends.MUST else ""
        return f"{name}({listed}){ends}" if listed else f"{name}{ends}"


_LENGTH = ShapeArgument("length", Takes.LENGTH)
_RADIUS = ShapeArgument("radius", Takes.LENGTH)

SHAPES: Mapping[str, ShapeKind] = {
    "box": ShapeKind(
        (
            _LENGTH,
            ShapeArgument("width", Takes.LENGTH),
            ShapeArgument("height", Takes.LENGTH),
        ),
        Ends.NEVER,
        "sides along x, y and z, centred",
    ),
    "cylinder": ShapeKind((_RADIUS, _LENGTH), Ends.MAY, "axis along z, centred"),
    "sphere": ShapeKind((_RADIUS,), Ends.NEVER, "centred"),
    "capsule": ShapeKind(
        (_RADIUS, _LENGTH),
        Ends.MAY,
        "axis along z, centred; `length` between the centres of its two half spheres",
    ),
    "mesh": ShapeKind(
        (ShapeArgument("file", Takes.FILE), ShapeArgument("scale", Takes.NUMBER, 1.0)),
        Ends.NEVER,
        "a file `.glb`, `.gltf`, `.stl` or `.obj`, in metres times `scale`",
    ),
    "hull": ShapeKind(
        (
            _LENGTH,
            ShapeArgument("width", Takes.LENGTH),
            ShapeArgument("height", Takes.LENGTH),
        ),
        Ends.NEVER,
        "a ship's hull in such a box: its bow along x, its deck on top",
    ),
    "ram": ShapeKind(
        (_RADIUS, ShapeArgument("barrel", Takes.LENGTH)),
        Ends.MUST,
        "a hydraulic cylinder: its barrel of that length and radius at `a`, its rod to `b`",
    ),
    "rope": ShapeKind(
        (
            ShapeArgument("radius", Takes.LENGTH, 0.02),
            ShapeArgument("paid", Takes.LENGTH, optional=True),
        ),
        Ends.MUST,
        "a line between two frames; a catenary where the length `paid` exceeds their distance",
    ),
    "arrow": ShapeKind(
        (
            ShapeArgument("vector", Takes.VECTOR),
            ShapeArgument("scale", Takes.NUMBER, optional=True),
        ),
        Ends.NEVER,
        "a vector in the axes of its frame, `scale` metres long for each unit; without it the "
        "viewer chooses one scale for all",
    ),
    "sea": ShapeKind(
        (ShapeArgument("waves", Takes.WAVES, optional=True),),
        Ends.NEVER,
        "the surface of the sea in the world: calm, or a sum of waves",
    ),
    "handle": ShapeKind(
        (
            ShapeArgument("position", Takes.POINT),
            ShapeArgument("force", Takes.VECTOR, optional=True),
            ShapeArgument("aim", Takes.POINT, optional=True),
        ),
        Ends.NEVER,
        "the grip of an input device, beside the scene or `at` the place that it steers, in the "
        "axes of the device; `force` on the hand, `aim` from the place to where it shall be",
    ),
}
"""All kinds of shapes by name."""

MESH_FILES = (".glb", ".gltf", ".stl", ".obj")

COLOURS: Mapping[str, str] = {
    "black": "#000000",
    "blue": "#0072b2",
    "brown": "#8b5a2b",
    "cyan": "#56b4e9",
    "darkblue": "#003f6b",
    "green": "#009e73",
    "grey": "#808080",
    "lightgrey": "#c8c8c8",
    "magenta": "#cc79a7",
    "navy": "#1b2a49",
    "orange": "#e69f00",
    "red": "#c0392b",
    "silver": "#b8bec4",
    "steel": "#6b7b8c",
    "teal": "#2a9d8f",
    "vermilion": "#d55e00",
    "white": "#ffffff",
    "yellow": "#f0c808",
}
"""Names of colours, beside `#rrggbb`."""
