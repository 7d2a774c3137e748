"""Requirements and devices of a scene, with nodes of the DAG."""

from __future__ import annotations

from bgc.algebra.nodes import Node
from bgc.diagnostics.source import Span
from bgc.record_class import dataclass
from bgc.values.shown_units import Shown


@dataclass(frozen=True, slots=True)
class Requirement:
    """The required accuracy (`tolerance`, absolute) of one component of an expression.

    `name` is the output that contains it: a column of the scene, or an additional one.
    """

    name: str
    unit: str
    node: Node
    tolerance: float
    span: Span
    shown: Shown | None = None


@dataclass(frozen=True, slots=True)
class DeviceUse:
    """A device of the scene: its name, driver, and the driver's options as text.

    `inputs` and `commands` list the channel components in use, numbered from 1:
    `inputs[k] = (channel, component)` is INPUT symbol `first_input + k`; `commands[k]` is given
    by node k of `values`.
    """

    name: str
    driver: str
    options: tuple[tuple[str, str], ...]
    first_input: int
    inputs: tuple[tuple[str, int], ...]
    commands: tuple[tuple[str, int], ...]
    values: tuple[Node, ...]
    span: Span
