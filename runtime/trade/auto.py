"""What `solver auto` takes: the method that `bgc trade` recommended for a scene, if it did."""

from __future__ import annotations

from collections.abc import Mapping

from bgc.building.backends import BACKENDS
from bgc.runtime.model import Model
from bgc.runtime.running.parameters import Quantity
from bgc.runtime.running.run import Method
from bgc.runtime.trade.store import stored_answer


def stored_method(model: Model, parameters: Mapping[str, Quantity]) -> Method | None:
    """The stored answer for a model with these parameters, None if there is none that holds."""
    values = model.parameters.given(parameters)
    known = (*model.solvers, *BACKENDS)
    method = stored_answer(model, values)
    return method if method is not None and method.name in known else None
