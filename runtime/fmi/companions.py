"""Files beside an FMU: its groups of variables for OSP, and reference results for cross-checks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import groupby

import numpy as np

from bgc.diagnostics.catalogue.arguments import no_duration
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.documents.templates import render_template
from bgc.runtime.fmi.fmu_model import FmuModel
from bgc.runtime.fmi.fmu_variables import Variable
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.failures import require
from bgc.runtime.running.run import set_method, start
from bgc.runtime.running.simulate import times_of


@dataclass(frozen=True, slots=True)
class _Group:
    """Inputs or outputs that are connected together: `hand.velocity` with its three components."""

    name: str
    members: tuple[str, ...]


def osp_description(model: FmuModel) -> str:
    """Write `NAME_OspModelDescription.xml`: a group for each input, output or channel.

    The components of a vector or of a device's channel are one group.
    """
    return render_template("osp_model.xml.j2", groups=list(_groups(model)))


def _groups(model: FmuModel) -> Iterator[_Group]:
    kinds = ("input", "output", "command", "account")
    listed = [
        v for v in model.table.listed if v.kind in kinds and v.causality in ("input", "output")
    ]
    for _, run in groupby(listed, key=_whole_name):
        members = list(run)
        yield _Group(_whole_name(members[0]), tuple(v.name for v in members))


def _whole_name(variable: Variable) -> str:
    return variable.name.partition("[")[0]


def reference_files(model: FmuModel) -> Mapping[str, str]:
    """Compute the files of a cross-check by their endings: `_ref.csv`, `_in.csv`, `_ref.opt`.

    The reference is the run of the scene with its own solver and rows, and with all inputs at their
    start. There is no `_in.csv` without inputs.

    Raises BgError: BG067 where the scene gives no duration, or the run fails.
    """
    loaded, method = model.loaded, model.method
    facts = loaded.facts
    if facts.duration is None:
        raise BgError([no_duration(facts.name)])
    times = times_of(loaded, method)
    rows = np.full((len(times), loaded.row_width), np.nan)
    instance = loaded.parameters.instance({})
    require(instance, set_method(instance, method, bool(loaded.accounts)))
    status, _ = start(instance, method, facts)
    require(instance, status)
    status, _ = instance.run(times, rows)
    require(instance, status, loaded.places)
    names = {v.name: (v.kind, v.index) for v in model.table.listed if v.causality == "output"}
    columns = [
        (name, rows[:, index if kind == "output" else len(loaded.measured) + index])
        for name, (kind, index) in names.items()
        if kind in ("output", "account")
    ]
    inputs = [(v.name, np.full(2, v.start or 0.0)) for v in model.table.of("input")]
    tolerance = model.description.tolerance or 0.0
    options = (
        ("StartTime", 0.0),
        ("StopTime", facts.duration),
        ("StepSize", float(times[1] - times[0])),
        *((("RelTol", tolerance),) if tolerance else ()),
    )
    files = {
        "_ref.csv": _csv(times, columns),
        "_ref.opt": "".join(f"{key}, {value!r}\n" for key, value in options),
    }
    if inputs:
        files["_in.csv"] = _csv(times[[0, -1]], inputs)
    return files


def _csv(times: Array, columns: list[tuple[str, Array]]) -> str:
    header = ",".join(f'"{name}"' for name in ("time", *(name for name, _ in columns)))
    values = np.column_stack([times, *(column for _, column in columns)])
    return "\n".join([header, *(",".join(map(repr, row)) for row in values.tolist())]) + "\n"
