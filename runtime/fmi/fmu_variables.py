"""The variables of an FMU, in the order of their value references.

The order is that of `runtime/c/fmi/fmi.h`: time, parameters, inputs, outputs, commands, the energy
accounts, states, rates, supplied and dissipated power, event indicators.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

from bgc.building.build_result import ENERGY_ACCOUNTS
from bgc.diagnostics.source import Span
from bgc.elaboration.scenes.scene_devices import channel_unit, command_unit
from bgc.ir.program import Program
from bgc.ir.scene_nodes import DeviceUse
from bgc.language.column_names import AccountColumn, name_in_si
from bgc.linearising.analysis_scene import channel_names
from bgc.record_class import dataclass, replace
from bgc.runtime.fmi.fmu_inputs import ChosenInputs
from bgc.values.shown_units import Shown

_COMPONENT = re.compile(r"(?P<whole>.*)\[(?P<places>\d+(?:,\s*\d+)*)\]")
_DOCUMENTATION = re.compile(r"\s*///\s?(.*)")


@dataclass(frozen=True, slots=True)
class Variable:
    """A scalar variable. `derivative_of` is the reference of the state whose rate it is.

    `causality` and `variability` are words of the standard; `start` is None where the value is
    calculated. `kind` is the group of its reference, `index` its place in it.
    """

    reference: int
    name: str
    unit: str
    causality: str
    variability: str
    kind: str
    index: int
    start: float | None = None
    low: float | None = None
    high: float | None = None
    nominal: float | None = None
    shown: Shown | None = None
    derivative_of: int | None = None
    description: str = ""
    hidden: bool = False
    reinit: bool = False

    @property
    def initial(self) -> str:
        """The attribute `initial`; empty where it follows from causality and variability."""
        if self.causality in ("independent", "input"):
            return ""
        return "exact" if self.start is not None else "calculated"


@dataclass(frozen=True, slots=True)
class Table:
    """All variables by reference; `hidden` ones are not in the model description.

    `free` are the numbers of the states that Model Exchange integrates, `continuous` the
    references of all its continuous states.
    """

    variables: tuple[Variable, ...]
    free: tuple[int, ...]
    continuous: tuple[int, ...]

    @property
    def listed(self) -> tuple[Variable, ...]:
        """The variables of the model description."""
        return tuple(v for v in self.variables if not v.hidden)

    def of(self, kind: str) -> tuple[Variable, ...]:
        """The variables of one group."""
        return tuple(v for v in self.variables if v.kind == kind)


def variable_table(
    program: Program,
    starts: Sequence[float],
    tunable: Sequence[bool],
    accounts: Sequence[AccountColumn],
    indicators: int = 0,
    inputs: ChosenInputs | None = None,
    timeless: bool = False,
) -> Table:
    """Tabulate the variables of a program.

    Parameters
    ----------
    program
        The optimised program.
    starts, tunable
        Of each parameter: its value, SI, and whether it may change during a run.
    accounts
        Columns of the energy accounts that the scene observes. They are in J in an FMU, so that
        `energy.supplied` is the integral of a power in W; other units are those of display. An
        account with several columns has the name and the unit of the first.
    indicators
        The number of event indicators that are variables, as FMI 3 has them.
    inputs
        The inputs after those of the devices.
    timeless
        Whether the time is missing from the model description: FMI 2 permits that, and the FMI
        Library would ask for its start value.
    """
    rows = _Rows(timeless)
    chosen = ChosenInputs(()) if inputs is None else inputs
    _add_parameters(rows, program, starts, tunable, chosen)
    others = ((name, unit, 0.0) for name, unit in chosen.found)
    for k, (name, unit, start) in enumerate((*_device_inputs(program), *others)):
        rows.add("input", k, name, unit, "input", start=start)
    for k, output in enumerate(program.observations):
        name = name_in_si(output.name)
        rows.add("output", k, name, output.unit, "output", shown=output.shown)
    for k, (name, unit) in enumerate(_commands(program.devices)):
        rows.add("command", k, name, unit, "output")
    _add_accounts(rows, program, accounts)
    free = free_states(program)
    _add_states(rows, program, free)
    for k in range(2):
        supplied_or_dissipated = rows.reference("account", k + 1)
        rows.add_rate("power", k, supplied_or_dissipated, "W", hidden=not accounts)
    for k in range(indicators):
        name = f"event_indicator[{k + 1}]" if indicators > 1 else "event_indicator"
        rows.add("indicator", k, name, "1", "local")
    continuous = tuple(rows.reference("state", k) for k in free)
    if accounts:
        continuous += (rows.reference("account", 1), rows.reference("account", 2))
    return Table(tuple(rows.found), free, continuous)


class _Rows:
    """The variables so far, in the order of their references; the first is the time."""

    def __init__(self, timeless: bool) -> None:
        time = Variable(0, "time", "s", "independent", "continuous", "time", 0, hidden=timeless)
        self.found = [time]
        self._names = {"time"}
        self._references: dict[tuple[str, int], int] = {}

    def reference(self, kind: str, index: int) -> int:
        """The reference of a variable that has been added."""
        return self._references[kind, index]

    def add(
        self, kind: str, index: int, name: str, unit: str, causality: str, **rest: object
    ) -> None:
        """Add a variable; a name that another one has is extended by the kind."""
        while name in self._names:
            whole, bracket, places = name.partition("[")
            inner = whole if name.endswith("]") else name
            name = f"{inner}.{kind}{bracket}{places}" if inner != name else f"{name}.{kind}"
        self._names.add(name)
        variability = str(rest.pop("variability", "continuous"))
        reference = self._references[kind, index] = len(self.found)
        variable = Variable(reference, name, unit, causality, variability, kind, index)
        self.found.append(replace(variable, **rest))  # type: ignore[arg-type]

    def add_rate(self, kind: str, index: int, of: int, unit: str, hidden: bool) -> None:
        """Add the rate of the variable with the reference `of`."""
        name = f"der({self.found[of].name})"
        self.add(kind, index, name, unit, "local", derivative_of=of, hidden=hidden)


def _add_parameters(
    rows: _Rows,
    program: Program,
    starts: Sequence[float],
    tunable: Sequence[bool],
    chosen: ChosenInputs,
) -> None:
    """Add the parameters; those that an input replaces are hidden."""
    for k, parameter in enumerate(program.parameters):
        hidden = parameter.name in chosen.replaced
        rows.add(
            "parameter",
            k,
            f"{parameter.name}.parameter" if hidden else parameter.name,
            parameter.unit,
            "parameter",
            variability="tunable" if tunable[k] else "fixed",
            start=starts[k],
            low=parameter.low,
            high=parameter.high,
            shown=parameter.shown,
            description=_documentation(parameter.span),
            hidden=hidden,
        )


def _add_accounts(rows: _Rows, program: Program, accounts: Sequence[AccountColumn]) -> None:
    """Add the energy accounts; those that the scene does not observe are no outputs."""
    columns = {found.account: found for found in reversed(accounts)}
    for k, account in enumerate(ENERGY_ACCOUNTS):
        column = columns.get(account, AccountColumn(account, f"energy.{account}"))
        used = bool(accounts) and (account in columns or account in ("supplied", "dissipated"))
        rows.add(
            "account",
            k,
            name_in_si(column.column),
            "J",
            "output" if account in columns else "local",
            shown=None if column.unit == "J" else Shown(column.unit, column.factor),
            hidden=not used,
            reinit=bool(program.jumps) and account in ("supplied", "dissipated"),
        )


def _add_states(rows: _Rows, program: Program, free: Sequence[int]) -> None:
    """Add the states, then their rates; those that are not `free` have hidden rates."""
    moved = bool(program.jumps) or program.closures is not None
    moved = moved or any(state.projection is not None for state in program.states)
    for k, state in enumerate(program.states):
        reinit = moved and k in free
        rows.add("state", k, state.name, state.unit, "local", shown=state.shown, reinit=reinit)
    for k, state in enumerate(program.states):
        of = rows.reference("state", k)
        rows.add_rate("rate", k, of, _rate_unit(state.unit), hidden=k not in free)


def free_states(program: Program) -> tuple[int, ...]:
    """The numbers of the states that Model Exchange integrates.

    All but those that follow from algebraic equations; all where the mass matrix couples these to
    other states.
    """
    algebraic = {k for k, state in enumerate(program.states) if state.kind == "algebraic"}
    coupled = any(
        (entry.column in algebraic) != (entry.row in algebraic) or entry.row in algebraic
        for entry in program.mass or ()
        if entry.value != program.dag.zero
    )
    every = range(len(program.states))
    return tuple(every) if coupled else tuple(k for k in every if k not in algebraic)


def _device_inputs(program: Program) -> Iterator[tuple[str, str, float]]:
    for device in program.devices:
        channels = channel_names(device.name, device.inputs)
        for name, (channel, component) in zip(channels, device.inputs, strict=True):
            at_rest = 1.0 if channel == "orientation" and component == 1 else 0.0
            yield name, channel_unit(channel), at_rest


def _commands(devices: Sequence[DeviceUse]) -> Iterator[tuple[str, str]]:
    for device in devices:
        channels = channel_names(device.name, device.commands)
        for name, (channel, _) in zip(channels, device.commands, strict=True):
            yield name, command_unit(channel)


def _rate_unit(unit: str) -> str:
    if unit in ("", "1"):
        return "1/s"
    if unit.endswith("*s"):
        return unit.removesuffix("*s")
    return unit.removesuffix("/s") + "/s^2" if unit.endswith("/s") else f"{unit}/s"


def _documentation(span: Span) -> str:
    """The `///` comment above a declaration."""
    line, _ = span.source.position(span.start)
    lines = span.source.text.splitlines()
    found: list[str] = []
    for text in reversed(lines[: line - 1]):
        match = _DOCUMENTATION.fullmatch(text)
        if match is None:
            break
        found.append(match[1].strip())
    return " ".join(reversed(found))


# --- arrays -----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Array:
    """A variable of FMI 3: a scalar, or an array of consecutive references.

    `variable` is its first component, with the name of the whole; `shape` is empty for a scalar.
    """

    variable: Variable
    components: tuple[Variable, ...]
    shape: tuple[int, ...]


def arrays_of(table: Table) -> tuple[Array, ...]:
    """Collect components `x[1]`, `x[2]`, .. with consecutive references to arrays.

    Components differ in nothing but name, reference, start and what they are derivatives of. An
    array of states has an array of rates of the same shape, or neither is one.
    """
    names = {v.name for v in table.listed}
    found: list[Array] = []
    for _, run in groupby(table.listed, key=lambda v: (v.kind, _family(v))):
        members = tuple(run)
        shape = _shape(members)
        whole = _whole(members[0].name)
        if shape and whole not in names:
            found.append(Array(replace(members[0], name=whole), members, shape))
        else:
            found += [Array(v, (v,), ()) for v in members]
    alone = _without_counterpart(found)
    return tuple(
        part
        for array in found
        for part in (
            [Array(v, (v,), ()) for v in array.components]
            if array.variable.reference in alone
            else [array]
        )
    )


def _without_counterpart(arrays: Sequence[Array]) -> set[int]:
    """References of the arrays of states without such an array of rates, and the reverse."""
    rates = {a.variable.derivative_of: a for a in arrays if a.variable.kind == "rate"}
    states = {a.variable.reference: a for a in arrays if a.variable.kind == "state"}
    paired = {
        head for head, state in states.items() if head in rates and rates[head].shape == state.shape
    }
    derived = {c.derivative_of for a in rates.values() for c in a.components}
    alone = {head for head, a in states.items() if a.shape and head not in paired}
    alone -= {
        head for head in alone if not any(c.reference in derived for c in states[head].components)
    }
    return alone | {
        a.variable.reference for head, a in rates.items() if a.shape and head not in paired
    }


def _family(variable: Variable) -> tuple[object, ...]:
    """A key that the components of one array share."""
    if _COMPONENT.fullmatch(_inner(variable.name)) is None:
        return (variable.reference,)
    return (
        _whole(variable.name),
        variable.unit,
        variable.causality,
        variable.variability,
        variable.shown,
        variable.low,
        variable.high,
        variable.start is None,
    )


def _inner(name: str) -> str:
    """The name of the state of a rate; another name is unchanged."""
    return name[4:-1] if name.startswith("der(") and name.endswith(")") else name


def _whole(name: str) -> str:
    match = _COMPONENT.fullmatch(_inner(name))
    if match is None:
        return name
    return f"der({match['whole']})" if name.startswith("der(") else match["whole"]


def _shape(members: Sequence[Variable]) -> tuple[int, ...]:
    """The shape of an array, row by row; empty where the components are not all in order."""
    if len(members) < 2:
        return ()
    places = []
    for variable in members:
        match = _COMPONENT.fullmatch(_inner(variable.name))
        if match is None:
            return ()
        places.append(tuple(int(place) for place in match["places"].split(",")))
    if [v.reference for v in members] != list(
        range(members[0].reference, members[0].reference + len(members))
    ):
        return ()
    shape = places[-1]
    if any(len(place) != len(shape) for place in places):
        return ()
    return shape if places == list(_places(shape)) else ()


def _places(shape: Sequence[int]) -> Iterator[tuple[int, ...]]:
    if not shape:
        yield ()
        return
    for k in range(1, shape[0] + 1):
        for rest in _places(shape[1:]):
            yield (k, *rest)
