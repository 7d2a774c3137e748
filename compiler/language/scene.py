"""The record of a run: what a scene states about it."""

from __future__ import annotations

from bgc.language.column_names import AccountColumn
from bgc.language.records import Where, option
from bgc.language.scene_tables import OVERRUN_POLICIES
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field


@dataclass(frozen=True, slots=True)
class Plot:
    """Columns to draw together, against the column `across`: `time`, or another one."""

    columns: tuple[str, ...]
    across: str = "time"


@dataclass(frozen=True, slots=True)
class Sampled:
    """A value that a sampled part holds: its number among all such values."""

    number: int
    name: str
    unit: str


@dataclass(frozen=True, slots=True)
class Rest:
    """A start at rest: the outputs whose values are held, and the parameters that are varied.

    The compiled model adds `momenta`, the indices of the states that are momenta, `sampled`, the
    values of sampled parts without those of sampled ports, the `stiffness` of each state, and what
    the model gives of it (`given`): a parameter or `q0 of spring`, empty where it gives nothing.
    `switches` names the element in whose law each switch stands, or the state that it reads; empty
    where it reads time, or several states outside laws.
    """

    hold: tuple[str, ...] = ()
    vary: tuple[str, ...] = ()
    momenta: tuple[int, ...] = ()
    sampled: tuple[Sampled, ...] = ()
    stiffness: tuple[float, ...] = ()
    given: tuple[str, ...] = ()
    switches: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Scene:
    """The run of a scene, in SI units; None where the scene says nothing.

    Attributes
    ----------
    name, model
        Names of the scene and of its model.
    columns
        The observed columns in order. Those that are no outputs of the model are energy accounts,
        which `accounts` lists.
    solver
        Its method and options.
    step, duration, every, deadline
        Times, s: see their options.
    plots
        The panels of its plot.
    rest
        Its start at rest; None where it starts from the initial values that are given.
    overrun
        What a loop in real time does that is late.
    criteria
        Limits of columns, as `bgc operability` reads them: `max(tension) < 300000.0 N`.
    """

    name: str
    model: str
    columns: tuple[str, ...]
    accounts: tuple[AccountColumn, ...] = ()
    solver: Solver = field(default_factory=Solver)
    step: float | None = option(
        "step of fixed-step methods, and period at which devices are sampled",
        of=None,
        unit="s",
        noun="step",
        where=Where.SCENE,
    )
    every: float | None = option(
        "interval between rows",
        of=None,
        unit="s",
        default="that of the scene",
        noun="interval",
        example='"10 ms"',
    )
    duration: float | None = option(
        "simulated time",
        of=None,
        unit="s",
        default="that of the scene",
        noun="duration",
        flag="--time",
        example='"60 s"; by default that of the scene',
    )
    deadline: float | None = option(
        "processor time that a step may take", of=None, unit="s", noun="deadline", where=Where.SCENE
    )
    plots: tuple[Plot, ...] = ()
    rest: Rest | None = None
    overrun: str | None = option(
        "treatment of missed periods",
        of=None,
        kind=str,
        choices=OVERRUN_POLICIES,
        where=Where.SCENE,
    )
    criteria: tuple[str, ...] = ()

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
