"""The causal graph: which flows are independent, what each bond's variables follow from.

Duality
-------
Gyrators are removed before anything else; the pieces that are left are regions, and the bonds
of some regions are *dualised*: effort and flow change names there (J0 <-> J1, C <-> I,
Se <-> Sf), which turns a gyrator between two differently coloured regions into a transformer.
In this module every bond therefore has a *through* variable (its flow; its effort where
`dual`) and an *across* variable (the other one), and one matrix serves both:

    through = N u  (u: the independent through variables),    N' across = 0.

A port's own sense is that of power into its element: `through` times `turn_through(port)` and
`across` times `turn_across(port)`, each +1 or -1.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from bgc.algebra.fingerprint import Fingerprints
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.ir.graph import FlatGraph, Node
from bgc.ir.program import PositiveParameter


class Role(Enum):
    """What an element's port is in the terms of its region (its dual name where dualised)."""

    FLOW_SOURCE = "flow source"  # gives the through variable
    EFFORT_SOURCE = "effort source"  # gives the across variable
    INERTIA = "inertia"  # integrates across, gives through
    COMPLIANCE = "compliance"  # integrates through, gives across
    RESISTANCE = "resistance"  # relates the two at once


@dataclass(frozen=True, slots=True)
class ElementPort:
    """A port of an element that stores, dissipates or drives.

    `position` counts the element's ports; a gyrator's ports 2 follow its ports 1.
    """

    element: int
    position: int
    bond: int
    sign: int  # +1 where the arrow points into the element
    dual: bool
    role: Role

    @property
    def turn_through(self) -> int:
        """Through variable in the element's sense = this times the bond's."""
        return 1 if self.dual else self.sign

    @property
    def turn_across(self) -> int:
        """Across variable in the element's sense = this times the bond's."""
        return self.sign if self.dual else 1


@dataclass(frozen=True, slots=True)
class BondClass:
    """Bonds that share one through variable, and the element ports on them."""

    bonds: tuple[int, ...]
    ports: tuple[int, ...]  # indices of CausalGraph.ports


@dataclass(frozen=True, slots=True)
class RowEnd:
    """Where a row meets a bond: the coefficient there, and the sign of the port."""

    bond: int
    sign: int
    coefficient: Node


@dataclass(frozen=True, slots=True)
class Row:
    """`sum coefficient * through = 0`, which a junction or a transformer demands.

    Its multiplier l gives the across variable at its ends: `sign * coefficient * l`.
    """

    element: int
    ends: tuple[RowEnd, ...]


@dataclass(frozen=True, slots=True)
class Step:
    """One elimination: `working` says what `dependent` is in terms of other classes.

    `working` is what is left of row `row` after the earlier steps; its entry at `dependent` is
    certain never to vanish. `factors[k] = (r, f)`: f times the working row of row r was taken
    from it before, so the row itself is `working + sum f * working_r`.
    """

    row: int
    dependent: int
    working: tuple[tuple[int, Node], ...]
    factors: tuple[tuple[int, Node], ...]


class BasisKind(Enum):
    """What an independent through variable is determined by."""

    FLOW_SOURCE = "flow source"
    INERTIA = "inertia"
    RESISTANCE = "resistance"
    COMPLIANCE = "compliance"
    INDETERMINATE = "indeterminate"


@dataclass(frozen=True, slots=True)
class Basis:
    """An independent class and what determines it."""

    bond_class: int
    kind: BasisKind


class Rule(Enum):
    """Why a stroke is where it is, in the terms of the sequential assignment (SCAP)."""

    FIXED = "fixed"
    PREFERRED = "preferred"
    INDIFFERENT = "indifferent"
    DERIVATIVE = "derivative"
    IMPLIED = "implied"


@dataclass(frozen=True, slots=True)
class Stroke:
    """The causal stroke of a bond: the end that is given the effort and gives the flow."""

    at_head: bool
    rule: Rule
    reason: str


@dataclass(frozen=True, slots=True)
class CausalGraph:
    """A flat graph with its independent flows, and how everything else follows from them."""

    graph: FlatGraph
    fingerprints: Fingerprints
    dual: tuple[bool, ...]  # of each bond
    ports: tuple[ElementPort, ...]
    classes: tuple[BondClass, ...]
    class_of: tuple[int, ...]  # of each bond
    rows: tuple[Row, ...]
    steps: tuple[Step, ...]
    redundant: frozenset[int]  # rows that repeat each other: their multipliers are indeterminate
    basis: tuple[Basis, ...]
    flows: tuple[tuple[tuple[int, Node], ...], ...]  # of each class: (index in basis, entry of N)
    strokes: tuple[Stroke, ...]  # of each bond
    positive: tuple[PositiveParameter, ...]
    warnings: tuple[Diagnostic, ...]
