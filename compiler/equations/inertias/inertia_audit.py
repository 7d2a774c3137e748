"""Numerical checks of merged inertias at a random point, on every compile.

The reduced mass `M_r = N' M N` has to be positive definite; a model for which it is not is refused.
The emitted flows have to solve `M_r u = pi`, and the forces of varying moduli have to do exactly
the work that the change of `N` requires, so that no energy is created. These two are properties of
the compiler, and a failure is a bug in bgc.
"""

from __future__ import annotations

import math
import random
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import Evaluator
from bgc.causality.assign import may_be_opened
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.inertias.flows import flow_definitions
from bgc.equations.inertias.groups import Group, inertias_of
from bgc.equations.storage.kinds import StorageElement, StoragePort
from bgc.equations.variables.definitions import Rate, Variables
from bgc.ir.causal import BasisKind
from bgc.ir.graph import Node

_LEAST_EIGENVALUE = 1e-9  # eigenvalue of the reduced mass scaled to a diagonal of ones
_ROUNDING = 1e-13  # the same without masses
_NO_MASS = 1e-24  # of the largest: less is what coefficients of rounded data leave over, squared
_NO_MASS_IN_A_CHAIN = 1e-12  # the same where a closed chain can be opened, and moves them then
_STILL = 1e-6  # of the fastest flow: slower ones are zero up to rounding
_TAKING_PART = 1e-3  # of the fastest
_FLOW_TOLERANCE = (
    1e-6  # relative; far above rounding and difference errors, far below the effect of a wrong sign
)
_SHIFT = 1e-5  # of the point, for differences
_ROUNDED = 1e-15  # of a flow


@dataclass(frozen=True, slots=True)
class MergedGroup:
    """A group of inertias with linear laws: independent flow -> its momentum, and its flow."""

    group: Group
    momenta: Mapping[int, Node]
    flows: Mapping[int, Node]


class MergedAudit:
    """The checks of all groups of a graph; skipped where a function has no value."""

    def __init__(self, variables: Variables) -> None:
        self._variables = variables
        self._point = _Point(variables)
        self._groups: list[MergedGroup] = []
        self._flows: dict[int, float] = {}  # of the basis

    def require_definite(self, group: Group) -> None:
        """Refuse a group of linear laws whose reduced mass is (nearly) singular.

        Raises
        ------
        BgError
            Names what can move without inertia.
        """
        mass = self._moved_by_all(group, _LEAST_EIGENVALUE)
        if mass is None:
            return
        for i, k in enumerate(group.flows):
            speed = random.Random(f"flow {k}").uniform(0.3, 1)
            self._flows[k] = speed / mass[i][i] ** 0.5

    def require_held(self, group: Group) -> None:
        """Refuse a group with a motion that moves no inertia, whatever the laws.

        Raises
        ------
        BgError
            Names the inertias beside the motion.
        """
        self._moved_by_all(group, _ROUNDING)

    def _moved_by_all(self, group: Group, least: float) -> list[list[float]] | None:
        """The reduced mass if every motion moves some of it; None where that is unknown."""
        mass = _reduced_mass(self._point, group)
        if not all(math.isfinite(entry) for row in mass for entry in row):
            return None
        if any(0 < row[i] < sys.float_info.min for i, row in enumerate(mass)):
            return None  # too few digits to judge
        may_be_rounding = may_be_opened(self._variables.causal)
        rounding = _NO_MASS_IN_A_CHAIN if may_be_rounding else _NO_MASS
        motion = motion_without_inertia(mass, least, rounding)
        if motion is not None:
            raise _moving_without_inertia(self._point, group, motion)
        return mass

    def note(self, merged: MergedGroup) -> None:
        """Register the definitions of a group, to be checked by `finish`."""
        self._groups.append(merged)

    def finish(self, *, complete: bool) -> None:
        """Assert the properties; `complete` is true where all laws were linear."""
        if any(k not in self._flows for merged in self._groups for k in merged.momenta):
            return
        for k, independent in enumerate(self._variables.causal.basis):
            if independent.kind is BasisKind.FLOW_SOURCE:
                self._flows[k] = self._point.value(self._variables.independent(k))
        self._assert_solved()
        ports = [port for merged in self._groups for port in merged.group.ports]
        # otherwise forces of an energy that varies with charges are among the turning ones
        constant = complete and all(port.bias == self._variables.dag.zero for port in ports)
        if constant and not self._turned_by_themselves(ports):
            self._assert_powerless()

    def _turned_by_themselves(self, ports: Sequence[StoragePort]) -> bool:
        """Return whether a modulus reads a momentum that it merges, or a variable of a bond.

        The random point, which chooses moduli before momenta, does not hold for such.
        """
        dag = self._variables.dag
        moduli = (x for d in flow_definitions(self._variables).values() for x in d.row.values())
        leaves = {node for node in dag.reachable(moduli) if dag.symbol_of(node) is not None}
        kinds = {symbol.kind for symbol in map(dag.symbol_of, leaves) if symbol is not None}
        own = {port.state for port in ports}
        return not leaves.isdisjoint(own) or not kinds.isdisjoint({Kind.EFFORT, Kind.FLOW})

    def _assert_solved(self) -> None:
        """The independent flows follow from the momenta that they have."""
        variables, point = self._variables, self._point
        basis = variables.causal.basis
        classes = point.flows(self._flows)
        known = {variables.symbols.of_class(number): flow for number, flow in classes.items()}
        totals: dict[int, float] = {}
        for merged in self._groups:
            for port, momentum in _momenta(point, merged.group.elements, classes):
                for k, x in point.row_of(port).items():
                    totals[k] = totals.get(k, 0.0) + x * momentum
            known |= {node: totals[k] for k, node in merged.momenta.items()}
        point.set_known(known)
        for merged in self._groups:
            for k, node in merged.flows.items():
                flow = classes[basis[k].bond_class]
                error = abs(point.value(node) / flow - 1)
                assert not error > _FLOW_TOLERANCE, (
                    f"a flow of merged inertias is off by {error:.1e}"
                )

    def _assert_powerless(self) -> None:
        """The forces of turning moduli take the power that turning moduli give the flows."""
        point = self._point
        before, after = (_Point(self._variables, shift) for shift in (-_SHIFT, _SHIFT))
        now, first, last = (p.flows(self._flows) for p in (point, before, after))
        class_of = self._variables.causal.class_of
        powers, rounding = [], 0.0  # a difference of flows is exact to the rounding of the flows
        for merged in self._groups:
            for port, momentum in _momenta(point, merged.group.elements, now):
                point.set_known({port.state: momentum})
                number, sign = class_of[port.port.bond], port.port.through_sign
                rise = (last[number] - first[number]) / (2 * _SHIFT)
                powers.append(momentum * sign * rise)
                rounding += _ROUNDED * abs(momentum * now[number]) / _SHIFT
        point.set_around(before, after)
        for number, force in self._variables.balances.turning.items():
            powers.append(point.value(force) * now[number])
        defect, size = abs(sum(powers)), sum(map(abs, powers))
        bound = _FLOW_TOLERANCE * size + rounding
        assert not defect > bound, f"turning moduli give the power {defect / size:.1e}"


class _Point:
    """Numbers at a random state; `shift` moves it along a random direction."""

    def __init__(self, variables: Variables, shift: float = 0.0) -> None:
        self.variables = variables
        self._shift = shift
        self._around: tuple[_Point, _Point] | None = None
        self._known: dict[Node, float] = {}
        self._numbers = Evaluator(variables.dag, self._leaf)
        self._rows = self._flow_rows()

    def value(self, node: Node) -> float:
        """The value of a raw node."""
        return self._numbers.value(node)

    def set_known(self, values: Mapping[Node, float]) -> None:
        """Set the values of flows and momenta."""
        self._known.update(values)

    def set_around(self, before: _Point, after: _Point) -> None:
        """Set the two points between which rates are differences."""
        self._around = before, after

    def row_of(self, port: StoragePort) -> dict[int, float]:
        """A port's row of N in the element's sense."""
        number = self.variables.causal.class_of[port.port.bond]
        return {k: port.port.through_sign * x for k, x in self._rows[number].items()}

    def flows(self, independent: Mapping[int, float]) -> dict[int, float]:
        """The flows of all classes; those not given are zero."""
        return {
            number: sum(entry * independent.get(k, 0.0) for k, entry in row.items())
            for number, row in self._rows.items()
        }

    def _flow_rows(self) -> dict[int, dict[int, float]]:
        """Rows of N, as numbers, from the definitions; of classes that stand still empty."""
        basis = self.variables.causal.basis
        rows = {independent.bond_class: {k: 1.0} for k, independent in enumerate(basis)}
        for definition in reversed(flow_definitions(self.variables).values()):
            row: dict[int, float] = {}
            for number, node in definition.row.items():
                entry = self.value(node)
                for k, x in rows[number].items():
                    row[k] = row.get(k, 0.0) + entry * x
            rows[definition.variable] = row
        return rows

    def _leaf(self, symbol: Symbol) -> float:
        node = self.variables.dag.symbol(symbol.kind, symbol.index)
        if node in self._known:
            return self._known[node]
        if symbol.kind is Kind.PARAM:
            return self.variables.default(node)
        rate = self.variables.definitions.get(node)
        if self._around is not None and isinstance(rate, Rate):
            before, after = (point.value(rate.of) for point in self._around)
            return (after - before) / (2 * _SHIFT)
        rng = random.Random(f"{symbol.kind} {symbol.index}")
        return rng.uniform(0.2, 1) + self._shift * rng.uniform(-1, 1)


def _entries(
    point: _Point, element: StorageElement
) -> Iterator[tuple[StoragePort, StoragePort, float]]:
    """The nonzero entries of an element's inertia matrix; the identity for a nonlinear law."""
    capacity = element.law.capacity
    if capacity is None:
        yield from ((port, port, 1.0) for port in inertias_of(element))
        return
    for port, other in product(inertias_of(element), repeat=2):
        entry = point.value(capacity[port.port.position][other.port.position])
        if entry:
            yield port, other, entry


def _momenta(
    point: _Point, elements: Sequence[StorageElement], classes: Mapping[int, float]
) -> Iterator[tuple[StoragePort, float]]:
    """The inertias of elements with their momenta, given the flows of classes."""
    class_of = point.variables.causal.class_of
    for element in elements:
        totals = {port.index: 0.0 for port in inertias_of(element)}
        for port, other, entry in _entries(point, element):
            flow = other.port.through_sign * classes[class_of[other.port.bond]]
            totals[port.index] += entry * flow
        yield from ((port, totals[port.index]) for port in inertias_of(element))


def _reduced_mass(point: _Point, group: Group) -> list[list[float]]:
    """`N' M N`."""
    order = {k: i for i, k in enumerate(group.flows)}
    mass = [[0.0] * len(order) for _ in order]
    for element in group.elements:
        for port, other, entry in _entries(point, element):
            columns = [(order[m], y) for m, y in point.row_of(other).items() if m in order]
            for k, x in point.row_of(port).items():
                if k in order:
                    line = mass[order[k]]
                    for j, y in columns:
                        line[j] += entry * x * y
    return mass


def motion_without_inertia(
    mass: Sequence[Sequence[float]], least: float, rounding: float
) -> list[float] | None:
    """A motion along which a mass matrix, scaled to a unit diagonal, has at most the value `least`.

    So has one whose own mass is `rounding` of the largest. None where all eigenvalues are larger,
    which a Cholesky factorisation of the scaled matrix minus `least` times the identity proves.
    Where the factorisation breaks down, the rows up to there give the motion.
    """
    largest = max((row[i] for i, row in enumerate(mass)), default=0.0)
    least_mass = rounding * largest
    scale = [row[i] ** 0.5 if row[i] > least_mass else 0.0 for i, row in enumerate(mass)]
    factors: list[list[float]] = []
    for i, row in enumerate(mass):
        if scale[i] == 0:
            return [float(j == i) for j in range(len(mass))]
        line: list[float] = []
        for j in range(i):
            known = sum(x * y for x, y in zip(line, factors[j], strict=False))
            line.append((row[j] / (scale[i] * scale[j]) - known) / factors[j][j])
        pivot = 1 - least - sum(x * x for x in line)
        if not pivot > 0:
            for j in reversed(range(i)):
                line[j] /= factors[j][j]
                for m in range(j):
                    line[m] -= factors[j][m] * line[j]
            scaled = [*(-x for x in line), 1.0]
            found = [x / s for x, s in zip(scaled, scale, strict=False)]
            return found + [0.0] * (len(mass) - len(found))
        factors.append([*line, pivot**0.5])
    return None


def _moving_without_inertia(point: _Point, group: Group, motion: Sequence[float]) -> BgError:
    """The error that names the elements that take part in a motion; if none does, its bonds."""
    speed_of = dict(zip(group.flows, motion, strict=True))
    speeds = [
        max(
            abs(sum(x * speed_of.get(k, 0.0) for k, x in point.row_of(port).items()))
            for port in inertias_of(element)
        )
        for element in group.elements
    ]
    if max(speeds) < _STILL * max(map(abs, motion)):
        causal = point.variables.causal
        classes = [
            causal.classes[causal.basis[k].bond_class]
            for k, speed in speed_of.items()
            if abs(speed) > _TAKING_PART * max(map(abs, motion))
        ]
        bonds = [causal.graph.bonds[members.bonds[0]] for members in classes]
        names = [bond.name for bond in bonds]
        return BgError([storage_messages.motion_without_inertia(bonds[0].span, names)])
    moving = [
        element.storage
        for element, speed in zip(group.elements, speeds, strict=True)
        if speed > _TAKING_PART * max(speeds)
    ]
    names = [storage.name for storage in moving]
    return BgError([storage_messages.motion_without_inertia(moving[0].span, names)])
