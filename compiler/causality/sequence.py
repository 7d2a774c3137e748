"""Order the rows so that most of them can be solved one by one, without combining them.

Elimination finds the independent flows, but it substitutes rows into each other, and along a chain
of transformers its working rows grow. Once the dependent classes are known, the matrix of their
coefficients is permuted to triangular form by removing rows, then columns, with a single open
class. The raw rows then give one class each from those before, every modulus stays as written in
the model, and flows, efforts and their rates take a number of operations proportional to the number
of rows. Only the remaining core, true loops of transformers, is eliminated again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from bgc.algebra.dag import Dag
from bgc.algebra.fingerprint import Fingerprints
from bgc.causality.certificates import Certifier, Size
from bgc.ir.causal import Row, Step
from bgc.ir.graph import Node

_Form = dict[int, Node]  # class -> coefficient that is not zero


def sequence_rows(
    dag: Dag,
    fingerprints: Fingerprints,
    certifier: Certifier,
    class_of: Sequence[int],
    rows: Sequence[Row],
    steps: Sequence[Step],
) -> tuple[tuple[Step, ...], list[tuple[Node, int]]]:
    """Replace the steps of an elimination by steps on raw rows wherever possible.

    The rows and dependent classes are the same, and as after an elimination a dependent class is
    only in working rows up to its own. Also returns the nodes of PARAM level used as pivots, each
    with its row. If a core has no certified pivot in the order taken here, the given steps are
    returned.
    """
    sequence = _Sequence(dag, fingerprints, certifier, class_of, rows, steps)
    last = sequence.take_rows()
    first = sequence.take_columns()
    core = sequence.eliminate_rest()
    if core is None:
        return tuple(steps), []
    return (*first, *core, *reversed(last)), sequence.watched


class _Sequence:
    def __init__(
        self,
        dag: Dag,
        fingerprints: Fingerprints,
        certifier: Certifier,
        class_of: Sequence[int],
        rows: Sequence[Row],
        steps: Sequence[Step],
    ) -> None:
        self._dag = dag
        self._fingerprints = fingerprints
        self._certifier = certifier
        self._forms: dict[int, _Form] = {}
        self._factors: dict[int, _Form] = {}  # row -> subtracted row -> its factor
        self._left: dict[int, set[int]] = {}  # open row -> its open classes
        self._where: dict[int, set[int]] = {step.dependent: set() for step in steps}
        self.watched: list[tuple[Node, int]] = []
        for step in steps:
            form: _Form = {}
            for end in rows[step.row].ends:
                number = class_of[end.bond]
                form[number] = dag.add(form.get(number, dag.zero), end.coefficient)
            self._forms[step.row] = {
                number: entry
                for number, node in form.items()
                if (entry := self._fingerprints.simplified(node)) != dag.zero
            }
            self._factors[step.row] = {}
            self._left[step.row] = set(self._forms[step.row]) & set(self._where)
            for number in self._left[step.row]:
                self._where[number].add(step.row)

    def take_rows(self) -> list[Step]:
        """Remove rows with one open class, in the order in which they can be solved."""
        found = []
        queue = deque(row for row, left in self._left.items() if len(left) == 1)
        while queue:
            row = queue.popleft()
            if len(self._left.get(row, ())) != 1:
                continue
            (number,) = self._left[row]
            if self._may_divide(row, number):
                found.append(self._close(row, number))
                queue.extend(sorted(r for r in self._where[number] if len(self._left[r]) == 1))
                del self._where[number]
        return found

    def take_columns(self) -> list[Step]:
        """Remove open classes that are in a single open row; no open class depends on them."""
        found = []
        queue = deque(number for number, rows in self._where.items() if len(rows) == 1)
        while queue:
            number = queue.popleft()
            if len(self._where.get(number, ())) != 1:
                continue
            (row,) = self._where[number]
            if self._may_divide(row, number):
                others = sorted(self._left[row] - {number})
                found.append(self._close(row, number))
                del self._where[number]
                queue.extend(n for n in others if len(self._where[n]) == 1)
        return found

    def eliminate_rest(self) -> list[Step] | None:
        """Eliminate the remaining open classes; None if there is no certified pivot.

        Independent classes count among the entries of a row too: along a chain of rotations each
        row then stays in terms of the frame before, and does not gather all coordinates to it.
        """
        found = []
        while self._left:
            candidates = [
                (size.is_small, (len(self._forms[row]) - 1) * (len(rows) - 1), row, number)
                for number, rows in self._where.items()
                for row in rows
                if (size := self._size(row, number)) is not None
            ]
            if not candidates:
                return None
            *_, row, number = min(candidates)
            self._may_divide(row, number)
            found.append(self._close(row, number))
            for other in sorted(self._where.pop(number)):
                self._subtract(other, row, number)
        return found

    def _size(self, row: int, number: int) -> Size | None:
        form = self._forms[row]
        return self._certifier.size_in(form[number], form.values())

    def _may_divide(self, row: int, number: int) -> bool:
        certificate = self._certifier.certify(self._forms[row][number])
        if certificate is None:
            return False
        self.watched.extend((node, row) for node in certificate.watched)
        return True

    def _close(self, row: int, number: int) -> Step:
        """Make the step that solves an open row for a class."""
        for other in self._left.pop(row):
            self._where[other].discard(row)
        for other_row in self._where[number]:
            self._left[other_row].discard(number)
        form, factors = self._forms[row], self._factors[row]
        return Step(row, number, tuple(form.items()), tuple(factors.items()))

    def _subtract(self, row: int, source: int, number: int) -> None:
        """Eliminate the class of a solved row from another row."""
        dag, form, taken = self._dag, self._forms[row], self._forms[source]
        factor = dag.div(form.pop(number), taken[number])
        self._factors[row][source] = factor
        for other, entry in taken.items():
            if other == number:
                continue
            changed = dag.sub(form.get(other, dag.zero), dag.mul(factor, entry))
            form[other] = self._fingerprints.simplified(changed)
            if form[other] == dag.zero:
                del form[other]
            if other in self._where:
                held = other in form
                (self._left[row].add if held else self._left[row].discard)(other)
                (self._where[other].add if held else self._where[other].discard)(row)
