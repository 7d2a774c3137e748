"""The energy of linear storage along the variables that constraints leave free.

Inertias on dependent flows and compliances along free motions are one thing. Their energy is a
quadratic form `1/2 v' Q v - b' v` of flows or charges v, some of which are defined by others. With
z the free ones and s those given from outside, v = N z + N_s s, and z follows from

    N' Q N z = N' (b - Q N_s s),

where N' Q N is the reduced mass, or the common stiffness. It is solved by `algebra/quadratic.py`,
one elimination step at a time. Both the matrix and the solution are checked in numbers at a random
point. A modulus that reads flows or charges is a number like any other there.
"""

from __future__ import annotations

import math
import random
import sys
from collections.abc import Callable, Iterable, Sequence

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.dense import soft_motion
from bgc.algebra.evaluate import Evaluator
from bgc.algebra.quadratic import ConstrainedEnergy, Definition, Minimum, minimise
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.storage.kinds import StorageElement
from bgc.equations.variables.definitions import Explicit, Unknown, Variables
from bgc.ir.graph import Node

_TOLERANCE = 1e-6  # of the terms of a sum; far above rounding, far below the effect of a wrong sign


def determine(
    variables: Variables,
    unknowns: Sequence[Node],
    energy: ConstrainedEnergy | None,
    symbol_of: Callable[[int], Node],
    row_of: Callable[[int], Node],
) -> Sequence[Node]:
    """Define unknowns, in their order, as the free variables of least energy; gives the pivots.

    They are raw nodes in each other and in the variables that are not free. `row_of` gives the
    residual of each by its place: a row determines it where the solution fails the check, or where
    there is no quadratic energy.

    Raises
    ------
    SingularFormError
        The matrix of the energy along the free variables is always singular.
    """
    dag, minima = variables.dag, list[Minimum]()
    if energy is not None:
        fingerprints = variables.causal.fingerprints
        minima = minimise(dag, fingerprints, energy.form, energy.definitions, energy.free)
        if is_minimum(at_random(variables), energy, minima):
            place = dict(zip(energy.free, unknowns, strict=True))
            for m in minima:
                known = dag.sum(dag.mul(c, symbol_of(k)) for k, c in m.row.items())
                value = dag.div(dag.sub(m.offset, known), m.pivot)
                variables.definitions[place[m.variable]] = Explicit(value)
            return [m.pivot for m in minima]
    for k, unknown in enumerate(unknowns):
        variables.definitions[unknown] = Unknown()
        variables.add_equation(row_of(k), unknown)
    return ()


def at_random(variables: Variables) -> Evaluator:
    """Numbers for raw nodes at a random point, with parameters at their defaults."""

    def leaf(symbol: Symbol) -> float:
        if symbol.kind is Kind.PARAM:
            return variables.default(variables.dag.symbol(symbol.kind, symbol.index))
        return random.Random(f"{symbol.kind} {symbol.index}").uniform(0.2, 1)

    return Evaluator(variables.dag, leaf)


def is_minimum(numbers: Evaluator, energy: ConstrainedEnergy, minima: Sequence[Minimum]) -> bool:
    """Return whether `N' (Q v - b)` vanishes at the minima, or has no value."""
    values = _values_at(numbers, energy, minima)
    slopes: dict[int, float] = {}
    sizes: dict[int, float] = {}  # of the terms of each slope

    def add(k: int, slope: float, size: float) -> None:
        slopes[k] = slopes.get(k, 0.0) + slope
        sizes[k] = sizes.get(k, 0.0) + size

    for k, row in energy.form.matrix.items():
        for j, node in row.items():
            force = numbers.value(node) * values[j]
            add(k, force, abs(force))
    for k, node in energy.form.vector.items():
        force = numbers.value(node)
        add(k, -force, abs(force))
    for definition in energy.definitions:
        k = definition.variable
        for j, node in definition.row.items():
            c = numbers.value(node)
            add(j, c * slopes.get(k, 0.0), abs(c) * sizes.get(k, 0.0))
    return not any(abs(slopes.get(k, 0.0)) > _TOLERANCE * sizes.get(k, 0.0) for k in energy.free)


def _values_at(
    numbers: Evaluator, energy: ConstrainedEnergy, minima: Sequence[Minimum]
) -> dict[int, float]:
    """All variables at the minima; those given from outside are random."""
    steps: dict[int, Minimum | Definition] = {d.variable: d for d in energy.definitions}
    steps |= {minimum.variable: minimum for minimum in minima}
    values: dict[int, float] = {}
    waiting = [*steps, *energy.form.matrix]
    while waiting:
        k = waiting[-1]
        step = steps.get(k)
        missing = [j for j in step.row if j not in values] if step is not None else []
        if missing:
            waiting += missing
            continue
        waiting.pop()
        if step is None:
            values[k] = random.Random(f"variable {k}").uniform(0.2, 1)
            continue
        values[k] = sum(numbers.value(c) * values[j] for j, c in step.row.items())
        if isinstance(step, Minimum):
            offset, pivot = numbers.values([step.offset, step.pivot])
            values[k] = (offset - values[k]) / pivot if pivot else math.nan
    return values


class ReducedMatrix:
    """`N' Q N` in numbers at a random point.

    Attributes
    ----------
    rows
        Variable -> its row of N: place among the free variables -> entry.
    entries
        The matrix, in the order of the free variables.
    sizes
        The sums of the absolute values of the terms of its diagonal.
    """

    def __init__(self, variables: Variables, energy: ConstrainedEnergy) -> None:
        numbers, size = at_random(variables), len(energy.free)
        self.rows: dict[int, dict[int, float]] = {k: {i: 1.0} for i, k in enumerate(energy.free)}
        for definition in reversed(energy.definitions):
            row: dict[int, float] = {}
            for k, node in definition.row.items():
                entry = numbers.value(node)
                for i, x in self.rows.get(k, {}).items():
                    row[i] = row.get(i, 0.0) + entry * x
            self.rows[definition.variable] = row
        self.entries = [[0.0] * size for _ in range(size)]
        self.sizes = [0.0] * size
        for k, coupled in energy.form.matrix.items():
            pulls: dict[int, float] = {}  # the slope along variable k
            for other, node in coupled.items():
                entry = numbers.value(node)
                for j, y in self.rows.get(other, {}).items():
                    pulls[j] = pulls.get(j, 0.0) + entry * y
            for i, x in self.rows.get(k, {}).items():
                self.sizes[i] += abs(x * pulls.get(i, 0.0))
                for j, pull in pulls.items():
                    self.entries[i][j] += x * pull

    @property
    def is_known(self) -> bool:
        """Return whether it has values, with enough digits to judge."""
        finite = all(math.isfinite(entry) for row in self.entries for entry in row)
        diagonal = [abs(row[i]) for i, row in enumerate(self.entries)]
        return finite and not any(0 < x < sys.float_info.min for x in diagonal)

    def is_definite(self, least: float) -> bool:
        """Return whether it is known, and has eigenvalues above `least`.

        It is scaled to a diagonal of ones, less where parts of it cancel. Only its lower half is
        read: what is not symmetric fails the check of the solution.
        """
        return self.is_known and soft_motion(self.entries, self.sizes, least, 0.0) is None

    def is_singular(self, least: float) -> bool:
        """Return whether it is known and Gaussian elimination has a pivot of at most `least`."""
        roots = [size**0.5 or 1.0 for size in self.sizes]
        rows = [
            [x / (a * b) for x, b in zip(row, roots, strict=True)]
            for row, a in zip(self.entries, roots, strict=True)
        ]
        for k in range(len(rows) if self.is_known else 0):
            best = max(range(k, len(rows)), key=lambda i: abs(rows[i][k]))
            rows[k], rows[best] = rows[best], rows[k]
            if abs(rows[k][k]) <= least:
                return True
            for row in rows[k + 1 :]:
                factor = row[k] / rows[k][k]
                row[k:] = [x - factor * y for x, y in zip(row[k:], rows[k][k:], strict=True)]
        return False


def cannot_merge(element: StorageElement, names: Iterable[str], why: str) -> BgError:
    """The error that refuses storage which is merged, at its first element."""
    first = element.storage
    others = [name for name in dict.fromkeys(names) if name != first.name]
    return BgError([storage_messages.dependent_storage(first.span, first.name, others, why)])
