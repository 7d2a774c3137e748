"""The start of storage that is joined: given values hold, the rest has least energy.

Storage starts jointly where inertias are merged, where the flow of a junction is given that depends
on several of them, such as the rate of a joint, and where a free motion moves charges and momenta.
Its answers y, the independent flows of inertias and the efforts of charges, determine what is
stored:

    x = A y + d,    A = N' M N of flows and the capacity of charges, d the share of sources.

Each given value is a row of `R y = r`: an answer itself, or a row of the law for a momentum or a
charge. So are the balances on free motions, and rows that close chains by their rates, which always
hold. The energy is least where `x = R' w`:

    R A^-1 R' w = r + R A^-1 d.

Without given values nothing is stored. Zeros that are only the defaults of parts give way: first
those of elements, then those of junctions. The joints of a crane on a moving vessel therefore start
at rest, and its beams move.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from bgc.algebra.disjoint_sets import DisjointSets
from bgc.algebra.symbolic_systems import solve_definite
from bgc.equations.inertias.flows import kinetic_energy, momenta_in
from bgc.equations.storage.conditions import (
    Condition,
    Row,
    independent_conditions,
    solve_conditions,
)
from bgc.equations.storage.initial_values import GivenVariable, given_of_element
from bgc.equations.storage.kinds import IntegratedState, StorageElement, StoragePort
from bgc.equations.variables.definitions import Variables
from bgc.ir.causal import BasisKind, Role
from bgc.ir.graph import Junction, Node
from bgc.record_class import dataclass, replace


@dataclass(frozen=True, slots=True)
class Balance:
    """The balance on a free motion, over the states that it moves: `row * dH/dx + driven = 0`."""

    row: Mapping[Node, Node]
    driven: Node


@dataclass(frozen=True, slots=True)
class _Block:
    """Storage that starts together: its elements with the ports that take part, and its rows.

    An answer is known by a node: a flow by its symbol, the effort of a charge by the charge.
    """

    elements: Sequence[tuple[StorageElement, Sequence[StoragePort]]]
    flows: Sequence[int]  # indices in the basis
    answers: Sequence[Node]  # of the flows, then of charges
    junctions: Mapping[int, Condition]  # by element
    closing: Sequence[Condition]
    balances: Sequence[Condition]

    @property
    def is_linear(self) -> bool:
        """Return whether the laws are linear, and those of charges can be inverted.

        A field of which some ports answer by flows and others by efforts is neither.
        """
        return all(
            element.law.capacity is not None
            and len({port.port.role for port in element.ports}) == 1
            and (
                element.law.response is not None
                or all(port.port.role is Role.INERTIA for port in ports)
            )
            for element, ports in self.elements
        )

    @property
    def is_given(self) -> bool:
        """Return whether given values join the elements, beside laws that they share."""
        initials = [i for element, _ in self.elements for i in element.storage.initial]
        return bool(
            self.junctions
            or (self.balances and initials)
            or (self.closing and any(not initial.is_default for initial in initials))
        )


def joint_start(
    variables: Variables,
    elements: Sequence[StorageElement],
    states: Sequence[IntegratedState],
    balances: Sequence[Balance],
) -> list[IntegratedState]:
    """The states with the initial values of storage that starts jointly.

    Where a pivot may vanish, as those of rotations do, they are in terms of START symbols, which
    the runtime solves for. Elements with a law that is not linear are noted in
    `Variables.starting`; so are junctions that depend on anything but inertias and sources.

    Raises
    ------
    BgError
        A value contradicts others or a balance, or cannot be used.
    """
    dag = variables.dag
    answers = _answers_of(variables, elements, states)
    start: dict[Node, Node] = {}
    for block in _find_blocks(variables, elements, balances, answers):
        is_merged = any(port.state not in answers for _, ports in block.elements for port in ports)
        if not is_merged and not block.is_given:
            continue
        found = _stored(variables, block)
        if found is None:
            variables.starting.update(e.ports[0].port.element for e, _ in block.elements)
            variables.starting.update(block.junctions)
            continue
        stored = dict(zip(block.answers, found, strict=True))
        for symbol, (answer, entry) in answers.items():
            if answer in stored:
                start[symbol] = dag.mul(entry, stored[answer])
    return [replace(s, initial=start.get(s.symbol, s.initial)) for s in states]


# --- rows -------------------------------------------------------------------------------------


def _answers_of(
    variables: Variables, elements: Sequence[StorageElement], states: Sequence[IntegratedState]
) -> dict[Node, tuple[Node, Node]]:
    """The answer of each state by its symbol, with the entry by which the state counts."""
    ports = {port.index: port for element in elements for port in element.ports}
    found = {}
    for state in states:
        if state.flow is not None:
            found[state.symbol] = variables.independent(state.flow), variables.dag.one
        elif state.port is not None:
            (found[state.symbol],) = _row_of(variables, ports[state.port])[0].items()
    return found


def _row_of(variables: Variables, port: StoragePort) -> tuple[Row, Node]:
    """The answer of a port as a row over the answers, and the share of sources in it."""
    if port.port.role is Role.INERTIA:
        return _over_answers(variables, port.flow)
    return {port.state: variables.dag.one}, variables.dag.zero


def _over_answers(variables: Variables, flows: Mapping[int, Node]) -> tuple[Row, Node]:
    """A row over the independent flows as one over answers, and the share of other flows."""
    dag, basis = variables.dag, variables.causal.basis
    row: Row = {}
    known = dag.zero
    for k, entry in flows.items():
        if basis[k].kind is BasisKind.INERTIA:
            row[variables.independent(k)] = entry
        else:
            known = dag.add(known, dag.mul(entry, variables.independent(k)))
    return row, known


def _find_blocks(
    variables: Variables,
    elements: Sequence[StorageElement],
    balances: Sequence[Balance],
    answers: Mapping[Node, tuple[Node, Node]],
) -> list[_Block]:
    """Inertias and moved compliances in blocks that share no answer."""
    balanced = [_balanced(variables, balance, answers) for balance in balances]
    moved = {answer for condition in balanced for answer in condition.row}
    parts: list[tuple[StorageElement, list[StoragePort]]] = []
    for element in elements:
        is_moved = any(port.state in moved for port in element.ports)
        ports = [p for p in element.ports if p.port.role is Role.INERTIA or is_moved]
        if ports:
            parts.append((element, ports))
    own = [dict.fromkeys(a for p in ports for a in _row_of(variables, p)[0]) for _, ports in parts]
    number = {
        a: len(parts) + i for i, a in enumerate(dict.fromkeys(a for each in own for a in each))
    }
    junctions = _given_junctions(variables, number)
    closing = _closing_rows(variables, number)
    sets = DisjointSets(len(parts) + len(number))
    for index, each in enumerate(own):
        sets.join([index, *(number[answer] for answer in each)])
    for condition in (*junctions.values(), *closing, *balanced):
        sets.join(number[answer] for answer in condition.row)
    flows = {
        variables.independent(k): k
        for k, basis in enumerate(variables.causal.basis)
        if basis.kind is BasisKind.INERTIA
    }
    blocks = []
    for indices in sets.groups(range(len(parts))):
        found = dict.fromkeys(answer for i in indices for answer in own[i])
        shared = [answer for answer in flows if answer in found]
        blocks.append(
            _Block(
                tuple(parts[i] for i in indices),
                tuple(flows[answer] for answer in shared),
                (*shared, *(answer for answer in found if answer not in flows)),
                {k: c for k, c in junctions.items() if not found.keys().isdisjoint(c.row)},
                [c for c in closing if not found.keys().isdisjoint(c.row)],
                [c for c in balanced if not found.keys().isdisjoint(c.row)],
            )
        )
    return blocks


def _balanced(
    variables: Variables, balance: Balance, answers: Mapping[Node, tuple[Node, Node]]
) -> Condition:
    dag = variables.dag
    row = {answers[s][0]: dag.mul(answers[s][1], node) for s, node in balance.row.items()}
    return Condition(row, dag.neg(balance.driven), "", None)


def _closing_rows(variables: Variables, known: Collection[Node]) -> list[Condition]:
    """The rows that close chains by their rates alone.

    Where positions close a chain too, the runtime closes the start: its rows are not known before.
    """
    causal, dag = variables.causal, variables.dag
    found = []
    for closure in () if causal.graph.conditions else causal.closures:
        total: Row = {}
        for end in causal.rows[closure.row].ends:
            for k, entry in dict(causal.flows[causal.class_of[end.bond]]).items():
                term = dag.mul(end.coefficient, entry)
                total[k] = dag.add(total.get(k, dag.zero), term)
        row, driven = _over_answers(variables, total)
        if _is_determined(variables, total, known):
            found.append(Condition(row, dag.neg(driven), "", None))
    return found


def _given_junctions(variables: Variables, known: Collection[Node]) -> dict[int, Condition]:
    """The given junctions whose flow inertias and sources determine, by element.

    The others are noted, but for zeros that are the defaults of parts: these give way to storage
    that starts empty.
    """
    causal = variables.causal
    found = {}
    for index, element in enumerate(causal.graph.elements):
        if not isinstance(element, Junction) or element.initial is None or not element.ports:
            continue
        bond, initial = element.ports[0].bond, element.initial
        flows = dict(causal.flows[causal.class_of[bond]])
        if (element.kind == "J1") != causal.dual[bond] and _is_determined(variables, flows, known):
            row, driven = _over_answers(variables, flows)
            value = variables.dag.sub(initial.value, driven)
            found[index] = Condition(row, value, element.name, initial)
            variables.given_junctions.add(index)
        elif not initial.is_default:
            variables.starting.add(index)
    return found


def _is_determined(variables: Variables, flows: Collection[int], known: Collection[Node]) -> bool:
    """Return whether a row over the independent flows holds known answers, and sources beside."""
    basis = variables.causal.basis
    free = [k for k in flows if basis[k].kind is not BasisKind.FLOW_SOURCE]
    return bool(free) and all(variables.independent(k) in known for k in free)


def _given_rows(variables: Variables, block: _Block) -> list[Condition]:
    """The given values of the elements.

    Charges stay zero if no motion moves them and no given value depends on them.
    """
    moved = {answer for condition in block.balances for answer in condition.row}
    found: list[Condition] = []
    kept: list[Condition] = []
    for element, ports in block.elements:
        given = list(given_of_element(variables.dag, element))
        for one in given:
            if element.ports[one.initial.port] in ports:
                found.append(_given_row(variables, element, one))
        for place, port in enumerate(element.ports):
            if port.port.role is not Role.COMPLIANCE or port not in ports or port.state in moved:
                continue
            if not any(_depends_on(variables, element, one, place) for one in given):
                row, _ = _law_row(variables, element, place)
                kept.append(Condition(row, variables.dag.zero, element.storage.name, None))
    return [*found, *kept] if found else []


def _given_row(variables: Variables, element: StorageElement, one: GivenVariable) -> Condition:
    port = element.ports[one.initial.port]
    is_stored = one.node == port.state
    row, known = (
        _law_row(variables, element, one.initial.port) if is_stored else _row_of(variables, port)
    )
    return Condition(row, variables.dag.sub(one.initial.value, known), one.name, one.initial)


def _law_row(variables: Variables, element: StorageElement, place: int) -> tuple[Row, Node]:
    """Write the stored quantity of a port as a row over the answers, and the share of sources."""
    dag, capacity = variables.dag, element.law.capacity
    assert capacity is not None, "laws that are not linear start elsewhere"
    row: Row = {}
    total = dag.zero
    for other, weight in zip(element.ports, capacity[place], strict=True):
        if weight == dag.zero:
            continue
        part, known = _row_of(variables, other)
        total = dag.add(total, dag.mul(weight, known))
        for answer, entry in part.items():
            row[answer] = dag.add(row.get(answer, dag.zero), dag.mul(weight, entry))
    return row, total


def _depends_on(
    variables: Variables, element: StorageElement, one: GivenVariable, place: int
) -> bool:
    """Return whether a given value of a compliance depends on the charge of a port."""
    given, response = one.initial.port, element.law.response
    assert response is not None, "laws that cannot be inverted start elsewhere"
    if one.node == element.ports[given].state:
        return given == place
    return response[given][place] != variables.dag.zero


# --- solution ---------------------------------------------------------------------------------


def _stored(variables: Variables, block: _Block) -> list[Node] | None:
    """Find the stored quantities of the start, one an answer: momenta of flows, then charges.

    None where a law is not linear, where inertias on their own flows keep their momenta beside
    others, or where the rows cannot be evaluated before the start is known.
    """
    dag = variables.dag
    reacting = variables.balances.reacting
    if not block.is_linear or any(
        p.index in reacting for _, ports in block.elements for p in ports
    ):
        return None
    given = _given_rows(variables, block)
    own, default = [c for c in given if not c.is_default], [c for c in given if c.is_default]
    conditions = [*own, *block.junctions.values(), *default]
    always = [(c.row, c.value) for c in block.balances] if conditions else []
    closing = independent_conditions(variables, block.closing, always)
    if closing is None:
        return None
    always += [(c.row, c.value) for c in closing]
    chosen = independent_conditions(variables, conditions, always)
    if chosen is None:
        return None
    rows = [*always, *((c.row, c.value) for c in chosen)]
    if not rows:
        return [dag.zero for _ in block.answers]
    if len(rows) < len(block.answers):
        found = _of_least_energy(variables, block, rows)
    else:
        found = _determined(variables, block, rows)
    if found is not None:
        return found
    variables.start_names.extend(dict.fromkeys(c.name for c in chosen))
    return _by_equations(variables, block, rows)


def _determined(
    variables: Variables, block: _Block, rows: Sequence[tuple[Row, Node]]
) -> list[Node] | None:
    """Find the stored quantities where the rows fix all answers; None where a pivot may vanish."""
    dag = variables.dag
    if all(value == dag.zero for _, value in rows):
        return _at(variables, block, [dag.zero for _ in rows])
    place = {answer: i for i, answer in enumerate(block.answers)}
    matrix = [{place[answer]: entry for answer, entry in row.items()} for row, _ in rows]
    found = solve_conditions(variables, matrix, [value for _, value in rows])
    return None if found is None else _at(variables, block, found)


def _of_least_energy(
    variables: Variables, block: _Block, rows: Sequence[tuple[Row, Node]]
) -> list[Node] | None:
    """`R' w` with `R A^-1 R' w = r + R A^-1 d`; None where a pivot may vanish."""
    dag = variables.dag
    columns = [[row.get(answer, dag.zero) for answer in block.answers] for row, _ in rows]
    mass, driven = _reduced_mass(variables, block)
    flows = len(block.flows)
    *answers, response = solve_definite(
        dag,
        variables.causal.fingerprints,
        mass,
        [*(column[:flows] for column in columns), driven],
    )
    for column, answer in zip(columns, answers, strict=True):
        answer += _efforts(variables, block, column[flows:])
    matrix = [
        {j: dag.dot(column, answer) for j, answer in enumerate(answers)} for column in columns
    ]
    values = [
        dag.add(value, dag.dot(column[:flows], response))
        for (_, value), column in zip(rows, columns, strict=True)
    ]
    if all(value == dag.zero for value in values):
        return [dag.zero for _ in block.answers]
    weights = solve_conditions(variables, matrix, values)
    if weights is None:
        return None
    return [dag.dot(weights, entries) for entries in zip(*columns, strict=True)]


def _by_equations(
    variables: Variables, block: _Block, rows: Sequence[tuple[Row, Node]]
) -> list[Node]:
    """Write the stored quantities with unknowns of the start: answers y and multipliers w.

    Their equations are `R y = r` and, where these leave answers open, `x(y) = R' w`.
    """
    dag, size = variables.dag, len(block.answers)
    more = len(rows) if len(rows) < size else 0
    unknowns = variables.new_start_unknowns(size + more)
    y = dict(zip(block.answers, unknowns, strict=False))
    stored = _at(variables, block, unknowns[:size])
    for row, value in rows:
        total = dag.sum(dag.mul(entry, y[answer]) for answer, entry in row.items())
        variables.start_rows.append(dag.sub(total, value))
    for answer, quantity in zip(block.answers if more else (), stored, strict=False):
        pairs = zip(rows, unknowns[size:], strict=True)
        force = dag.sum(dag.mul(row[answer], w) for (row, _), w in pairs if answer in row)
        variables.start_rows.append(dag.sub(quantity, force))
    return stored


def _at(variables: Variables, block: _Block, answers: Sequence[Node]) -> list[Node]:
    """The stored quantities at the answers y: `A y + d`."""
    dag, flows = variables.dag, dict(zip(block.flows, answers, strict=False))
    energy = kinetic_energy(variables, [element for element, _ in block.elements], block.flows)
    momenta = momenta_in(variables, energy, flows)
    y = dict(zip(block.answers, answers, strict=True))
    charges = []
    for element, ports in block.elements:
        for place, port in enumerate(element.ports):
            if port in ports and port.state in y:
                row, _ = _law_row(variables, element, place)
                charges.append(dag.sum(dag.mul(x, y[answer]) for answer, x in row.items()))
    return [*momenta.values(), *charges]


def _efforts(variables: Variables, block: _Block, charges: Sequence[Node]) -> list[Node]:
    """The efforts of charges."""
    dag, x = variables.dag, dict(zip(block.answers[len(block.flows) :], charges, strict=True))
    efforts = []
    for element, ports in block.elements:
        for place, port in enumerate(element.ports):
            if port in ports and port.state in x:
                response = element.law.response
                assert response is not None, "laws that cannot be inverted start elsewhere"
                pairs = zip(response[place], element.ports, strict=True)
                efforts.append(dag.sum(dag.mul(k, x[other.state]) for k, other in pairs))
    return efforts


def _reduced_mass(variables: Variables, block: _Block) -> tuple[list[Row], list[Node]]:
    """`N' M N` of the flows, and `N' M N_s s` of the sources that drive the elements."""
    dag = variables.dag
    place = {variables.independent(k): i for i, k in enumerate(block.flows)}
    mass: list[Row] = [{} for _ in place]
    driven = [dag.zero] * len(place)
    for element, _ in block.elements:
        for position, port in enumerate(element.ports):
            if port.port.role is not Role.INERTIA:
                continue
            stored, share = _law_row(variables, element, position)
            for answer, left in _row_of(variables, port)[0].items():
                i = place[answer]
                driven[i] = dag.add(driven[i], dag.mul(left, share))
                for other, entry in stored.items():
                    j = place[other]
                    mass[i][j] = dag.add(mass[i].get(j, dag.zero), dag.mul(left, entry))
    return mass, driven
