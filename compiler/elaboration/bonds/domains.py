"""Evaluate domains: the units of each component, the named slices, the signals."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import names, shapes
from bgc.diagnostics.catalogue import widths as width_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.instances.limits import MAX_WIDTH
from bgc.elaboration.instances.quantities import dimension_of
from bgc.elaboration.instances.tree import Environment
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.record_class import dataclass
from bgc.resolution.modules import Declared
from bgc.values.units import Dimension, describe_dimension, multiply
from bgc.values.value import Shape

WATT: Dimension = (1, 2, -3, 0, 0, 0, 0)
JOULE: Dimension = (1, 2, -2, 0, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class DomainFacts:
    """The width of a domain, the units of its efforts and flows, and its named variables.

    `efforts` and `flows` map a name to its slice of the components: the first component (from 0)
    and the shape. `signals` maps a name to its shape and unit. Units keep the words in which they
    were written.
    """

    name: str
    pseudo: bool
    effort_units: tuple[Dimension | None, ...]
    flow_units: tuple[Dimension | None, ...]
    efforts: dict[str, tuple[int, Shape]]
    flows: dict[str, tuple[int, Shape]]
    signals: dict[str, tuple[Shape, Dimension | None]]

    @property
    def width(self) -> int:
        """The number of scalar bonds of one bond of the domain."""
        return len(self.effort_units)


class Domains:
    """Evaluates each domain once."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._known: dict[int, DomainFacts | BgError] = {}

    def facts(self, declared: Declared[syntax.Domain]) -> DomainFacts:
        """The facts of a domain.

        Raises BgError for an invalid domain: with diagnostics at the first call, empty later.
        """
        key = id(declared.syntax)
        known = self._known.get(key)
        if known is None:
            try:
                known = self._resolve(declared)
            except BgError as err:
                self._known[key] = BgError(())
                raise err
            self._known[key] = known
        if isinstance(known, BgError):
            raise known
        return known

    def _resolve(self, declared: Declared[syntax.Domain]) -> DomainFacts:
        domain = declared.syntax
        env = Environment(None, declared.module, {})
        units: dict[str, list[Dimension | None]] = {"effort": [], "flow": []}
        slices: dict[str, dict[str, tuple[int, Shape]]] = {"effort": {}, "flow": {}}
        signals: dict[str, tuple[Shape, Dimension | None]] = {}
        seen: dict[str, syntax.DomainVariable] = {}
        for variable in domain.variables:
            if seen.setdefault(variable.name, variable) is not variable:
                first = seen[variable.name].span
                raise BgError([names.duplicate_name(variable.span, variable.name, first)])
            if len(variable.dims) > 2:
                raise BgError(
                    [shapes.too_many_dimensions(variable.span, variable.name, len(variable.dims))]
                )
            shape = tuple(
                self._world.whole(d, env, "a dimension", 1, MAX_WIDTH) for d in variable.dims
            )
            unit = dimension_of(variable.unit, variable.span) if variable.unit else None
            if variable.kind == "signal":
                signals[variable.name] = (shape, unit)
                continue
            count = 1
            for size in shape:
                count *= size
            slices[variable.kind][variable.name] = (len(units[variable.kind]), shape)
            units[variable.kind].extend([unit] * count)
        efforts, flows = units["effort"], units["flow"]
        _check_power(domain, efforts, flows)
        return DomainFacts(
            domain.name,
            domain.pseudo,
            tuple(efforts),
            tuple(flows),
            slices["effort"],
            slices["flow"],
            signals,
        )


def _check_power(
    domain: syntax.Domain, efforts: Sequence[Dimension | None], flows: Sequence[Dimension | None]
) -> None:
    """Raise BgError unless efforts and flows pair up and their products are powers.

    In a pseudo domain the products may have any unit.
    """
    if len(efforts) != len(flows) or not efforts:
        raise BgError(
            [
                width_messages.domain_unbalanced(
                    domain.name_span, domain.name, len(efforts), len(flows)
                )
            ]
        )
    for k, (effort, flow) in enumerate(zip(efforts, flows, strict=True)):
        if domain.pseudo or effort is None or flow is None:
            continue
        power = multiply(effort, flow)
        if power != WATT:
            found = describe_dimension(power)
            raise BgError(
                [width_messages.domain_no_power(domain.name_span, domain.name, k + 1, found)]
            )
