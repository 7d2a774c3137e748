"""Find what a run has to know of sampled ports and of the forces on its devices.

A device is guarded by the sampled ports, or the observers, that read its position and make its
force. Both are found in the expressions: a scene may have several devices, each with a guard of its
own, or none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import fields

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.ir.defaults import program_values
from bgc.ir.graph import FmuUse, Held, Node, SampledPort, Slot
from bgc.ir.port_facts import FmuFacts, ForceFacts, PortFacts
from bgc.ir.program import Program
from bgc.ir.scene_nodes import DeviceUse

_OBSERVER = "Observer"  # of the library's `haptics.coupling`
_POSES = ("position", "orientation", "velocity", "angular_velocity", "gripper")
_FORCE = "force"


def port_facts(program: Program, ports: Sequence[SampledPort]) -> tuple[PortFacts, ...]:
    """The places of the efforts and displacements of sampled ports in a program."""
    states = {state.name: k for k, state in enumerate(program.states)}
    efforts = {held.name: held.index for held in program.held}
    found = []
    for port in ports:
        components = range(1, port.width + 1)
        moved = [states.get(f"{port.name}.moved[{k}]") for k in components]
        effort = [efforts.get(f"{port.name}.effort[{k}]") for k in components]
        known = PortFacts(
            port.name,
            tuple(k for k in effort if k is not None),
            tuple(k for k in moved if k is not None),
        )
        whole = len(known.efforts) == len(known.moved) == port.width
        found.append(known if whole else PortFacts(port.name))
    return tuple(found)


def fmu_facts(fmus: Sequence[FmuUse]) -> tuple[FmuFacts, ...]:
    """Collect what a run needs to open the FMUs of other tools."""
    return tuple(FmuFacts(*(getattr(fmu, each.name) for each in fields(FmuFacts))) for fmu in fmus)


def force_facts(
    program: Program, ports: Sequence[SampledPort], slots: Iterable[Slot]
) -> tuple[ForceFacts, ...]:
    """Collect the facts about the force on each device that takes one."""
    reads = _Reads(program)
    observers = [slot.path for slot in slots if slot.filled_by == _OBSERVER]
    guards = {path: reads.devices_of(path) for path in (*(p.name for p in ports), *observers)}
    return tuple(
        _force_of(device, reads, guards, frozenset(observers))
        for device in program.devices
        if any(channel == _FORCE for channel, _ in device.commands)
    )


def _force_of(
    device: DeviceUse,
    reads: _Reads,
    guards: dict[str, frozenset[str]],
    observers: frozenset[str],
) -> ForceFacts:
    pairs = zip(device.commands, device.values, strict=True)
    force = [value for (channel, _), value in pairs if channel == _FORCE]
    own = [path for path, devices in guards.items() if device.name in devices]
    seen = reads.held_behind(force, ())
    acting = tuple(p for p in own if any(h.name.startswith(f"{p}.") for h in seen))
    return ForceFacts(
        device.name,
        ports=tuple(p for p in acting if p not in observers),
        observers=tuple(p for p in acting if p in observers),
        whole=bool(acting) and not reads.moves(force, acting),
        periods=tuple(dict.fromkeys(reads.period(held.rate) for held in seen)),
    )


class _Reads:
    """The inputs and held values that expressions of a program read."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._held = {held.index: held for held in program.held}
        self._poses = {
            device.first_input + k: device.name
            for device in program.devices
            for k, (channel, _) in enumerate(device.inputs)
            if channel in _POSES
        }

    def devices_of(self, path: str) -> frozenset[str]:
        """The devices whose poses a guard reads: at once, else through states."""
        start = f"{path}.position_before["
        updates = [held.update for held in self._program.held if held.name.startswith(start)]
        direct = self._devices(self._symbols(updates))
        return direct or self._devices(self._reached(updates))

    def held_behind(self, nodes: Iterable[Node], stop: Sequence[str]) -> list[Held]:
        """The held values that expressions read, and those that make these, in order.

        What makes the held values of the paths `stop` is left out.
        """
        found: dict[int, Held] = {}
        waiting = list(nodes)
        while waiting:
            for symbol in self._symbols([waiting.pop()]):
                held = self._held.get(symbol.index) if symbol.kind is Kind.INPUT else None
                if held is None or held.index in found:
                    continue
                found[held.index] = held
                if not held.name.startswith(tuple(f"{path}." for path in stop)):
                    waiting.append(held.update)
        return [found[index] for index in sorted(found)]

    def moves(self, nodes: Sequence[Node], guards: Sequence[str]) -> bool:
        """Return whether expressions depend on states or poses other than through guards."""
        inside = tuple(f"{path}." for path in guards)
        held = self.held_behind(nodes, guards)
        read = [*nodes, *(h.update for h in held if not h.name.startswith(inside))]
        return any(s.kind is Kind.STATE or self._is_pose(s) for s in self._symbols(read))

    def period(self, rate: int) -> str | float:
        """The period of a rate: the name of a parameter, else its value at the defaults, s."""
        node = self._program.rates[rate].period
        symbol = self._program.dag.symbol_of(node)
        if symbol is not None and symbol.kind is Kind.PARAM:
            return next(p.name for p in self._program.parameters if p.index == symbol.index)
        values = program_values(self._program)
        return evaluate_nodes(self._program.dag, [node], values)[0]

    def _is_pose(self, symbol: Symbol) -> bool:
        return symbol.kind is Kind.INPUT and symbol.index in self._poses

    def _devices(self, symbols: Iterable[Symbol]) -> frozenset[str]:
        return frozenset(self._poses[s.index] for s in symbols if self._is_pose(s))

    def _symbols(self, nodes: Sequence[Node]) -> Collection[Symbol]:
        return self._program.dag.symbols_in(nodes).values()

    def _reached(self, nodes: Sequence[Node]) -> set[Symbol]:
        """All that expressions depend on, through held values and the rates of states too."""
        found: set[Symbol] = set()
        waiting = list(nodes)
        while waiting:
            for symbol in set(self._symbols([waiting.pop()])) - found:
                found.add(symbol)
                if symbol.kind is Kind.STATE:
                    waiting.append(self._program.states[symbol.index].derivative)
                elif symbol.kind is Kind.INPUT and symbol.index in self._held:
                    waiting.append(self._held[symbol.index].update)
        return found
