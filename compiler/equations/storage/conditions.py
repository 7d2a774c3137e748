"""Linear conditions that given initial values impose on the stored quantities.

They are inserted one at a time. A condition that depends on earlier ones must agree with them, or
it is named as the culprit. Default zeros that the user did not choose give way instead.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from enum import Enum
from typing import TypeAlias, TypeVar

from bgc.algebra.dag import Level
from bgc.algebra.symbolic_systems import SingularSystemError, solve_general
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.storage.contradicted_start import opposing_source, parameters_behind
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Initial, Node
from bgc.record_class import dataclass

Row: TypeAlias = dict[int, Node]
NEGLIGIBLE = 1e-9  # of a condition's coefficients, or of its value


@dataclass(frozen=True, slots=True)
class Condition:
    """`sum row * unknown = value`, from an initial value of the element `name`."""

    row: Row
    value: Node
    name: str
    initial: Initial | None  # None for a value that is not given

    @property
    def is_default(self) -> bool:
        """Return whether it is a zero by default, ignored where it contradicts given values."""
        return self.initial is not None and self.initial.is_default


def independent_conditions(
    variables: Variables,
    conditions: Sequence[Condition],
    balances: Sequence[tuple[Row, Node]],
) -> list[Condition] | None:
    """Insert conditions one at a time; a dependent one has to agree with the earlier ones.

    All are evaluated numerically, at the start and the parameters' defaults. The balances, as rows
    and right-hand sides, always hold and come first. Defaults come after given values, and those of
    one element hold together or not at all. Elements with ignored defaults are recorded in the
    variables. None where a flow or an effort takes part that is not known before the start.
    """
    if not conditions:
        return []
    equations = [*balances, *((c.row, c.value) for c in conditions)]
    columns = sorted({j for row, _ in equations for j in row})
    nodes = [
        node
        for row, value in equations
        for node in (*(row.get(j, variables.dag.zero) for j in columns), value)
    ]
    values = variables.at_start(nodes)
    if values is None or not all(map(math.isfinite, values)):
        return None
    width = len(columns) + 1
    numbers = [values[k : k + width] for k in range(0, len(values), width)]
    system = System()
    for row in numbers[: len(balances)]:
        system.insert(row)
    chosen: list[Condition] = []
    given = zip(conditions, numbers[len(balances) :], strict=True)
    for group in in_order(given):
        found = system.copy()
        answers = [(condition, found.insert(row, condition)) for condition, row in group]
        condition = next((c for c, answer in answers if answer is Answer.CONTRADICTS), None)
        if condition is None:
            system = found
            chosen += [c for c, answer in answers if answer is Answer.ADDS]
        elif condition.is_default:
            variables.ignored_defaults.append(condition.name)
        else:
            raise contradiction(variables, condition, [c for c in chosen if c in found.behind])
    return chosen


_Any = TypeVar("_Any")


def in_order(given: Iterable[tuple[Condition, _Any]]) -> list[list[tuple[Condition, _Any]]]:
    """Conditions, each with its data, in groups that hold together, in order of precedence."""
    given_values: list[list[tuple[Condition, _Any]]] = []
    defaults: dict[str, list[tuple[Condition, _Any]]] = {}  # by element
    not_given: list[list[tuple[Condition, _Any]]] = []
    for condition, row in given:
        if condition.initial is None:
            not_given.append([(condition, row)])
        elif condition.is_default:
            defaults.setdefault(condition.name, []).append((condition, row))
        else:
            given_values.append([(condition, row)])
    return [*given_values, *defaults.values(), *not_given]


class Answer(Enum):
    """The relation of a condition to the earlier ones."""

    ADDS = "says something new"
    FOLLOWS = "follows from the others"
    CONTRADICTS = "contradicts the others"


class System:
    """Linear equations in numbers, each reduced by those before it."""

    def __init__(self) -> None:
        self._reduced: list[_Reduced] = []
        self.behind: list[Condition] = []  # the row that contradicted the others last

    def copy(self) -> System:
        """A system with the same equations that grows on its own."""
        other = System()
        other._reduced = self._reduced[:]
        return other

    def insert(self, row: list[float], condition: Condition | None = None) -> Answer:
        """Insert coefficients followed by their value, if they are independent."""
        size, value = max(map(abs, row[:-1]), default=0.0), row[-1]
        used = []
        for k, other in enumerate(self._reduced):
            factor = row[other.pivot] / other.row[other.pivot]
            if factor:
                used.append(k)
                row = [x - factor * y for x, y in zip(row, other.row, strict=True)]
        pivot = max(range(len(row) - 1), key=lambda j: abs(row[j]), default=-1)
        if pivot >= 0 and abs(row[pivot]) > NEGLIGIBLE * size:
            self._reduced.append(_Reduced(pivot, row, condition, used))
            return Answer.ADDS
        if abs(row[-1]) > NEGLIGIBLE * max(1.0, abs(value)):
            self.behind = self._conditions_of(used)
            return Answer.CONTRADICTS
        return Answer.FOLLOWS

    def _conditions_of(self, used: list[int]) -> list[Condition]:
        """The conditions that rows are made of, directly or by the rows that reduced them."""
        reached = set(used)
        for k in range(len(self._reduced) - 1, -1, -1):  # a row is reduced by earlier ones
            if k in reached:
                reached.update(self._reduced[k].used)
        found = (self._reduced[k].condition for k in sorted(reached))
        return [condition for condition in found if condition is not None]


@dataclass(frozen=True, slots=True)
class _Reduced:
    """A row with its value and pivot, its condition, and the rows that were subtracted from it."""

    pivot: int
    row: list[float]
    condition: Condition | None
    used: list[int]


def contradiction(
    variables: Variables, condition: Condition, others: Sequence[Condition]
) -> BgError:
    """The error for a value that does not agree with others, or with a source."""
    names = list(dict.fromkeys(other.name for other in others))
    assert condition.initial is not None, "what nothing was said about contradicts nothing"
    variable, span = f"{condition.initial.variable}0", condition.initial.span
    graph, initial = variables.causal.graph, condition.initial
    source = None if names else opposing_source(graph, condition.name, initial.variable)
    if source is not None:
        behind = parameters_behind(graph, initial, source)
        return BgError(
            [
                storage_messages.initial_against_source(
                    span, condition.name, variable, source.name, source.span, behind
                )
            ]
        )
    return BgError([storage_messages.initial_conflict(span, condition.name, variable, names)])


def solve_conditions(
    variables: Variables, matrix: Sequence[Row], right: Sequence[Node]
) -> list[Node] | None:
    """The unknowns of as many conditions, which are independent.

    None where a pivot varies and is not certain to differ from zero.
    """
    dag = variables.dag
    unsafe: list[Node] = []

    def note(pivot: Node, _: bool) -> None:
        if dag.level[pivot] > Level.PARAM and variables.certificate(pivot) is None:
            unsafe.append(pivot)

    try:
        values = solve_general(
            dag, variables.causal.fingerprints, matrix, right, variables.signs.rank, note
        )
    except SingularSystemError:
        raise AssertionError("conditions that were inserted one by one are dependent") from None
    return None if unsafe else values


def unusable(name: str, initial: Initial) -> BgError:
    """The error for a value of an element that its state cannot be found from."""
    variable = f"{initial.variable}0"
    return BgError([storage_messages.initial_unusable(initial.span, name, variable)])
