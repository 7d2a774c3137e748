"""The shapes of a model: how its parts are drawn, and the outputs that hold their poses."""

from __future__ import annotations

from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class ShapeValue:
    """A quantity of a shape, such as its `radius` or its position `r`.

    It has the constant `numbers`, in row-major order, or, where it varies, the outputs `columns`.
    Positions are in the world, m; `A` turns the axes of the shape into those of the world.
    """

    field: str
    shape: tuple[int, ...]
    numbers: tuple[float, ...] | None
    columns: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ShapeUse:
    """A shape of a part. `values` is empty where a scene does not record shapes.

    `colour` is `#rrggbb`, empty for the viewer's choice; `file` is the file of a mesh.
    """

    name: str
    part: str
    kind: str
    colour: str
    file: str
    values: tuple[ShapeValue, ...] = ()
