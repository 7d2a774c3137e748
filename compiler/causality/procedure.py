"""The order in which sequential assignment (SCAP) places the causal strokes of a graph.

`assign` finds the strokes of a graph at once, by elimination. On paper they are placed one after
the other: each source, then each storage element, then each resistor takes the causality that it
needs or prefers, and what follows at junctions and two-ports is placed before the next choice
(Karnopp and Rosenberg 1975). Given the strokes, `place_in_order` finds that order and the reason
for each. Without them, as in a graph that `assign` refuses, it stops at the first contradiction. A
ring of bonds or an odd loop of gyrators may be one, as on paper; `assign` judges them by their
coefficients.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence

from bgc.causality.regions import roles_of
from bgc.causality.strokes import element_reason
from bgc.ir.causal import Role, Rule, Stroke
from bgc.ir.fields import BondIndex
from bgc.ir.graph import (
    FlatGraph,
    Gyrator,
    Junction,
    Port,
    Transformer,
    port_ends,
    ports_of,
)
from bgc.record_class import dataclass

_RECEIVES_EFFORT = {
    Role.FLOW_SOURCE: True,
    Role.EFFORT_SOURCE: False,
    Role.INERTIA: True,
    Role.COMPLIANCE: False,
    Role.RESISTANCE: False,
}
"""True where a port that can choose receives the effort; a resistance takes either."""
_TURNS = (
    (Role.FLOW_SOURCE, Role.EFFORT_SOURCE),
    (Role.INERTIA, Role.COMPLIANCE),
    (Role.RESISTANCE,),
)


@dataclass(frozen=True, slots=True)
class Placement:
    """A stroke in the order of the procedure; one that is no `choice` follows from others."""

    bond: BondIndex
    stroke: Stroke
    choice: bool


@dataclass(frozen=True, slots=True)
class Procedure:
    """The strokes of a graph in the order in which sequential assignment places them.

    `contradiction` says why no further stroke can be placed, and `at_fault` are the bonds that
    contradict each other; both are empty where all agree.
    """

    graph: FlatGraph
    placements: tuple[Placement, ...]
    contradiction: str = ""
    at_fault: tuple[BondIndex, ...] = ()

    @property
    def strokes(self) -> tuple[Stroke | None, ...]:
        """The stroke of each bond; None where the procedure placed none."""
        placed = {item.bond: item.stroke for item in self.placements}
        return tuple(placed.get(bond.index) for bond in self.graph.bonds)


def place_in_order(graph: FlatGraph, strokes: Sequence[Stroke] = ()) -> Procedure:
    """Place the strokes of a graph one after the other.

    With `strokes`, those of `assign`, every bond gets its own; where neither an element nor a
    junction or two-port asks for it, it comes last. Without them the procedure ends where sources
    contradict each other, and bonds at two-ports of several bonds may be left open.
    """
    course = _Course(graph, strokes)
    contradiction = course.run()
    found = contradiction or _Contradiction("", ())
    return Procedure(graph, tuple(course.placed.values()), found.reason, found.bonds)


@dataclass(frozen=True, slots=True)
class _Contradiction:
    reason: str
    bonds: tuple[int, ...]


class _Course:
    def __init__(self, graph: FlatGraph, strokes: Sequence[Stroke]) -> None:
        self._graph = graph
        self._given = strokes
        self._at = {(bond, sign): index for bond, sign, index in port_ends(graph)}
        self._roles = {
            (port.bond, port.sign): role
            for element in graph.elements
            for _, port, role in roles_of(graph.dag, element, [False] * len(graph.bonds))
        }
        self.placed: dict[int, Placement] = {}

    def run(self) -> _Contradiction | None:
        """Make every choice with its consequences; a contradiction of sources ends the procedure.

        A choice of another element that would lead to one is not made.
        """
        for bond, at_head in self._choices():
            if bond not in self.placed:
                before = dict(self.placed)
                found = self._place(bond, at_head) or self._propagate(bond)
                if found and not self._given:
                    if self._of_element(bond, at_head)[0] is Rule.FIXED:
                        return found
                    self.placed = before
        return None

    def _choices(self) -> Iterator[tuple[int, bool]]:
        """Each bond in its turn, and whether its stroke is wanted at the head."""
        for turn in _TURNS:
            for (bond, sign), role in self._roles.items():
                at_head = _RECEIVES_EFFORT[role] == (sign > 0)
                if self._given and role is Role.RESISTANCE:
                    at_head = self._given[bond].at_head
                if role in turn and (not self._given or self._given[bond].at_head == at_head):
                    yield bond, at_head
        for bond, stroke in enumerate(self._given):
            yield bond, stroke.at_head

    def _place(
        self, bond: int, at_head: bool, cause: str = "", through: int | None = None
    ) -> _Contradiction | None:
        """Place a stroke, unless a source at the bond sets the other; `cause` came by `through`."""
        rule, reason = self._of_element(bond, at_head)
        fixed, other = self._of_element(bond, not at_head)
        if fixed is Rule.FIXED and not (rule is Rule.FIXED and self._given):
            bonds = (bond,) if through is None else (through, bond)
            return _Contradiction(f"{other}, but {cause or reason}", bonds)
        if not reason and not cause:
            reason = self._given[bond].reason
        choice = not cause and rule is not Rule.IMPLIED
        text = "; ".join(filter(None, (cause, reason)))
        self.placed[bond] = Placement(bond, Stroke(at_head, rule, text), choice)
        return None

    def _of_element(self, bond: int, at_head: bool) -> tuple[Rule, str]:
        """The rule and the reason of the source, storage or resistance at an end of a bond.

        A source gives none for the stroke that it does not set.
        """
        for turn in _TURNS:
            for sign in (1, -1):
                role, receives = self._roles.get((bond, sign)), at_head == (sign > 0)
                if role is None or role not in turn:
                    continue
                if turn is not _TURNS[0] or _RECEIVES_EFFORT[role] == receives:
                    name = self._graph.elements[self._at[bond, sign]].name
                    return element_reason(name, role, receives, "flow", "effort")
        return Rule.IMPLIED, ""

    def _propagate(self, bond: int) -> _Contradiction | None:
        """Place all that follows from a stroke."""
        queue = deque([bond])
        while queue:
            known = queue.popleft()
            for sign in (1, -1):
                found = self._consequences(self._at[known, sign])
                if isinstance(found, _Contradiction):
                    return found
                for port, receives, cause in found:
                    at_head = receives == (port.sign > 0)
                    if not self._given or self._given[port.bond].at_head == at_head:
                        contradiction = self._place(port.bond, at_head, cause, known)
                        if contradiction:
                            return contradiction
                        queue.append(port.bond)
        return None

    def _consequences(self, index: int) -> list[tuple[Port, bool, str]] | _Contradiction:
        """The ports of an element whose causality follows, whether they receive effort, and why."""
        element = self._graph.elements[index]
        ports = ports_of(element)
        free = [port for port in ports if port.bond not in self.placed]
        known = {port: self._receives(port) for port in ports if port not in free}
        match element:
            case Junction():
                return self._at_junction(element, free, known)
            case Transformer() | Gyrator():
                return self._at_two_port(element, free, known)
        return []

    def _at_two_port(
        self, element: Transformer | Gyrator, free: Sequence[Port], known: Mapping[Port, bool]
    ) -> list[tuple[Port, bool, str]] | _Contradiction:
        """One side follows from the other; where it has several bonds, only given strokes tell."""
        passes, name = isinstance(element, Transformer), element.name
        scalar = len(element.ports1) == len(element.ports2) == 1
        if scalar and element.matrix == ((self._graph.dag.zero,),):
            return []  # it passes nothing on
        if scalar and not free:
            first, second = known.values()
            if (first == second) == passes:
                bonds = tuple(port.bond for port in ports_of(element))
                return _Contradiction(f"`{name}` cannot give both sides the same variable", bonds)
        for side, other in ((element.ports1, element.ports2), (element.ports2, element.ports1)):
            causality = {known.get(port) for port in side}
            if len(causality) == 1 and None not in causality and (scalar or self._given):
                (receives,) = causality
                if passes:
                    cause = f"`{name}` passes on the {'flow' if not receives else 'effort'}"
                else:
                    turned = "an effort into a flow" if receives else "a flow into an effort"
                    cause = f"`{name}` turns {turned}"
                return [(port, receives != passes, cause) for port in other if port in free]
        return []

    def _at_junction(
        self, junction: Junction, free: Sequence[Port], known: Mapping[Port, bool]
    ) -> list[tuple[Port, bool, str]] | _Contradiction:
        """One bond brings the effort of a J0, or the flow of a J1, to all others."""
        common, special = ("effort", True) if junction.kind == "J0" else ("flow", False)
        name = junction.name
        bringing = [port for port, receives in known.items() if receives == special]
        givers = [self._neighbour(port) for port in bringing]
        if len(bringing) > 1:
            reason = f"`{name}` has one {common}, which `{givers[0]}` and `{givers[1]}` both bring"
            return _Contradiction(reason, tuple(port.bond for port in bringing))
        if bringing:
            cause = f"`{name}` has one {common}, which `{givers[0]}` brings"
            return [(port, not special, cause) for port in free]
        if len(free) == 1:
            return [(free[0], special, f"no other bond brings the {common} of `{name}`")]
        if not free:
            bonds = tuple(port.bond for port in junction.ports)
            return _Contradiction(f"no bond brings the {common} of `{name}`", bonds)
        return []

    def _receives(self, port: Port) -> bool:
        """Test whether the element at a port receives the effort of its bond."""
        return self.placed[port.bond].stroke.at_head == (port.sign > 0)

    def _neighbour(self, port: Port) -> str:
        return self._graph.elements[self._at[port.bond, -port.sign]].name
