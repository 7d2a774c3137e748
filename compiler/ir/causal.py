"""The causal graph: the independent flows, and the dependence of all other variables on them.

Duality
-------
Without its gyrators the graph falls into regions. The bonds of some regions are *dualised*:
effort and flow exchange roles there (J0 <-> J1, C <-> I, Se <-> Sf), which makes a gyrator between
a dual and a primal region a transformer. In this module every bond therefore has a *through*
variable (its flow; its effort where `dual`) and an *across* variable (the other one), and one
matrix relates both:

    through = N u  (u: the independent through variables),    N' across = 0.

In the sense of an element, in which power into it is positive, the variables of a port are
`through` times `through_sign` and `across` times `across_sign`, each +1 or -1.
"""

from __future__ import annotations

from enum import Enum

from bgc.algebra.fingerprint import Fingerprints
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.ir.fields import (
    BasisIndex,
    BondIndex,
    ClassIndex,
    ElementIndex,
    PortIndex,
    RowIndex,
)
from bgc.ir.graph import FlatGraph, Node
from bgc.ir.program import PositiveParameter
from bgc.record_class import dataclass


class Role(Enum):
    """The role of an element's port in its region; in a dual region that of the dual element."""

    FLOW_SOURCE = "flow source"  # gives the through variable
    EFFORT_SOURCE = "effort source"  # gives the across variable
    INERTIA = "inertia"  # integrates across, gives through
    COMPLIANCE = "compliance"  # integrates through, gives across
    RESISTANCE = "resistance"  # relates the two at once


@dataclass(frozen=True, slots=True)
class ElementPort:
    """A port of a storage element, resistor, source or gyrator.

    `position` numbers the element's ports; a gyrator's ports 2 follow its ports 1.
    """

    element: ElementIndex
    position: int
    bond: BondIndex
    sign: int  # +1 where the arrow points into the element
    dual: bool
    role: Role

    @property
    def through_sign(self) -> int:
        """The factor from the bond's through variable to that in the element's sense."""
        return 1 if self.dual else self.sign

    @property
    def across_sign(self) -> int:
        """The factor from the bond's across variable to that in the element's sense."""
        return self.sign if self.dual else 1


@dataclass(frozen=True, slots=True)
class BondClass:
    """Bonds with one common through variable, and the element ports on them."""

    bonds: tuple[BondIndex, ...]
    ports: tuple[PortIndex, ...]


@dataclass(frozen=True, slots=True)
class RowEnd:
    """A bond in a row: its coefficient, and the sign of the port."""

    bond: BondIndex
    sign: int
    coefficient: Node


@dataclass(frozen=True, slots=True)
class Row:
    """A constraint `sum coefficient * through = 0` of a junction or transformer.

    Its multiplier l gives the across variable at its ends: `sign * coefficient * l`.
    """

    element: ElementIndex
    ends: tuple[RowEnd, ...]


@dataclass(frozen=True, slots=True)
class Step:
    """One elimination step: class `dependent` expressed by other classes.

    `working` is row `row` reduced by the earlier steps; its entry at `dependent`, the pivot, is
    provably nonzero. `factors[k] = (r, f)`: f times the working row of row r was subtracted, so
    the original row is `working + sum f * working_r`.
    """

    row: RowIndex
    dependent: ClassIndex
    working: tuple[tuple[ClassIndex, Node], ...]
    factors: tuple[tuple[RowIndex, Node], ...]


@dataclass(frozen=True, slots=True)
class Closure:
    """A row that closes a chain: elimination found no certified pivot in it.

    It constrains independent through variables that inertias and sources determine. Its multiplier
    is an unknown that keeps it satisfied (`equations/closures`). `elements` are the junctions and
    transformers of the chain.
    """

    row: RowIndex
    elements: tuple[ElementIndex, ...]


class BasisKind(Enum):
    """The kind of port that determines an independent through variable."""

    FLOW_SOURCE = "flow source"
    INERTIA = "inertia"
    RESISTANCE = "resistance"
    COMPLIANCE = "compliance"
    INDETERMINATE = "indeterminate"


@dataclass(frozen=True, slots=True)
class Basis:
    """An independent class and the kind of port that determines it."""

    bond_class: ClassIndex
    kind: BasisKind


class Rule(Enum):
    """The rule of the sequential causality assignment procedure (SCAP) that placed a stroke."""

    FIXED = "fixed"
    PREFERRED = "preferred"
    INDIFFERENT = "indifferent"
    DERIVATIVE = "derivative"
    IMPLIED = "implied"


@dataclass(frozen=True, slots=True)
class Stroke:
    """The causal stroke of a bond, at the end where the effort is imposed."""

    at_head: bool
    rule: Rule
    reason: str


@dataclass(frozen=True, slots=True)
class CausalGraph:
    """A flat graph with its independent through variables and the causality of its bonds."""

    graph: FlatGraph
    fingerprints: Fingerprints
    dual: tuple[bool, ...]  # for each bond
    ports: tuple[ElementPort, ...]
    classes: tuple[BondClass, ...]
    class_of: tuple[ClassIndex, ...]  # for each bond
    rows: tuple[Row, ...]
    steps: tuple[Step, ...]
    redundant: frozenset[RowIndex]  # linearly dependent rows, whose multipliers are indeterminate
    closures: tuple[Closure, ...]
    cut: frozenset[ElementIndex]  # junctions of one through variable whose rows close chains
    basis: tuple[Basis, ...]
    flows: tuple[tuple[tuple[BasisIndex, Node], ...], ...]  # for each class: entries of a row of N
    strokes: tuple[Stroke, ...]  # for each bond
    positive: tuple[PositiveParameter, ...]
    warnings: tuple[Diagnostic, ...]
    ranged: bool = False  # whether divisors may vary within a range without zero
    opened: bool = False  # whether the coordinates of an open tree are independent
