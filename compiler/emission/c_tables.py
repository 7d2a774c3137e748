"""Print the constant tables of a model as C: names, units, bounds, patterns, devices."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import accumulate

from bgc.algebra.dag import Dag, Kind, Level, Symbol
from bgc.emission.block_tables import print_blocks
from bgc.emission.print_lu import MatrixText, is_unrolled
from bgc.emission.switches import few_states_read
from bgc.ir.defaults import default_values
from bgc.ir.lowered import Lowered
from bgc.ir.program import Closures, Program
from bgc.ir.scene_nodes import DeviceUse
from bgc.values.fmu_files import KINDS2, KINDS3

_CHANNELS = {
    "position": "BGC_POSITION",
    "orientation": "BGC_ORIENTATION",
    "velocity": "BGC_VELOCITY",
    "angular_velocity": "BGC_ANGULAR_VELOCITY",
    "gripper": "BGC_GRIPPER",
    "buttons": "BGC_BUTTONS",
    "force": "BGC_FORCE",
    "torque": "BGC_TORQUE",
    "gripper_force": "BGC_GRIPPER_FORCE",
    "held_force": "BGC_HELD_FORCE",
    "age": "BGC_AGE",
}
_PER_LINE = 16
_ROLES = (
    "parameter",
    "tunable",
    "input",
    "output",
)  # of numbers of an FMU, in the order of `bgc.h`

Field = tuple[str, str]  # a member of bgc_model and its value


def model_tables(
    lowered: Lowered, matrix: MatrixText, source_hash: str
) -> tuple[list[str], list[Field]]:
    """Print the tables, and the members of `bgc_model` that refer to them or give their sizes.

    `matrix` has the tables of the LU factors of W.
    """
    program, jacobian = lowered.program, lowered.jacobian
    scene = program.scene
    commands = [(d, use) for d, device in enumerate(program.devices) for use in device.commands]
    tables: list[str] = []
    fields: list[Field] = [
        ("abi", "BGC_ABI"),
        ("name", quoted(scene.name)),
        ("hash", quoted(source_hash)),
        *((f"n_{name}", str(size)) for name, size in _sizes(lowered, matrix).items()),
    ]

    def table(field: str, type_: str, rows: Sequence[str]) -> None:
        if rows:
            body = "".join(f"    {row},\n" for row in rows)
            tables.append(f"static const {type_}model_{field}[] = {{\n{body}}};\n")
        fields.append((field, f"model_{field}" if rows else "NULL"))

    def indices(field: str, values: Sequence[int]) -> None:
        chunks = [values[k : k + _PER_LINE] for k in range(0, len(values), _PER_LINE)]
        table(field, "int ", [", ".join(map(str, chunk)) for chunk in chunks])

    table("param", "bgc_param_info ", _parameters(program))
    table("state", "bgc_var_info ", _variables((s.name, s.unit) for s in program.states))
    table("switch_info", "bgc_switch_info ", _switches(lowered))
    if lowered.watches:
        indices("watch", [int(kind) for kind, _ in lowered.watches])
        fields.append(("n_watch", str(len(lowered.watches))))
    arguments = {
        "switch_state": [switch.argument for switch in lowered.switches],
        "watch_state": [argument for _, argument in lowered.watches],
    }
    for field, nodes in arguments.items():
        if read := few_states_read(program, nodes):
            indices(field, read)
            fields.append((f"n_{field}", str(len(read))))
    table("output", "bgc_var_info ", _variables((o.name, o.unit) for o in program.observations))
    table("input", "bgc_channel_use ", _inputs(program))
    table("command", "bgc_channel_use ", [_channel(d, use) for d, use in commands])
    table("device", "bgc_device_info ", [_device(device) for device in program.devices])
    table("assertion", "char *const ", [quoted(guard.message) for guard in program.guards])
    table("param_check", "char *const ", [quoted(check.message) for check in program.positive])
    if jacobian.inner:
        indices("jac_row", [row for row, _ in jacobian.slopes])
        indices("jac_col", [column for _, column in jacobian.slopes])
        indices("local_row", jacobian.rows)
        indices("local_col", jacobian.columns)
        fields.append(("n_inner", str(jacobian.inner)))
        fields.append(("n_local", str(len(jacobian.entries))))
    else:
        indices("jac_row", jacobian.rows)
        indices("jac_col", jacobian.columns)
    indices("mass_row", [entry.row for entry in program.mass or ()])
    indices("mass_col", [entry.column for entry in program.mass or ()])
    for name, values in matrix.tables.items():
        indices(name, values)
    if program.closures is not None:
        tables.append(_closure_info(program.dag, program.closures))
        fields.append(("closure_info", "&model_closure_info"))
    fields += [
        ("step", number(scene.step or 0.0)),
        ("duration", number(scene.duration or 0.0)),
        ("every", number(scene.every or 0.0)),
    ]
    if program.divisors:
        table("divisor", "char *const ", [quoted(divisor.what) for divisor in program.divisors])
        fields.append(("n_divisor", str(len(program.divisors))))
    if program.jumps:
        resets = [reset for jump in program.jumps for reset in jump.resets]
        indices("jump_first", [0, *accumulate(len(jump.resets) for jump in program.jumps)])
        indices("reset_state", [reset.state for reset in resets])
        indices("edge_switch", [k for k, s in enumerate(lowered.switches) if s.of_jump])
        fields.append(("n_jump", str(len(program.jumps))))
        fields.append(("n_edge", str(sum(s.of_jump for s in lowered.switches))))
    if program.held:
        indices("held_input", [held.index for held in program.held])
        indices("held_rate", [held.rate for held in program.held])
        fields.append(("n_held", str(len(program.held))))
        fields.append(("n_rate", str(len(program.rates))))
    if program.fmus:
        tables.append(_fmus(program))
        fields += [("n_fmu", str(len(program.fmus))), ("fmu", "model_fmu")]
    place = {held.index: k for k, held in enumerate(program.held)}
    if scene.accounts and program.coupling_energies:
        indices(
            "book", [place[index] for energies in program.coupling_energies for index in energies]
        )
        fields.append(("n_port", str(len(program.coupling_energies))))
    if program.slots:
        fields.append(("n_slot", str(program.slots)))
    if matrix.blocks is not None:
        tables.append(print_blocks(matrix.blocks, is_unrolled(lowered.plan)))
        fields.append(("blocks", "&model_blocks"))
    if program.start is not None:
        table("start_guess", "double ", [number(x) for x in program.start.guess])
        fields.append(("n_start", str(len(program.start.guess))))
    if program.given:
        names = [f"{given.variable} of {given.name}" for given in program.given]
        table("given_name", "char *const ", [quoted(name) for name in names])
        kinds = [2 if given.is_rounded else int(given.is_default) for given in program.given]
        indices("given_kind", kinds)
        fields.append(("n_given", str(len(program.given))))
    return tables, fields


def _fmus(program: Program) -> str:
    """The tables of the FMUs of other tools, and their `bgc_fmu_info`."""
    place = {program.dag.symbol(Kind.INPUT, held.index): k for k, held in enumerate(program.held)}
    tables, rows = [], []
    for index, fmu in enumerate(program.fmus):
        kinds = KINDS3 if fmu.version == 3 else (*[""] * len(KINDS3), *KINDS2)
        lines = [
            f"{{{link.reference}u, {kinds.index(link.kind)}, {_ROLES.index(link.role)}, "
            f"{place[link.symbol]}, {link.place}, {link.count}, {number(link.factor)}, "
            f"{number(link.offset)}, {'NAN' if link.start is None else number(link.start)}}}"
            for link in fmu.links
        ]
        name = f"model_fmu_{index}"
        body = "".join(f"    {line},\n" for line in lines)
        tables.append(f"static const bgc_fmu_variable {name}[] = {{\n{body}}};\n")
        texts = ", ".join(map(quoted, (fmu.name, fmu.file, fmu.token)))
        rate = program.held[place[fmu.links[-1].symbol]].rate
        rows.append(f"    {{{texts}, {fmu.version}, {rate}, {len(lines)}, {name}}},\n")
    infos = f"static const bgc_fmu_info model_fmu[] = {{\n{''.join(rows)}}};\n"
    return "\n".join((*tables, infos))


def _sizes(lowered: Lowered, matrix: MatrixText) -> dict[str, int]:
    """The sizes of the arrays of a model, by the members of `bgc_model` without `n_`."""
    program, plan = lowered.program, lowered.plan
    dag = program.dag
    # A batch of instances stores the entries of the plan in as many numbers.
    factors = max(plan.entries, matrix.blocks.factors) if matrix.blocks else plan.entries
    return {
        "param": len(program.parameters),
        "hoist": len(lowered.hoisted),
        "state": len(program.states),
        "input": program.inputs,
        "output": len(program.observations),
        "command": sum(len(device.commands) for device in program.devices),
        "assert": len(program.guards),
        "device": len(program.devices),
        "jac": len(lowered.jacobian.slopes or lowered.jacobian.entries),
        "mass": len(program.mass or ()),
        "lu": factors,
        "check": len(program.positive),
        "given_assert": sum(dag.level[guard.condition] <= Level.PARAM for guard in program.guards),
        "switch": len(lowered.switches),
        "timed": sum(switch.timed for switch in lowered.switches),
    }


def _closure_info(dag: Dag, closures: Closures) -> str:
    """The tables of closed chains, and their `bgc_closure_info`."""
    symbols = [dag.symbol_of(node) for node in closures.starts]
    selectors = [dag.symbol_of(node) for node in closures.selectors]
    arrays: list[tuple[str, str, list[str]]] = [
        ("chain_of", "int ", [str(k) for k in closures.chain_of]),
        ("rank", "int ", [str(k) for k in closures.ranks]),
        ("selector", "int ", ["-1" if s is None else str(s.index) for s in selectors]),
        ("impulse", "int ", [str(k) for k in closures.impulses]),
        ("moved", "int ", [str(k) for k in closures.moved]),
        ("start", "int ", [str(s.index) for s in symbols if s is not None]),
        ("chain", "char *const ", [quoted(", ".join(c.names)) for c in closures.chains]),
        ("condition", "char *const ", [quoted(name) for name in closures.names]),
    ]
    sizes = (
        closures.kept,
        len(closures.flows),
        closures.held,
        len(closures.conditions),
        closures.held_rank,
        len(closures.impulses),
        len(closures.moved),
        len(closures.starts),
        len(closures.chains),
        len(selectors) - selectors.count(None),
    )
    lines = [
        f"static const {type_}model_closure_{name}[] = {{{', '.join(values)}}};\n"
        for name, type_, values in arrays
        if values
    ]
    names = [f"model_closure_{name}" if values else "NULL" for name, _, values in arrays]
    body = ", ".join((*map(str, sizes), *names))
    return "".join(lines) + f"static const bgc_closure_info model_closure_info = {{{body}}};\n"


def number(value: float) -> str:
    """A double as C text; a default that does not exist is NAN, which no range contains."""
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return "(double)NAN" if math.isnan(value) else repr(float(value))


def quoted(text: str) -> str:
    """A C string literal in ASCII; other bytes of the UTF-8 text are escaped."""
    out = []
    for byte in text.encode("utf-8"):
        char = chr(byte)
        if char in '"\\?':  # a ? could begin a trigraph
            out.append(f"\\{char}")
        elif char == "\n":
            out.append("\\n")
        elif 32 <= byte < 127:
            out.append(char)
        else:
            out.append(f"\\{byte:03o}")
    return f'"{"".join(out)}"'


def _parameters(program: Program) -> list[str]:
    infinity = float("inf")
    values = default_values(program.dag, program.parameters)
    rows = []
    for parameter in program.parameters:
        value = values[Symbol(Kind.PARAM, parameter.index)]
        low = -infinity if parameter.low is None else parameter.low
        high = infinity if parameter.high is None else parameter.high
        numbers = ", ".join(map(number, (value, low, high)))
        rows.append(f"{{{quoted(parameter.name)}, {quoted(parameter.unit)}, {numbers}}}")
    return rows


def _variables(variables: Iterable[tuple[str, str]]) -> list[str]:
    return [
        f"/* {k} */ {{{quoted(name)}, {quoted(unit)}}}" for k, (name, unit) in enumerate(variables)
    ]


def _switches(lowered: Lowered) -> list[str]:
    return [
        f"{{BGC_{switch.operation.name}, {int(switch.timed)}, {switch.jumps + switch.of_jump}}}"
        for switch in lowered.switches
    ]


def _inputs(program: Program) -> list[str]:
    """The source of each input: a device channel, or device -1 for one that the caller sets."""
    rows = ["{-1, 0, 0}"] * program.inputs
    for d, device in enumerate(program.devices):
        for k, use in enumerate(device.inputs, device.first_input):
            rows[k] = _channel(d, use)
    return rows


def _channel(device: int, use: tuple[str, int]) -> str:
    channel, component = use
    return f"{{{device}, {_CHANNELS[channel]}, {component - 1}}}"  # C counts from 0


def _device(device: DeviceUse) -> str:
    options = "\n".join(f"{key}={value}" for key, value in device.options)
    return f"{{{quoted(device.name)}, {quoted(device.driver)}, {quoted(options)}}}"
