"""Values of parameters for which a reduced scene keeps within the requirement, and for which not.

Parameters are those that `bgc stress` drives. Each is driven away from its value in the scene, to a
half and a tenth and to twice and ten times it, until the reduced scene is too far off the whole one
at that value.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from bgc.diagnostics.diagnostic import BgError
from bgc.ir.graph import FlatGraph
from bgc.language.solver import Solver
from bgc.record_class import dataclass
from bgc.runtime.measuring.judging import combined
from bgc.runtime.measuring.session import changed_model
from bgc.runtime.reduce.trial import Case
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.stress.drives import Drive, all_drives
from bgc.runtime.trade.measurement import DONE
from bgc.values.shown_units import Shown

_NEAR, _FAR = (
    1.2,
    (2.0, 10.0),
)  # times the value; the nearest one where the first of the others fails
_SHARE = 0.1  # of the time that is left, for one run


@dataclass(frozen=True, slots=True)
class Side:
    """The values of a parameter on one side of the scene's, SI.

    `holds` is the farthest one up to which all runs were within the requirement, None where there
    is none. `fails` is the first one that was not, with its error over the requirement, infinite
    where a run failed; None where all were.
    """

    holds: float | None = None
    fails: float | None = None
    error: float = 0.0


@dataclass(frozen=True, slots=True)
class Validity:
    """A parameter with its value in the scene, SI, and what was found below and above it."""

    name: str
    shown: Shown
    own: float
    below: Side
    above: Side


@dataclass(frozen=True, slots=True, eq=False)
class Validities:
    """Drives the parameters of the whole and of the reduced scene together, in the first case.

    `method` and `reduced_method` are those of the two; `is_over` ends the study.
    """

    case: Case
    reduced: LoadedModel
    method: Solver
    reduced_method: Solver
    is_over: Callable[[], bool]

    def drives(self, graph: FlatGraph) -> list[Drive]:
        """The parameters to drive: those of the scene's model first, then those of its parts."""
        parameters = self.case.session.model.parameters
        found = all_drives(graph, [parameters[name] for name in parameters], 0.0)
        wanted = [drive for drive in found if drive.own and {*drive.parameters} <= {*parameters}]
        return sorted(wanted, key=lambda drive: drive.name.count("."))

    def of(self, drive: Drive) -> Validity | None:
        """What holds along a drive; None where the time was over before both sides were done."""
        own = drive.own or 0.0
        above = self._side(drive, [own * factor for factor in (_NEAR, *_FAR)])
        below = self._side(drive, [own / factor for factor in (_NEAR, *_FAR)])
        if above is None or below is None:
            return None
        return Validity(drive.name, drive.shown, own, below, above)

    def _side(self, drive: Drive, values: Sequence[float]) -> Side | None:
        """Drive to all values but the first; to that one if the second is too far off already."""
        one = self.case.session.model.parameters[drive.parameters[0]]
        allowed = [value for value in values if one.low <= value <= one.high]
        holds: float | None = None
        for value in allowed[1:]:
            error = self._error(drive, value)
            if error is None:
                return None
            if error > 1.0 and holds is None:
                nearer = self._error(drive, allowed[0])
                if nearer is None or nearer > 1.0:
                    return None if nearer is None else Side(None, allowed[0], nearer)
                holds = allowed[0]
            if error > 1.0:
                return Side(holds, value, error)
            holds = value
        return Side(holds)

    def _error(self, drive: Drive, value: float) -> float | None:
        """The error of the reduced scene over the requirement; None where the time is over."""
        if self.is_over():
            return None
        session, instants = self.case.session, self.case.reference.instants
        limit = max(_SHARE * session.left, 1.0)
        rows = []
        for model, method in (
            (session.model, self.method),
            (self.reduced, self.reduced_method),
        ):
            known = {*model.parameters, *model.parameters.folded}
            values = {name: value for name in drive.parameters if name in known}
            try:
                run = instants.run(
                    changed_model(model, (), values), method, accounts=False, limit=limit
                )
            except BgError:
                return float("inf")
            if run.status != DONE:
                return float("inf")
            rows.append(run.rows)
        whole, reduced = rows
        return combined(instants.errors(reduced, whole), self.case.target.quantities)
