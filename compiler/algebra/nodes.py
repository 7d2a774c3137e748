"""Types of nodes: an int that numbers a node of a `Dag`, and matrices of such ints."""

from __future__ import annotations

from typing import Annotated, TypeAlias

Node: TypeAlias = Annotated[int, "node"]
Matrix: TypeAlias = tuple[tuple[Node, ...], ...]
