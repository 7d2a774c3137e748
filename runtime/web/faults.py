"""The messages of a failed run for a page, which has no Python to write them.

Each is the message of the catalogue, with the names of this model. What is known only at a failure
is left open, in brackets: `⟦time⟧`, `⟦state⟧`, `⟦value⟧` and so on.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, Final, cast

from bgc.building.build_result import Places
from bgc.diagnostics.catalogue.arguments import device_not_opened, parameter_out_of_range
from bgc.diagnostics.catalogue.view import parameter_not_applied
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.runtime.running.binding import Instance, text
from bgc.runtime.running.failures import explain, origins_of
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.structures import Status

Message = dict[str, str]

# What a failure names, as the number by which web.c gives its index.
_NAMES: Final = {
    Status.BAD_PARAMETER: 0,
    Status.ASSERTION: 1,
    Status.STEP_TOO_SMALL: 2,
    Status.TOO_MANY_STEPS: 2,
    Status.NOT_FINITE: 2,
    Status.SINGULAR: 2,
    Status.INCONSISTENT: 2,
    Status.CHATTERING: 3,
    Status.VANISHING: 4,
    Status.SINGULAR_CHAIN: 5,
    Status.OPEN_CHAIN: 5,
    Status.ENDLESS_JUMPS: 6,
    Status.BAD_SAMPLE: 7,
    Status.DEVICE: 8,
}
_OTHERS: Final = (Status.NO_MEMORY, Status.NOT_EXPLICIT, Status.NOT_CONVERGED)


class _Open(float):
    """A number that is not known yet: it is printed as its name."""

    def __new__(cls, name: str) -> _Open:
        made = super().__new__(cls, 0.0)
        made.name = name
        return made

    name: str

    def __format__(self, form: str) -> str:
        return _open(self.name)


def fault_messages(model: LoadedModel, places: Places) -> dict[str, Any]:
    """Prepare the messages of all failures of a model.

    `by_status` has for each status of `bgc.h` the kind of index that web.c returns, the messages by
    that index, and one for any other index. `range` are those of parameters with a range, by their
    index; `refused` and `device` those of a value and of a device that the run does not take.
    """
    return {
        "by_status": {
            str(int(status)): _of_status(model, places, status) for status in (*_NAMES, *_OTHERS)
        },
        "range": dict(_ranges(model, places)),
        "refused": _message(parameter_not_applied(_open("name"), _open("reason"))),
        "device": _message(device_not_opened(_open("name"), _open("driver"), _open("reason"))),
    }


def _of_status(model: LoadedModel, places: Places, status: Status) -> dict[str, Any]:
    table = model.library.model
    counts = {
        Status.ASSERTION: table.n_assert,
        Status.CHATTERING: len(places.switches),
        Status.VANISHING: table.n_divisor,
        Status.ENDLESS_JUMPS: len(places.jumps),
        Status.BAD_SAMPLE: len(places.held),
        Status.DEVICE: table.n_device,
    }
    indices = list(range(counts.get(status, 0)))
    if status is Status.BAD_PARAMETER:  # `range` has those of parameters
        indices = list(range(table.n_param, table.n_param + table.n_check + 1 + len(places.given)))
    if status is Status.INCONSISTENT:  # states of algebraic loops have messages of their own
        torn = {name for names, _ in places.loops for name in names}
        indices = [k for k, state in enumerate(model.states) if state.name in torn]
    if status in (Status.SINGULAR_CHAIN, Status.OPEN_CHAIN):
        indices = list(range(len(_chain_names(model, status))))

    def explained(index: int, **more: Any) -> Message:
        failed = _failed(model, index, **more)
        return _message(explain(cast(Instance, failed), status, places))

    found: dict[str, Any] = {"names": _NAMES.get(status, -1)}
    found["items"] = {str(k): explained(k) for k in indices}
    if status not in (Status.BAD_PARAMETER, Status.ASSERTION, Status.VANISHING):
        found["any"] = explained(-1)
    if _NAMES.get(status) == 2:
        found["named"] = explained(len(model.states))
    if status is Status.DEVICE:
        found["reasons"] = {str(k): explained(k, device_reason=_open("reason")) for k in indices}
    return found


def _failed(model: LoadedModel, index: int, device_reason: str = "") -> SimpleNamespace:
    """An instance as `explain` reads it, which failed at an index.

    The state behind the last one has an open name.
    """
    table = model.library.model
    states = [SimpleNamespace(name=state.name.encode()) for state in model.states]
    states.append(SimpleNamespace(name=_open("state").encode()))
    known = {
        name: getattr(table, name)
        for name in ("assertion", "device", "n_device", "n_param", "n_check", "param_check")
    }
    return SimpleNamespace(
        library=SimpleNamespace(
            model=SimpleNamespace(**known, state=states, param=table.param, divisor=table.divisor)
        ),
        time=_Open("time"),
        failed_time=_Open("failed_time"),
        given={},
        failed=lambda what: table.n_device if what == "device" and index < 0 else index,
        failed_chain=_name_at(_chain_names(model, Status.SINGULAR_CHAIN), index),
        chain_position={},
        failed_condition=_name_at(_chain_names(model, Status.OPEN_CHAIN), index),
        device_reason=device_reason,
        parameter=lambda k: _Open("value"),
    )


def _chain_names(model: LoadedModel, status: Status) -> list[str]:
    """Names of the closed chains, or of the conditions on their positions."""
    functions = model.library.functions
    named = (
        functions.bgc_chain_name
        if status is Status.SINGULAR_CHAIN
        else functions.bgc_condition_name
    )
    found: list[str] = []
    while (name := named(model.library.pointer, len(found))) is not None:
        found.append(text(name))
    return found


def _name_at(names: list[str], index: int) -> str:
    return names[index] if 0 <= index < len(names) else ""


def _ranges(model: LoadedModel, places: Places) -> Iterator[tuple[str, Message]]:
    instance, table = model.parameters.instance({}), model.library.model
    for k, parameter in enumerate(model.parameters.all_in(instance)):
        shown = parameter.shown
        low, high = shown.number(parameter.low), shown.number(parameter.high)
        origins = origins_of(table, places, k, lambda _: False)
        names = [text(table.param[origin].name) for origin in origins]
        numbers = _Open("value"), low, high
        outside = parameter_out_of_range(parameter.name, shown.label, *numbers, names)
        yield str(k), _message(outside)


def _message(diagnostic: Diagnostic) -> Message:
    return {
        "code": diagnostic.code,
        "text": diagnostic.message,
        "help": diagnostic.help or "",
    }


def _open(name: str) -> str:
    return f"⟦{name}⟧"
