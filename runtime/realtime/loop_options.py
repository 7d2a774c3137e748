"""Options of a servo loop: from those of a user and of the scene to those of C."""

from __future__ import annotations

import math

from bgc.building.backends import BACKENDS
from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.realtime import cannot_start
from bgc.diagnostics.diagnostic import BgError
from bgc.language.records import Where, option, options_of
from bgc.language.solver import Solver
from bgc.record_class import dataclass
from bgc.runtime.realtime.servo_binding import POLICIES, OptionsStruct
from bgc.runtime.running.loaded_model import LoadedModel

_SHORTEST_PERIOD = 0.25e-3  # s: 4 kHz
_DEFAULT = 1e-3  # s: of a scene that samples nothing and has no step
_BUTTONS = 8


@dataclass(frozen=True, slots=True)
class RealtimeOptions:
    """Limits and tolerances of a loop, SI. A limit of 0 is none; None is the default.

    The only place of these limits: the options of commands, the checks and the options of C follow
    from the fields. `burst` counts missed deadlines, less a tenth of those that were kept.
    `max_force_rate` and `max_turn_rate` hold for devices with motors, as do `max_speed`,
    `workspace_margin` and `stale`; a torque has the number of `max_force_rate` in N m/s.
    """

    max_force: float = option(
        "largest force, such as 5 N; the device's own limit applies too", unit="N"
    )
    max_torque: float = option("largest torque", unit="N*m")
    max_gripper_force: float = option("largest force of the gripper", unit="N")
    max_force_rate: float | None = option(
        "fastest change of the force; by default the full force in 5 ms, or 2400 N/s",
        of=None,
        unit="N/s",
    )
    max_power: float = option("largest power into the hand", unit="W")
    max_speed: float = option(
        "fastest motion of a device with motors; a faster one ends the loop (5 m/s)",
        of=5.0,
        unit="m/s",
    )
    max_turn_rate: float = option(
        "fastest turn of a device with motors (60 rad/s)", of=60.0, unit="rad/s"
    )
    workspace_margin: float = option(
        "farthest position outside the workspace that the device states (0.1 m)", of=0.1, unit="m"
    )
    ramp: float = option("time in which the force rises (0.5 s)", of=0.5, unit="s")
    dead_man: int = option(
        "button without which there is no force: 1 to 8", of=0, kind=int, metavar="BUTTON"
    )
    stale: float = option(
        "longest time without new data from a device with motors (0.1 s)", of=0.1, unit="s"
    )
    burst: float | None = option(
        "number of missed deadlines that ends the loop (100 with motors); 0: no limit",
        of=None,
        metavar="COUNT",
    )
    watchdog: float = option("longest time without a sample (0.1 s)", of=0.1, unit="s")
    policy: str | None = option(
        "treatment of missed periods, in place of that in the scene's `deadline`",
        of=None,
        kind=str,
        choices=POLICIES,
    )
    priority: bool = option(
        "real-time priority and locked memory are asked for", of=True, where=Where.PYTHON
    )

    supervise: bool = option(
        "drivers of hardware run in processes of their own", of=True, where=Where.PYTHON
    )

    def checked(self) -> RealtimeOptions:
        """Return the options; BG066 for one that is out of range."""
        for name in options_of(RealtimeOptions, Where.PYTHON):
            value = getattr(self, name)
            if isinstance(value, float) and not (math.isfinite(value) and value >= 0.0):
                raise BgError([bad_option(name, value, "a number, 0 or more")])
        if not 0 <= self.dead_man <= _BUTTONS:
            raise BgError([bad_option("dead_man", self.dead_man, "a button, 1 to 8", "1")])
        if self.policy not in (None, *POLICIES):
            raise BgError([cannot_start(f"there is no policy `{self.policy}`: {POLICIES}")])
        return self


def period_of(model: LoadedModel, method: Solver, sampled: float) -> float:
    """The period of the loop, s: that of the samples, else the step.

    Raises BgError BG769 for a method that the loop cannot run, or a period below 0.25 ms.
    """
    if method.name in BACKENDS:
        raise BgError([cannot_start(f"`{method.name}` does not run in the loop")])
    period = sampled or model.facts.step or _DEFAULT
    if period < _SHORTEST_PERIOD * (1.0 - 1e-9):
        raise BgError(
            [
                cannot_start(
                    f"a period of {period:g} s is shorter than {_SHORTEST_PERIOD:g} s (4 kHz)"
                )
            ]
        )
    return period


def fill_options(
    struct: OptionsStruct,
    given: RealtimeOptions,
    model: LoadedModel,
    period: float,
    duration: float | None,
) -> OptionsStruct:
    """Fill the options of C: those of the user, below 0 for the default, and those of the scene."""
    for name in options_of(RealtimeOptions, Where.PYTHON):
        if hasattr(struct, name) and name != "policy":
            value = getattr(given, name)
            setattr(struct, name, -1.0 if value is None else value)
    struct.period = period
    struct.deadline = min(model.facts.deadline or period, period)
    struct.duration = math.inf if duration is None else duration
    struct.policy = POLICIES.index(given.policy or model.facts.overrun or POLICIES[0])
    struct.realtime = int(given.priority)
    return struct
