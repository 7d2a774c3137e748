"""Merge dependent storage along free motions; the remaining states are invariant under them.

On a free motion z (see `motions`) the stored quantities x move as `x' = B z + ..`, and the power
balance on it is a condition on them: `B' dH/dx + driven = 0`. Compliances that share a flow which
only compliances determine are the usual case; charges and momenta that an odd loop of gyrators
joins are another. For each motion one quantity `x_d` is designated, such that B is the identity
there; it follows from the condition. The others keep the difference

    y = x - B x_d,    y' = x' - B x_d' - B' x_d,

in which z cancels: it is set to zero there. The speed of a motion is that at which the designated
quantity follows: `z = d/dt x_d(y, t) - (x_d' at z = 0)`. The common stiffness `B' K B` is symmetric
positive definite; with a law that is not linear the condition is solved by iteration.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.disjoint_sets import groups_sharing
from bgc.algebra.quadratic import ConstrainedEnergy, Definition, Form
from bgc.algebra.reduction import Reduction
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.motions.joint_start import Balance, joint_start
from bgc.equations.motions.motions import free_motions, part_of
from bgc.equations.storage.constrained_energy import (
    ReducedMatrix,
    cannot_merge,
    determine,
)
from bgc.equations.storage.coordinates import (
    effort_coordinate,
    element_coordinate,
    flow_coordinate,
)
from bgc.equations.storage.kinds import IntegratedState, StorageElement, StoragePort
from bgc.equations.variables.definitions import Column, Explicit, Row, Variables
from bgc.ir.causal import BasisKind, Role
from bgc.ir.graph import Node, Source
from bgc.record_class import dataclass, replace

_LEAST_EIGENVALUE = 1e-9  # eigenvalue or pivot, of the matrix scaled to a diagonal of ones or less


@dataclass(frozen=True, slots=True)
class Slot:
    """A stored quantity as a state: of a compliance's port, or on an independent flow."""

    state: IntegratedState
    element: StorageElement
    port: StoragePort | None  # None of a merged momentum

    @property
    def is_charge(self) -> bool:
        """Return whether it belongs to a compliance (in the terms of its region)."""
        return self.port is not None and self.port.port.role is Role.COMPLIANCE

    @property
    def place(self) -> int:
        """The element that messages name."""
        return self.element.ports[0].port.element

    def kind(self, dag: Dag) -> Kind:
        """Return whether it is a charge or a momentum of its element."""
        return dag.leaf(self.state.symbol).kind


def merge_along_motions(
    variables: Variables,
    elements: Sequence[StorageElement],
    states: Sequence[IntegratedState],
) -> list[IntegratedState]:
    """Merge storage along all free motions and return the remaining states with their start.

    Defines the flows of the motions, and the quantities that are no longer states.

    Raises
    ------
    BgError
        A motion moves nothing that is stored, or through moduli only that may vanish.
    """
    free = free_motions(variables)
    if not free:
        return joint_start(variables, elements, states, ())
    return _Merging(variables, elements, states, free).run()


class _Merging:
    def __init__(
        self,
        variables: Variables,
        elements: Sequence[StorageElement],
        states: Sequence[IntegratedState],
        free: Mapping[Column, Row],
    ) -> None:
        self._variables = variables
        self._elements = elements
        self._dag = variables.dag
        self._fingerprints = variables.causal.fingerprints
        self._free = list(free)
        self._owners = {element.storage.name: element for element in elements}
        self._slots = self._slots_of(elements, states)
        self._motions = Reduction(self._dag, self._fingerprints, self._moving(free.values()))
        self._taken = {slot.state.name for slot in self._slots}
        self._leaders: dict[int, int] = {}  # motion -> the slot of its designated quantity
        self._effort_sources = [
            (port, source)
            for port in variables.causal.ports
            if port.role is Role.EFFORT_SOURCE
            and isinstance(source := variables.causal.graph.elements[port.element], Source)
        ]

    def run(self) -> list[IntegratedState]:
        """Designate a quantity for each motion, define it, and return the remaining states."""
        self._designate()
        self._define_flows()
        rests: dict[int, Node] = {}
        for members in self._groups():
            rests |= self._define_quantities(members)
        states = [slot.state for slot in self._slots]
        started = joint_start(self._variables, self._elements, states, self._balances())
        start = {state.symbol: state.initial for state in started}
        led = set(self._leaders.values())
        return [
            self._kept(i, rests[i], start) if i in rests else state
            for i, (slot, state) in enumerate(zip(self._slots, started, strict=True))
            if i not in led
        ]

    # --- motions ------------------------------------------------------------------------------

    def _slots_of(
        self, elements: Sequence[StorageElement], states: Sequence[IntegratedState]
    ) -> list[Slot]:
        ports = {port.index: (element, port) for element in elements for port in element.ports}
        return [
            Slot(state, self._owners[state.stores[0]], None)
            if state.port is None
            else Slot(state, *ports[state.port])
            for state in states
        ]

    def _moving(self, free: Collection[Row]) -> list[Row]:
        """The motions, each with ("slot", i): what a unit of it adds to the rate of a quantity."""
        dag = self._dag
        holding: dict[Column, list[int]] = {}
        for j, motion in enumerate(free):
            for column in motion:
                holding.setdefault(column, []).append(j)
        motions = [dict(motion) for motion in free]
        for i, slot in enumerate(self._slots):
            kind = "flow" if slot.is_charge else "push"
            alone = {} if slot.state.flow is None else {slot.state.flow: dag.one}
            for k, entry in (alone if slot.port is None else slot.port.flow).items():
                for j in holding.get((kind, k), ()):
                    moved = dag.mul(entry, motions[j][kind, k])
                    motions[j]["slot", i] = dag.add(motions[j].get(("slot", i), dag.zero), moved)
        return motions

    def _moved_by(self, j: int) -> list[int]:
        """The slots that a motion moves."""
        return sorted(part_of(self._motions.rows[j], "slot"))

    def _moved(self, i: int) -> dict[int, Node]:
        """The rate of a slot's quantity by one unit of each motion."""
        holding = sorted(self._motions.holding.get(("slot", i), ()))
        return {j: self._motions.rows[j]["slot", i] for j in holding}

    def _groups(self) -> list[list[int]]:
        """Motions that move something of one element in common."""
        motions = range(len(self._free))
        return groups_sharing([{self._slots[i].place for i in self._moved_by(j)} for j in motions])

    # --- designated quantities ----------------------------------------------------------------

    def _designate(self) -> None:
        """Find a quantity for each motion, and turn the motions so that each moves only its own."""
        waiting = list(range(len(self._free)))
        while waiting:
            postponed = [j for j in waiting if not self._designate_for(j)]
            if len(postponed) == len(waiting):
                raise self._not_held(postponed[0])
            waiting = postponed

    def _designate_for(self, j: int) -> bool:
        moved = part_of(self._motions.rows[j], "slot")
        candidates = [
            (not self._slots[i].is_charge, len(self._motions.holding["slot", i]), i)
            for i, node in moved.items()
            if self._variables.certificate(node) is not None
        ]
        if not candidates:
            return False
        *_, i = min(candidates)
        name = self._slots[i].state.stores[0]
        self._variables.may_divide(moved[i], f"the modulus that joins `{name}` must not be zero")
        self._motions.eliminate(j, ("slot", i))
        self._leaders[j] = i
        return True

    # --- definitions --------------------------------------------------------------------------

    def _define_flows(self) -> None:
        """The flows and efforts that take part in motions."""
        variables, dag = self._variables, self._dag
        shares: dict[Node, Node] = {}
        for j, motion in enumerate(self._motions.rows):
            state = self._slots[self._leaders[j]].state
            speed = variables.new_speed(state.symbol, state.derivative)
            flows = part_of(motion, "flow").items()
            parts = {variables.symbol_of(("flow", k)): node for k, node in flows}
            for k, node in part_of(motion, "port").items():
                turned = variables.symbols.turned(node, variables.causal.ports[k].across_sign)
                parts[variables.symbol_of(("port", k))] = turned
            for symbol, node in parts.items():
                shares[symbol] = dag.add(shares.get(symbol, dag.zero), dag.mul(node, speed))
        alone = {variables.symbol_of(column) for column in self._free}
        for symbol, share in shares.items():
            variables.set_share(symbol, share, alone=symbol in alone)

    def _define_quantities(self, members: Sequence[int]) -> dict[int, Node]:
        """The quantities that a group of motions moves; gives the new states by slot."""
        variables, dag = self._variables, self._dag
        leaders = {self._leaders[j]: j for j in members}
        rests: dict[int, Node] = {}
        for i in self._moved_slots(members):
            if i in leaders:
                continue
            slot = self._slots[i]
            rests[i] = variables.new_state(slot.kind(dag))
            moved = self._moved(i).items()
            parts = (dag.mul(node, self._leading(j).state.symbol) for j, node in moved)
            whole = Explicit(dag.add(rests[i], dag.sum(parts)))
            variables.set_definition(slot.state.symbol, whole, slot.place)
        for i in leaders:
            variables.places.note(self._slots[i].state.symbol, self._slots[i].place)
        states = [slot.state.symbol for slot in self._slots]
        count = len(states)
        determine(
            variables,
            [states[self._leaders[j]] for j in members],
            self._definite_energy(members, rests),
            lambda k: states[k] if k < count else rests[k - count],
            lambda place: self._condition(members[place]),
        )
        return rests

    def _condition(self, j: int) -> Node:
        """The residual of the balance on a motion: `B' dH/dx + driven`."""
        dag, variables = self._dag, self._variables
        total = self._driven(j)
        motion = self._motions.rows[j]
        for i in self._moved_by(j):
            slot = self._slots[i]
            if slot.is_charge:
                assert slot.port is not None
                total = dag.add(total, dag.mul(motion["slot", i], slot.port.answer))
        for k, node in part_of(motion, "push").items():
            if variables.causal.basis[k].kind is not BasisKind.FLOW_SOURCE:
                total = dag.add(total, dag.mul(node, variables.independent(k)))
        return total

    def _driven(self, j: int) -> Node:
        """The share of sources in the balance on a motion."""
        dag, variables, causal = self._dag, self._variables, self._variables.causal
        motion = self._motions.rows[j]
        total = dag.zero
        for k, node in part_of(motion, "push").items():
            if causal.basis[k].kind is BasisKind.FLOW_SOURCE:
                total = dag.add(total, dag.mul(node, variables.independent(k)))
        flows = part_of(motion, "flow").items()
        for port, source in self._effort_sources:
            row = dict(causal.flows[causal.class_of[port.bond]])
            moved = dag.sum(dag.mul(row[k], x) for k, x in flows if k in row)
            force = variables.symbols.turned(source.value, port.sign)
            total = dag.add(total, dag.mul(moved, force))
        return total

    def _definite_energy(
        self, members: Sequence[int], rests: Mapping[int, Node]
    ) -> ConstrainedEnergy | None:
        """The energy of a group of linear compliances.

        None for other groups, and where the common stiffness is not positive definite.
        """
        elements = [self._slots[i].element for i in self._moved_slots(members)]
        ports = [port for element in elements for port in element.ports]
        if not all(e.law.response for e in elements) or any(
            port.port.role is not Role.COMPLIANCE for port in ports
        ):
            return None
        energy = self._potential_energy(members, rests)
        stiffness = ReducedMatrix(self._variables, energy)
        if stiffness.is_definite(_LEAST_EIGENVALUE):
            return energy
        if stiffness.is_singular(_LEAST_EIGENVALUE):
            raise self._cannot_merge(members, "their common stiffness is singular")
        return None

    def _potential_energy(
        self, members: Sequence[int], rests: Mapping[int, Node]
    ) -> ConstrainedEnergy:
        """`1/2 x' K x + driven' x_d` over the slots of charges, where `x = y + B x_d`.

        The designated x_d are free. The remaining states y have numbers behind those of the slots.
        """
        dag, count = self._dag, len(self._slots)
        slots = self._moved_slots(members)
        at = {slot.port.index: i for i, slot in enumerate(self._slots) if slot.port is not None}
        matrix: dict[int, dict[int, Node]] = {}
        for element in {self._slots[i].place: self._slots[i].element for i in slots}.values():
            assert element.law.response is not None
            for port, line in zip(element.ports, element.law.response, strict=True):
                matrix[at[port.index]] = {
                    at[other.index]: entry
                    for other, entry in zip(element.ports, line, strict=True)
                    if entry != dag.zero
                }
        free = [self._leaders[j] for j in members]
        definitions = [
            Definition(
                i,
                {count + i: dag.one}
                | {self._leaders[j]: node for j, node in self._moved(i).items()},
            )
            for i in rests
        ]
        driven = {k: dag.neg(self._driven(j)) for k, j in zip(free, members, strict=True)}
        return ConstrainedEnergy(Form(matrix, driven), definitions, free)

    # --- remaining states ---------------------------------------------------------------------

    def _kept(self, i: int, symbol: Node, start: Mapping[Node, Node]) -> IntegratedState:
        """The state `y = x - B x_d` of a slot."""
        dag, slot = self._dag, self._slots[i]
        old = slot.state
        rate, initial = old.derivative, start[old.symbol]
        led: list[str] = []
        for j, node in self._moved(i).items():
            leader = self._leading(j).state
            led += leader.stores
            rate = dag.sub(rate, dag.mul(node, leader.derivative))
            initial = dag.sub(initial, dag.mul(node, start[leader.symbol]))
            if dag.level[node] > Level.PARAM:
                turning = self._variables.rate_of(node, slot.place)
                rate = dag.sub(rate, dag.mul(turning, leader.symbol))
        self._variables.resting.add(symbol)
        held = tuple(dict.fromkeys((*old.stores, *led)))
        name = self._name(slot)
        return replace(
            old, symbol=symbol, name=name, derivative=rate, initial=initial, port=None, stores=held
        )

    def _name(self, slot: Slot) -> str:
        """The name of the state that remains of a slot."""
        causal, name = self._variables.causal, slot.state.name
        if slot.port is None:
            return name
        bond = slot.port.port.bond
        if slot.is_charge:
            found = effort_coordinate(self._variables, bond, self._taken)
        else:
            found = flow_coordinate(self._variables, causal.class_of[bond], self._taken)
        found = element_coordinate(name, self._taken) if found is None else found
        self._taken.add(found)
        return found

    def _balances(self) -> list[Balance]:
        return [
            Balance(
                {
                    self._slots[i].state.symbol: self._motions.rows[j]["slot", i]
                    for i in self._moved_by(j)
                },
                self._driven(j),
            )
            for j in range(len(self._free))
        ]

    def _moved_slots(self, members: Sequence[int]) -> list[int]:
        return sorted({i for j in members for i in self._moved_by(j)})

    def _leading(self, j: int) -> Slot:
        return self._slots[self._leaders[j]]

    # --- errors -------------------------------------------------------------------------------

    def _not_held(self, j: int) -> BgError:
        """The error for a motion that moves no storage, or only through moduli that may vanish."""
        if self._moved_by(j):
            return self._cannot_merge([j], "the modulus that joins them may become zero")
        variables, motion = self._variables, self._motions.rows[j]
        symbols = [variables.symbol_of(("flow", k)) for k in part_of(motion, "flow")]
        symbols += [variables.symbol_of(("port", k)) for k in part_of(motion, "port")]
        return variables.places.unsolvable(symbols)

    def _cannot_merge(self, members: Sequence[int], why: str) -> BgError:
        slots = [self._slots[i] for i in self._moved_slots(members)]
        names = [name for slot in slots for name in slot.state.stores]
        return cannot_merge(slots[0].element, names, why)
