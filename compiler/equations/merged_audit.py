"""What is asserted of merged inertias on every compile, at a random point.

The reduced mass `M_r = N' M N` is positive definite, and the flows written for its solution solve
it; the forces of turning moduli do the work that the turning of `N` does, so that no energy comes
from nowhere. The first may fail by the model, which is then refused; the others are the
compiler's own doing.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import Evaluator
from bgc.causality.causal import BasisKind, Role
from bgc.equations.merged_flows import flow_definitions
from bgc.equations.merged_groups import Group, inertias_of
from bgc.equations.storage import StoragePort
from bgc.equations.variables import Rate, Variables
from bgc.grammar.catalogue import causality as catalogue
from bgc.grammar.diagnostics import BgError
from bgc.graph import Node

_LEAST = 1e-9  # eigenvalue of the reduced mass scaled to a diagonal of ones
_TOLERANCE = 1e-6  # relative; far above rounding and differences, far below a slip
_SHIFT = 1e-5  # of the point, for differences


@dataclass(frozen=True, slots=True)
class MergedGroup:
    """A group of inertias with linear laws: independent flow -> its momentum, and its flow."""

    group: Group
    momenta: Mapping[int, Node]
    flows: Mapping[int, Node]


def require_definite(variables: Variables, group: Group) -> None:
    """Refuse a group of linear laws whose reduced mass is (nearly) singular at a random point.

    Raises
    ------
    BgError
        Names what can move without inertia.
    """
    point = _Point(variables, [])
    if all(map(math.isfinite, point.flows.values())):
        _require_definite(point, group)


def check_merged(variables: Variables, groups: Sequence[MergedGroup], *, complete: bool) -> None:
    """Check what was written for merged inertias; nothing where a function has no value.

    `complete` tells that there are no others, whose laws are not linear.
    """
    if not groups:
        return
    point = _Point(variables, groups)
    if not point.is_finite():
        return
    _assert_solved(point, groups)
    if complete:
        _assert_powerless(point, groups)


class _Point:
    """Numbers at a random state, with random flows unless these are given.

    `shift` moves the state along a random direction.
    """

    def __init__(
        self,
        variables: Variables,
        groups: Sequence[MergedGroup],
        shift: float = 0.0,
        independent: Sequence[float] = (),
    ) -> None:
        self.variables = variables
        self.groups = groups
        self._shift = shift
        self._around: tuple[_Point, _Point] | None = None
        self._known: dict[Node, float] = {}
        self._numbers = Evaluator(variables.dag, self._leaf)
        self._rows = self._flow_rows()
        self.independent = independent or [
            self._independent(k) for k in range(len(variables.causal.basis))
        ]
        self.flows = {
            number: sum(entry * self.independent[k] for k, entry in row.items())
            for number, row in self._rows.items()
        }

    def value(self, node: Node) -> float:
        """The value of a raw node."""
        return self._numbers.value(node)

    def set_known(self, values: Mapping[Node, float]) -> None:
        """Say what flows and momenta are."""
        self._known.update(values)

    def set_around(self, before: _Point, after: _Point) -> None:
        """Give the points from which rates are differences."""
        self._around = before, after

    def row_of(self, port: StoragePort) -> dict[int, float]:
        """A port's row of N in the element's sense."""
        number = self.variables.causal.class_of[port.port.bond]
        return {k: port.port.turn_through * x for k, x in self._rows.get(number, {}).items()}

    def flow_of(self, port: StoragePort) -> float:
        """A port's flow in the element's sense."""
        number = self.variables.causal.class_of[port.port.bond]
        return port.port.turn_through * self.flows.get(number, 0.0)

    def momenta(self) -> list[tuple[StoragePort, float]]:
        """The ports of all groups with their momenta."""
        found = []
        for merged in self.groups:
            for element in merged.group.elements:
                assert element.law.capacity is not None
                for port, line in zip(element.ports, element.law.capacity, strict=True):
                    if port.port.role is Role.INERTIA:
                        terms = zip(line, element.ports, strict=True)
                        found.append(
                            (port, sum(self.value(m) * self.flow_of(other) for m, other in terms))
                        )
        return found

    def is_finite(self) -> bool:
        """Whether all flows and momenta are numbers."""
        numbers = [*self.flows.values(), *(p for _, p in self.momenta())]
        return all(map(math.isfinite, numbers))

    def _independent(self, k: int) -> float:
        """An independent flow: what a source gives, or a random number."""
        if self.variables.causal.basis[k].kind is BasisKind.FLOW_SOURCE:
            return self.value(self.variables.independent(k))
        return random.Random(f"flow {k}").uniform(-1, 1)

    def _flow_rows(self) -> dict[int, dict[int, float]]:
        """Rows of N, as numbers, from the definitions."""
        basis = self.variables.causal.basis
        rows = {independent.bond_class: {k: 1.0} for k, independent in enumerate(basis)}
        definitions = flow_definitions(self.variables)
        for definition in reversed(definitions.values()):
            row: dict[int, float] = {}
            for number, node in definition.row.items():
                entry = self.value(node)
                for k, x in rows[number].items():
                    row[k] = row.get(k, 0.0) + entry * x
            rows[definition.variable] = row
        return rows

    def _leaf(self, symbol: Symbol) -> float:
        dag = self.variables.dag
        node = dag.symbol(symbol.kind, symbol.index)
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


def _require_definite(point: _Point, group: Group) -> None:
    """Refuse a group whose reduced mass, scaled, has an eigenvalue that is (nearly) zero."""
    order = {k: i for i, k in enumerate(group.flows)}
    mass = [[0.0] * len(order) for _ in order]
    for element in group.elements:
        capacity = element.law.capacity
        assert capacity is not None
        for port, line in zip(element.ports, capacity, strict=True):
            for other, node in zip(element.ports, line, strict=True):
                entry = point.value(node)
                for k, x in point.row_of(port).items() if entry else ():
                    for m, y in point.row_of(other).items():
                        if k in order and m in order:
                            mass[order[k]][order[m]] += entry * x * y
    motion = motion_without_inertia(mass, _LEAST)
    if motion is None:
        return
    speeds = {
        element.storage: max(
            abs(sum(x * motion[order[k]] for k, x in point.row_of(p).items() if k in order))
            for p in inertias_of(element)
        )
        for element in group.elements
    }
    least = 1e-3 * max(speeds.values())
    moving = [storage for storage, speed in speeds.items() if speed > least]
    names = [storage.name for storage in moving]
    raise BgError([catalogue.motion_without_inertia(moving[0].span, names)])


def motion_without_inertia(mass: Sequence[Sequence[float]], least: float) -> list[float] | None:
    """A motion along which a mass matrix, scaled to a diagonal of ones, is `least` or less.

    None where all eigenvalues are above it: Cholesky's factors exist of the scaled matrix less
    that number times the identity. Where they end, the last row and those before it give the
    motion.
    """
    scale = [row[i] ** 0.5 if row[i] > 0 else 0.0 for i, row in enumerate(mass)]
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
            return [x / s for x, s in zip(scaled, scale, strict=False)] + [0.0] * (
                len(mass) - i - 1
            )
        factors.append([*line, pivot**0.5])
    return None


def _assert_solved(point: _Point, groups: Sequence[MergedGroup]) -> None:
    """The independent flows follow from the momenta that they have."""
    variables = point.variables
    totals: dict[int, float] = {}
    for port, momentum in point.momenta():
        for k, x in point.row_of(port).items():
            totals[k] = totals.get(k, 0.0) + x * momentum
    symbols = variables.symbols
    point.set_known({symbols.of_class(number): flow for number, flow in point.flows.items()})
    for merged in groups:
        point.set_known({node: totals[k] for k, node in merged.momenta.items()})
    for merged in groups:
        for k, node in merged.flows.items():
            flow = point.flows[variables.causal.basis[k].bond_class]
            error = abs(point.value(node) - flow)
            assert error < _TOLERANCE, f"an independent flow of inertias is wrong by {error:.1e}"


def _assert_powerless(point: _Point, groups: Sequence[MergedGroup]) -> None:
    """The forces of turning moduli take the power that turning moduli give the flows."""
    variables = point.variables
    if any(p.bias != variables.dag.zero for m in groups for p in m.group.ports):
        return  # forces of an energy that varies with charges are among them
    before, after = (_Point(variables, groups, s, point.independent) for s in (-_SHIFT, _SHIFT))
    powers = []
    for port, momentum in point.momenta():
        point.set_known({port.state: momentum})
        rise = (after.flow_of(port) - before.flow_of(port)) / (2 * _SHIFT)
        powers.append(momentum * rise)
    point.set_around(before, after)
    for number, force in variables.balances.turning.items():
        powers.append(point.value(force) * point.flows[number])
    defect, size = abs(sum(powers)), sum(map(abs, powers))
    assert not defect > _TOLERANCE * size, f"turning moduli give the power {defect / size:.1e}"
