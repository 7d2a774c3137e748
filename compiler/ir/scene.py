"""The run of a scene: its solver, requirements, plots, devices and start."""

from __future__ import annotations

from dataclasses import dataclass

from bgc.algebra.nodes import Node
from bgc.diagnostics.source import Span
from bgc.language.columns import AccountColumn
from bgc.values.shown import Shown


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


@dataclass(frozen=True, slots=True)
class SolverChoice:
    """A statement `solver name(rtol = ..)`, options in SI units; `auto` chooses by measurement."""

    name: str
    options: tuple[tuple[str, float], ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Plot:
    """A panel of the scene's plot: columns over the column `against`; None means over time."""

    columns: tuple[str, ...]
    against: str | None


@dataclass(frozen=True, slots=True)
class Rest:
    """A start at rest: observations whose values are held, and parameters that are varied."""

    hold: tuple[str, ...]
    vary: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SceneFacts:
    """The run of a scene: times in s, None where the scene gives none."""

    name: str
    model: str
    solver: SolverChoice | None
    step: float | None
    duration: float | None
    every: float | None
    deadline: float | None
    accounts: tuple[AccountColumn, ...]  # the columns that hold energy accounts, in order
    columns: tuple[str, ...]  # all observed columns in order, the accounts among them
    plots: tuple[Plot, ...] = ()
    rest: Rest | None = None  # the start at rest
    overrun: str | None = None  # one of OVERRUN_POLICIES
    criteria: tuple[str, ...] = ()  # limits of columns: "max(tension) < 300000.0 N"

    def needed_accounts(self, jumps: bool) -> frozenset[str]:
        """The accounts among stored, supplied, dissipated in use; the residual needs all.

        What jumps take or add is the change of the stored energy; so is what is supplied by setting
        a parameter of an FMU during a run.
        """
        basic = {"stored", "supplied", "dissipated"}
        observed = {found.account for found in self.accounts}
        needed = basic if "residual" in observed else basic & observed
        reads_stored = (jumps and needed) or "supplied" in needed
        return frozenset(needed | {"stored"} if reads_stored else needed)
