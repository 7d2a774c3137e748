"""Typical sizes of the through variables of classes, relative to each other.

A gyrator of 2700 V*s/m relates variables of different units, so that 1 beside 2700 in a row is no
weak coefficient there, as 5e-12 beside 1 is in a rotation. Sizes follow from element to element:
junctions keep them; transformers and gyrators multiply them by their largest modulus, if none of
their moduli is of the size of one.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence

from bgc.algebra.dag import Dag, Level
from bgc.causality.certificates import Certifier
from bgc.ir.causal import Row

_OF_ONE = 10.0  # moduli between a tenth and this may belong to variables of the same unit


def typical_sizes(
    dag: Dag, certifier: Certifier, class_of: Sequence[int], rows: Sequence[Row]
) -> list[float]:
    """The size of each class; classes that no row joins have their own.

    Where loops of moduli contradict each other, the shortest way counts.
    """
    factors: dict[int, float] = {}
    for row in rows:
        for size in _moduli(dag, certifier, row):
            factors[row.element] = _combined(factors.get(row.element), size)
    sizes = [0.0] * (max(class_of, default=-1) + 1)
    rows_with: list[list[int]] = [[] for _ in sizes]
    for index, row in enumerate(rows):
        for end in row.ends:
            rows_with[class_of[end.bond]].append(index)
    for first in range(len(sizes)):
        if sizes[first]:
            continue
        sizes[first] = 1.0
        queue = deque([first])
        while queue:
            number = queue.popleft()
            for index in rows_with[number]:
                row = rows[index]
                factor = factors.get(row.element, 1.0)
                own, *others = (class_of[end.bond] for end in row.ends)
                base = sizes[number] / factor if number == own else sizes[number]
                for other in (own, *others):
                    if not sizes[other]:
                        sizes[other] = base * factor if other == own else base
                        queue.append(other)
    return sizes


def _moduli(dag: Dag, certifier: Certifier, row: Row) -> Iterator[float]:
    """The sizes of the constant moduli in the row of a transformer or gyrator, but for zeros."""
    for end in row.ends[1:]:
        if dag.level[end.coefficient] <= Level.PARAM:
            size = abs(certifier.default(end.coefficient))
            if size and math.isfinite(size):
                yield size


def _combined(known: float | None, size: float) -> float:
    """The factor of an element with a further modulus: 1 from one of the size of one on."""
    if known == 1.0 or 1 / _OF_ONE <= size <= _OF_ONE:
        return 1.0
    return size if known is None else max(known, size)
