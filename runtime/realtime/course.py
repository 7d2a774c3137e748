"""Models of a servo loop: the one that runs, and others that take its place while it runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bgc.diagnostics.catalogue.exchange import cannot_exchange
from bgc.diagnostics.diagnostic import BgError
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field
from bgc.runtime.realtime.loop_options import RealtimeOptions, fill_options, period_of
from bgc.runtime.realtime.servo_binding import POSE_SIZE, OptionsStruct
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.rest_report import AtRest
from bgc.runtime.running.binding import Instance, text
from bgc.runtime.running.failures import require
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.port_bounds import require_ports
from bgc.runtime.running.run import set_method, start
from bgc.values.shown_units import Shown

RESTING = (*[0.0] * 3, 1.0, *[0.0] * (POSE_SIZE - 4))
"""A pose at rest in the middle of the workspace."""


@dataclass(frozen=True, slots=True)
class Course:
    """A model in a loop, with its method, its instance, and the parameters that it was given."""

    model: LoadedModel
    method: Solver
    instance: Instance
    given: Mapping[str, ParameterValue] = field(default_factory=dict)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the model's outputs, in the scene's order."""
        return tuple(variable.name for variable in self.model.outputs)

    @property
    def shown(self) -> tuple[Shown, ...]:
        """The units in which the outputs are shown, in the scene's order."""
        return tuple(variable.shown for variable in self.model.outputs)

    def outputs(self, rows: Array) -> Array:
        """The outputs in rows that C wrote, (n, outputs)."""
        return self.model.selection().of(rows)

    @property
    def devices(self) -> tuple[str, ...]:
        """Names of the model's devices."""
        model = self.instance.library.model
        return tuple(text(model.device[index].name) for index in range(model.n_device))

    @property
    def coupled(self) -> frozenset[str]:
        """Devices whose whole force comes from sampled ports.

        The energy of such a force is that of a coupling, so that of it may be taken back what the
        loop creates. An observer does that itself; rate control has no such energy.
        """
        return frozenset(
            force.device
            for force in self.model.facts.forces
            if force.ports and force.whole and not force.observers
        )

    @property
    def period(self) -> float:
        """Time between two samples, s."""
        return period_of(self.model, self.method, self.instance.sample_period)

    @property
    def rests(self) -> bool:
        """True for a start at rest, during which the hand has to rest too."""
        return self.model.facts.rest_for(self.method.start) is not None

    def start(self) -> AtRest | None:
        """Put the instance at its start; BgError where there is none."""
        model = self.model
        status, at_rest = start(self.instance, self.method, model.facts)
        require(self.instance, status, model.places)
        require_ports(self.instance, model.facts, model.places)
        return at_rest


def make_course(
    model: LoadedModel, method: Solver, parameters: Mapping[str, ParameterValue]
) -> Course:
    """Make an instance of a model with its parameters and its method."""
    instance = model.parameters.instance(parameters)
    require(instance, set_method(instance, method, bool(model.accounts)))
    return Course(model, method, instance, dict(parameters))


def places_of(course: Course, devices: Sequence[str], period: float) -> list[int]:
    """Find the devices of a loop that those of a course are, in the order of the course.

    Raises BgError BG757 where the devices or the periods differ.
    """
    scene = course.model.facts.name
    if sorted(course.devices) != sorted(devices):
        own = f"`{', '.join(course.devices)}`" if course.devices else "no devices"
        there = f"`{', '.join(devices)}`" if devices else "none"
        raise BgError([cannot_exchange(f"scene `{scene}` has {own}, the loop {there}")])
    if abs(course.period - period) > 1e-9 * period:
        reason = (
            f"scene `{scene}` has a period of {course.period:g} s, the loop one of {period:g} s"
        )
        raise BgError([cannot_exchange(reason)])
    return [devices.index(name) for name in course.devices]


def resting_poses(devices: int) -> Array:
    """Poses at rest, (devices, POSE_SIZE)."""
    return np.tile(np.array(RESTING), (max(devices, 1), 1))


def options_of(
    course: Course, struct: OptionsStruct, given: RealtimeOptions, duration: float | None
) -> OptionsStruct:
    """The options of C for a course: limits of the user, deadline and policy of the scene."""
    return fill_options(struct, given, course.model, course.period, duration)
