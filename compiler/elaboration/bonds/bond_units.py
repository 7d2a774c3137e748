"""Infer the units of the efforts and flows of all scalar bonds.

The unit of one variable determines the other where effort times flow is a power. A resistance in
ohms determines both, since the product and the quotient of the two are then known.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from bgc.algebra.disjoint_sets import DisjointSets
from bgc.diagnostics.catalogue import widths as width_messages
from bgc.diagnostics.collection import Report
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.domains import WATT
from bgc.record_class import dataclass
from bgc.values.units import (
    DIMENSIONLESS,
    Dimension,
    Written,
    describe_dimension,
    divide,
    multiply,
    power,
    preferred,
    written_text,
)

SECOND: Dimension = (0, 0, 1, 0, 0, 0, 0)
_TORQUE: Dimension = (1, 2, -2, 0, 0, 0, 0)
_TURNING: Dimension = (0, 0, -1, 0, 0, 0, 0)
_ROTATION = {_TORQUE: Written(_TORQUE, "N*m"), _TURNING: Written(_TURNING, "rad/s")}
_FLOWS: frozenset[Dimension] = frozenset(
    {(0, 0, 0, 1, 0, 0, 0), (0, 1, -1, 0, 0, 0, 0), _TURNING, (0, 3, -1, 0, 0, 0, 0)}
)  # current, velocity, angular velocity, volume flow
_RECIPROCAL = {
    "resistance": "conductance",
    "conductance": "resistance",
    "stiffness": "compliance",
    "compliance": "stiffness",
}


@dataclass(frozen=True, slots=True)
class Ratio:
    """The dimension of `effort / flow` of a bond, from an argument of an element.

    The dimension of the argument (such as `stiffness`) is `(effort / flow)^sense * s^time`:
    `sense` is -1 for a conductance or compliance, else 1; `time` is 1 for an inertia or
    compliance, -1 for a stiffness, else 0.
    """

    bond: int
    dimension: Dimension
    span: Span
    argument: str
    sense: int
    time: int

    def as_reciprocal(self) -> tuple[str, Dimension] | None:
        """The reciprocal argument and `effort / flow` if the number was meant as that.

        `C(100 N/m)` gives a compliance where the stiffness was meant. None where the element has
        no such argument.
        """
        if self.argument not in _RECIPROCAL:
            return None
        across = power(SECOND, -2 * self.time * self.sense)
        return _RECIPROCAL[self.argument], divide(across, self.dimension)

    def argument_for(self, effort_by_flow: Dimension) -> Dimension:
        """The dimension of the argument for a dimension of `effort / flow`."""
        return multiply(power(effort_by_flow, self.sense), power(SECOND, self.time))


@dataclass(frozen=True, slots=True)
class Link:
    """A relation between two bonds: `target variable = dimension * source variable`."""

    target: tuple[str, int]
    source: tuple[str, int]
    dimension: Dimension
    span: Span


@dataclass(slots=True)
class _Known:
    dimension: Dimension
    span: Span


class BondUnits:
    """The known units of each class of bonds with common units."""

    def __init__(self, names: list[str], report: Report) -> None:
        self._names = names
        self._report = report
        self._sets = DisjointSets(len(names))
        self._known: dict[tuple[str, int], _Known] = {}
        self._first: dict[int, Ratio] = {}
        self._pseudo: set[int] = set()
        self._reported: set[int] = set()

    def join(self, bonds: Iterable[int]) -> None:
        """Give the bonds of a junction common units."""
        self._sets.join(bonds)

    def common(self, bond: int) -> int:
        """The bond that stands for all those with its units."""
        return self._sets.find(bond)

    def mark_pseudo(self, bond: int) -> None:
        """Declare that effort times flow of the bond is not a power; call this before any unit."""
        self._pseudo.add(self._sets.find(bond))

    def is_power(self, bond: int) -> bool:
        """Return whether effort times flow is a power."""
        return self._sets.find(bond) not in self._pseudo

    def set_unit(self, variable: str, bond: int, dimension: Dimension, span: Span) -> bool:
        """Set the unit of an `effort` or `flow`, and of the other where the product is a power.

        Returns True if the unit was unknown. A contradiction is reported once for each class. The
        first unit that comes in words gives the bond its words.
        """
        root = self._sets.find(bond)
        known = self._known.get((variable, root))
        if known is not None:
            if known.dimension != dimension and root not in self._reported:
                self._reported.add(root)
                one, two = describe_dimension(known.dimension), describe_dimension(dimension)
                self._report.add(
                    width_messages.units_differ(
                        span, self._names[bond], variable, one, known.span, two, span
                    )
                )
            elif known.dimension == dimension:
                words = preferred(known.dimension, dimension)
                assert words is not None
                known.dimension = words
            return False
        self._known[variable, root] = _Known(dimension, span)
        other = "flow" if variable == "effort" else "effort"
        if root not in self._pseudo:
            self.set_unit(other, bond, divide(WATT, dimension), span)
        return True

    def solve(self, ratios: list[Ratio], links: list[Link]) -> None:
        """Propagate known units along ratios and links until nothing changes."""
        changed = True
        while changed:
            changed = False
            for ratio in ratios:
                changed |= self._apply_ratio(ratio)
            for link in links:
                changed |= self._apply_link(link)

    def _apply_ratio(self, ratio: Ratio) -> bool:
        bond, dimension, span = ratio.bond, ratio.dimension, ratio.span
        effort, flow = self.dimension("effort", bond), self.dimension("flow", bond)
        if effort is not None and flow is not None:
            if divide(effort, flow) != dimension:
                self._report_misfit(ratio, divide(effort, flow))
            return False
        if effort is not None:
            return self.set_unit("flow", bond, divide(effort, dimension), span)
        if flow is not None:
            return self.set_unit("effort", bond, multiply(flow, dimension), span)
        if self.is_power(bond):
            squared = power(multiply(WATT, dimension), Fraction(1, 2))
            self._first[self._sets.find(bond)] = ratio
            return self.set_unit("effort", bond, squared, span)
        return False

    def _report_misfit(self, ratio: Ratio, expected: Dimension) -> None:
        """Report an argument whose unit contradicts the known units of its bond."""
        root = self._sets.find(ratio.bond)
        if root in self._reported:
            return
        self._reported.add(root)
        first = self._first.get(root)
        meant = first.as_reciprocal() if first is not None else None
        if first is not None and meant is not None and meant[1] == ratio.dimension:
            ratio, expected = first, ratio.dimension  # it alone gave the bond its units
        places = [
            (known.span, f"{variable}: {describe_dimension(known.dimension)}")
            for variable in ("effort", "flow")
            if (known := self._known.get((variable, root))) is not None
        ]
        wanted = describe_dimension(ratio.argument_for(expected))
        given = describe_dimension(ratio.argument_for(ratio.dimension))
        name, argument = self._names[ratio.bond], ratio.argument
        meant = ratio.as_reciprocal()
        instead = meant[0] if meant is not None and meant[1] == expected else ""
        inverse = multiply(ratio.dimension, expected) == DIMENSIONLESS
        exchanged = inverse and self._is_exchanged(root)
        self._report.add(
            width_messages.unit_misfit(
                ratio.span, name, argument, wanted, given, places, instead, exchanged
            )
        )

    def _is_exchanged(self, root: int) -> bool:
        """Return whether the unit of a flow was given to the effort, as by an `Sf` for an `Se`."""
        effort, flow = (self._known.get((variable, root)) for variable in ("effort", "flow"))
        if effort is None or flow is None:
            return False
        return effort.dimension in _FLOWS and flow.dimension not in _FLOWS

    def _apply_link(self, link: Link) -> bool:
        if self._sets.find(link.source[1]) in self._reported:
            return False  # its units are in doubt
        source = self.dimension(*link.source)
        target = self.dimension(*link.target)
        if source is not None:
            changed = self.set_unit(*link.target, multiply(source, link.dimension), link.span)
            if self._sets.find(link.target[1]) in self._reported:  # report one cause once
                self._reported.add(self._sets.find(link.source[1]))
            return changed
        if target is not None:
            return self.set_unit(*link.source, divide(target, link.dimension), link.span)
        return False

    def dimension(self, variable: str, bond: int) -> Dimension | None:
        """The unit of an `effort` or `flow` in its words, as a domain has them; None if unknown.

        An effort in J with a flow in 1/s is a torque with an angular velocity, if nothing says so.
        """
        root = self._sets.find(bond)
        known = self._known.get((variable, root))
        if known is None or written_text(known.dimension) or root in self._pseudo:
            return known.dimension if known else None
        other = self._known.get(("flow" if variable == "effort" else "effort", root))
        rotation = _ROTATION.get(known.dimension)
        if rotation is None or other is None or other.dimension not in _ROTATION:
            return known.dimension
        return rotation
