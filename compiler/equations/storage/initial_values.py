"""Initial values of storage: given charges, momenta, efforts or flows, turned into states."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.symbolic_systems import SingularSystemError, solve_general
from bgc.diagnostics.catalogue import causality as catalogue
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.equations.storage.conditions import unusable
from bgc.equations.storage.kinds import StorageElement
from bgc.equations.variables.definitions import Variables
from bgc.ir.graph import Initial, Node
from bgc.record_class import dataclass

Given = dict[tuple[int, str], Initial]  # (port, variable) -> what the user gave


def given_values(element: StorageElement) -> Given:
    """The given values of an element by port and variable; refuses two that fix each other."""
    found: Given = {}
    for initial in element.storage.initial:
        port = element.ports[initial.port]
        pair = ("p", "f") if port.has_momentum else ("q", "e")
        others = [v for v in pair if v != initial.variable and initial.variable in pair]
        for variable in (initial.variable, *others):
            if (initial.port, variable) in found:
                raise BgError(
                    [
                        storage_messages.initial_twice(
                            initial.span, element.storage.name, f"{variable}0",
                            f"{initial.variable}0",
                        )
                    ]
                )  # fmt: skip
        found[initial.port, initial.variable] = initial
    return found


@dataclass(frozen=True, slots=True)
class GivenVariable:
    """A variable that has an initial value: a node of raw symbols."""

    name: str  # of its element
    initial: Initial
    node: Node


def given_of_element(dag: Dag, element: StorageElement) -> Iterator[GivenVariable]:
    """The variables of a storage element that have initial values and impose something.

    Raises
    ------
    BgError
        BG515: no state of the element follows from the variable.
    """
    for (position, variable), initial in given_values(element).items():
        port = element.ports[position]
        state, answer = ("p", "f") if port.has_momentum else ("q", "e")
        if variable == "q" and port.has_momentum:
            continue  # the charge of an IC beside its momentum starts by itself
        if variable == "p" and not port.has_momentum and initial.value == dag.zero:
            continue  # imposes nothing on a port without momentum
        if variable not in {state, answer}:
            raise unusable(element.storage.name, initial)
        node = port.state if variable == state else port.answer
        yield GivenVariable(element.storage.name, initial, node)


def own_initial_states(variables: Variables, element: StorageElement) -> list[Node]:
    """The initial charge or momentum of every port of an independent element.

    Values not given are zero. A given effort or flow is converted by the law; where that is not
    possible before the parameters are known, the element is noted in `Variables.starting`.
    """
    dag = variables.dag
    given = given_values(element)
    values: dict[int, Node] = {}
    answers: dict[int, Initial] = {}
    for position, port in enumerate(element.ports):
        state, answer = ("p", "f") if port.has_momentum else ("q", "e")
        if (position, answer) in given:
            answers[position] = given[position, answer]
        else:
            start = given.get((position, state))
            values[position] = start.value if start is not None else dag.zero
    if answers:
        values |= _from_answers(variables, element, values, answers)
    return [values[position] for position in range(len(element.ports))]


def _from_answers(
    variables: Variables,
    element: StorageElement,
    values: Mapping[int, Node],
    answers: Mapping[int, Initial],
) -> dict[int, Node]:
    """The states of the ports whose effort or flow is given."""
    dag, law = variables.dag, element.law
    if law.capacity is not None and all(
        any(entry != dag.zero for entry in law.capacity[k])
        and all(m in answers for m, entry in enumerate(law.capacity[k]) if entry != dag.zero)
        for k in answers
    ):
        return {
            k: dag.sum(dag.mul(law.capacity[k][m], answers[m].value) for m in answers)
            for k in answers
        }
    if law.response is None:
        variables.starting.add(element.ports[0].port.element)
        return dict.fromkeys(answers, dag.zero)
    order = {k: i for i, k in enumerate(answers)}
    response = law.response
    matrix = [{order[m]: response[k][m] for m in answers} for k in answers]
    right = [
        dag.sub(
            answers[k].value,
            dag.sum(dag.mul(response[k][m], value) for m, value in values.items()),
        )
        for k in answers
    ]
    try:
        solution = solve_general(
            dag, variables.causal.fingerprints, matrix, right, variables.signs.rank
        )
    except SingularSystemError:
        raise unusable(element.storage.name, next(iter(answers.values()))) from None
    return {k: solution[i] for k, i in order.items()}


def closed_initials(
    dag: Dag, initials: Sequence[Node], places: Sequence[tuple[str, Span | None]]
) -> list[Node]:
    """Replace each state in an initial value by that state's own initial value.

    Raises
    ------
    BgError
        Initial values depend on each other cyclically.
    """
    needs = [
        sorted(symbol.index for symbol in dag.symbols_in([node], Kind.STATE).values())
        for node in initials
    ]
    closed: dict[int, Node] = {}
    for start in range(len(initials)):
        stack, entered = [start], set[int]()
        while stack:
            k = stack[-1]
            missing = [n for n in needs[k] if n not in closed]
            if k in closed:
                stack.pop()
            elif not missing:
                replaced = {dag.symbol(Kind.STATE, n): closed[n] for n in needs[k]}
                (closed[k],) = dag.substitute([initials[k]], replaced)
                stack.pop()
            elif k in entered:
                name, span = places[k]
                raise BgError([catalogue.invalid_initial(span, name)])
            else:
                entered.add(k)
                stack.extend(missing)
    return [closed[k] for k in range(len(initials))]
