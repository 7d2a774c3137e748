"""Options of a servo loop: from those of a user and of the scene to those of C."""

from __future__ import annotations

import math

from bgc.building.backends import BACKENDS
from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.realtime import cannot_start
from bgc.diagnostics.diagnostic import BgError
from bgc.language.solver import Solver
from bgc.record_class import dataclass
from bgc.runtime.realtime.servo_binding import POLICIES, OptionsStruct
from bgc.runtime.running.loaded_model import LoadedModel

_SHORTEST_PERIOD = 0.25e-3  # s: 4 kHz
_DEFAULT = 1e-3  # s: of a scene that samples nothing and has no step
_BUTTONS = 8


@dataclass(frozen=True, slots=True)
class RealtimeOptions:
    """Limits and tolerances of a loop. A limit of 0 is none; None is the default.

    Attributes
    ----------
    max_force, max_torque, max_gripper_force
        Largest force, N, torque, N m, and gripper force, N; the device's own limits hold too.
    max_force_rate
        Fastest change of the force, N/s (of the torque, N m/s).
    max_power
        Largest power into the hand, W.
    ramp
        Time in which the force rises after a start and after each press of the dead man's button,
        s.
    dead_man
        Button, 1 to 8, without which there is no force; 0: none.
    stale
        Longest time without news of a device that has motors, s.
    burst
        Missed deadlines, less a tenth of those that were kept, that end the loop. By default 100
        where a device has motors, else never.
    watchdog
        Longest time without a sample, s.
    policy
        `hold`, `skip` or `slow`: in place of the scene's.
    priority
        Whether SCHED_FIFO and locked memory are asked for.
    """

    max_force: float = 0.0
    max_torque: float = 0.0
    max_gripper_force: float = 0.0
    max_force_rate: float = 0.0
    max_power: float = 0.0
    ramp: float = 0.5
    dead_man: int = 0
    stale: float = 0.1
    burst: float | None = None
    watchdog: float = 0.1
    policy: str | None = None
    priority: bool = True

    def checked(self) -> RealtimeOptions:
        """Return the options; BG066 for one that is out of range."""
        for name in self.__dataclass_fields__:
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
    """Fill the options of C; a burst limit below 0 is the default."""
    struct.period = period
    struct.deadline = min(model.facts.deadline or period, period)
    struct.duration = math.inf if duration is None else duration
    struct.policy = POLICIES.index(given.policy or model.facts.overrun or POLICIES[0])
    struct.realtime = int(given.priority)
    for name in ("max_force", "max_torque", "max_gripper_force", "max_force_rate", "max_power"):
        setattr(struct, name, getattr(given, name))
    struct.ramp, struct.dead_man = given.ramp, given.dead_man
    struct.stale, struct.watchdog = given.stale, given.watchdog
    struct.burst = -1.0 if given.burst is None else given.burst
    return struct
