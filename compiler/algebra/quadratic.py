"""Minimum of a quadratic form in variables of which some are defined by others.

    minimise  1/2 f' Q f - b' f   where   f_d = sum_j c_dj f_j  for every definition d.

A definition is *substituted*: the variables of its row replace its variable. A free variable is
*minimised over* once it is in no definition. Both steps keep the form symmetric and positive
semidefinite, and each pivot is the curvature of the form along a motion that all definitions allow,
so that it vanishes only where the whole form is singular. The steps may therefore be mixed in any
order, and the order decides the number of operations:

- all substitutions first, which leaves the reduced matrix `N' Q N`, then L D L' in
  minimum-degree order: few operations where the rows share most variables;
- the variable next that leaves the narrowest form: the one whose removal couples the fewest
  variables, by substitution or by minimisation (minimum degree, as of sparse matrices). Along a
  chain or a tree the form never grows, and the number of operations is proportional to its length
  (for rigid bodies on joints this is the articulated-body algorithm of Featherstone 1983, here for
  any graph). Substitutions in the order of the definitions alone are no such order: they may carry
  the translations of all bodies to the base before the first rotation, beside which each
  translation then has a row.

Where a substitution and a minimisation leave equally many, either may be the better: minimising
first keeps the form narrow for certain, substituting first often merges a body with the next. All
three are tried, and the one with the fewest operations is kept.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import Enum
from heapq import heappop, heappush

from bgc.algebra.dag import Dag, Op
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.nodes import Node
from bgc.record_class import dataclass

Row = dict[int, Node]  # variable -> coefficient


_Key = tuple[int, int, int, int]  # of a variable that may be removed: the least is the next


class Order(Enum):
    """The order in which variables are removed from a form."""

    NARROW = "the fewest coupled variables first, of equals the free ones"
    MERGING = "the fewest coupled variables first, of equals the defined ones"
    SUBSTITUTIONS_FIRST = "all substitutions, then the fewest coupled variables first"


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
class ConstrainedEnergy:
    """A form, the definitions of variables in it, and the free variables, as `minimise` takes."""

    form: Form
    definitions: Sequence[Definition]
    free: Sequence[int]


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
    variables that are neither defined nor free. All orders agree up to rounding.

    Raises
    ------
    SingularFormError
        The form is singular for all values of the symbols.
    """
    best = minimise_in_order(dag, fingerprints, form, definitions, free, Order.NARROW)
    cost = _operations(dag, best)
    for order in (Order.MERGING, Order.SUBSTITUTIONS_FIRST):
        work = _Work(dag, fingerprints, form, definitions, free, order)
        found = work.minimise(budget=2 * cost)
        if found is not None and (other := _operations(dag, found)) < cost:
            best, cost = found, other
    return best


def minimise_in_order(
    dag: Dag,
    fingerprints: Fingerprints,
    form: Form,
    definitions: Sequence[Definition],
    free: Sequence[int],
    order: Order,
) -> list[Minimum]:
    """Minimise as `minimise` does, in the order that the caller chooses."""
    found = _Work(dag, fingerprints, form, definitions, free, order).minimise(budget=None)
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
    return len(dag.repeated(roots))


class _Work:
    def __init__(
        self,
        dag: Dag,
        fingerprints: Fingerprints,
        form: Form,
        definitions: Sequence[Definition],
        free: Sequence[int],
        order: Order,
    ) -> None:
        self._dag = dag
        self._order = order
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
        self._keys: dict[int, _Key] = {}  # of variables in no definition
        self._queue: list[tuple[_Key, int]] = []
        self._minima: list[Minimum] = []
        for k, count in self._held.items():
            if count == 0:
                self._enter(k)

    def minimise(self, *, budget: int | None) -> list[Minimum] | None:
        """Remove all variables; None as soon as that makes more nodes than the budget."""
        first = len(self._dag)
        while self._queue:
            key, k = heappop(self._queue)
            if self._keys.get(k) != key:
                continue  # another entry holds the key of now
            del self._keys[k]
            touched = [*self._matrix.get(k, ()), *self._definitions.get(k, ())]
            if k in self._definitions:
                self._substitute(k)
            else:
                self._minima.append(self._minimise(k))
            for other in touched:
                if other in self._keys:
                    self._enter(other)
            if budget is not None and len(self._dag) - first > budget:
                return None
        return self._minima

    def _enter(self, k: int) -> None:
        """Queue a variable that is in no definition, by its key of now."""
        key = self._key(k)
        if self._keys.get(k) != key:
            self._keys[k] = key
            heappush(self._queue, (key, k))

    def _key(self, k: int) -> _Key:
        coupled, row = self._matrix.get(k, {}), self._definitions.get(k)
        if self._order is Order.SUBSTITUTIONS_FIRST:
            return (1, len(coupled), 0, 0) if row is None else (0, self._place[k], 0, 0)
        if row is None:
            others = len(coupled) - 1
            rank = 0 if self._order is Order.NARROW else 2
            return others, rank, others * (others + 1) // 2, -1
        others = len(coupled.keys() | row.keys()) - (k in coupled)
        products = len(row) * (2 * len(coupled) + len(row) + 1) // 2 if len(row) > 1 else 0
        return others, 1, products, self._place[k]

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
                    self._enter(k)

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
