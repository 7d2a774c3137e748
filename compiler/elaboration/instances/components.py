"""Components of vectors and matrices: their indices, order and names."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce

from bgc.values.value import Shape


def indices(shape: Shape) -> list[tuple[int, ...]]:
    """The indices of all components, from 1, matrices by rows; `[()]` for a scalar."""
    found: list[tuple[int, ...]] = [()]
    for size in shape:
        found = [(*index, k) for index in found for k in range(1, size + 1)]
    return found


def ordinal(index: tuple[int, ...], shape: Shape) -> int:
    """The position (from 0, matrices by rows) of the component with an index (from 1)."""
    steps = zip(index, shape, strict=True)
    return reduce(lambda before, step: before * step[1] + step[0] - 1, steps, 0)


def component_name(name: str, index: tuple[int, ...]) -> str:
    """The name of a component, `M[1,2]`; the plain name for a scalar."""
    return f"{name}[{','.join(map(str, index))}]" if index else name


def component_names(name: str, shape: Shape) -> Iterator[str]:
    """The names of all components in order."""
    return (component_name(name, index) for index in indices(shape))
