"""Minimum of a quadratic form in variables of which some are defined by others.

    minimise  1/2 f' Q f - b' f   where   f_d = sum_j c_dj f_j  for every definition d.

A definition is *substituted*: the variables of its row replace its variable. A free variable is
*minimised over* once it is in no definition. Both steps keep the form symmetric and positive
semidefinite, and each pivot is the curvature of the form along a motion that all definitions allow,
so that it vanishes only where the whole form is singular. The steps may therefore be mixed in any
order, and the order decides the number of operations:

- all substitutions first, which leaves the reduced matrix `N' Q N`, then L D L' in
  minimum-degree order: few operations where the rows share most variables;
- each variable as soon as possible: along a chain the form never grows, and the number of
  operations is proportional to its length (for rigid bodies on joints this is the articulated-body
  algorithm of Featherstone 1983, here for any graph).

Both are tried, and the one with fewer operations is kept.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.nodes import Node

Row = dict[int, Node]  # variable -> coefficient


class SingularFormError(Exception):
    """The form is singular: its curvature along the free variable `variable` is zero."""

    def __init__(self, variable: int) -> None:
        super().__init__("singular form")
        self.variable = variable


@dataclass(frozen=True, slots=True)
class Form:
    """`1/2 f' Q f - b' f`; `matrix` holds both halves of the symmetric Q."""

    matrix: dict[int, Row]
    vector: dict[int, Node]


@dataclass(frozen=True, slots=True)
class Definition:
    """`variable = sum coefficient * other`; `variable` is in no later definition's row."""

    variable: int
    row: Row


@dataclass(frozen=True, slots=True)
class Minimum:
    """`pivot * variable = offset - sum coefficient * other`, the others being known by then."""

    variable: int
    pivot: Node
    offset: Node
    row: Row


def minimise(
    dag: Dag,
    fingerprints: Fingerprints,
    form: Form,
    definitions: Sequence[Definition],
    free: Sequence[int],
) -> list[Minimum]:
    """Minimise the form over the free variables, in terms of the remaining ones.

    The row of a minimum holds variables (also defined ones) that follow from later minima and from
    variables that are neither defined nor free. Both orders agree up to rounding.

    Raises
    ------
    SingularFormError
        The form is singular for all values of the symbols.
    """
    early = _minimise(dag, fingerprints, form, definitions, free, early=True, budget=None)
    assert early is not None
    cost = _operations(dag, early)
    late = _minimise(dag, fingerprints, form, definitions, free, early=False, budget=2 * cost)
    return early if late is None or _operations(dag, late) >= cost else late


def minimise_in_order(
    dag: Dag,
    fingerprints: Fingerprints,
    form: Form,
    definitions: Sequence[Definition],
    free: Sequence[int],
    *,
    early: bool,
) -> list[Minimum]:
    """Minimise as `minimise` does, in the order that the caller chooses."""
    found = _minimise(dag, fingerprints, form, definitions, free, early=early, budget=None)
    assert found is not None
    return found


def inline(dag: Dag, definitions: Sequence[Definition]) -> list[Definition]:
    """Remove variables that are always zero, or equal to another one up to the sign."""
    alias: dict[int, tuple[int, Node] | None] = {}  # None: the variable is zero
    found = []
    for definition in reversed(definitions):
        row: Row = {}
        for number, entry in definition.row.items():
            target = alias.get(number, (number, dag.one))
            if target is not None:
                other, sign = target
                row[other] = dag.add(row.get(other, dag.zero), dag.mul(entry, sign))
        row = {number: entry for number, entry in row.items() if entry != dag.zero}
        match list(row.items()):
            case []:
                alias[definition.variable] = None
            case [(other, entry)] if dag.value(entry) in {1, -1}:
                alias[definition.variable] = (other, entry)
            case _:
                pass
        found.append(Definition(definition.variable, row))
    return found[::-1]


def _operations(dag: Dag, minima: Iterable[Minimum]) -> int:
    """Count the operations at run time."""
    roots = [n for m in minima for n in (m.pivot, m.offset, *m.row.values())]
    used = dag.reachable(roots)
    return sum(dag.op[n] > Op.SYMBOL and dag.level[n] > Level.PARAM for n in used)


def _minimise(
    dag: Dag,
    fingerprints: Fingerprints,
    form: Form,
    definitions: Sequence[Definition],
    free: Sequence[int],
    *,
    early: bool,
    budget: int | None,
) -> list[Minimum] | None:
    """Minimise in one order; None as soon as it makes more nodes than the budget."""
    work = _Work(dag, fingerprints, form, definitions, free)
    first = len(dag)
    while work.step(minimise_first=early):
        if budget is not None and len(dag) - first > budget:
            return None
    return work.minima


class _Work:
    def __init__(
        self,
        dag: Dag,
        fingerprints: Fingerprints,
        form: Form,
        definitions: Sequence[Definition],
        free: Sequence[int],
    ) -> None:
        self._dag = dag
        self._fingerprints = fingerprints
        self._matrix = {k: dict(row) for k, row in form.matrix.items()}
        self._vector = dict(form.vector)
        self._place = {d.variable: place for place, d in enumerate(definitions)}
        self._definitions: dict[int, Row] = {}
        needed = set(form.matrix)
        for definition in inline(dag, definitions):
            if definition.variable in needed:
                self._definitions[definition.variable] = definition.row
                needed |= set(definition.row)
        self._moving = {*free, *self._definitions}
        self._held = dict.fromkeys(self._moving, 0)  # variable -> number of definitions it is in
        for row in self._definitions.values():
            for k in row:
                if k in self._held:
                    self._held[k] += 1
        self._deepest: list[tuple[int, int]] = []
        self._free: list[tuple[int, int]] = []
        self.minima: list[Minimum] = []
        for k, count in self._held.items():
            if count == 0:
                self._release(k)

    def step(self, *, minimise_first: bool) -> bool:
        """Eliminate one variable, of the preferred kind if possible; False at the end."""
        kinds = [self._minimise_next, self._substitute_next]
        return any(take() for take in (kinds if minimise_first else reversed(kinds)))

    def _release(self, variable: int) -> None:
        """Queue a variable that is in no definition any more."""
        if variable in self._definitions:
            heappush(self._deepest, (self._place[variable], variable))
        else:
            heappush(self._free, (len(self._matrix.get(variable, ())), variable))

    def _minimise_next(self) -> bool:
        """Minimise over the queued free variable with the fewest entries."""
        while self._free:
            degree, k = heappop(self._free)
            now = len(self._matrix.get(k, ()))
            if degree == now:
                self.minima.append(self._minimise(k))
                return True
            heappush(self._free, (now, k))
        return False

    def _substitute_next(self) -> bool:
        """Substitute the queued definition that is farthest from the free variables."""
        if self._deepest:
            self._substitute(heappop(self._deepest)[1])
            return True
        return False

    def _substitute(self, d: int) -> None:
        """Substitute a definition into the form."""
        dag, row = self._dag, self._definitions[d]
        coupled = self._remove(d)
        own = coupled.pop(d, dag.zero)
        pull = self._vector.pop(d, dag.zero)
        whole = {j: dag.add(coupled.get(j, dag.zero), dag.mul(c, own)) for j, c in row.items()}
        variables = list(row)
        for place, i in enumerate(variables):
            c = row[i]
            self._pull(i, dag.mul(c, pull))
            half = coupled.get(i, dag.zero)
            self._add(i, i, dag.mul(c, dag.add(whole[i], half)))
            for j in variables[place + 1 :]:
                self._add(i, j, dag.add(dag.mul(c, whole[j]), dag.mul(row[j], half)))
            for j, entry in coupled.items():
                if j not in row:
                    self._add(i, j, dag.mul(c, entry))
        for k in row:
            if k in self._held:
                self._held[k] -= 1
                if self._held[k] == 0:
                    self._release(k)

    def _minimise(self, k: int) -> Minimum:
        dag = self._dag
        row = self._remove(k)
        pivot = row.pop(k, dag.zero)
        offset = self._vector.pop(k, dag.zero)
        if pivot == dag.zero:
            raise SingularFormError(k)
        others = sorted(row)
        for place, i in enumerate(others):
            factor = dag.div(row[i], pivot)
            self._pull(i, dag.neg(dag.mul(factor, offset)))
            for j in others[place:]:
                self._add(i, j, dag.neg(dag.mul(factor, row[j])))
        return Minimum(k, pivot, offset, row)

    def _remove(self, variable: int) -> Row:
        row = self._matrix.pop(variable, {})
        for other in row:
            if other != variable:
                del self._matrix[other][variable]
        return row

    def _pull(self, i: int, node: Node) -> None:
        if i in self._moving and node != self._dag.zero:
            self._vector[i] = self._dag.add(self._vector.get(i, self._dag.zero), node)

    def _add(self, i: int, j: int, node: Node) -> None:
        """Add to an entry of Q, unless both variables are given from outside."""
        dag = self._dag
        if node == dag.zero or not (i in self._moving or j in self._moving):
            return
        total = dag.add(self._matrix.get(i, {}).get(j, dag.zero), node)
        if dag.op[total] != Op.CONST:  # a constant of a long fraction takes long to recover
            value = self._fingerprints.constant(total)
            total = total if value is None else dag.const(value)
        for row, column in ((i, j), (j, i)):
            if total == dag.zero:
                self._matrix.get(row, {}).pop(column, None)
            else:
                self._matrix.setdefault(row, {})[column] = total
