"""The shapes of a run: how parts are drawn, and their poses at each row.

In an `.npz` file, `about` has a list `shapes` with an entry for each::

    {"name": "crane.boom.box", "part": "crane.boom", "kind": "box", "colour": "#808080",
     "file": "", "values": {"length": 12.0, "r": "shape:crane.boom.box:r", ..}}

A value is a number or a nested list of numbers where it is constant, or the name of the array in
the same file with one entry for each row. `r` (3) is the position in the world in m, `A` (3, 3)
turns the axes of the shape into those of the world; a shape between two frames has the positions
`from` and `to` instead.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.row_files import RowArray


@dataclass(frozen=True, eq=False, repr=False)
class Shape:
    """A shape of a part, with its quantities over the rows of a run.

    Attributes
    ----------
    name, part
        A name of its own, and the path of the part that it belongs to.
    kind
        `box`, `cylinder`, `sphere`, `capsule`, `hull`, `ram`, `mesh`, `rope`, `arrow`, `sea` or
        `handle`.
    colour
        `#rrggbb`; empty where the viewer chooses.
    file
        The file of a mesh, relative to the file of the model; empty for other shapes.
    constant, varying
        Quantities by name, SI: with their own shape, or with one entry for each row before it.
    rows
        The number of rows.
    """

    name: str
    part: str
    kind: str
    colour: str
    file: str
    constant: Mapping[str, Array]
    varying: Mapping[str, Array]
    rows: int

    def __repr__(self) -> str:
        return f"<shape {self.name}: {', '.join((*self.constant, *self.varying))}>"

    def __contains__(self, name: object) -> bool:
        return name in self.constant or name in self.varying

    def __getitem__(self, name: str) -> Array:
        """A quantity at each row: `shape["radius"]` (n,), `shape["r"]` (n, 3)."""
        if name in self.varying:
            return self.varying[name]
        value = np.asarray(self.constant[name])
        return np.broadcast_to(value, (self.rows, *value.shape))

    @property
    def r(self) -> Array:
        """Positions in the world, m, (n, 3)."""
        return self["r"]

    @property
    def A(self) -> Array:
        """Rotation matrices, axes of the shape -> world's, (n, 3, 3)."""
        return self["A"]

    def array_of(self, name: str) -> str:
        """The name of the array in a file that has a varying quantity."""
        return f"shape:{self.name}:{name}"


def shapes_of(text: str, columns: Mapping[str, int], rows: Array) -> tuple[Shape, ...]:
    """Take the recorded shapes, the JSON text of the model, from the rows of a run."""
    found = []
    for entry in json.loads(text or "[]"):
        constant, varying = {}, {}
        for name, shape, content in entry.pop("values"):
            if content and isinstance(content[0], str):
                places = [columns[column] for column in content]
                varying[name] = rows[:, places].reshape(len(rows), *shape)
            else:
                constant[name] = np.array(content, dtype=float).reshape(shape)
        found.append(Shape(**entry, constant=constant, varying=varying, rows=len(rows)))
    return tuple(found)


def shape_arrays(text: str, columns: Mapping[str, int]) -> tuple[RowArray, ...]:
    """The arrays of all varying quantities in a file, with their places in the rows of a run."""
    found = []
    for entry in json.loads(text or "[]"):
        for name, shape, content in entry["values"]:
            if content and isinstance(content[0], str):
                places = tuple(columns[column] for column in content)
                found.append(RowArray(f"shape:{entry['name']}:{name}", "", tuple(shape), places))
    return tuple(found)


def described(shapes: Sequence[Shape]) -> list[dict[str, Any]]:
    """The entries of shapes in the description of a file."""
    return [
        {
            "name": shape.name,
            "part": shape.part,
            "kind": shape.kind,
            "colour": shape.colour,
            "file": shape.file,
            "values": {
                **{name: value.tolist() for name, value in shape.constant.items()},
                **{name: shape.array_of(name) for name in shape.varying},
            },
        }
        for shape in shapes
    ]


def arrays_of(shapes: Sequence[Shape]) -> dict[str, Array]:
    """The arrays of all varying quantities, by their names in a file."""
    return {s.array_of(name): value for s in shapes for name, value in s.varying.items()}


def read_shapes(path: str | Path) -> tuple[Shape, ...]:
    """Read the shapes from an `.npz` file of a result; none where it has recorded none."""
    found = []
    with np.load(path) as arrays:
        rows = len(arrays["time"])
        for entry in json.loads(str(arrays["about"])).get("shapes", []):
            values = entry.pop("values")
            named = {name: v for name, v in values.items() if isinstance(v, str)}
            constant = {n: np.array(v, dtype=float) for n, v in values.items() if n not in named}
            varying = {name: arrays[array] for name, array in named.items()}
            found.append(Shape(**entry, constant=constant, varying=varying, rows=rows))
    return tuple(found)
