"""Numerical checks of merged inertias at a random point, on every compile.

The reduced mass `M_r = N' M N` has to be positive definite; a model for which it is not is refused.
The flows that elimination gives have to solve `M_r u = pi`; those of a group that do not are left
to the implicit equations `pi = N' p`. The forces of varying moduli have to do exactly the work that
the change of `N` requires, so that no energy is created; a failure of that is a bug in bgc.
"""

from __future__ import annotations

import math
import random
import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import product

from bgc.algebra.dag import Dag, Kind, Symbol
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
_ITERATIONS = 60  # of the moduli and the flows that they read
_SETTLED = 1e-14  # change of a flow, relative or absolute


class MergedAudit:
    """The checks of all groups of a graph; skipped where a function has no value."""

    def __init__(self, variables: Variables, groups: Sequence[Group]) -> None:
        self._variables = variables
        self._groups = groups
        basis = variables.causal.basis
        speeds = {k: random.Random(f"flow {k}").uniform(0.3, 1) for k in range(len(basis))}
        elements = [element for group in groups for element in group.elements]
        self._point = _Point(variables, elements, speeds)
        self._masses = {group.flows: _reduced_mass(self._point, group) for group in groups}
        for flows, mass in self._masses.items():
            for i, k in enumerate(flows):
                if sys.float_info.min <= mass[i][i] < math.inf:
                    speeds[k] /= mass[i][i] ** 0.5
        self._moving = self._point.at(speeds)

    def require_moved(self, group: Group) -> None:
        """Refuse a group with a motion that moves none of the reduced mass, where it is known.

        With linear laws, one that moves nearly none is refused as well.

        Raises
        ------
        BgError
            Names what can move without inertia, or the inertias beside the motion.
        """
        mass = self._masses[group.flows]
        if not _is_known(mass):
            return
        may_be_rounding = may_be_opened(self._variables.causal)
        rounding = _NO_MASS_IN_A_CHAIN if may_be_rounding else _NO_MASS
        least = _LEAST_EIGENVALUE if group.is_linear else _ROUNDING
        motion = motion_without_inertia(mass, least, rounding)
        if motion is not None:
            raise _moving_without_inertia(self._point, group, motion)

    def is_solved(
        self, group: Group, momenta: Mapping[int, Node], flows: Mapping[int, Node]
    ) -> bool:
        """Return whether flows follow from the momenta that they have, or that is unknown.

        Both are nodes by independent flow of the group.
        """
        variables, point = self._variables, self._moving
        if not point.is_consistent or not _is_known(self._masses[group.flows]):
            return True
        totals: dict[int, float] = {}
        for port, momentum in _momenta(point, group.elements, point.flows):
            for k, x in point.row_of(port).items():
                totals[k] = totals.get(k, 0.0) + x * momentum
        point.known |= {_symbol(variables.dag, x): totals[k] for k, x in momenta.items()}
        number_of = {k: variables.causal.basis[k].bond_class for k in flows}
        errors = [abs(point.value(x) / point.flows[number_of[k]] - 1) for k, x in flows.items()]
        return not any(error > _FLOW_TOLERANCE for error in errors)

    def assert_powerless(self) -> None:
        """The forces of turning moduli take the power that turning moduli give the flows.

        Not asserted where laws are not linear, or an energy varies with charges: its forces are
        among the turning ones.
        """
        ports = [port for group in self._groups for port in group.ports]
        if (
            any(port.bias != self._variables.dag.zero for port in ports)
            or not all(group.is_linear for group in self._groups)
            or not all(map(_is_known, self._masses.values()))
        ):
            return
        point = self._moving
        before, after = (point.at(point.speeds, shift) for shift in (-_SHIFT, _SHIFT))
        if not (point.is_consistent and before.is_consistent and after.is_consistent):
            return
        now, first, last = point.flows, before.flows, after.flows
        class_of = self._variables.causal.class_of
        powers, rounding = [], 0.0  # a difference of flows is exact to the rounding of the flows
        for group in self._groups:
            for port, momentum in _momenta(point, group.elements, now):
                number, sign = class_of[port.port.bond], port.port.through_sign
                rise = (last[number] - first[number]) / (2 * _SHIFT)
                powers.append(momentum * sign * rise)
                rounding += _ROUNDED * abs(momentum * now[number]) / _SHIFT
        point.around = before, after
        for number, force in self._variables.balances.turning.items():
            powers.append(point.value(force) * now[number])
        defect, size = abs(sum(powers)), sum(map(abs, powers))
        bound = _FLOW_TOLERANCE * size + rounding
        assert not defect > bound, f"turning moduli give the power {defect / size:.1e}"


def _is_known(mass: Sequence[Sequence[float]]) -> bool:
    """Return whether a reduced mass has values, with enough digits to judge."""
    finite = all(math.isfinite(entry) for row in mass for entry in row)
    return finite and not any(0 < row[i] < sys.float_info.min for i, row in enumerate(mass))


class _Point:
    """Numbers at a random state, where all flows are those that their definitions give.

    `speeds` are the independent flows. Where moduli or sources read flows, or momenta of
    `elements`, these are found by iteration. `shift` moves the state along a random direction, with
    all independent flows, those of sources as well, kept. `known` holds the values of flows and
    momenta, and of further symbols that nothing has read before they are set. Rates are
    differences between the points `around`.
    """

    def __init__(
        self,
        variables: Variables,
        elements: Sequence[StorageElement],
        speeds: Mapping[int, float],
        shift: float = 0.0,
        known: Mapping[Symbol, float] | None = None,
    ) -> None:
        self.variables = variables
        self.speeds = dict(speeds)
        self._elements = elements
        self._shift = shift
        self.around: tuple[_Point, _Point] | None = None
        self.known = dict(known or {})
        for _ in range(_ITERATIONS):
            found = self._evaluated()
            self.is_consistent = all(
                abs(found[symbol] - used) <= _SETTLED * max(1.0, abs(used))
                for symbol, used in self._read.items()
                if symbol in found
            )
            self.known = found
            if self.is_consistent:
                break

    def at(self, speeds: Mapping[int, float], shift: float = 0.0) -> _Point:
        """The same with other independent flows, and another shift."""
        return _Point(self.variables, self._elements, speeds, shift, self.known)

    def value(self, node: Node) -> float:
        """The value of a raw node."""
        return self._numbers.value(node)

    def row_of(self, port: StoragePort) -> dict[int, float]:
        """A port's row of N in the element's sense."""
        number = self.variables.causal.class_of[port.port.bond]
        return {k: port.port.through_sign * x for k, x in self._rows[number].items()}

    def _evaluated(self) -> dict[Symbol, float]:
        """Rows and flows by the flows and momenta known so far; those that these give."""
        variables = self.variables
        self._read: dict[Symbol, float] = {}  # all symbols that these are evaluated with
        self._numbers = Evaluator(variables.dag, self._leaf)
        self._rows = self._flow_rows()
        for k, independent in enumerate(variables.causal.basis):
            if independent.kind is BasisKind.FLOW_SOURCE and not self._shift:
                self.speeds[k] = self.value(variables.independent(k))
        self.flows = {  # of all classes
            number: sum(entry * self.speeds[k] for k, entry in row.items())
            for number, row in self._rows.items()
        }
        found = {
            Symbol(Kind.EFFORT if variables.causal.dual[bond] else Kind.FLOW, bond): flow
            for number, flow in self.flows.items()
            for bond in variables.causal.classes[number].bonds
        }
        momenta = _momenta(self, self._elements, self.flows)
        return found | {_symbol(variables.dag, port.state): x for port, x in momenta}

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
        if symbol.kind is Kind.PARAM:
            return self.variables.default(self.variables.dag.symbol(symbol.kind, symbol.index))
        value = self.known.get(symbol)
        self._read[symbol] = self._unknown(symbol) if value is None else value
        return self._read[symbol]

    def _unknown(self, symbol: Symbol) -> float:
        """A random number, or the rate of a node as a difference."""
        if self.around is not None and symbol.kind is Kind.RATE:
            rate = self.variables.definitions.get(
                self.variables.dag.symbol(symbol.kind, symbol.index)
            )
            if isinstance(rate, Rate):
                before, after = (point.value(rate.of) for point in self.around)
                return (after - before) / (2 * _SHIFT)
        rng = random.Random(f"{symbol.kind} {symbol.index}")
        return rng.uniform(0.2, 1) + self._shift * rng.uniform(-1, 1)


def _symbol(dag: Dag, node: Node) -> Symbol:
    symbol = dag.symbol_of(node)
    assert symbol is not None
    return symbol


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
