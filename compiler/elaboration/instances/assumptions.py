"""Values that quantities are assumed to have while an expression is differentiated."""

from __future__ import annotations

from collections.abc import Mapping

from bgc.elaboration.instances.tree import Quantity, Status
from bgc.record_class import dataclass, field
from bgc.values.value import Value


@dataclass(slots=True, eq=False)
class Assumed:
    """The evaluation of a quantity under an assumption, as a demand."""

    status: Status = Status.NEW


@dataclass(slots=True, eq=False)
class Assumption:
    """Values that are given instead of those defined, and those that follow from them."""

    given: Mapping[Quantity, Value]
    values: dict[Quantity, Value] = field(default_factory=dict)
    demands: dict[Quantity, Assumed] = field(default_factory=dict)
