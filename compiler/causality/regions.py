"""The junction structure of a flat graph as linear rows in its through variables.

Regions between gyrators are found and dualised, bonds are united into classes, and junctions,
transformers and gyrators give the rows that `elimination` solves.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator, Sequence
from typing import TypeAlias, assert_never

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.disjoint_sets import DisjointSets, groups_sharing
from bgc.algebra.linalg import connected_blocks, transpose
from bgc.ir.causal import BondClass, ElementPort, Role, Row, RowEnd
from bgc.ir.graph import (
    Element,
    EnergyLaw,
    FlatGraph,
    Gyrator,
    Gyristor,
    Junction,
    LinearLaw,
    Matrix,
    Port,
    Resistor,
    Source,
    Storage,
    Transformer,
    ports_of,
)
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Block:
    """Rows `upper - matrix * lower = 0` of a transformer, or of a gyrator between two colours.

    `rows` are the indices of the rows, `upper` and `lower` the bonds, `inverse` the inverse of the
    whole matrix if it is known. `varies` if a matrix of several rows depends on more than
    parameters. `spreads` if the transformer has more upper bonds than lower ones.
    """

    rows: tuple[int, ...]
    upper: tuple[int, ...]
    lower: tuple[int, ...]
    matrix: Matrix
    inverse: Matrix | None
    varies: bool
    spreads: bool


@dataclass(frozen=True, slots=True)
class Structure:
    """The constraints that junctions, transformers and gyrators put on the through variables."""

    dual: tuple[bool, ...]
    ports: tuple[ElementPort, ...]
    classes: tuple[BondClass, ...]
    class_of: tuple[int, ...]
    rows: tuple[Row, ...]
    blocks: tuple[Block, ...]
    read: frozenset[int]  # classes whose flow, or what is stored by it, a modulus reads
    bond_loops: tuple[int, ...]  # bonds that close a loop of junctions; across is indeterminate
    closing: tuple[Row, ...]  # of cut junctions; elimination leaves them out


def junction_structure(graph: FlatGraph, cut: frozenset[int] = frozenset()) -> Structure:
    """Find regions, dualise them, unite bonds into classes, and write the rows.

    Guarantees that a gyrator between regions of different colour gives rows like a transformer, and
    that one between regions of equal colour (in an odd loop of gyrators) is a pair of resistive
    ports. The bonds of a junction in `cut` that share a through variable keep one each, with
    `closing` rows that set them equal.
    """
    dual = _dualised(graph)
    class_of, bond_loops = _classes(graph, dual, cut)
    rows: list[Row] = []
    closing: list[Row] = []
    blocks: list[Block] = []
    ports: list[ElementPort] = []
    for index, element in enumerate(graph.elements):
        match element:
            case Junction():
                if sums_through(element, dual):
                    one = graph.dag.one
                    signed = {1: one, -1: graph.dag.const(-1)}
                    ends = tuple(RowEnd(p.bond, p.sign, signed[p.sign]) for p in element.ports)
                    rows.append(Row(index, ends))
                elif index in cut:
                    closing.extend(_equal_rows(graph.dag, index, element.ports))
            case Transformer() | Gyrator():
                if isinstance(element, Gyrator):
                    parts, resistive = _gyrator_parts(graph.dag, index, element, dual)
                    ports.extend(resistive)
                else:
                    parts = _transformer_parts(graph.dag, element, dual)
                excess = sum(len(upper) - len(lower) for upper, lower, _, _ in parts)
                for upper, lower, matrix, inverse in parts:
                    block = Block(
                        rows=tuple(range(len(rows), len(rows) + len(upper))),
                        upper=tuple(port.bond for port in upper),
                        lower=tuple(port.bond for port in lower),
                        matrix=matrix,
                        inverse=inverse,
                        varies=_varies(graph.dag, matrix),
                        spreads=excess > 0,
                    )
                    blocks.append(block)
                    rows.extend(_linear_rows(graph.dag, index, upper, lower, matrix))
            case _:
                ports.extend(
                    ElementPort(index, k, p.bond, p.sign, dual[p.bond], role)
                    for k, p, role in roles_of(graph.dag, element, dual)
                )
    return Structure(
        dual=dual,
        ports=tuple(ports),
        classes=_members(class_of, ports),
        class_of=class_of,
        rows=tuple(rows),
        blocks=tuple(blocks),
        read=_read_by_moduli(graph, dual, class_of),
        bond_loops=bond_loops,
        closing=tuple(closing),
    )


# --- regions and colours --------------------------------------------------------------------


def _dualised(graph: FlatGraph) -> tuple[bool, ...]:
    """Colour the regions in two colours across gyrators; dualise the smaller part of each piece."""
    sets = DisjointSets(len(graph.bonds))
    crossings: list[tuple[int, int]] = []
    for element in graph.elements:
        if isinstance(element, Gyrator):
            for side2, side1 in connected_blocks(graph.dag, element.matrix):
                first = [element.ports1[j].bond for j in side1]
                second = [element.ports2[i].bond for i in side2]
                sets.join(first)
                sets.join(second)
                if first and second:
                    crossings.append((first[0], second[0]))
        else:
            for group in _coupled_ports(graph.dag, element):
                sets.join(p.bond for p in group)
    neighbours: dict[int, list[int]] = {}
    for a, b in crossings:
        neighbours.setdefault(sets.find(a), []).append(sets.find(b))
        neighbours.setdefault(sets.find(b), []).append(sets.find(a))
    size: dict[int, int] = {}
    for bond in range(len(graph.bonds)):
        size[sets.find(bond)] = size.get(sets.find(bond), 0) + 1
    colour: dict[int, bool] = {}
    for start in size:
        if start in colour:
            continue
        colour[start] = False
        piece, queue = [start], deque([start])
        while queue:
            region = queue.popleft()
            for other in neighbours.get(region, ()):
                if other not in colour:
                    colour[other] = not colour[region]
                    piece.append(other)
                    queue.append(other)
        if 2 * sum(size[r] for r in piece if colour[r]) > sum(size[r] for r in piece):
            colour.update({r: not colour[r] for r in piece})
    return tuple(colour[sets.find(bond)] for bond in range(len(graph.bonds)))


def _coupled_ports(dag: Dag, element: Element) -> list[list[Port]]:
    """The ports of an element in groups that its law does not couple."""
    match element:
        case Transformer():
            over, under = element.ports2, element.ports1
            if element.given in ("f1", "e2"):
                over, under = under, over
            return [
                [over[i] for i in rows] + [under[j] for j in columns]
                for rows, columns in connected_blocks(dag, element.matrix)
            ]
        case Storage(law=LinearLaw(matrix=matrix)) | Resistor(law=LinearLaw(matrix=matrix)):
            held = [
                {i, *(j for j, node in enumerate(row) if node != dag.zero)}
                for i, row in enumerate(matrix)
            ]
            return [[element.ports[k] for k in group] for group in groups_sharing(held)]
        case _:
            return [list(ports_of(element))]


# --- classes --------------------------------------------------------------------------------


def sums_through(junction: Junction, dual: Sequence[bool]) -> bool:
    """Test whether a junction sums the through variables of its bonds; otherwise they are equal."""
    return bool(junction.ports) and (junction.kind == "J0") != dual[junction.ports[0].bond]


def _classes(
    graph: FlatGraph, dual: Sequence[bool], cut: Collection[int]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    sets = DisjointSets(len(graph.bonds))
    closing: list[int] = []
    for index, element in enumerate(graph.elements):
        if isinstance(element, Junction) and not sums_through(element, dual) and index not in cut:
            first, *others = (p.bond for p in element.ports)
            closing.extend(bond for bond in others if not sets.unite(first, bond))
    numbers: dict[int, int] = {}
    class_of = tuple(
        numbers.setdefault(sets.find(bond), len(numbers)) for bond in range(len(graph.bonds))
    )
    return class_of, tuple(closing)


def _read_by_moduli(
    graph: FlatGraph, dual: Sequence[bool], class_of: Sequence[int]
) -> frozenset[int]:
    """The classes whose through variable a modulus reads, or the state of a storage port there."""
    moduli = [e for e in graph.elements if isinstance(e, Transformer | Gyrator)]
    nodes = [node for element in moduli for row in element.matrix for node in row]
    kinds = (Kind.FLOW, Kind.EFFORT, Kind.MOMENTUM, Kind.DISPLACEMENT)
    symbols = graph.dag.symbols_in(nodes, *kinds).values()
    through = [
        s.index for s in symbols if s.kind in kinds[:2] and (s.kind is Kind.EFFORT) == dual[s.index]
    ]
    states = {s.index for s in symbols if s.kind in kinds[2:]}
    storage = [e for e in graph.elements if isinstance(e, Storage)] if states else []
    through += [
        port.bond for e in storage for k, port in enumerate(e.ports, e.first_state) if k in states
    ]
    return frozenset(class_of[bond] for bond in through)


def _members(class_of: Sequence[int], ports: Sequence[ElementPort]) -> tuple[BondClass, ...]:
    bonds: list[list[int]] = [[] for _ in range(max(class_of, default=-1) + 1)]
    members: list[list[int]] = [[] for _ in bonds]
    for bond, number in enumerate(class_of):
        bonds[number].append(bond)
    for k, port in enumerate(ports):
        members[class_of[port.bond]].append(k)
    return tuple(BondClass(tuple(b), tuple(p)) for b, p in zip(bonds, members, strict=True))


def roles_of(dag: Dag, element: Element, dual: Sequence[bool]) -> list[tuple[int, Port, Role]]:
    """The position, the port and the role of each port of an element; none of a junction."""
    match element:
        case Source(follows=True):
            return [(0, element.port, Role.RESISTANCE)]
        case Source():
            gives_through = (element.kind == "Sf") != dual[element.port.bond]
            return [(0, element.port, Role.FLOW_SOURCE if gives_through else Role.EFFORT_SOURCE)]
        case Storage():
            momenta = _ports_with_momentum(dag, element)
            return [
                (k, p, Role.INERTIA if (k in momenta) != dual[p.bond] else Role.COMPLIANCE)
                for k, p in enumerate(element.ports)
            ]
        case Resistor() | Gyristor():
            return [(k, p, Role.RESISTANCE) for k, p in enumerate(element.ports)]
        case Junction() | Transformer() | Gyrator():
            return []
        case _:
            assert_never(element)


def _ports_with_momentum(dag: Dag, storage: Storage) -> set[int]:
    """All ports of an I, none of a C, and those of an IC whose momentum is in its energy."""
    if storage.kind == "C":
        return set()
    if storage.kind == "I" or not isinstance(storage.law, EnergyLaw):
        return set(range(len(storage.ports)))
    held = {s.index for s in dag.symbols_in([storage.law.energy], Kind.MOMENTUM).values()}
    return {k for k in range(len(storage.ports)) if storage.first_state + k in held}


# --- rows -----------------------------------------------------------------------------------


def _equal_rows(dag: Dag, index: int, ports: Sequence[Port]) -> Iterator[Row]:
    """`through(first) - through(other) = 0` for the ports of a junction."""
    first, *others = ports
    for other in others:
        ends = (
            RowEnd(first.bond, first.sign, dag.one),
            RowEnd(other.bond, other.sign, dag.const(-1)),
        )
        yield Row(index, ends)


def _linear_rows(
    dag: Dag, index: int, over: Sequence[Port], under: Sequence[Port], matrix: Matrix
) -> tuple[Row, ...]:
    """`through(over) - matrix * through(under) = 0`."""
    return tuple(
        Row(
            index,
            (
                RowEnd(port.bond, port.sign, dag.one),
                *(
                    RowEnd(other.bond, other.sign, dag.neg(entry))
                    for other, entry in zip(under, line, strict=True)
                    if entry != dag.zero
                ),
            ),
        )
        for port, line in zip(over, matrix, strict=True)
    )


_Part: TypeAlias = tuple[list[Port], list[Port], Matrix, Matrix | None]
"""Upper ports, lower ports, the matrix that gives upper through variables, its known inverse."""


def _transformer_parts(dag: Dag, tf: Transformer, dual: Sequence[bool]) -> list[_Part]:
    """The independent blocks of a transformer."""
    over, under = tf.ports2, tf.ports1
    if tf.given in ("f1", "e2"):
        over, under = under, over
    found: list[_Part] = []
    for rows, columns in connected_blocks(dag, tf.matrix):
        matrix = tuple(tuple(tf.matrix[i][j] for j in columns) for i in rows)
        upper, lower = [over[i] for i in rows], [under[j] for j in columns]
        whole = len(rows) == len(tf.matrix) and len(columns) == len(tf.matrix[0])
        inverse = tf.inverse if whole else None
        if dual[(upper + lower)[0].bond]:
            upper, lower = lower, upper
            matrix = _transposed(matrix, len(columns))
            inverse = transpose(inverse) if inverse else None
        found.append((upper, lower, matrix, inverse))
    return found


def _varies(dag: Dag, matrix: Matrix) -> bool:
    """Test whether a matrix of several rows depends on more than parameters."""
    return len(matrix) > 1 and any(dag.level[x] > Level.PARAM for row in matrix for x in row)


def _transposed(matrix: Matrix, width: int) -> Matrix:
    """The transpose, also for a matrix without rows."""
    return transpose(matrix) if matrix else ((),) * width


def _gyrator_parts(
    dag: Dag, index: int, gyrator: Gyrator, dual: Sequence[bool]
) -> tuple[list[_Part], list[ElementPort]]:
    """The independent blocks that join two colours, and the resistive ports of the others."""
    parts: list[_Part] = []
    resistive: list[ElementPort] = []
    first, second = gyrator.ports1, gyrator.ports2
    for rows, columns in connected_blocks(dag, gyrator.matrix):
        matrix = tuple(tuple(gyrator.matrix[i][j] for j in columns) for i in rows)
        side1, side2 = [first[j] for j in columns], [second[i] for i in rows]
        dual1 = dual[side1[0].bond] if side1 else not dual[side2[0].bond]
        dual2 = dual[side2[0].bond] if side2 else not dual1
        if dual1 == dual2:
            places = [*columns, *(len(first) + i for i in rows)]
            resistive += (
                ElementPort(index, k, p.bond, p.sign, dual1, Role.RESISTANCE)
                for k, p in zip(places, (*side1, *side2), strict=True)
            )
        elif dual2:  # e2 = r f1
            parts.append((side2, side1, matrix, None))
        else:  # e1 = r' f2
            parts.append((side1, side2, _transposed(matrix, len(columns)), None))
    return parts, resistive
