"""What a node of a DAG is to everybody else: a number; and matrices of them."""

from __future__ import annotations

from typing import TypeAlias

Node: TypeAlias = int
Matrix: TypeAlias = tuple[tuple[Node, ...], ...]
