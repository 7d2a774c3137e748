"""Start an instance at rest: search for the state, check it, and say what moved."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from threadpoolctl import threadpool_limits

from bgc.diagnostics.catalogue.starts import no_rest, rest_not_found, rest_too_far
from bgc.diagnostics.diagnostic import BgError
from bgc.language.scene import Rest
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.rest_report import AtRest, Fixed, Free, Move
from bgc.runtime.running.binding import Instance, text
from bgc.runtime.running.relations import Undefined
from bgc.runtime.running.rest_algebra import leading_rows, row_scales
from bgc.runtime.running.rest_equations import require_ok
from bgc.runtime.running.rest_newton import AT_REST
from bgc.runtime.running.rest_search import RestSearch
from bgc.runtime.running.structures import Status

_TORN = 1e-6  # of a state, in its scale: relations between positions do not hold
_KEPT = 1e-9  # of a state, in its scale: it is where it was, but for the accuracy of the search
_UNMOVED = 1e-13  # of a state, in its scale, or of an argument: rounding


def go_to_rest(instance: Instance, rest: Rest) -> tuple[Status, AtRest | None]:
    """Put an instance that has been reset at the nearest state of rest.

    Returns OK with what was found, or the status of an evaluation that failed.

    Raises
    ------
    BgError
        BG760 if rates remain, BG761 if they do where values are held, BG773 if relations between
        positions could not be followed to the state of rest.
    """
    # The matrices are small: shared among threads, they took ten times as long on two processors.
    with threadpool_limits(limits=1, user_api="blas"):
        try:
            return _finish(_searched(instance, rest))
        except Undefined as undefined:
            return undefined.status, None


def _searched(instance: Instance, rest: Rest) -> RestSearch:
    """Search for the nearest state of rest."""
    search = RestSearch(instance, rest)
    search.run()
    if search.trapped.size and (
        _torn(search) or not _remaining(search)[1].max(initial=0.0) <= AT_REST
    ):
        # A valve that opens under the load, such as a relief valve, frees what seemed trapped.
        search.go(search.begin)
        require_ok(instance.reset(search.time, checked=False))
        search = RestSearch(instance, rest)
        search.run(giving_way=False)
    return search


def _torn(search: RestSearch) -> bool:
    """Return whether z violates relations between positions, and no held value causes this.

    A closed chain is left out: its own conditions keep it together.
    """
    _, closing, _ = search.resting.chain_rows()
    may_tear = not search.held and not closing.size
    return may_tear and float(np.abs(search.off()).max(initial=0.0)) > _TORN


def _finish(search: RestSearch) -> tuple[Status, AtRest | None]:
    """Check the rates that remain, and make the state the start of a run."""
    torn = _torn(search)
    if torn and search.nearest is not None:
        search.z = search.nearest  # what still moves there keeps the system from its rest
    _keep_declared(search)
    remaining, sizes = _remaining(search)
    worst = float(sizes.max(initial=0.0))
    if not worst <= AT_REST:
        _refuse(search, remaining, sizes)
    if torn or not search.arrived:
        raise BgError([rest_too_far()])
    free, tipped = _free(search), _tipped(search)
    search.go(search.z)
    status = search.instance.restart()
    if status is not Status.OK:
        return status, None
    return status, AtRest(worst, _moves(search), _variations(search), free, tipped)


def _remaining(search: RestSearch) -> tuple[Array, Array]:
    """The residuals, and their magnitudes relative to the states that they depend on."""
    remaining = search.residuals(search.z)
    slope, _ = search.slopes(search.z)
    search.rows = row_scales(slope)
    return remaining, np.abs(remaining / search.rows)


def _keep_declared(search: RestSearch) -> None:
    """Undo what moved states by rounding alone: a counter stays a whole number."""
    search.go(search.z)
    y = search.z[: search.size]
    moved = np.abs(y - search.declared) > _UNMOVED * (1 + np.abs(search.declared))
    search.z = np.concatenate([np.where(moved, y, search.declared), search.z[search.size :]])


def _refuse(search: RestSearch, remaining: Array, sizes: Array) -> None:
    if search.held:
        raise BgError([rest_not_found()])
    rates = sizes[: search.size]
    order = np.argsort(-rates, kind="stable")
    left = [int(k) for k in order if rates[k] > max(AT_REST, 1e-3 * rates.max(initial=0.0))]
    names, units, changes = (
        search.resting.names,
        search.resting.units,
        remaining[: search.size] * search.scale,
    )
    charges = np.flatnonzero(search.stiffness).tolist()
    kinds = dict.fromkeys(charges, "q") | dict.fromkeys(search.momenta, "p")
    shown = ((names[k], float(changes[k]), units[k], kinds.get(k, "")) for k in left)
    raise BgError([no_rest(list(shown), _tipped(search))])


def _tipped(search: RestSearch) -> tuple[str, ...]:
    """The elements whose switches have changed their mode on the way from the start, by name.

    An argument that the accuracy of the search may change as much is left out: it may be zero.
    """
    begin, after = search.begin, search.z
    nearby = begin.copy()
    nearby[: search.size] += AT_REST
    points = []
    for z in (begin, nearby, after):
        search.go(z)
        points.append(search.instance.switch_arguments())
    first, second, last = points
    clear = np.abs(last) > np.abs(second - first) + _UNMOVED * np.abs(first)
    tipped = np.flatnonzero(clear & ((first > 0) != (last > 0)))
    names = (search.switches[k] for k in tipped)
    return tuple(dict.fromkeys(name for name in names if name))


def _moves(search: RestSearch) -> tuple[Move, ...]:
    after = search.resting.state / search.scale
    change = np.abs(after - search.start)
    order = np.argsort(-change, kind="stable")
    pairs = [(int(k), search.scale[k]) for k in order if change[k] > 1e-12]
    return tuple(
        Move(
            search.resting.names[k],
            search.resting.units[k],
            float(search.start[k] * s),
            float(after[k] * s),
            search.given_by[k] if k < len(search.given_by) else "",
        )
        for k, s in pairs
    )


def _free(search: RestSearch) -> tuple[Free, ...]:
    """The directions that rest leaves free at z, each by a state that stands for it.

    States that are kept are named first: what is joined to them follows.
    """
    with suppress(Undefined):
        search.along()
    found: dict[int, Fixed] = {}
    for fixed, places, motions, count in reversed(search.left_free):
        places = np.array([k for k in places if k not in found], dtype=np.intp)
        for k in places[leading_rows(motions[places], count)].tolist():
            change = abs(search.z[k] - search.declared[k])
            moved = fixed == "kept" and change > _KEPT * (1 + abs(search.declared[k]))
            found[k] = "nearest" if moved else fixed
    return tuple(Free(search.resting.names[k], fixed) for k, fixed in found.items())


def _variations(search: RestSearch) -> tuple[Move, ...]:
    info = search.instance.library.model.param
    return tuple(
        Move(text(info[k].name), text(info[k].unit), float(given), search.instance.parameter(k))
        for k, given in zip(search.varied, search.given, strict=True)
    )
